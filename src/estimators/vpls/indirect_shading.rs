//! `indirect_shading`: the discontinuity filter, which joins what the texels of a window have drawn, and writes the set buffer.

use std::sync::Arc;

use super::set_buffers::{SetBuffers, set_step};
use super::vpl_buffer::UploadedSet;
use crate::estimators::EstimatorInputs;
use crate::settings::VplSettings;
use crate::vulkan::{ComputePipeline, Device, Frame, Image, VulkanError, shaders};

/// The pass.
pub struct IndirectShadingPass {
    filter: ComputePipeline,
}

impl IndirectShadingPass {
    /// Makes the pipeline.
    pub fn new(device: &Arc<Device>, settings: &VplSettings) -> Result<Self, VulkanError> {
        let constants = [settings.interleave, set_step(settings)];
        let filter = shaders::INDIRECT_SHADING_COMP;
        Ok(Self { filter: ComputePipeline::specialised(device, "indirect_shading", filter, &constants)? })
    }

    /// Filters into the set's layer of the set buffers.
    pub fn record(
        &self,
        frame: &mut Frame<'_>,
        inputs: &EstimatorInputs<'_>,
        set: &UploadedSet,
        drawn_irradiance: &Image,
        sets: &SetBuffers,
    ) -> Result<(), VulkanError> {
        let pass = frame
            .pass("indirect_shading", &self.filter)
            .read("frame_uniforms", inputs.frame)
            .read("gbuffer_depth", &inputs.gbuffer.depth)
            .read("gbuffer_normal", &inputs.gbuffer.normal)
            .read("drawn_irradiance", drawn_irradiance)
            .write("set_buffers", sets.buffers());
        set.bind(pass).dispatch_over(sets.buffers().extent())
    }
}
