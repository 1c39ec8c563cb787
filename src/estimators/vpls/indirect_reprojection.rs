//! `indirect_reprojection`: all set buffers into the current view, each by the camera and the instance
//! transforms of the frame that rendered it (algorithm 4 of Tonna 2019).
//!
//! Set buffers of half the resolution are added up for one pixel of four (`set_reprojection`), denoised, then upsampled along
//! surfaces (`irradiance_upsampling`). So the cost for each set is a quarter of what every pixel would take.

use std::sync::Arc;

use super::set_buffers::{SetBuffers, SetPush};
use super::vpl_buffer::UploadedSet;
use crate::passes::frame_inputs::FrameInputs;
use crate::passes::storage_image;
use crate::vulkan::{ComputePipeline, Device, Frame, Image, Pass, VulkanError, shaders, vk};

/// The passes.
pub struct IndirectReprojectionPass {
    sum: ComputePipeline,
    upsample: ComputePipeline,
    /// The sum of all sets at half the resolution; a: how many sets had seen the surface.
    pub coarse_irradiance: Image,
    /// The variance of its luminance.
    pub coarse_variance: Image,
    irradiance: Image,
}

impl IndirectReprojectionPass {
    /// Makes the pipelines, and the images for pictures of `extent` texels: 11 bytes a pixel.
    pub fn new(device: &Arc<Device>, extent: [u32; 2]) -> Result<Self, VulkanError> {
        let pipeline = |name, spirv| ComputePipeline::new(device, name, spirv);
        let half = extent.map(|side| side.div_ceil(2));
        let halves = vk::Format::R16G16B16A16_SFLOAT;
        Ok(Self {
            sum: pipeline("set_reprojection", shaders::SET_REPROJECTION_COMP)?,
            upsample: pipeline("irradiance_upsampling", shaders::IRRADIANCE_UPSAMPLING_COMP)?,
            coarse_irradiance: storage_image(device, "coarse_irradiance", halves, half)?,
            coarse_variance: storage_image(device, "coarse_variance", vk::Format::R32_SFLOAT, half)?,
            irradiance: storage_image(device, "irradiance", halves, extent)?,
        })
    }

    /// Indirect irradiance of the last frame; a: how many sets had seen the pixel's surface.
    pub fn output(&self) -> &Image {
        &self.irradiance
    }

    /// Adds up sets of half the resolution.
    pub fn add_up(
        &self,
        frame: &mut Frame<'_>,
        inputs: &FrameInputs<'_>,
        set: &UploadedSet,
        (sets, push): (&SetBuffers, &SetPush),
    ) -> Result<(), VulkanError> {
        let pass = frame.pass("set_reprojection", &self.sum).push(push);
        bind(pass, inputs, set, sets)
            .write("coarse_irradiance", &self.coarse_irradiance)
            .write("coarse_variance", &self.coarse_variance)
            .dispatch_over(self.coarse_irradiance.extent())
    }

    /// Gives every pixel its irradiance: from the denoised sum, or from sets of the full resolution themselves.
    pub fn upsample(
        &self,
        frame: &mut Frame<'_>,
        inputs: &FrameInputs<'_>,
        set: &UploadedSet,
        (sets, push): (&SetBuffers, &SetPush),
        denoised: &Image,
    ) -> Result<(), VulkanError> {
        let pass = frame.pass("irradiance_upsampling", &self.upsample).push(push);
        bind(pass, inputs, set, sets)
            .read("coarse_irradiance", denoised)
            .write("irradiance", &self.irradiance)
            .dispatch_over(self.irradiance.extent())
    }
}

/// Binds what both shaders read.
fn bind<'f>(
    pass: Pass<'f>,
    inputs: &'f FrameInputs<'_>,
    set: &'f UploadedSet,
    sets: &'f SetBuffers,
) -> Pass<'f> {
    let pass = inputs.bind(pass).read("gbuffer_instance", &inputs.gbuffer.instance);
    sets.bind(set.bind(pass))
}
