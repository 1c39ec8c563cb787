//! `indirect_reprojection`: all set buffers into the current view, each by the camera and the instance
//! transforms of the frame that drew it (algorithm 4 of Tonna 2019).
//!
//! Set buffers of half the resolution are added up for one pixel of four, then upsampled along surfaces. So the cost for each
//! set is a quarter of what every pixel would take.

use std::sync::Arc;

use super::set_buffers::{SetBuffers, SetPush};
use super::vpl_buffer::UploadedSet;
use crate::estimators::EstimatorInputs;
use crate::passes::storage_image;
use crate::vulkan::{ComputePipeline, Device, Frame, Image, Pass, VulkanError, shaders, vk};

/// The pass.
pub struct IndirectReprojectionPass {
    coarse: Arc<ComputePipeline>,
    full: Arc<ComputePipeline>,
    coarse_irradiance: Image,
    irradiance: Image,
}

impl IndirectReprojectionPass {
    /// Makes the pipelines, and the images for pictures of `extent` texels.
    pub fn new(device: &Arc<Device>, extent: [u32; 2]) -> Result<Self, VulkanError> {
        let pipeline = |name, spirv| Ok(Arc::new(ComputePipeline::new(device, name, spirv)?));
        let coarse = pipeline("coarse_reprojection", shaders::COARSE_REPROJECTION_COMP)?;
        let full = pipeline("indirect_reprojection", shaders::INDIRECT_REPROJECTION_COMP)?;
        Self::of(device, coarse, full, extent)
    }

    /// The same pass for pictures of `extent` texels.
    pub fn resized(&self, device: &Arc<Device>, extent: [u32; 2]) -> Result<Self, VulkanError> {
        Self::of(device, Arc::clone(&self.coarse), Arc::clone(&self.full), extent)
    }

    fn of(
        device: &Arc<Device>,
        coarse: Arc<ComputePipeline>,
        full: Arc<ComputePipeline>,
        extent: [u32; 2],
    ) -> Result<Self, VulkanError> {
        let image = |name, extent| storage_image(device, name, vk::Format::R32G32B32A32_SFLOAT, extent);
        Ok(Self {
            coarse,
            full,
            coarse_irradiance: image("coarse_irradiance", extent.map(|side| side.div_ceil(2)))?,
            irradiance: image("irradiance", extent)?,
        })
    }

    /// Indirect irradiance of the last frame; a: how many sets had seen the pixel's surface.
    pub fn output(&self) -> &Image {
        &self.irradiance
    }

    /// Brings all sets together.
    pub fn record(
        &self,
        frame: &mut Frame<'_>,
        inputs: &EstimatorInputs<'_>,
        set: &UploadedSet,
        (sets, push): (&SetBuffers, &SetPush),
    ) -> Result<(), VulkanError> {
        if sets.step() == 2 {
            let pass = frame.pass("indirect_reprojection", &self.coarse).push(push);
            bind(pass, inputs, set, sets)
                .write("coarse_irradiance", &self.coarse_irradiance)
                .dispatch_over(self.coarse_irradiance.extent())?;
        }
        let pass = frame.pass("indirect_reprojection", &self.full).push(push);
        bind(pass, inputs, set, sets)
            .read("coarse_irradiance", &self.coarse_irradiance)
            .write("irradiance", &self.irradiance)
            .dispatch_over(self.irradiance.extent())
    }
}

/// Binds what both shaders read.
fn bind<'f>(
    pass: Pass<'f>,
    inputs: &'f EstimatorInputs<'_>,
    set: &'f UploadedSet,
    sets: &'f SetBuffers,
) -> Pass<'f> {
    let pass = pass
        .read("frame_uniforms", inputs.frame)
        .read("gbuffer_depth", &inputs.gbuffer.depth)
        .read("gbuffer_normal", &inputs.gbuffer.normal)
        .read("gbuffer_instance", &inputs.gbuffer.instance);
    sets.bind(set.bind(pass), &inputs.instances.data)
}
