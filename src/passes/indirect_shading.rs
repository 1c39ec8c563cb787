//! `indirect_shading`: irradiance of the frame's set from its visible VPLs, then the discontinuity filter,
//! which joins the classes of each pixel's neighbourhood and writes the set buffer.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};

use super::gbuffer::GBuffer;
use super::indirect_shadows::{Chunk, UploadedSet};
use super::set_history::SetHistory;
use super::storage_image;
use crate::vulkan::{Buffer, ComputePipeline, Device, Frame, Image, Upload, VulkanError, shaders, vk};

/// What the pass reads.
pub struct IndirectShadingInputs<'a> {
    /// Frame uniforms.
    pub frame: &'a Upload,
    /// The visible surfaces.
    pub gbuffer: &'a GBuffer,
    /// The VPLs.
    pub set: &'a UploadedSet,
    /// One bit a pixel and VPL.
    pub visibility: &'a Buffer,
}

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct FilterPush {
    total_flux: f32,
    layer: u32,
}

/// The pass.
pub struct IndirectShadingPass {
    gather: Arc<ComputePipeline>,
    filter: Arc<ComputePipeline>,
    class_irradiance: Image,
}

impl IndirectShadingPass {
    /// Makes the pipelines and the image, of `extent` texels.
    pub fn new(device: &Arc<Device>, extent: [u32; 2], interleave: u32) -> Result<Self, VulkanError> {
        let pipeline =
            |name, spirv| Ok(Arc::new(ComputePipeline::specialised(device, name, spirv, &[interleave])?));
        Ok(Self {
            gather: pipeline("indirect_shading", shaders::INDIRECT_SHADING_COMP)?,
            filter: pipeline("discontinuity_filter", shaders::DISCONTINUITY_FILTER_COMP)?,
            class_irradiance: class_irradiance(device, extent)?,
        })
    }

    /// The same pass for pictures of `extent` texels.
    pub fn resized(&self, device: &Arc<Device>, extent: [u32; 2]) -> Result<Self, VulkanError> {
        Ok(Self {
            gather: Arc::clone(&self.gather),
            filter: Arc::clone(&self.filter),
            class_irradiance: class_irradiance(device, extent)?,
        })
    }

    /// Adds up the VPLs of one chunk.
    pub fn gather(
        &self,
        frame: &mut Frame<'_>,
        inputs: &IndirectShadingInputs<'_>,
        chunk: &Chunk,
    ) -> Result<(), VulkanError> {
        frame
            .pass("indirect_shading", &self.gather)
            .read("frame", inputs.frame)
            .read("gbuffer_position", &inputs.gbuffer.position)
            .read("gbuffer_normal", &inputs.gbuffer.normal)
            .read("vpls", &inputs.set.vpls)
            .read("class_starts", &inputs.set.class_starts)
            .read("visibility", inputs.visibility)
            .write("class_irradiance", &self.class_irradiance)
            .push(chunk)
            .dispatch_over(self.class_irradiance.extent())
    }

    /// Irradiance of each pixel's class as bits of floats; a: its surface, packed.
    pub fn unfiltered(&self) -> &Image {
        &self.class_irradiance
    }

    /// Filters into the spare layer of the set buffers.
    pub fn filter(
        &self,
        frame: &mut Frame<'_>,
        inputs: &IndirectShadingInputs<'_>,
        sets: &SetHistory,
    ) -> Result<(), VulkanError> {
        let push = FilterPush { total_flux: inputs.set.total_flux, layer: sets.spare_layer() };
        frame
            .pass("indirect_shading", &self.filter)
            .read("frame", inputs.frame)
            .read("gbuffer_normal", &inputs.gbuffer.normal)
            .read("class_irradiance", &self.class_irradiance)
            .read("class_flux", &inputs.set.class_flux)
            .write("set_buffers", sets.buffers())
            .push(&push)
            .dispatch_over(sets.buffers().extent())
    }
}

fn class_irradiance(device: &Arc<Device>, extent: [u32; 2]) -> Result<Image, VulkanError> {
    storage_image(device, "class_irradiance", vk::Format::R32G32B32A32_UINT, extent)
}
