//! `still`: progressive accumulation. A still scene converges to the reference: the mean of raw radiance, before all denoisers and with
//! the jitter of antialiasing, over all frames in which nothing changes. The picture fades from the denoised one to that mean.
//!
//! In: everything that radiance is made of, as sampled; the denoised picture. Out: the picture. Frames that a pixel has no sample of
//! irradiance in are not in its mean.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};

use super::combine::CombineInputs;
use super::frame_inputs::FrameInputs;
use super::storage_image;
use crate::vulkan::{Buffer, ComputePipeline, Device, Frame, Image, VulkanError, shaders, vk};

/// Share of the frames from which on the picture fades to the mean, however noisy that is.
const FADE_START: f32 = 0.5;

/// Irradiance of the visible surfaces as one frame has sampled it: an unbiased estimate that nothing has filtered.
pub struct SampledIrradiance<'a> {
    /// rgb, RGBA16F or RGBA32F; a texel for one pixel of `step` x `step`.
    pub image: &'a Image,
    /// Irradiance over what the image holds.
    pub scale: f32,
    /// Pixels from one texel to the next: 1 or 2.
    pub step: u32,
    /// The pixel that a texel stands for, counted from the first of those.
    pub offset: [u32; 2],
}

/// The pass reads these.
pub struct StillInputs<'a> {
    /// As sampled; its irradiance is not read.
    pub raw: &'a CombineInputs<'a>,
    /// As sampled.
    pub irradiance: SampledIrradiance<'a>,
    /// The denoised picture with smooth edges, RGBA16F; none: it lies where this pass writes.
    pub antialiased: Option<&'a Image>,
    /// Factor of the last frame's exposure.
    pub exposure: &'a Buffer,
}

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Push {
    counts: [u32; 4],
    represented: [u32; 2],
    sample_step: u32,
    scale: f32,
    adds: u32,
    is_antialiased: u32,
    least_weight: f32,
}

/// The pass.
pub struct StillPass {
    pipeline: ComputePipeline,
    /// rgb: mean radiance; a: squared differences of its luminance, added up.
    mean: Image,
    /// Frames in the mean of each pixel of 2 x 2.
    counts: [u32; 4],
}

impl StillPass {
    /// Makes the pipeline, for a scene with thin surfaces or without, and the mean, of `extent` texels: 16 bytes a pixel.
    pub fn new(device: &Arc<Device>, thin_surfaces: bool, extent: [u32; 2]) -> Result<Self, VulkanError> {
        let constants = [u32::from(thin_surfaces)];
        Ok(Self {
            pipeline: ComputePipeline::specialised(device, "still", shaders::STILL_COMP, &constants)?,
            mean: storage_image(device, "still mean", vk::Format::R32G32B32A32_SFLOAT, extent)?,
            counts: [0; 4],
        })
    }

    /// Adds a still frame to the mean and brings `picture` nearer to it; once the picture is frozen, it is the mean.
    pub fn record(
        &mut self,
        frame: &mut Frame<'_>,
        inputs: &FrameInputs<'_>,
        still: &StillInputs<'_>,
        picture: &Image,
    ) -> Result<(), VulkanError> {
        let SampledIrradiance { image, scale, step, offset } = still.irradiance;
        let averaged = inputs.clock.averaged();
        if averaged == Some(0) {
            self.counts = [0; 4];
        }
        if averaged.is_some() {
            self.counts[(offset[0] + 2 * offset[1]) as usize] += 1;
        }
        let fade = (inputs.clock.progress() - FADE_START) / (1.0 - FADE_START);
        let push = Push {
            counts: self.counts,
            represented: offset,
            sample_step: step,
            scale,
            adds: u32::from(averaged.is_some()),
            is_antialiased: u32::from(still.antialiased.is_some()),
            least_weight: fade.max(0.0).powi(2),
        };
        let pass = frame.pass("still", &self.pipeline);
        still
            .raw
            .bind_radiance(pass)
            .read("sampled_irradiance", image)
            // Where there is none, another image of the format is bound, and not read.
            .read("antialiased", still.antialiased.unwrap_or(still.raw.direct))
            .read("exposure", still.exposure)
            .write("picture", picture)
            .write("mean", &self.mean)
            .push(&push)
            .dispatch_over(self.mean.extent())
    }
}
