//! SVGF, spatiotemporal variance-guided filtering (Schied et al. 2017): accumulate a signal over time along the motion of
//! surfaces, estimate its variance, and blur it along surfaces as far as that variance explains differences.
//!
//! In: a signal without the albedo of the surface, one noisy frame after the other. Out: the signal, denoised.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};

use super::spatial::{self, Spatial};
use super::{Denoiser, DenoiserDescription, DenoiserInputs, DenoiserPass, Method, SignalNoise, Use};
use crate::denoiser_pass;
use crate::passes::effect_view::Visualization;
use crate::passes::history::History;
use crate::passes::storage_image;
use crate::settings::{Denoise, HistoryClamp, SvgfSettings};
use crate::vulkan::{ComputePipeline, Device, Frame, Image, Pass, VulkanError, shaders, vk};

const TEMPORAL: DenoiserPass =
    denoiser_pass!("svgf_temporal", [[170, 130, 200], [205, 120, 120], [210, 110, 150]]);
const VARIANCE: DenoiserPass =
    denoiser_pass!("svgf_variance", [[190, 160, 215], [225, 160, 150], [230, 150, 180]]);
const ATROUS: DenoiserPass = denoiser_pass!("svgf_atrous", [[130, 90, 170], [180, 70, 90], [185, 65, 120]]);

/// A signal whose variance is known is a mean already: it gets the spatial half alone.
pub(super) const METHOD: Method =
    Method { passes: &[spatial::PASS, TEMPORAL, VARIANCE, ATROUS], ..Method::new(Denoise::SVGF, make) };

fn make(device: &Arc<Device>, description: &DenoiserDescription) -> Result<Box<dyn Denoiser>, VulkanError> {
    let DenoiserDescription { usage, noise, extent, settings } = *description;
    Ok(if noise == SignalNoise::Variance {
        Box::new(Spatial::new(device, usage, extent)?)
    } else {
        Box::new(Svgf::new(device, usage, extent, &overridden(&settings.svgf, usage))?)
    })
}

/// The settings with the overrides of a use.
fn overridden(settings: &SvgfSettings, usage: Use) -> SvgfSettings {
    let (alpha, levels) = match usage {
        Use::Indirect => (settings.indirect_alpha, settings.indirect_levels),
        Use::SoftShadows => (settings.soft_shadows_alpha, settings.soft_shadows_levels),
        Use::Reflections => (settings.reflections_alpha, settings.reflections_levels),
    };
    SvgfSettings {
        alpha: alpha.unwrap_or(settings.alpha),
        levels: levels.unwrap_or(settings.levels),
        ..*settings
    }
}

/// The denoiser of one signal: 48 bytes a pixel.
pub struct Svgf {
    usage: Use,
    temporal: ComputePipeline,
    variance: ComputePipeline,
    /// The whole window; or along x, then along y.
    atrous: Vec<ComputePipeline>,
    /// Whether these read the roughness.
    reads_roughness: bool,
    settings: SvgfSettings,
    /// Whether the signal is accumulated as Reinhard's curve has it: the filter's last step expands it.
    is_compressed: bool,
    /// Radius of an adaptive filter, pixels; 0: it is not adaptive.
    widest: f32,
    /// The mean of the frames so far, in which the newest count the most, after the level that feeds back.
    history: History<Image>,
    /// Moments of its luminance.
    moments: History<Image>,
    /// Images before and after a step of the filter, by turns.
    light: [Image; 2],
    /// Which of them holds the result; none without a filter: the history is the result.
    result: Option<usize>,
}

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct TemporalPush {
    least_alpha: f32,
    least_moments_alpha: f32,
    recent_alpha: f32,
    longest: f32,
    rejection: f32,
    brightest: f32,
    clamp_deviations: f32,
    clips: u32,
    has_history: u32,
    compress: u32,
    adaptive: u32,
}

impl TemporalPush {
    fn new(settings: &SvgfSettings, camera_moves: bool) -> Self {
        let moving_alpha = settings.moving_alpha.filter(|_| camera_moves);
        Self {
            least_alpha: moving_alpha.unwrap_or(settings.alpha),
            least_moments_alpha: settings.moments_alpha,
            recent_alpha: RECENT_ALPHA,
            longest: settings.longest_history as f32,
            rejection: settings.history_rejection * deviation_of_change(settings.moments_alpha),
            brightest: settings.firefly,
            clamp_deviations: settings.clamp_deviations,
            clips: u32::from(settings.history_clamp == HistoryClamp::Clip),
            adaptive: u32::from(settings.adaptive),
            ..Self::zeroed()
        }
    }
}

/// Share of the newest frame in the mean of the last ones.
const RECENT_ALPHA: f32 = 1.0 / 3.0;

/// Standard deviation of the difference of two means over time of the same noise, in which the newest frame has the shares
/// [`RECENT_ALPHA`] and `alpha`; that of the noise is 1.
fn deviation_of_change(alpha: f32) -> f32 {
    let covariance = |a: f32, b: f32| a * b / (a + b - a * b).max(f32::MIN_POSITIVE);
    let variance = covariance(RECENT_ALPHA, RECENT_ALPHA) + covariance(alpha, alpha);
    (variance - 2.0 * covariance(RECENT_ALPHA, alpha)).max(0.0).sqrt()
}

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct AtrousPush {
    step: i32,
    depth_tolerance: f32,
    normal_exponent: f32,
    luminance_tolerance: f32,
    widest: f32,
    expand: u32,
}

impl Svgf {
    /// Makes the pipelines, and the images of `extent` texels.
    ///
    /// # Errors
    /// Where the device lacks memory.
    pub fn new(
        device: &Arc<Device>,
        usage: Use,
        extent: [u32; 2],
        settings: &SvgfSettings,
    ) -> Result<Self, VulkanError> {
        let image = |name: &str| storage_image(device, name, vk::Format::R16G16B16A16_SFLOAT, extent);
        let radii: &[[u32; 2]] = if settings.separable { &[[2, 0], [0, 2]] } else { &[[2, 2]] };
        let reads_roughness = settings.widened && usage == Use::Reflections;
        let shader =
            if reads_roughness { shaders::SVGF_WIDENED_ATROUS_COMP } else { shaders::SVGF_ATROUS_COMP };
        let atrous = |radii: &[u32; 2]| ComputePipeline::specialised(device, "svgf_atrous", shader, radii);
        let temporal = match settings.history_clamp {
            HistoryClamp::None => shaders::SVGF_TEMPORAL_COMP,
            HistoryClamp::Clamp | HistoryClamp::Clip => shaders::SVGF_CLAMPED_TEMPORAL_COMP,
        };
        Ok(Self {
            usage,
            temporal: ComputePipeline::new(device, "svgf_temporal", temporal)?,
            variance: ComputePipeline::new(device, "svgf_variance", shaders::SVGF_VARIANCE_COMP)?,
            atrous: radii.iter().map(atrous).collect::<Result<_, _>>()?,
            reads_roughness,
            settings: *settings,
            is_compressed: settings.reinhard && settings.levels > 0,
            widest: if settings.adaptive { settings.filter_radius() } else { 0.0 },
            history: History::new(|_| image("svgf history"))?,
            moments: History::new(|_| image("svgf moments"))?,
            light: [image("svgf light 0")?, image("svgf light 1")?],
            result: None,
        })
    }

    /// rgb: the denoised signal of the last frame; a: its standard deviation.
    pub fn output(&self) -> &Image {
        self.result.map_or(self.history(), |index| &self.light[index])
    }

    /// Moments of the last frame: r: mean luminance; g: its standard deviation; b: length of the history, frames.
    pub fn moments(&self) -> &Image {
        self.moments.last()
    }

    /// Outputs of the last two levels of the filter, as [`Self::output`].
    pub fn light(&self, index: usize) -> &Image {
        &self.light[index]
    }

    /// History for the next frame, as [`Self::output`].
    pub fn history(&self) -> &Image {
        self.history.last()
    }

    /// Adds the frame to the mean.
    fn accumulate(&mut self, frame: &mut Frame<'_>, inputs: &DenoiserInputs<'_>) -> Result<(), VulkanError> {
        let push = TemporalPush {
            has_history: u32::from(self.history.is_valid()),
            compress: u32::from(self.is_compressed),
            ..TemporalPush::new(&self.settings, inputs.camera_moves)
        };
        frame
            .pass(TEMPORAL.name(self.usage), &self.temporal)
            .read("frame_uniforms", inputs.uniforms)
            .read("surface", inputs.surface)
            .read("noisy", inputs.noisy)
            .read("reprojected", inputs.reprojected)
            .read("history", self.history.last())
            .read("last_moments", self.moments.last())
            .write("light", self.history.next())
            .write("moments", self.moments.next())
            .push(&push)
            .dispatch_over(self.light[0].extent())?;
        self.history.advance();
        self.moments.advance();
        Ok(())
    }

    /// Filters the signal, from image to image. The level that feeds back writes the history.
    fn blur(&mut self, frame: &mut Frame<'_>, inputs: &DenoiserInputs<'_>) -> Result<(), VulkanError> {
        let SvgfSettings { levels, feedback, .. } = self.settings;
        if levels == 0 {
            return Ok(());
        }
        let feedback = feedback.min(levels - 1);
        self.estimate_variance(frame, inputs)?;
        let mut from = Some(0);
        for level in 1..=levels {
            for part in 0..self.atrous.len() {
                let becomes_history = level == feedback && part + 1 == self.atrous.len();
                let to = if becomes_history { None } else { Some(from.map_or(0, |index| 1 - index)) };
                self.filter(frame, inputs, (level, part), [from, to])?;
                from = to;
            }
        }
        self.result = from;
        Ok(())
    }

    fn estimate_variance(
        &self,
        frame: &mut Frame<'_>,
        inputs: &DenoiserInputs<'_>,
    ) -> Result<(), VulkanError> {
        bind(frame.pass(VARIANCE.name(self.usage), &self.variance), inputs)
            .read("moments", self.moments())
            .read("light", self.history())
            .write("filtered", &self.light[0])
            .push(&[self.settings.depth_tolerance, self.settings.normal_exponent, self.widest])
            .dispatch_over(self.light[0].extent())
    }

    /// Pixels between the taps of a level. Wide lights take twice as many, up to 8 (Granja 2021, section 3.6).
    fn step(&self, level: u32, light_is_wide: bool) -> i32 {
        let step = 1 << (level - 1);
        if self.settings.widened && light_is_wide { step.max((2 * step).min(8)) } else { step }
    }

    /// One step of the filter; none of the places is the history.
    fn filter(
        &self,
        frame: &mut Frame<'_>,
        inputs: &DenoiserInputs<'_>,
        (level, part): (u32, usize),
        places: [Option<usize>; 2],
    ) -> Result<(), VulkanError> {
        let is_last = level == self.settings.levels && part + 1 == self.atrous.len();
        let [from, to] = places.map(|place| place.map_or(self.history(), |index| &self.light[index]));
        let pass = bind(frame.pass(ATROUS.name(self.usage), &self.atrous[part]), inputs);
        let pass = if self.reads_roughness { pass.read("gbuffer_albedo", inputs.albedo) } else { pass };
        pass.read("light", from)
            .write("filtered", to)
            .push(&AtrousPush {
                step: self.step(level, inputs.light_is_wide),
                depth_tolerance: self.settings.depth_tolerance,
                normal_exponent: self.settings.normal_exponent,
                luminance_tolerance: self.settings.luminance_tolerance,
                widest: self.widest,
                expand: u32::from(self.is_compressed && is_last),
            })
            .dispatch_over(self.light[0].extent())
    }
}

impl Denoiser for Svgf {
    fn record(&mut self, frame: &mut Frame<'_>, inputs: &DenoiserInputs<'_>) -> Result<(), VulkanError> {
        self.accumulate(frame, inputs)?;
        self.blur(frame, inputs)
    }

    fn output<'a>(&'a self, _: &'a Image) -> &'a Image {
        self.output()
    }

    fn debug_image(&self, stage: &str, signal: Visualization) -> Option<(&Image, Visualization)> {
        match stage {
            "temporal" => Some((self.history(), signal)),
            "variance" => Some((self.output(), Visualization::Deviation)),
            "history" => Some((self.moments(), Visualization::History)),
            _ => None,
        }
    }
}

/// Binds what the passes read that blur.
fn bind<'f>(pass: Pass<'f>, inputs: &'f DenoiserInputs<'_>) -> Pass<'f> {
    inputs.bind(pass).read("surface", inputs.surface).read("noisy", inputs.noisy)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_override_changes_only_its_use() {
        let shared = SvgfSettings::default();
        let of = |settings: &SvgfSettings| {
            Use::ALL.map(|usage| {
                let SvgfSettings { alpha, levels, .. } = overridden(settings, usage);
                (alpha, levels)
            })
        };
        let default = (shared.alpha, shared.levels);
        assert_eq!(of(&shared), [default; 3]);
        let changed = SvgfSettings { indirect_levels: Some(1), reflections_alpha: Some(0.5), ..shared };
        assert_eq!(of(&changed), [(shared.alpha, 1), default, (0.5, shared.levels)]);
        let changed = SvgfSettings { soft_shadows_alpha: Some(0.25), soft_shadows_levels: Some(0), ..shared };
        assert_eq!(of(&changed), [default, (0.25, 0), default]);
    }
}
