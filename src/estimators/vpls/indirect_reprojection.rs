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

/// Texels between the taps of the filter, step by step.
const FILTER_STEPS: [i32; 3] = [1, 2, 4];

/// The pass.
pub struct IndirectReprojectionPass {
    sum: ComputePipeline,
    filter: ComputePipeline,
    full: ComputePipeline,
    /// Irradiance and its variance, at half the resolution: before and after a step of the filter, in turns.
    coarse: [(Image, Image); 2],
    irradiance: Image,
}

impl IndirectReprojectionPass {
    /// Makes the pipelines, and the images for pictures of `extent` texels.
    pub fn new(device: &Arc<Device>, extent: [u32; 2]) -> Result<Self, VulkanError> {
        let pipeline = |name, spirv| ComputePipeline::new(device, name, spirv);
        let sum = pipeline("coarse_reprojection", shaders::COARSE_REPROJECTION_COMP)?;
        let filter = pipeline("variance_filter", shaders::VARIANCE_FILTER_COMP)?;
        let full = pipeline("indirect_reprojection", shaders::INDIRECT_REPROJECTION_COMP)?;
        let half = extent.map(|side| side.div_ceil(2));
        let irradiance = |name, extent| storage_image(device, name, vk::Format::R32G32B32A32_SFLOAT, extent);
        let coarse = || -> Result<_, VulkanError> {
            let variance = storage_image(device, "coarse_variance", vk::Format::R32_SFLOAT, half)?;
            Ok((irradiance("coarse_irradiance", half)?, variance))
        };
        Ok(Self {
            sum,
            filter,
            full,
            coarse: [coarse()?, coarse()?],
            irradiance: irradiance("irradiance", extent)?,
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
        let [from, to] = &self.coarse;
        let (mut noisy, mut filtered) = (from, to);
        if sets.step() == 2 {
            let extent = noisy.0.extent();
            let pass = frame.pass("indirect_reprojection", &self.sum).push(push);
            bind(pass, inputs, set, sets)
                .write("coarse_irradiance", &noisy.0)
                .write("coarse_variance", &noisy.1)
                .dispatch_over(extent)?;
            for step in FILTER_STEPS {
                let pass = frame
                    .pass("indirect_reprojection", &self.filter)
                    .read("frame_uniforms", inputs.frame)
                    .read("gbuffer_depth", &inputs.gbuffer.depth)
                    .read("gbuffer_normal", &inputs.gbuffer.normal)
                    .read("noisy_irradiance", &noisy.0)
                    .read("noisy_variance", &noisy.1)
                    .write("coarse_irradiance", &filtered.0)
                    .write("coarse_variance", &filtered.1)
                    .push(&step);
                set.bind(pass).dispatch_over(extent)?;
                std::mem::swap(&mut noisy, &mut filtered);
            }
        }
        let pass = frame.pass("indirect_reprojection", &self.full).push(push);
        bind(pass, inputs, set, sets)
            .read("coarse_irradiance", &noisy.0)
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
