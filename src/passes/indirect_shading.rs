//! `indirect_shading`: the discontinuity filter, which joins the classes of each pixel's neighbourhood and writes the set
//! buffer.

use bytemuck::{Pod, Zeroable};

use std::sync::Arc;

use super::gbuffer::GBuffer;
use super::indirect_shadows::UploadedSet;
use super::set_history::SetHistory;
use crate::vulkan::{Buffer, ComputePipeline, Device, Frame, Upload, VulkanError, shaders};

/// What the pass reads.
pub struct IndirectShadingInputs<'a> {
    /// Frame uniforms.
    pub frame: &'a Upload,
    /// The visible surfaces.
    pub gbuffer: &'a GBuffer,
    /// The VPLs.
    pub set: &'a UploadedSet,
    /// Irradiance of each pixel from its class, and its surface.
    pub class_irradiance: &'a Buffer,
}

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Push {
    first_texel: u32,
    total_flux: f32,
    layer: u32,
}

/// The pass.
pub struct IndirectShadingPass {
    pipeline: ComputePipeline,
}

impl IndirectShadingPass {
    /// Makes the pipeline.
    pub fn new(device: &Arc<Device>, interleave: u32) -> Result<Self, VulkanError> {
        let spirv = shaders::DISCONTINUITY_FILTER_COMP;
        Ok(Self {
            pipeline: ComputePipeline::specialised(device, "discontinuity_filter", spirv, &[interleave])?,
        })
    }

    /// Filters into the spare layer of the set buffers.
    pub fn record(
        &self,
        frame: &mut Frame<'_>,
        inputs: &IndirectShadingInputs<'_>,
        sets: &SetHistory,
    ) -> Result<(), VulkanError> {
        // A thread for four pixels, one below the other.
        let [width, height] = sets.buffers().extent();
        let set = inputs.set;
        let push =
            Push { first_texel: set.first_texel(), total_flux: set.total_flux, layer: sets.spare_layer() };
        frame
            .pass("indirect_shading", &self.pipeline)
            .read("frame", inputs.frame)
            .read("gbuffer_normal", &inputs.gbuffer.normal)
            .read("class_irradiance", inputs.class_irradiance)
            .read("vpl_set", &inputs.set.texels)
            .write("set_buffers", sets.buffers())
            .push(&push)
            .dispatch_over([width, height.div_ceil(4)])
    }
}
