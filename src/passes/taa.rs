//! `taa`: temporal antialiasing. Frames sample each pixel at 16 positions in turn; their pictures are blended along the motion of
//! surfaces.
//!
//! In: the picture as radiance, motion and depth. Out: the picture with smooth edges.

use std::sync::Arc;

use super::frame_inputs::FrameInputs;
use super::history::History;
use super::storage_image;
use crate::vulkan::{ComputePipeline, Device, Frame, Image, Sampler, VulkanError, shaders, vk};

/// Least share of the newest frame. Less: smoother edges, and changes show later.
const LEAST_ALPHA: f32 = 0.1;

/// The pass.
pub struct TaaPass {
    blend: ComputePipeline,
    history: History<Image>,
    sampler: Sampler,
    /// Frames in the history.
    frames: u32,
}

impl TaaPass {
    /// Makes the pipeline, and the images of `extent` texels: 16 bytes a pixel.
    pub fn new(device: &Arc<Device>, extent: [u32; 2]) -> Result<Self, VulkanError> {
        let halves = vk::Format::R16G16B16A16_SFLOAT;
        Ok(Self {
            blend: ComputePipeline::new(device, "taa", shaders::TAA_COMP)?,
            history: History::new(|_| storage_image(device, "antialiased", halves, extent))?,
            sampler: Sampler::linear(device, [vk::SamplerAddressMode::CLAMP_TO_EDGE; 2])?,
            frames: 0,
        })
    }

    /// The picture of the last frame, RGBA16F.
    pub fn output(&self) -> &Image {
        self.history.last()
    }

    /// Blends one more frame.
    pub fn record(
        &mut self,
        frame: &mut Frame<'_>,
        inputs: &FrameInputs<'_>,
        radiance: &Image,
    ) -> Result<(), VulkanError> {
        frame
            .pass("taa", &self.blend)
            .read("frame_uniforms", inputs.uniforms)
            .read("radiance", radiance)
            .read("gbuffer_motion", &inputs.gbuffer.motion)
            .read("gbuffer_depth", &inputs.gbuffer.depth)
            .read("history", (self.history.last(), &self.sampler))
            .write("antialiased", self.history.next())
            .push(&LEAST_ALPHA.max(1.0 / (self.frames + 1) as f32))
            .dispatch_over(radiance.extent())?;
        self.history.advance();
        self.frames = self.frames.saturating_add(1);
        Ok(())
    }
}
