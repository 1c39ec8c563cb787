//! What a graphics pass draws into, and its draws.

use ash::vk;
use bytemuck::Pod;

use super::{Buffer, Image, MaterialSets, Pass};

/// Images that a graphics pass draws into.
pub enum Targets<'a> {
    /// Cleared to zero first; depth 0 is infinitely far away.
    Cleared {
        /// Colour images.
        colors: &'a [&'a Image],
        /// Depth image.
        depth: &'a Image,
    },
    /// Only depth, and only this much of it from the top left; cleared first.
    DepthPart(&'a Image, [u32; 2]),
    /// Drawn over, without a depth image; for pipelines that blend.
    Over(&'a Image),
}

impl<'a> Targets<'a> {
    pub(super) fn colors(&self) -> &[&'a Image] {
        match self {
            Self::Cleared { colors, .. } => colors,
            Self::DepthPart(..) => &[],
            Self::Over(image) => std::slice::from_ref(image),
        }
    }

    pub(super) fn depth(&self) -> Option<&'a Image> {
        match self {
            Self::Cleared { depth, .. } | Self::DepthPart(depth, _) => Some(depth),
            Self::Over(_) => None,
        }
    }

    pub(super) fn extent(&self) -> [u32; 2] {
        match self {
            Self::Cleared { depth, .. } => depth.extent(),
            Self::DepthPart(_, part) => *part,
            Self::Over(image) => image.extent(),
        }
    }

    pub(super) fn load_op(&self) -> vk::AttachmentLoadOp {
        match self {
            Self::Cleared { .. } | Self::DepthPart(..) => vk::AttachmentLoadOp::CLEAR,
            Self::Over(_) => vk::AttachmentLoadOp::LOAD,
        }
    }
}

/// The draws of one graphics pass.
pub struct DrawList<'p> {
    pub(super) pass: &'p Pass<'p>,
}

impl DrawList<'_> {
    /// Draws into a part of the targets from now on.
    pub fn viewport(&mut self, offset: [u32; 2], extent: [u32; 2]) {
        let viewport = vk::Viewport {
            x: offset[0] as f32,
            y: offset[1] as f32,
            width: extent[0] as f32,
            height: extent[1] as f32,
            min_depth: 0.0,
            max_depth: 1.0,
        };
        let scissor = vk::Rect2D {
            offset: vk::Offset2D {
                x: i32::try_from(offset[0]).unwrap_or(0),
                y: i32::try_from(offset[1]).unwrap_or(0),
            },
            extent: vk::Extent2D { width: extent[0], height: extent[1] },
        };
        // SAFETY: rendering is open; both are dynamic state of every graphics pipeline.
        unsafe {
            let raw = self.pass.recorder.device().raw();
            raw.cmd_set_viewport(self.pass.recorder.commands(), 0, &[viewport]);
            raw.cmd_set_scissor(self.pass.recorder.commands(), 0, &[scissor]);
        }
    }

    /// Draws with this variant of the pipeline from now on; at first it is the first.
    pub fn variant(&mut self, index: usize) {
        let point = vk::PipelineBindPoint::GRAPHICS;
        // SAFETY: all variants have the same layout and dynamic state, so what is bound and set stays.
        unsafe {
            let raw = self.pass.recorder.device().raw();
            raw.cmd_bind_pipeline(self.pass.recorder.commands(), point, self.pass.pipelines[index]);
        }
    }

    /// Takes vertices and 32-bit indices from here on.
    pub fn geometry(&mut self, vertices: &Buffer, indices: &Buffer) {
        // SAFETY: both buffers live until the frame is done and were filled before it.
        unsafe {
            let raw = self.pass.recorder.device().raw();
            let commands = self.pass.recorder.commands();
            raw.cmd_bind_vertex_buffers(commands, 0, &[vertices.raw], &[0]);
            raw.cmd_bind_index_buffer(commands, indices.raw, 0, vk::IndexType::UINT32);
        }
    }

    /// Uses the textures of a material from now on.
    pub fn material(&mut self, sets: &MaterialSets, index: usize) {
        // SAFETY: the set was made for set 1 of a pipeline with this layout.
        unsafe {
            self.pass.recorder.device().raw().cmd_bind_descriptor_sets(
                self.pass.recorder.commands(),
                vk::PipelineBindPoint::GRAPHICS,
                self.pass.layout.raw,
                1,
                &[sets.sets[index]],
                &[],
            );
        }
    }

    /// Draws `count` indices from `first` on with these push constants.
    pub fn draw<T: Pod>(&mut self, constants: &T, first: u32, count: u32) {
        let bytes = bytemuck::bytes_of(constants);
        assert_eq!(
            bytes.len(),
            self.pass.layout.reflection.push_size as usize,
            "push constants of pass {}",
            self.pass.name
        );
        // SAFETY: the indices lie within the bound buffers, which the scene's upload made together.
        unsafe {
            let raw = self.pass.recorder.device().raw();
            let commands = self.pass.recorder.commands();
            raw.cmd_push_constants(commands, self.pass.layout.raw, self.pass.layout.stages, 0, bytes);
            raw.cmd_draw_indexed(commands, count, 1, first, 0, 0);
        }
    }
    /// Draws `instances` times `count` vertices that the shader makes up itself.
    pub fn draw_made_up(&mut self, count: u32, instances: u32) {
        // SAFETY: the pipeline takes no vertex buffer.
        unsafe {
            let raw = self.pass.recorder.device().raw();
            raw.cmd_draw(self.pass.recorder.commands(), count, instances, 0, 0);
        }
    }
}
