//! Render targets and draw calls of a graphics pass.

use ash::vk;
use bytemuck::Pod;

use super::layout::MATERIAL_SET;
use super::{Buffer, Image, MaterialSets, Pass};

/// Render targets of a graphics pass.
pub enum Targets<'a> {
    /// Colour and depth, cleared to zero; reversed depth, 0 is infinitely far away.
    Cleared {
        /// Colour images.
        colors: &'a [&'a Image],
        /// Depth image.
        depth: &'a Image,
    },
    /// Loaded, without depth; for pipelines that blend.
    Over(&'a Image),
}

impl<'a> Targets<'a> {
    pub(super) fn colors(&self) -> &[&'a Image] {
        match self {
            Self::Cleared { colors, .. } => colors,
            Self::Over(image) => std::slice::from_ref(image),
        }
    }

    pub(super) fn depth(&self) -> Option<&'a Image> {
        match self {
            Self::Cleared { depth, .. } => Some(depth),
            Self::Over(_) => None,
        }
    }

    pub(super) fn extent(&self) -> [u32; 2] {
        match self {
            Self::Cleared { depth: image, .. } | Self::Over(image) => image.extent(),
        }
    }

    pub(super) fn load_op(&self) -> vk::AttachmentLoadOp {
        match self {
            Self::Cleared { .. } => vk::AttachmentLoadOp::CLEAR,
            Self::Over(_) => vk::AttachmentLoadOp::LOAD,
        }
    }
}

/// The draws of one graphics pass.
pub struct DrawList<'p> {
    pub(super) pass: &'p Pass<'p>,
}

impl DrawList<'_> {
    /// Sets viewport and scissor to all of the targets, of `extent` texels, without culling and bias.
    pub(super) fn viewport(&mut self, extent: [u32; 2]) {
        let [width, height] = extent.map(|side| side as f32);
        let viewport = vk::Viewport { x: 0.0, y: 0.0, width, height, min_depth: 0.0, max_depth: 1.0 };
        let scissor = vk::Rect2D { extent: extent2d(extent), ..Default::default() };
        self.cull(vk::CullModeFlags::NONE);
        self.depth_bias(0.0);
        // SAFETY: rendering is open; both are dynamic state of every graphics pipeline.
        unsafe {
            let raw = self.pass.recorder.device().raw();
            raw.cmd_set_viewport(self.pass.recorder.commands(), 0, &[viewport]);
            raw.cmd_set_scissor(self.pass.recorder.commands(), 0, &[scissor]);
        }
    }

    /// Leaves out triangles that show one of their sides in the draws that follow; counter-clockwise ones show their front.
    pub fn cull(&mut self, sides: vk::CullModeFlags) {
        // SAFETY: rendering is open; this is dynamic state of every graphics pipeline.
        unsafe {
            let raw = self.pass.recorder.device().raw();
            raw.cmd_set_cull_mode(self.pass.recorder.commands(), sides);
        }
    }

    /// In the draws that follow, adds to depth this many times what it changes by from pixel to pixel.
    pub fn depth_bias(&mut self, slopes: f32) {
        // SAFETY: rendering is open; this is dynamic state of every graphics pipeline.
        unsafe {
            let raw = self.pass.recorder.device().raw();
            raw.cmd_set_depth_bias(self.pass.recorder.commands(), 0.0, 0.0, slopes);
        }
    }

    /// Selects a variant of the pipeline for the draws that follow; initially the first.
    pub fn variant(&mut self, index: usize) {
        let point = vk::PipelineBindPoint::GRAPHICS;
        // SAFETY: all variants have the same layout and dynamic state, so what is bound and set stays.
        unsafe {
            let raw = self.pass.recorder.device().raw();
            raw.cmd_bind_pipeline(self.pass.recorder.commands(), point, self.pass.pipelines[index]);
        }
    }

    /// Binds the vertex buffer and the 32-bit index buffer.
    pub fn geometry(&mut self, vertices: &Buffer, indices: &Buffer) {
        // SAFETY: both buffers live until the frame is done and were filled before it.
        unsafe {
            let raw = self.pass.recorder.device().raw();
            let commands = self.pass.recorder.commands();
            raw.cmd_bind_vertex_buffers(commands, 0, &[vertices.raw], &[0]);
            raw.cmd_bind_index_buffer(commands, indices.raw, 0, vk::IndexType::UINT32);
        }
    }

    /// Binds the textures of a material.
    pub fn material(&mut self, sets: &MaterialSets, index: usize) {
        // SAFETY: the set was made for this set of a pipeline with this layout.
        unsafe {
            self.pass.recorder.device().raw().cmd_bind_descriptor_sets(
                self.pass.recorder.commands(),
                vk::PipelineBindPoint::GRAPHICS,
                self.pass.layout.raw,
                MATERIAL_SET,
                &[sets.sets[index]],
                &[],
            );
        }
    }

    /// Draws `count` indices, starting at `first`, with these push constants.
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

    /// Draws `instances` instances of `count` vertices without a vertex buffer.
    pub fn draw_made_up(&mut self, count: u32, instances: u32) {
        // SAFETY: the pipeline takes no vertex buffer.
        unsafe {
            let raw = self.pass.recorder.device().raw();
            raw.cmd_draw(self.pass.recorder.commands(), count, instances, 0, 0);
        }
    }
}

pub(super) fn extent2d([width, height]: [u32; 2]) -> vk::Extent2D {
    vk::Extent2D { width, height }
}
