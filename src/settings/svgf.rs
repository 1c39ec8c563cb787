//! The settings of the denoiser SVGF: `[settings.svgf]`.
//!
//! Defaults are those of Schied et al. 2017 and, for times, of Falcor's SVGFPass, but for the moments, which are as long as the
//! light's, as history is dropped in time, and for the history, which is not blurred.

use super::Denoise;
use super::effects::effects_are_rendered;
use super::setting::settings;
use super::value::{Kind, above_0, at_least_0, choice, choices, number, whole};

/// The range of shares of the newest frame.
const ALPHA: Kind = number("SHARE", 0.0, 1.0);
/// The range of levels of the filter.
const LEVELS: Kind = whole("N", 0, 5);

/// The bound of history by the colours of the new frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum HistoryClamp {
    /// Nothing. --svgf-history-rejection tests its mean.
    None,
    /// Each channel of history is clamped to the box around the new frame's colours, in YCoCg (Granja 2021).
    Clamp,
    /// History outside of that box moves towards its middle until it touches it.
    Clip,
}

choices!(HistoryClamp);

settings! {
    /// Settings of `--denoise svgf`.
    struct SvgfSettings: Copy, table "settings.svgf", "SVGF (--denoise svgf)";
    at settings => settings.svgf;
    used if |settings| effects_are_rendered(settings) && settings.effects.denoise != Denoise::NONE;

    /// Least share of the newest frame in the denoised signal. More: more noise, and changes show sooner. Any costs the same.
    "svgf_alpha" alpha: f32 = 0.05, ALPHA;
    /// --svgf-alpha while the camera moves; auto: the same. More: shorter trails, and more noise in motion. Any costs the same.
    "svgf_moving_alpha" moving_alpha: Option<f32> = None, Kind::Auto(&ALPHA);
    /// Least share of the newest frame in the moments of luminance. More: the estimate of the noise follows changes sooner and is
    /// itself noisier. Any costs the same.
    "svgf_moments_alpha" moments_alpha: f32 = 0.05, number("SHARE", 0.0, 1.0);
    /// Longest history in frames. More: less noise where --svgf-alpha is small, and longer trails. Any costs the same.
    "svgf_history" longest_history: u32 = 32, whole("FRAMES", 1, 1024);
    /// Standard errors by which the mean of the last frames, over 5x5 pixels, may differ from history before that is dropped; more
    /// where it is brighter and bright samples are rare; 0: any. More: what has changed goes later; less: more noise, as history is
    /// dropped by chance. Costs 25 reads of 8 bytes a pixel.
    "svgf_history_rejection" history_rejection: f32 = 2.5, at_least_0("ERRORS");
    /// Standard deviations above the mean of 5x5 pixels, beyond which a sample that is brighter than those around is a firefly and
    /// taken down, while anything moves; 0: none is. Less: fewer spots, and rare bright light gets darker. Shares the reads of
    /// --svgf-history-rejection.
    "svgf_firefly" firefly: f32 = 10.0, at_least_0("DEVIATIONS");
    /// Bound of history by the mean and deviation of the new frame's 3x3 pixels, in place of --svgf-history-rejection and
    /// --svgf-firefly; for comparison. Costs 9 reads of 8 bytes a pixel.
    "svgf_history_clamp" history_clamp: HistoryClamp = HistoryClamp::None, choice::<HistoryClamp>();
    /// Standard deviations from the mean to the sides of the box of --svgf-history-clamp. More: less noise, longer trails. Any costs
    /// the same.
    "svgf_clamp_deviations" clamp_deviations: f32 = 1.0, above_0("DEVIATIONS");
    /// Levels of the a-trous filter. More: each doubles the radius of the blur, at one more pass; 0: no blur.
    "svgf_levels" levels: u32 = 4, LEVELS;
    /// The level after which the signal becomes history, at most the last but one; 0: before the first. More: less noise where
    /// history is short, and blur that grows from frame to frame. Any costs the same.
    "svgf_feedback" feedback: u32 = 0, whole("LEVEL", 0, 4);
    /// Whether levels filter along x, then along y: 10 taps in place of 25, about half their time, and edges that are neither
    /// upright nor level blur more.
    "svgf_separable" separable: bool = false, Kind::Flag;
    /// Whether the blur of reflections is only as wide as is of use, which that of a sharp mirror is not. One more read a pixel and
    /// level.
    "svgf_adaptive" adaptive: bool = true, Kind::Flag;
    /// Whether taps lie twice as far apart where much noise is expected, as in Granja 2021: in reflections of surfaces of a roughness
    /// from 0.2 on, and in shadows of lights more than 6 degrees wide; for comparison. Costs nothing.
    "svgf_widened" widened: bool = false, Kind::Flag;
    /// Whether light is averaged as light / (1 + luminance) (Reinhard 2002): less flicker of rare bright samples, which darkens
    /// what is noisy. Costs nothing.
    "svgf_reinhard" reinhard: bool = false, Kind::Flag;
    /// Pixel footprints off the plane of the surface, for each pixel between, by which the weight of a tap falls to 1/e. More: less
    /// noise on curved surfaces, and light that leaks over edges. Any costs the same.
    "svgf_depth" depth_tolerance: f32 = 1.0, above_0("FOOTPRINTS");
    /// Exponent of the cosine between normals in the weight of a tap. More: sharper edges and relief, and more noise there. Any
    /// costs the same.
    "svgf_normal" normal_exponent: f32 = 128.0, number("EXPONENT", 0.0, 1024.0);
    /// Standard deviations of luminance by which the weight of a tap falls to 1/e. More: less noise, and softer edges of light. Any
    /// costs the same.
    "svgf_luminance" luminance_tolerance: f32 = 4.0, above_0("DEVIATIONS");
    /// --svgf-alpha for soft shadows alone; auto: as --svgf-alpha. More: more noise there, and changes show sooner. Any costs the same.
    "soft_shadows_svgf_alpha" soft_shadows_alpha: Option<f32> = None, Kind::Auto(&ALPHA);
    /// --svgf-levels for soft shadows alone; auto: as --svgf-levels. More: each doubles the radius of the blur there, at one more pass.
    "soft_shadows_svgf_levels" soft_shadows_levels: Option<u32> = None, Kind::Auto(&LEVELS);
    /// --svgf-alpha for reflections alone; auto: as --svgf-alpha. More: more noise there, and changes show sooner. Any costs the same.
    "reflections_svgf_alpha" reflections_alpha: Option<f32> = None, Kind::Auto(&ALPHA);
    /// --svgf-levels for reflections alone; auto: as --svgf-levels. More: each doubles the radius of the blur there, at one more pass.
    "reflections_svgf_levels" reflections_levels: Option<u32> = None, Kind::Auto(&LEVELS);
    /// --svgf-alpha for the irradiance of a method whose frames are noisy alone; auto: as --svgf-alpha. More: more noise there, and changes show sooner. Any costs the same.
    "indirect_svgf_alpha" indirect_alpha: Option<f32> = None, Kind::Auto(&ALPHA);
    /// --svgf-levels for the irradiance of a method whose frames are noisy alone; auto: as --svgf-levels. More: each doubles the radius of the blur there, at one more pass.
    "indirect_svgf_levels" indirect_levels: Option<u32> = None, Kind::Auto(&LEVELS);
}

impl SvgfSettings {
    /// Radius of the whole filter, pixels.
    pub fn filter_radius(&self) -> f32 {
        ((2 << self.levels) - 2) as f32
    }
}
