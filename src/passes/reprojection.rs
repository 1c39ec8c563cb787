//! `reprojection`: where each visible surface was in the last frame, and which texels there showed it.

use std::sync::Arc;

use super::gbuffer::GBuffer;
use super::storage_image;
use crate::vulkan::{Buffer, ComputePipeline, Device, Frame, Image, Upload, VulkanError, shaders, vk};

/// What the pass reads.
pub struct ReprojectionInputs<'a> {
    /// Frame uniforms.
    pub frame: &'a Upload,
    /// Of the G-buffer, like the next three.
    pub depth: &'a Image,
    /// Shading and geometric normals.
    pub normal: &'a Image,
    /// Instances, plus one.
    pub instance: &'a Image,
    /// Motion, pixels.
    pub motion: &'a Image,
    /// Transforms of this frame and the last one.
    pub instances: &'a Buffer,
}

impl<'a> ReprojectionInputs<'a> {
    /// Those of a frame.
    pub fn of(frame: &'a Upload, gbuffer: &'a GBuffer, instances: &'a Buffer) -> Self {
        let GBuffer { depth, normal, instance, motion, .. } = gbuffer;
        Self { frame, depth, normal, instance, motion, instances }
    }
}

/// The pass.
pub struct ReprojectionPass {
    pipeline: ComputePipeline,
    /// Those of this frame and of the last one, in turns.
    surfaces: [Image; 2],
    reprojected: Image,
    /// Which of `surfaces` is the last frame's; none before the first.
    last: Option<usize>,
}

impl ReprojectionPass {
    /// Makes the pipeline, and the images of `extent` texels.
    pub fn new(device: &Arc<Device>, extent: [u32; 2]) -> Result<Self, VulkanError> {
        let surface = |name| storage_image(device, name, vk::Format::R16G16B16A16_UINT, extent);
        Ok(Self {
            pipeline: ComputePipeline::new(device, "reprojection", shaders::REPROJECTION_COMP)?,
            surfaces: [surface("surface 0")?, surface("surface 1")?],
            reprojected: storage_image(device, "reprojected", vk::Format::R16G16B16A16_SFLOAT, extent)?,
            last: None,
        })
    }

    /// What the last frame saw: depth, normal and instance, packed as in shaders/include/visible_surface.glsl.
    pub fn surface(&self) -> &Image {
        &self.surfaces[self.last.unwrap_or_default()]
    }

    /// xy: motion, pixels; z and w: which texels of the frame before show the surface, as in shaders/passes/reprojection.comp.
    pub fn reprojected(&self) -> &Image {
        &self.reprojected
    }

    /// Looks for every pixel.
    pub fn record(
        &mut self,
        frame: &mut Frame<'_>,
        inputs: &ReprojectionInputs<'_>,
    ) -> Result<(), VulkanError> {
        let last = self.last.unwrap_or_default();
        frame
            .pass("reprojection", &self.pipeline)
            .read("frame_uniforms", inputs.frame)
            .read("instances", inputs.instances)
            .read("gbuffer_depth", inputs.depth)
            .read("gbuffer_normal", inputs.normal)
            .read("gbuffer_instance", inputs.instance)
            .read("gbuffer_motion", inputs.motion)
            .read("last_surface", &self.surfaces[last])
            .write("surface", &self.surfaces[1 - last])
            .write("reprojected", &self.reprojected)
            .push(&u32::from(self.last.is_some()))
            .dispatch_over(self.reprojected.extent())?;
        self.last = Some(1 - last);
        Ok(())
    }
}
