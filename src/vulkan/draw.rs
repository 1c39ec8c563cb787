//! What a graphics pass draws into, and its draws.

use ash::vk;
use bytemuck::Pod;

use super::{Area, Buffer, Image, MaterialSets, Pass};

/// Images that a graphics pass draws into.
pub enum Targets<'a> {
    /// Colour and depth.
    Surfaces {
        /// Colour images.
        colors: &'a [&'a Image],
        /// Depth image.
        depth: &'a Image,
        /// The only part of them that is drawn into.
        area: Area,
        /// Whether it is set to zero first; depth 0 is infinitely far away.
        clear: bool,
    },
    /// Only depth.
    Depth {
        /// Its image.
        depth: &'a Image,
        /// The only part of it that is drawn into.
        area: Area,
        /// Whether it is set to zero first.
        clear: bool,
    },
    /// Drawn over, without a depth image; for pipelines that blend.
    Over(&'a Image),
}

impl<'a> Targets<'a> {
    pub(super) fn colors(&self) -> &[&'a Image] {
        match self {
            Self::Surfaces { colors, .. } => colors,
            Self::Depth { .. } => &[],
            Self::Over(image) => std::slice::from_ref(image),
        }
    }

    pub(super) fn depth(&self) -> Option<&'a Image> {
        match self {
            Self::Surfaces { depth, .. } | Self::Depth { depth, .. } => Some(depth),
            Self::Over(_) => None,
        }
    }

    pub(super) fn extent(&self) -> [u32; 2] {
        match self {
            Self::Surfaces { depth: image, .. } | Self::Depth { depth: image, .. } | Self::Over(image) => {
                image.extent()
            }
        }
    }

    pub(super) fn area(&self) -> Area {
        match self {
            Self::Surfaces { area, .. } | Self::Depth { area, .. } => *area,
            Self::Over(image) => Area::whole(image.extent()),
        }
    }

    pub(super) fn load_op(&self) -> vk::AttachmentLoadOp {
        match self {
            Self::Surfaces { clear: true, .. } | Self::Depth { clear: true, .. } => {
                vk::AttachmentLoadOp::CLEAR
            }
            _ => vk::AttachmentLoadOp::LOAD,
        }
    }
}

/// The draws of one graphics pass.
pub struct DrawList<'p> {
    pub(super) pass: &'p Pass<'p>,
    /// Which side is left out; none before that is set.
    pub(super) culled: Option<vk::CullModeFlags>,
}

impl DrawList<'_> {
    /// Fills this rectangle of the targets with clip space from now on; of what lies there, only what lies in `area` is drawn.
    pub fn viewport(&mut self, rectangle: Area, area: Area) {
        let [[x, y], [width, height]] =
            [rectangle.offset, rectangle.extent].map(|sides| sides.map(|side| side as f32));
        let viewport = vk::Viewport { x, y, width, height, min_depth: 0.0, max_depth: 1.0 };
        // SAFETY: rendering is open; both are dynamic state of every graphics pipeline.
        unsafe {
            let raw = self.pass.recorder.device().raw();
            raw.cmd_set_viewport(self.pass.recorder.commands(), 0, &[viewport]);
            raw.cmd_set_scissor(self.pass.recorder.commands(), 0, &[area.raw()]);
        }
    }

    /// Leaves out triangles that show this side, from now on; at first none.
    pub fn cull(&mut self, side: vk::CullModeFlags) {
        if self.culled.replace(side) == Some(side) {
            return;
        }
        // SAFETY: rendering is open; this is dynamic state of every graphics pipeline.
        unsafe {
            self.pass.recorder.device().raw().cmd_set_cull_mode(self.pass.recorder.commands(), side);
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
