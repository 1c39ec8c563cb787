//! `overlay`: lines and points in world space, drawn over what is displayed. Parts that surfaces hide are
//! dimmed, not dropped.

use std::sync::Arc;

use glam::Vec3;
use serde::{Deserialize, Serialize};

use crate::gpu_scene::structs::OverlayLine;
use crate::gpu_scene::to_u32;
use crate::vulkan::{
    Device, Frame, GraphicsDescription, GraphicsPipeline, Image, Targets, Upload, VulkanError, shaders, vk,
};

/// A straight line with round ends; one of no length is a point.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Line {
    /// World position of one end.
    pub from: Vec3,
    /// World position of the other.
    pub to: Vec3,
    /// Red, green and blue as display values, and opacity; 0 to 1.
    pub colour: [f32; 4],
    /// Width, or diameter of a point, in pixels.
    pub width: f32,
    /// Factor on the opacity of hidden parts: 1 shows them as the rest, 0 not at all.
    pub hidden: f32,
}

impl Line {
    /// A point; see the fields.
    pub fn point(at: Vec3, colour: [f32; 4], width: f32, hidden: f32) -> Self {
        Self { from: at, to: at, colour, width, hidden }
    }
}

/// The pass.
pub struct OverlayPass {
    pipeline: GraphicsPipeline,
}

impl OverlayPass {
    /// Makes the pipeline.
    pub fn new(device: &Arc<Device>) -> Result<Self, VulkanError> {
        let description = GraphicsDescription {
            name: "overlay",
            vertex: shaders::OVERLAY_VERT,
            fragment: shaders::OVERLAY_FRAG,
            vertex_stride: 0,
            attributes: &[],
            colors: &[vk::Format::R8G8B8A8_UNORM],
            blend: true,
            variants: &[0],
        };
        Ok(Self { pipeline: GraphicsPipeline::new(device, &description)? })
    }

    /// Draws `lines` one after the other over `display`; `depth` is that of the G-buffer.
    pub fn record(
        &self,
        frame: &mut Frame<'_>,
        uniforms: &Upload,
        lines: &[Line],
        depth: &Image,
        display: &Image,
    ) -> Result<(), VulkanError> {
        if lines.is_empty() {
            return Ok(());
        }
        let data: Vec<OverlayLine> = lines.iter().map(overlay_line).collect();
        let upload = frame.upload(&data)?;
        frame
            .draw_pass("overlay", &self.pipeline)
            .read("frame_uniforms", uniforms)
            .read("lines", &upload)
            .read("gbuffer_depth", depth)
            .draw(&Targets::Over(display), |list| {
                list.draw_made_up(6, to_u32(data.len()));
            })
    }
}

fn overlay_line(line: &Line) -> OverlayLine {
    OverlayLine {
        from_width: line.from.extend(line.width),
        to_hidden: line.to.extend(line.hidden),
        colour: line.colour.into(),
    }
}
