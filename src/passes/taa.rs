//! `taa`: temporal antialiasing. Frames sample each pixel at 16 positions in turn; their pictures are blended along the motion of
//! surfaces. In a static scene `taa_average` averages them once.
//!
//! In: the picture as radiance, motion and depth. Out: the picture with smooth edges.

use std::sync::Arc;

use super::frame_inputs::FrameInputs;
use super::history::History;
use super::storage_image;
use crate::vulkan::{ComputePipeline, Device, Frame, Image, Sampler, VulkanError, shaders, vk};

/// Least share of the newest frame. Less: smoother edges, and changes show later.
const LEAST_ALPHA: f32 = 0.1;

/// The passes.
pub struct TaaPass {
    blend: ComputePipeline,
    add: ComputePipeline,
    history: History<Image>,
    sampler: Sampler,
    /// The mean of the pictures of a static scene.
    average: Image,
    /// Whether the mean is complete, and the picture.
    is_averaged: bool,
    /// Frames in the history.
    frames: u32,
}

impl TaaPass {
    /// Makes the pipelines, and the images of `extent` texels: 32 bytes a pixel.
    pub fn new(device: &Arc<Device>, extent: [u32; 2]) -> Result<Self, VulkanError> {
        let halves = vk::Format::R16G16B16A16_SFLOAT;
        Ok(Self {
            blend: ComputePipeline::new(device, "taa", shaders::TAA_COMP)?,
            add: ComputePipeline::new(device, "taa_average", shaders::TAA_AVERAGE_COMP)?,
            history: History::new(|_| storage_image(device, "antialiased", halves, extent))?,
            sampler: Sampler::linear(device, [vk::SamplerAddressMode::CLAMP_TO_EDGE; 2])?,
            average: storage_image(device, "average", vk::Format::R32G32B32A32_SFLOAT, extent)?,
            is_averaged: false,
            frames: 0,
        })
    }

    /// The picture of the last frame: RGBA16F or, once a static scene has converged, RGBA32F.
    pub fn output(&self) -> &Image {
        if self.is_averaged { &self.average } else { self.history.last() }
    }

    /// Whether the output is [`vk::Format::R32G32B32A32_SFLOAT`].
    pub fn is_averaged(&self) -> bool {
        self.is_averaged
    }

    /// Blends one more frame; a frozen picture stays as it is.
    pub fn record(
        &mut self,
        frame: &mut Frame<'_>,
        inputs: &FrameInputs<'_>,
        radiance: &Image,
    ) -> Result<(), VulkanError> {
        if inputs.clock.is_frozen() {
            return Ok(());
        }
        let extent = self.average.extent();
        if let Some(before) = inputs.clock.averaged() {
            frame
                .pass("taa_average", &self.add)
                .read("frame_uniforms", inputs.uniforms)
                .read("radiance", radiance)
                .write("average", &self.average)
                .push(&before)
                .dispatch_over(extent)?;
        }
        self.is_averaged = inputs.clock.is_last_averaged();
        frame
            .pass("taa", &self.blend)
            .read("frame_uniforms", inputs.uniforms)
            .read("radiance", radiance)
            .read("gbuffer_motion", &inputs.gbuffer.motion)
            .read("gbuffer_depth", &inputs.gbuffer.depth)
            .read("history", (self.history.last(), &self.sampler))
            .write("antialiased", self.history.next())
            .push(&LEAST_ALPHA.max(1.0 / (self.frames + 1) as f32))
            .dispatch_over(extent)?;
        self.history.advance();
        self.frames = self.frames.saturating_add(1);
        Ok(())
    }
}
