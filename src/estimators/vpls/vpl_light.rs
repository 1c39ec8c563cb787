//! `vpl_light`: irradiance of every pixel by one VPL alone, for looking at VPLs one by one.

use std::sync::Arc;

use super::manager::GpuVpl;
use super::vpl_buffer::UploadedSet;
use crate::gpu_scene::tracer::TracerVariant;
use crate::passes::frame_inputs::FrameInputs;
use crate::passes::storage_image;
use crate::vulkan::{ComputePipeline, Device, Frame, Image, VulkanError, shaders, vk};

/// The pass.
pub struct VplLightPass {
    pipeline: ComputePipeline,
    light: Image,
}

impl VplLightPass {
    /// Makes the pipeline and its image, of `extent` texels.
    pub fn new(device: &Arc<Device>, tracer: TracerVariant, extent: [u32; 2]) -> Result<Self, VulkanError> {
        let pipeline = tracer.pipeline(device, "vpl_light", shaders::VPL_LIGHT_COMP, &[])?;
        Ok(Self { pipeline, light: light(device, extent)? })
    }

    /// Irradiance, weighted; a: 1 where the VPL sees the pixel.
    pub fn output(&self) -> &Image {
        &self.light
    }

    /// Casts a ray a pixel to a VPL whose irradiance is multiplied by `weight`; none: there is no light.
    pub fn record(
        &self,
        frame: &mut Frame<'_>,
        inputs: &FrameInputs<'_>,
        set: &UploadedSet,
        (vpl, weight): (Option<GpuVpl>, f32),
    ) -> Result<(), VulkanError> {
        let vpls = frame.upload(&[vpl.unwrap_or_default()])?;
        inputs
            .bind(frame.pass("vpl_light", &self.pipeline))
            .read("vpl_uniforms", &set.uniforms)
            .read("vpls", &vpls)
            .write("vpl_light", &self.light)
            .push(&if vpl.is_some() { weight } else { 0.0 })
            .dispatch_over(self.light.extent())
    }
}

fn light(device: &Arc<Device>, extent: [u32; 2]) -> Result<Image, VulkanError> {
    storage_image(device, "vpl_light", vk::Format::R16G16B16A16_SFLOAT, extent)
}
