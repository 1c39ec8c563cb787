//! SSPSF: the mean over 9 x 9 pixels that see about the same surface (Meijer 2019, section 4.1).

use std::sync::Arc;

use super::{WINDOW_PASS, pixel_spread};
use crate::passes::frame_inputs::FrameInputs;
use crate::passes::storage_image;
use crate::vulkan::{ComputePipeline, Device, Frame, Image, VulkanError, shaders, vk};

/// The filter: 8 bytes a pixel.
pub struct WindowFilter {
    pipeline: ComputePipeline,
    filtered: Image,
}

impl WindowFilter {
    pub(super) fn new(device: &Arc<Device>, extent: [u32; 2]) -> Result<Self, VulkanError> {
        Ok(Self {
            pipeline: ComputePipeline::new(device, WINDOW_PASS.name, shaders::SSPSF_COMP)?,
            filtered: storage_image(device, "filtered", vk::Format::R16G16B16A16_SFLOAT, extent)?,
        })
    }

    pub(super) fn output(&self) -> &Image {
        &self.filtered
    }

    pub(super) fn record(
        &self,
        frame: &mut Frame<'_>,
        inputs: &FrameInputs<'_>,
        irradiance: &Image,
    ) -> Result<(), VulkanError> {
        let extent = self.filtered.extent();
        frame
            .pass(WINDOW_PASS.name, &self.pipeline)
            .read("frame_uniforms", inputs.uniforms)
            .read("gbuffer_depth", &inputs.gbuffer.depth)
            .read("gbuffer_normal", &inputs.gbuffer.normal)
            .read("irradiance", irradiance)
            .write("filtered", &self.filtered)
            .push(&pixel_spread(inputs, extent))
            .dispatch_over(extent)
    }
}
