//! `vpl_light`: what one VPL alone sends to every pixel, for looking at VPLs one by one.

use std::sync::Arc;

use super::gbuffer::GBuffer;
use super::storage_image;
use super::tracer::{RayTracer, Tracer};
use crate::vpl::GpuVpl;
use crate::vulkan::{ComputePipeline, Device, Frame, Image, Upload, VulkanError, shaders, vk};

/// What the pass reads.
pub struct VplLightInputs<'a> {
    /// Frame uniforms.
    pub frame: &'a Upload,
    /// The visible surfaces.
    pub gbuffer: &'a GBuffer,
    /// What casts the rays.
    pub tracer: &'a Tracer,
    /// The VPL; none: there is no light.
    pub vpl: Option<GpuVpl>,
    /// What its irradiance is multiplied by.
    pub weight: f32,
}

/// The pass.
pub struct VplLightPass {
    pipeline: Arc<ComputePipeline>,
    light: Image,
}

impl VplLightPass {
    /// Makes the pipeline and its image, of `extent` texels.
    pub fn new(device: &Arc<Device>, tracer: RayTracer, extent: [u32; 2]) -> Result<Self, VulkanError> {
        let pipeline = ComputePipeline::new(device, "vpl_light", tracer.of(shaders::VPL_LIGHT_COMP))?;
        Ok(Self { pipeline: Arc::new(pipeline), light: light(device, extent)? })
    }

    /// The same pass for pictures of `extent` texels.
    pub fn resized(&self, device: &Arc<Device>, extent: [u32; 2]) -> Result<Self, VulkanError> {
        Ok(Self { pipeline: Arc::clone(&self.pipeline), light: light(device, extent)? })
    }

    /// Casts a ray a pixel. Gives the weighted irradiance; a: 1 where the VPL sees the pixel.
    pub fn record(&self, frame: &mut Frame<'_>, inputs: &VplLightInputs<'_>) -> Result<&Image, VulkanError> {
        let vpls = frame.upload(&[inputs.vpl.unwrap_or_default()])?;
        let pass = frame
            .pass("vpl_light", &self.pipeline)
            .read("frame_uniforms", inputs.frame)
            .read("gbuffer_depth", &inputs.gbuffer.depth)
            .read("gbuffer_normal", &inputs.gbuffer.normal)
            .read("vpls", &vpls)
            .write("vpl_light", &self.light)
            .push(&if inputs.vpl.is_some() { inputs.weight } else { 0.0 });
        inputs.tracer.bind(pass).dispatch_over(self.light.extent())?;
        Ok(&self.light)
    }
}

fn light(device: &Arc<Device>, extent: [u32; 2]) -> Result<Image, VulkanError> {
    storage_image(device, "vpl_light", vk::Format::R32G32B32A32_SFLOAT, extent)
}
