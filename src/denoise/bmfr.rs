//! BMFR, blockwise multi-order feature regression (Koskela et al. 2019): accumulate a signal over time, fit it in blocks by what is known
//! of the surfaces, and accumulate the fits.
//!
//! In: a signal without the albedo of the surface, and the surfaces. Out: the signal, denoised.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};

use super::{Denoiser, DenoiserDescription, DenoiserInputs, DenoiserPass, Method, SignalNoise, Use, svgf};
use crate::denoiser_pass;
use crate::passes::effect_view::Visualization;
use crate::passes::history::History;
use crate::passes::storage_image;
use crate::settings::{BmfrSettings, Denoise};
use crate::vulkan::{ComputePipeline, Device, Frame, Image, VulkanError, shaders, vk};

const ACCUMULATE: DenoiserPass =
    denoiser_pass!("bmfr_accumulate", [[170, 130, 200]; 3]).only_for(Use::Indirect);
const FIT: DenoiserPass = denoiser_pass!("bmfr_fit", [[130, 90, 170]; 3]).only_for(Use::Indirect);
const FILTERED: DenoiserPass = denoiser_pass!("bmfr_filtered", [[190, 160, 215]; 3]).only_for(Use::Indirect);

/// Signals other than indirect light are noisy at edges that no feature knows, those of shadows and mirror images: they get SVGF.
pub(super) const METHOD: Method = Method {
    passes: &[ACCUMULATE, FIT, FILTERED],
    follows_known_noise: true,
    ..Method::new(Denoise::BMFR, make)
};

fn make(device: &Arc<Device>, description: &DenoiserDescription) -> Result<Box<dyn Denoiser>, VulkanError> {
    let DenoiserDescription { usage, noise, extent, settings } = description;
    if *usage != Use::Indirect {
        return (svgf::METHOD.make)(device, description);
    }
    let is_known = *noise == SignalNoise::Variance;
    Ok(Box::new(Bmfr::new(device, *extent, &settings.bmfr, is_known)?))
}

/// Texels along a side of a block.
const SIDE: u32 = 32;
/// Threads of a block. Twin: shaders/denoise/bmfr_fit.comp.
const THREADS: u32 = 256;

/// Where the blocks of a frame begin, texels: so that their edges are seen nowhere twice in a row (those of Koskela et al. 2019).
const OFFSETS: [[i32; 2]; 16] = [
    [-14, -14],
    [4, -6],
    [-8, 14],
    [8, 0],
    [-10, -8],
    [2, 12],
    [12, -12],
    [-10, 0],
    [12, 14],
    [-8, -16],
    [6, 6],
    [-2, -2],
    [6, -14],
    [-16, 12],
    [14, -4],
    [-6, 4],
];

/// The denoiser: 40 bytes a texel.
pub struct Bmfr {
    settings: BmfrSettings,
    accumulate: ComputePipeline,
    fit: ComputePipeline,
    filter: ComputePipeline,
    /// rgb: the mean of the noisy frames; a: how many.
    noisy: History<Image>,
    fitted: Image,
    /// The mean of the fits, likewise.
    output: History<Image>,
    frame: u32,
    /// Only a signal with a variance has noise.
    needs_variance: bool,
}

/// `Push` in shaders/denoise/bmfr_accumulate.comp.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct AccumulatePush {
    least_alpha: f32,
    has_history: u32,
    pixels: i32,
}

/// `Push` in shaders/denoise/bmfr_fit.comp.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct FitPush {
    offset: [i32; 2],
    pixels: i32,
}

impl Bmfr {
    /// Makes the pipelines, and the images of `extent` texels. `needs_variance`: a frame without a variance has no noise.
    ///
    /// # Errors
    /// Where the device lacks memory.
    pub fn new(
        device: &Arc<Device>,
        extent: [u32; 2],
        settings: &BmfrSettings,
        needs_variance: bool,
    ) -> Result<Self, VulkanError> {
        let image = |name: &str| storage_image(device, name, vk::Format::R16G16B16A16_SFLOAT, extent);
        let accumulate = |name, second: u32| {
            ComputePipeline::specialised(device, name, shaders::BMFR_ACCUMULATE_COMP, &[second])
        };
        let features = settings.features.len() as u32;
        Ok(Self {
            settings: *settings,
            accumulate: accumulate("bmfr_accumulate", 0)?,
            fit: ComputePipeline::specialised(device, "bmfr_fit", shaders::BMFR_FIT_COMP, &[features])?,
            filter: accumulate("bmfr_filtered", 1)?,
            noisy: History::new(|_| image("bmfr noisy"))?,
            fitted: image("bmfr fitted")?,
            output: History::new(|_| image("bmfr output"))?,
            frame: 0,
            needs_variance,
        })
    }

    /// rgb: the denoised signal of the last frame; a: frames in the noisy mean.
    pub fn output(&self) -> &Image {
        self.output.last()
    }

    /// rgb: the mean of noisy frames, which was fitted last; a: how many.
    pub fn noisy(&self) -> &Image {
        self.noisy.last()
    }

    /// rgb: the fit of the last frame; a: as of [`Self::noisy`].
    pub fn fitted(&self) -> &Image {
        &self.fitted
    }
}

impl Denoiser for Bmfr {
    fn record(&mut self, frame: &mut Frame<'_>, inputs: &DenoiserInputs<'_>) -> Result<(), VulkanError> {
        if self.needs_variance && inputs.variance.is_none() {
            return Ok(());
        }
        let extent = self.fitted.extent();
        let pixels = inputs.depth.extent()[0].div_ceil(extent[0]) as i32;
        let push = |least_alpha, history: &History<Image>| AccumulatePush {
            least_alpha,
            has_history: u32::from(history.is_valid()),
            pixels,
        };
        frame
            .pass(ACCUMULATE.name(Use::Indirect), &self.accumulate)
            .read("frame_uniforms", inputs.uniforms)
            .read("signal", inputs.noisy)
            .read("reprojected", inputs.reprojected)
            .read("history", self.noisy.last())
            .write("accumulated", self.noisy.next())
            .push(&push(self.settings.alpha, &self.noisy))
            .dispatch_over(extent)?;
        self.noisy.advance();

        let features = frame.upload(&[self.settings.features.words()])?;
        let offset = OFFSETS[self.frame as usize % OFFSETS.len()];
        // Blocks begin up to a side outside the picture, and cover it from there.
        let blocks = extent.map(|side| side.div_ceil(SIDE) + 1);
        let push_fit = FitPush { offset: offset.map(|along| along - SIDE as i32 / 2), pixels };
        inputs
            .bind(frame.pass(FIT.name(Use::Indirect), &self.fit))
            .read("gbuffer_albedo", inputs.albedo)
            .read("features", &features)
            .read("signal", self.noisy.last())
            .write("fitted", &self.fitted)
            .push(&push_fit)
            .dispatch_threads([blocks[0] * THREADS, blocks[1], 1])?;
        self.frame += 1;

        frame
            .pass(FILTERED.name(Use::Indirect), &self.filter)
            .read("frame_uniforms", inputs.uniforms)
            .read("signal", &self.fitted)
            .read("reprojected", inputs.reprojected)
            .read("history", self.output.last())
            .write("accumulated", self.output.next())
            .push(&push(self.settings.filtered_alpha, &self.output))
            .dispatch_over(extent)?;
        self.output.advance();
        Ok(())
    }

    fn output<'a>(&'a self, _: &'a Image) -> &'a Image {
        self.output()
    }

    fn debug_image(&self, stage: &str, signal: Visualization) -> Option<(&Image, Visualization)> {
        match stage {
            "temporal" => Some((self.noisy(), signal)),
            _ => None,
        }
    }
}
