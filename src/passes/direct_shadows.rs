//! `direct_shadows`: visibility of each light from each pixel, by one ray for each light that it faces.
//!
//! In: the visible surfaces and the lights. Out: a bit for each light or, in scenes with thin surfaces, the colour that these let
//! pass. Rays need no bias that would leak light through walls without thickness or lose shadows under a grazing light.

use std::sync::Arc;

use super::frame_inputs::FrameInputs;
use super::storage_image_array;
use crate::gpu_scene::tracer::TracerVariant;
use crate::vulkan::{ComputePipeline, Device, Frame, Image, VulkanError, shaders, vk};

/// Lights in a texel of one layer. Twin: `LIGHTS_PER_LAYER` in shaders/include/lights.glsl.
fn lights_per_layer(thin_surfaces: bool) -> u32 {
    if thin_surfaces { 1 } else { 32 }
}

/// The pass.
pub struct DirectShadowsPass {
    tracer: TracerVariant,
    pipeline: ComputePipeline,
    /// Bit i of layer l: whether the pixel sees light 32 l + i; with thin surfaces, layer i: the transmittance towards light i, packed.
    visibility: Image,
    device: Arc<Device>,
}

impl DirectShadowsPass {
    /// Makes the pipeline for a tracer, and the image of `extent` texels.
    pub fn new(device: &Arc<Device>, tracer: TracerVariant, extent: [u32; 2]) -> Result<Self, VulkanError> {
        let pipeline = tracer.pipeline(device, "direct_shadows", shaders::DIRECT_SHADOWS_COMP, &[])?;
        Ok(Self { tracer, pipeline, visibility: visibility(device, extent, 1)?, device: Arc::clone(device) })
    }

    /// The masks of the last frame.
    pub fn output(&self) -> &Image {
        &self.visibility
    }

    /// Casts the rays.
    pub fn record(
        &mut self,
        frame: &mut Frame<'_>,
        inputs: &FrameInputs<'_>,
        light_count: u32,
    ) -> Result<&Image, VulkanError> {
        self.make_room(light_count)?;
        if light_count > 0 {
            inputs
                .bind(frame.pass("direct_shadows", &self.pipeline))
                .write("direct_shadows", &self.visibility)
                .dispatch_over(self.visibility.extent())?;
        }
        Ok(&self.visibility)
    }

    fn make_room(&mut self, lights: u32) -> Result<(), VulkanError> {
        let layers = lights.div_ceil(lights_per_layer(self.tracer.thin_surfaces));
        if layers > self.visibility.layers() {
            // Frames in flight still read the old image.
            self.device.wait_idle()?;
            self.visibility = visibility(&self.device, self.visibility.extent(), layers)?;
        }
        Ok(())
    }
}

fn visibility(device: &Arc<Device>, extent: [u32; 2], layers: u32) -> Result<Image, VulkanError> {
    storage_image_array(device, "direct_shadows", vk::Format::R32_UINT, extent, layers)
}
