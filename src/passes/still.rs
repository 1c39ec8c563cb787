//! `still`: progressive accumulation. A still scene converges to the reference: the mean of raw radiance, before all denoisers and with
//! the jitter of antialiasing, over all frames in which nothing changes. What that mean corrects in the denoised picture is filtered as far
//! as its variance asks for, and so the picture goes over from the denoised one to the mean.
//!
//! In: everything that radiance is made of, as sampled; the denoised picture. Out: the picture. Frames that a pixel has no sample of
//! irradiance in are not in its mean.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};

use super::combine::CombineInputs;
use super::frame_inputs::FrameInputs;
use super::storage_image;
use crate::vulkan::{Buffer, ComputePipeline, Device, Frame, Image, VulkanError, shaders, vk};

/// Levels of the filter, each with twice the distance between taps.
const LEVELS: u32 = 4;

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
struct MeanPush {
    counts: [u32; 4],
    represented: [u32; 2],
    sample_step: u32,
    scale: f32,
    adds: u32,
}

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct FadePush {
    is_antialiased: u32,
    least_weight: f32,
}

/// The stage.
pub struct StillPass {
    accumulate: ComputePipeline,
    filter: ComputePipeline,
    fade: ComputePipeline,
    /// rgb: mean radiance; a: squared differences of its luminance, added up.
    mean: Image,
    /// What the mean corrects in the denoised picture, as shaders/include/still.glsl has it.
    correction: Image,
    /// After a level of the filter, in turns.
    filtered: [Image; 2],
    /// Frames in the mean of each pixel of 2 x 2.
    counts: [u32; 4],
}

impl StillPass {
    /// Makes the pipelines, for a scene with thin surfaces or without, and the images, of `extent` texels: 40 bytes a pixel.
    pub fn new(device: &Arc<Device>, thin_surfaces: bool, extent: [u32; 2]) -> Result<Self, VulkanError> {
        let constants = [u32::from(thin_surfaces)];
        let correction = |name| storage_image(device, name, vk::Format::R16G16B16A16_SFLOAT, extent);
        Ok(Self {
            accumulate: ComputePipeline::specialised(
                device,
                "still_mean",
                shaders::STILL_MEAN_COMP,
                &constants,
            )?,
            filter: ComputePipeline::new(device, "still_filter", shaders::STILL_FILTER_COMP)?,
            fade: ComputePipeline::new(device, "still_fade", shaders::STILL_FADE_COMP)?,
            mean: storage_image(device, "still mean", vk::Format::R32G32B32A32_SFLOAT, extent)?,
            correction: correction("still correction")?,
            filtered: [correction("filtered correction 0")?, correction("filtered correction 1")?],
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
        self.accumulate(frame, inputs, still, still.antialiased.unwrap_or(picture))?;
        let mut from = &self.correction;
        for (level, to) in (0..LEVELS).zip(self.filtered.iter().cycle()) {
            frame
                .pass("still_filter", &self.filter)
                .read("frame_uniforms", inputs.uniforms)
                .read("gbuffer_depth", &inputs.gbuffer.depth)
                .read("gbuffer_normal", &inputs.gbuffer.normal)
                .read("noisy", from)
                .write("filtered", to)
                .push(&(1i32 << level))
                .dispatch_over(self.mean.extent())?;
            from = to;
        }
        let fade = (inputs.clock.progress() - FADE_START) / (1.0 - FADE_START);
        frame
            .pass("still_fade", &self.fade)
            .read("frame_uniforms", inputs.uniforms)
            .read("correction", &self.correction)
            .read("filtered", from)
            .read("mean", &self.mean)
            .read("direct", still.raw.direct)
            // Where there is none, another image of the format is bound, and not read.
            .read("antialiased", still.antialiased.unwrap_or(still.raw.direct))
            .read("exposure", still.exposure)
            .write("picture", picture)
            .push(&FadePush {
                is_antialiased: u32::from(still.antialiased.is_some()),
                least_weight: fade.max(0.0).powi(2),
            })
            .dispatch_over(self.mean.extent())
    }

    /// Adds the frame to the mean, and writes what that corrects in `denoised`.
    fn accumulate(
        &mut self,
        frame: &mut Frame<'_>,
        inputs: &FrameInputs<'_>,
        still: &StillInputs<'_>,
        denoised: &Image,
    ) -> Result<(), VulkanError> {
        let SampledIrradiance { image, scale, step, offset } = still.irradiance;
        let averaged = inputs.clock.averaged();
        if averaged == Some(0) {
            self.counts = [0; 4];
        }
        if averaged.is_some() {
            self.counts[(offset[0] + 2 * offset[1]) as usize] += 1;
        }
        let push = MeanPush {
            counts: self.counts,
            represented: offset,
            sample_step: step,
            scale,
            adds: u32::from(averaged.is_some()),
        };
        let pass = frame.pass("still_mean", &self.accumulate);
        still
            .raw
            .bind_radiance(pass)
            .read("sampled_irradiance", image)
            .read("denoised", denoised)
            .read("exposure", still.exposure)
            .write("mean", &self.mean)
            .write("correction", &self.correction)
            .push(&push)
            .dispatch_over(self.mean.extent())
    }
}
