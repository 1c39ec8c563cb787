//! `indirect_shading`: the discontinuity filter, which joins what the texels of a window have rendered, and averages it with what the
//! set buffer holds of the turns before.

use std::sync::Arc;

use super::set_buffers::{SetBuffers, set_step};
use super::vpl_buffer::UploadedSet;
use crate::passes::frame_inputs::FrameInputs;
use crate::settings::{MissingSets, VplSettings};
use crate::vulkan::{ComputePipeline, Device, Frame, Image, VulkanError, shaders};

/// The pass.
pub struct IndirectShadingPass {
    filter: ComputePipeline,
}

/// Constants of the filter: `INTERLEAVE` and `SET_STEP` in shaders/estimators/vpls/discontinuity_filter.comp.
pub fn filter_constants(settings: &VplSettings) -> [u32; 2] {
    [settings.interleave, set_step(settings)]
}

impl IndirectShadingPass {
    /// Makes the pipeline, with the constants of [`filter_constants`] alone.
    pub fn new(device: &Arc<Device>, constants: &[u32; 2]) -> Result<Self, VulkanError> {
        let filter = shaders::DISCONTINUITY_FILTER_COMP;
        Ok(Self { filter: ComputePipeline::specialised(device, "discontinuity_filter", filter, constants)? })
    }

    /// Filters into the set's layer of the set buffers.
    pub fn record(
        &self,
        frame: &mut Frame<'_>,
        inputs: &FrameInputs<'_>,
        set: &UploadedSet,
        sampled_irradiance: &Image,
        sets: &SetBuffers,
    ) -> Result<(), VulkanError> {
        let pass = inputs
            .bind(frame.pass("discontinuity_filter", &self.filter))
            .read("gbuffer_instance", &inputs.gbuffer.instance)
            .read("sampled_irradiance", sampled_irradiance)
            .write("set_buffers", sets.buffers())
            .read("set_views", sets.views())
            .push(&sets.push(MissingSets::Dark, &[]));
        set.bind(pass).dispatch_over(sets.buffers().extent())
    }
}
