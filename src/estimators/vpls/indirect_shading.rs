//! `indirect_shading`: the discontinuity filter, which joins the classes of each pixel's neighbourhood and writes the set
//! buffer. Where too few classes lie on a surface, rays of its own gather the whole set.

use std::sync::Arc;

use super::set_buffers::{SetBuffers, set_step};
use super::vpl_buffer::UploadedSet;
use crate::estimators::EstimatorInputs;
use crate::passes::tracer::RayTracer;
use crate::settings::VplSettings;
use crate::vulkan::{ComputePipeline, Device, Frame, Image, VulkanError, shaders};

/// VPLs of all sets that a sparse window gathers, where there are so many: all at the default settings.
const ENOUGH_VPLS: u32 = 512;

/// The pass.
pub struct IndirectShadingPass {
    filter: ComputePipeline,
    sparse_windows: ComputePipeline,
    /// From one VPL that a sparse window gathers to the next.
    stride: u32,
}

impl IndirectShadingPass {
    /// Makes the pipelines for a tracer.
    pub fn new(device: &Arc<Device>, tracer: RayTracer, settings: &VplSettings) -> Result<Self, VulkanError> {
        let constants = [settings.interleave, set_step(settings)];
        let filter = shaders::INDIRECT_SHADING_COMP;
        let sparse_windows = tracer.of(shaders::SPARSE_WINDOWS_COMP);
        Ok(Self {
            filter: ComputePipeline::specialised(device, "indirect_shading", filter, &constants)?,
            sparse_windows: ComputePipeline::new(device, "sparse_windows", sparse_windows)?,
            stride: (settings.slots / ENOUGH_VPLS).max(1),
        })
    }

    /// Filters into the set's layer of the set buffers.
    pub fn record(
        &self,
        frame: &mut Frame<'_>,
        inputs: &EstimatorInputs<'_>,
        set: &UploadedSet,
        class_irradiance: &Image,
        sets: &SetBuffers,
    ) -> Result<(), VulkanError> {
        let extent = sets.buffers().extent();
        let pass = frame
            .pass("indirect_shading", &self.filter)
            .read("frame_uniforms", inputs.frame)
            .read("gbuffer_depth", &inputs.gbuffer.depth)
            .read("gbuffer_normal", &inputs.gbuffer.normal)
            .read("class_irradiance", class_irradiance)
            .write("set_buffers", sets.buffers());
        set.bind_classes(pass).dispatch_over(extent)?;
        let pass = frame
            .pass("indirect_shading", &self.sparse_windows)
            .read("frame_uniforms", inputs.frame)
            .read("gbuffer_depth", &inputs.gbuffer.depth)
            .read("gbuffer_normal", &inputs.gbuffer.normal)
            .write("set_buffers", sets.buffers())
            .write("ray_counters", &*set.ray_counters)
            .push(&[sets.step(), self.stride]);
        set.bind(inputs.tracer.bind(pass)).dispatch_over(extent)
    }
}
