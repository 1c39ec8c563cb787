//! Access tracking: the last use of a resource, and the barrier that its next use needs.

use std::sync::{Mutex, MutexGuard, PoisonError};

use ash::vk;

/// A use of a resource.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Access {
    /// Source of a copy.
    TransferRead,
    /// Destination of a copy or clear.
    TransferWrite,
    /// Read by a compute shader: sampled image, uniform buffer or readonly storage.
    ComputeRead,
    /// Read and written by a compute shader as storage.
    ComputeWrite,
    /// Read by vertex or fragment shaders.
    GraphicsRead,
    /// Vertex or index buffer.
    VertexRead,
    /// Acceleration structure traversed by a compute shader.
    ComputeTrace,
    /// Destination or scratch memory of an acceleration structure build.
    StructureBuild,
    /// Input of an acceleration structure build.
    BuildInput,
    /// Colour attachment.
    ColorAttachment,
    /// Depth attachment.
    DepthAttachment,
}

/// Stage, access and layout of a use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Use {
    stage: vk::PipelineStageFlags2,
    access: vk::AccessFlags2,
    layout: vk::ImageLayout,
    writes: bool,
}

impl Access {
    /// The only mapping from a use to stage, access and image layout.
    fn to_use(self, storage_image: bool) -> Use {
        use vk::{AccessFlags2 as A, ImageLayout as L, PipelineStageFlags2 as S};
        let shader_reads = A::SHADER_SAMPLED_READ | A::SHADER_STORAGE_READ | A::UNIFORM_READ;
        let read_layout = if storage_image { L::GENERAL } else { L::SHADER_READ_ONLY_OPTIMAL };
        let (stage, access, layout, writes) = match self {
            Self::TransferRead => (S::ALL_TRANSFER, A::TRANSFER_READ, L::TRANSFER_SRC_OPTIMAL, false),
            Self::TransferWrite => (S::ALL_TRANSFER, A::TRANSFER_WRITE, L::TRANSFER_DST_OPTIMAL, true),
            Self::ComputeRead => (S::COMPUTE_SHADER, shader_reads, read_layout, false),
            Self::ComputeWrite => {
                (S::COMPUTE_SHADER, A::SHADER_STORAGE_READ | A::SHADER_STORAGE_WRITE, L::GENERAL, true)
            }
            Self::GraphicsRead => (S::VERTEX_SHADER | S::FRAGMENT_SHADER, shader_reads, read_layout, false),
            Self::VertexRead => {
                (S::VERTEX_INPUT, A::VERTEX_ATTRIBUTE_READ | A::INDEX_READ, L::UNDEFINED, false)
            }
            Self::ComputeTrace => {
                (S::COMPUTE_SHADER, A::ACCELERATION_STRUCTURE_READ_KHR, L::UNDEFINED, false)
            }
            Self::StructureBuild => (
                S::ACCELERATION_STRUCTURE_BUILD_KHR,
                A::ACCELERATION_STRUCTURE_READ_KHR | A::ACCELERATION_STRUCTURE_WRITE_KHR,
                L::UNDEFINED,
                true,
            ),
            Self::BuildInput => (S::ACCELERATION_STRUCTURE_BUILD_KHR, A::SHADER_READ, L::UNDEFINED, false),
            Self::ColorAttachment => (
                S::COLOR_ATTACHMENT_OUTPUT,
                A::COLOR_ATTACHMENT_READ | A::COLOR_ATTACHMENT_WRITE,
                L::COLOR_ATTACHMENT_OPTIMAL,
                true,
            ),
            Self::DepthAttachment => (
                S::EARLY_FRAGMENT_TESTS | S::LATE_FRAGMENT_TESTS,
                A::DEPTH_STENCIL_ATTACHMENT_READ | A::DEPTH_STENCIL_ATTACHMENT_WRITE,
                L::DEPTH_STENCIL_ATTACHMENT_OPTIMAL,
                true,
            ),
        };
        Use { stage, access, layout, writes }
    }
}

/// A barrier to record before the next use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Barrier {
    pub src_stage: vk::PipelineStageFlags2,
    pub src_access: vk::AccessFlags2,
    pub dst_stage: vk::PipelineStageFlags2,
    pub dst_access: vk::AccessFlags2,
    pub old_layout: vk::ImageLayout,
    pub new_layout: vk::ImageLayout,
}

/// The last write of a resource and the stages that have read it since.
#[derive(Clone, Copy, Debug, Default)]
struct State {
    write_stage: vk::PipelineStageFlags2,
    write_access: vk::AccessFlags2,
    read_stages: vk::PipelineStageFlags2,
    layout: vk::ImageLayout,
}

/// The tracker of one resource. For buffers the layouts mean nothing and never differ.
#[derive(Debug, Default)]
pub(super) struct Tracker {
    // Uncontended: the lock only makes its owner `Sync`.
    state: Mutex<State>,
}

impl Tracker {
    /// Records the next use of a buffer; returns the barrier that it needs first, if any.
    pub(super) fn use_buffer(&self, access: Access) -> Option<Barrier> {
        let mut next = access.to_use(false);
        next.layout = vk::ImageLayout::UNDEFINED;
        self.plan(next)
    }

    /// Records the next use of an image; returns the barrier that it needs first, if any.
    pub(super) fn use_image(&self, access: Access, storage: bool) -> Option<Barrier> {
        self.plan(access.to_use(storage))
    }

    pub(super) fn layout(&self) -> vk::ImageLayout {
        self.state().layout
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn plan(&self, next: Use) -> Option<Barrier> {
        let mut state = self.state();
        let last = *state;
        let moves = last.layout != next.layout;
        let fresh = last.write_stage.is_empty() && last.read_stages.is_empty();
        let hazard = if next.writes {
            !fresh
        } else {
            !last.write_stage.is_empty() && !last.read_stages.contains(next.stage)
        };
        *state = if next.writes || moves {
            State {
                write_stage: next.stage,
                write_access: if next.writes { next.access } else { vk::AccessFlags2::empty() },
                read_stages: if next.writes { vk::PipelineStageFlags2::empty() } else { next.stage },
                layout: next.layout,
            }
        } else {
            State { read_stages: last.read_stages | next.stage, ..last }
        };
        (moves || hazard).then_some(Barrier {
            src_stage: last.write_stage | last.read_stages,
            src_access: last.write_access,
            dst_stage: next.stage,
            dst_access: next.access,
            old_layout: last.layout,
            new_layout: next.layout,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_after_one_write_wait_once_a_stage() {
        let tracker = Tracker::default();
        assert!(tracker.use_buffer(Access::TransferWrite).is_none(), "nothing came before");
        let first = tracker.use_buffer(Access::ComputeRead).expect("read after write");
        assert_eq!(first.src_access, vk::AccessFlags2::TRANSFER_WRITE);
        assert!(tracker.use_buffer(Access::ComputeRead).is_none(), "already visible");
        let other = tracker.use_buffer(Access::GraphicsRead).expect("another stage must wait too");
        assert!(other.src_stage.contains(vk::PipelineStageFlags2::ALL_TRANSFER));
    }

    #[test]
    fn writes_wait_for_all_readers() {
        let tracker = Tracker::default();
        tracker.use_buffer(Access::ComputeWrite);
        tracker.use_buffer(Access::GraphicsRead);
        let barrier = tracker.use_buffer(Access::ComputeWrite).expect("write after read");
        assert!(barrier.src_stage.contains(vk::PipelineStageFlags2::FRAGMENT_SHADER));
        assert!(tracker.use_buffer(Access::ComputeWrite).is_some(), "write after write");
    }

    #[test]
    fn an_image_changes_layout_even_between_reads() {
        let tracker = Tracker::default();
        assert!(tracker.use_image(Access::ColorAttachment, false).is_some(), "from undefined");
        assert!(tracker.use_image(Access::ComputeRead, false).is_some());
        assert!(tracker.use_image(Access::ComputeRead, false).is_none());
        let barrier = tracker.use_image(Access::TransferRead, false).expect("another layout");
        assert_eq!(barrier.old_layout, vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL);
        assert_eq!(barrier.new_layout, vk::ImageLayout::TRANSFER_SRC_OPTIMAL);
    }
}
