//! `taa`: temporal antialiasing. Frames sample each pixel at 16 positions in turn; their pictures are blended along the motion of
//! surfaces and, in a still scene, averaged once.
//!
//! In: the picture as radiance, motion and depth. Out: the picture with smooth edges.

use std::sync::Arc;

use super::storage_image;
use crate::vulkan::{ComputePipeline, Device, Frame, Image, Upload, VulkanError, shaders, vk};

/// Least share of the newest frame. Less: smoother edges, and changes show later.
const LEAST_ALPHA: f32 = 0.1;

/// What the pass reads.
pub struct TaaInputs<'a> {
    /// Frame uniforms.
    pub frame: &'a Upload,
    /// The picture, RGBA32F.
    pub radiance: &'a Image,
    /// Of the G-buffer.
    pub depth: &'a Image,
    /// Of the G-buffer.
    pub motion: &'a Image,
    /// In a still scene the place of this frame among those to be averaged, 0 to 15.
    pub averaged: Option<u32>,
}

/// Where the picture of the last frame lies.
#[derive(Clone, Copy)]
enum Shown {
    History(usize),
    Average,
}

/// The pass.
pub struct TaaPass {
    blend: ComputePipeline,
    add: ComputePipeline,
    /// Of this frame and the last one, in turns.
    histories: [Image; 2],
    average: Image,
    shown: Shown,
    /// Frames in the history.
    frames: u32,
}

/// The last of the frames that are averaged.
const LAST: u32 = 15;

impl TaaPass {
    /// Makes the pipelines, and the images of `extent` texels: 32 bytes a pixel.
    pub fn new(device: &Arc<Device>, extent: [u32; 2]) -> Result<Self, VulkanError> {
        let history = |name| storage_image(device, name, vk::Format::R16G16B16A16_SFLOAT, extent);
        Ok(Self {
            blend: ComputePipeline::new(device, "taa", shaders::TAA_COMP)?,
            add: ComputePipeline::new(device, "taa_average", shaders::TAA_AVERAGE_COMP)?,
            histories: [history("antialiased 0")?, history("antialiased 1")?],
            average: storage_image(device, "average", vk::Format::R32G32B32A32_SFLOAT, extent)?,
            shown: Shown::History(0),
            frames: 0,
        })
    }

    /// The picture of the last frame: RGBA16F or, in a still scene in the end, RGBA32F.
    pub fn output(&self) -> &Image {
        match self.shown {
            Shown::History(index) => &self.histories[index],
            Shown::Average => &self.average,
        }
    }

    /// Whether the output is [`vk::Format::R32G32B32A32_SFLOAT`].
    pub fn is_averaged(&self) -> bool {
        matches!(self.shown, Shown::Average)
    }

    /// Blends one more frame.
    pub fn record(&mut self, frame: &mut Frame<'_>, inputs: &TaaInputs<'_>) -> Result<(), VulkanError> {
        let extent = self.average.extent();
        if let Some(before) = inputs.averaged {
            frame
                .pass("taa", &self.add)
                .read("frame_uniforms", inputs.frame)
                .read("radiance", inputs.radiance)
                .write("average", &self.average)
                .push(&before)
                .dispatch_over(extent)?;
            if before == LAST {
                self.shown = Shown::Average;
                return Ok(());
            }
        }
        let to = match self.shown {
            Shown::History(last) => 1 - last,
            Shown::Average => 0,
        };
        frame
            .pass("taa", &self.blend)
            .read("frame_uniforms", inputs.frame)
            .read("radiance", inputs.radiance)
            .read("gbuffer_motion", inputs.motion)
            .read("gbuffer_depth", inputs.depth)
            .read("history", self.output())
            .write("antialiased", &self.histories[to])
            .push(&LEAST_ALPHA.max(1.0 / (self.frames + 1) as f32))
            .dispatch_over(extent)?;
        self.shown = Shown::History(to);
        self.frames = self.frames.saturating_add(1);
        Ok(())
    }
}
