//! `still`: progressive accumulation. A still scene converges to the reference: the mean of raw radiance, before all denoisers and with
//! the jitter of antialiasing, over all frames in which nothing changes. The mean's difference from the denoised picture is filtered as far
//! as its variance asks for, and so the picture goes over from the denoised one to the mean.
//!
//! In: everything that radiance is made of, as sampled; the denoised picture. Out: the picture. Frames that a pixel has no sample of
//! irradiance in are not in its mean.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};

use super::combine::CombineInputs;
use super::frame_inputs::FrameInputs;
use super::spatial_filter::{FilteredSignal, SpatialFilter};
use super::storage_image;
use crate::vulkan::{Buffer, ComputePipeline, Device, Frame, Image, VulkanError, shaders, vk};

/// Levels of the filter.
const LEVELS: u32 = 5;

/// Pixels of 2 x 2 have samples of different frames, so their means differ: the filter's first level evens that out, whatever the difference.
const FIRST_TOLERANCE: f32 = 1e4;

/// Share of the frames from which on the picture fades to the mean, however noisy that is.
const FADE_START: f32 = 0.5;

/// Irradiance of the visible surfaces as one frame has sampled it: an unbiased estimate that nothing has filtered.
pub struct SampledIrradiance<'a> {
    /// rgb, RGBA16F or RGBA32F; a texel for each pixel, or for each 2 x 2.
    pub image: &'a Image,
    /// Irradiance over what the image holds.
    pub scale: f32,
    /// The pixel of each 2 x 2 that was sampled; none: all were.
    pub checkerboard: Option<[u32; 2]>,
}

/// The pass reads these.
pub struct StillInputs<'a> {
    /// Images as sampled; the irradiance is not read.
    pub raw: &'a CombineInputs<'a>,
    /// Irradiance as sampled.
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
    sampled_pixel: [u32; 2],
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
    filter: SpatialFilter,
    fade: ComputePipeline,
    /// rgb: mean radiance; a: squared differences of its luminance, added up.
    mean: Image,
    /// Correction of the denoised picture by the mean, as shaders/include/still.glsl has it.
    correction: Image,
    /// Variance of its luminance.
    variance: Image,
    /// Frames in the mean of each pixel of 2 x 2.
    counts: [u32; 4],
}

impl StillPass {
    /// Makes the pipelines, for a scene with thin surfaces or without, and the images, of `extent` texels: 40 bytes a pixel.
    pub fn new(device: &Arc<Device>, thin_surfaces: bool, extent: [u32; 2]) -> Result<Self, VulkanError> {
        let constants = [u32::from(thin_surfaces)];
        Ok(Self {
            accumulate: ComputePipeline::specialised(
                device,
                "still_mean",
                shaders::STILL_MEAN_COMP,
                &constants,
            )?,
            filter: SpatialFilter::new(device, "still_spatial_filter", extent)?,
            fade: ComputePipeline::new(device, "still_fade", shaders::STILL_FADE_COMP)?,
            mean: storage_image(device, "still mean", vk::Format::R32G32B32A32_SFLOAT, extent)?,
            correction: storage_image(device, "correction", vk::Format::R16G16B16A16_SFLOAT, extent)?,
            variance: storage_image(device, "correction variance", vk::Format::R32_SFLOAT, extent)?,
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
        self.filter.record(
            frame,
            &FilteredSignal {
                uniforms: inputs.uniforms,
                depth: &inputs.gbuffer.depth,
                normal: &inputs.gbuffer.normal,
                noisy: &self.correction,
                variance: &self.variance,
                levels: LEVELS,
                first_tolerance: FIRST_TOLERANCE,
            },
        )?;
        let fade = (inputs.clock.progress() - FADE_START) / (1.0 - FADE_START);
        frame
            .pass("still_fade", &self.fade)
            .read("frame_uniforms", inputs.uniforms)
            .read("correction", self.filter.output())
            .read("variance", self.filter.variance())
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
        let SampledIrradiance { image, scale, checkerboard } = still.irradiance;
        let sampled_pixel = checkerboard.unwrap_or_default();
        let averaged = inputs.clock.averaged();
        if averaged == Some(0) {
            self.counts = [0; 4];
        }
        if averaged.is_some() {
            self.counts[(sampled_pixel[0] + 2 * sampled_pixel[1]) as usize] += 1;
        }
        let push = MeanPush {
            counts: self.counts,
            sampled_pixel,
            sample_step: if checkerboard.is_some() { 2 } else { 1 },
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
            .write("variance", &self.variance)
            .push(&push)
            .dispatch_over(self.mean.extent())
    }
}
