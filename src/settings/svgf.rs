//! The settings of the denoiser SVGF: `[settings.svgf]`.

use serde::Serialize;

use super::{Range, text};

/// Settings of `--denoise svgf`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, clap::Args)]
#[command(next_help_heading = "SVGF (--denoise svgf)")]
#[group(id = "settings.svgf")]
pub struct SvgfSettings {
    /// Least share of the newest frame in the denoised signal, 0 to 1. More: more noise, and changes show sooner.
    #[arg(id = "svgf_alpha", long = "svgf-alpha", value_name = "SHARE", value_parser = text::parse_number, allow_negative_numbers = true, default_value = "0.05")]
    #[serde(rename = "svgf_alpha")]
    pub alpha: f32,
    /// Least share of the newest frame in the moments of luminance, 0 to 1. More: the estimate of the noise follows changes sooner
    /// and is itself noisier.
    #[arg(id = "svgf_moments_alpha", long = "svgf-moments-alpha", value_name = "SHARE", value_parser = text::parse_number, allow_negative_numbers = true, default_value = "0.05")]
    #[serde(rename = "svgf_moments_alpha")]
    pub moments_alpha: f32,
    /// Longest history, 1 to 1,024 frames. More: less noise where --svgf-alpha is small, and longer trails.
    #[arg(id = "svgf_history", long = "svgf-history", value_name = "FRAMES", value_parser = text::parse_whole, allow_negative_numbers = true, default_value = "32")]
    #[serde(rename = "svgf_history")]
    pub longest_history: u32,
    /// Standard errors by which the mean of the last frames, over 5x5 pixels, may differ from history before that is dropped; more
    /// where it is brighter and bright samples are rare; 0: any. More: what has changed goes later; less: more noise, as history is
    /// dropped by chance. Costs 25 reads of 8 bytes a pixel.
    #[arg(id = "svgf_clamp", long = "svgf-clamp", value_name = "ERRORS", value_parser = text::parse_number, allow_negative_numbers = true, default_value = "2.5")]
    #[serde(rename = "svgf_clamp")]
    pub clamp: f32,
    /// Standard deviations above the mean of 5x5 pixels, beyond which a sample that is brighter than those around is a firefly and
    /// taken down, while anything moves; 0: none is. Less: fewer spots, and rare bright light gets darker. Shares the clamp's
    /// reads.
    #[arg(id = "svgf_firefly", long = "svgf-firefly", value_name = "DEVIATIONS", value_parser = text::parse_number, allow_negative_numbers = true, default_value = "10")]
    #[serde(rename = "svgf_firefly")]
    pub firefly: f32,
    /// Levels of the a-trous filter, 0 to 5. More: each doubles the radius of the blur, at one more pass; 0: no blur.
    #[arg(id = "svgf_levels", long = "svgf-levels", value_name = "N", value_parser = text::parse_whole, allow_negative_numbers = true, default_value = "4")]
    #[serde(rename = "svgf_levels")]
    pub levels: u32,
    /// The level after which the signal becomes history, at most the last but one; 0: before the first. More: less noise where history
    /// is short, and blur that grows from frame to frame. Any costs the same.
    #[arg(id = "svgf_feedback", long = "svgf-feedback", value_name = "LEVEL", value_parser = text::parse_whole, allow_negative_numbers = true, default_value = "0")]
    #[serde(rename = "svgf_feedback")]
    pub feedback: u32,
    /// Whether levels filter along x, then along y: 10 taps in place of 25, about half their time, and edges that are neither
    /// upright nor level blur more.
    #[arg(id = "svgf_separable", long = "svgf-separable", value_name = "true|false", action = clap::ArgAction::Set, default_value = "false")]
    #[serde(rename = "svgf_separable")]
    pub separable: bool,
    /// Whether the blur is only as wide as is of use: that of a sharp mirror or of a shadow's edge near what casts it is not. One
    /// more read a pixel and level.
    #[arg(id = "svgf_adaptive", long = "svgf-adaptive", value_name = "true|false", action = clap::ArgAction::Set, default_value = "true")]
    #[serde(rename = "svgf_adaptive")]
    pub adaptive: bool,
    /// Whether light is averaged as light / (1 + luminance) (Reinhard 2002): less flicker of rare bright samples, which darkens what is
    /// noisy. Costs nothing.
    #[arg(id = "svgf_reinhard", long = "svgf-reinhard", value_name = "true|false", action = clap::ArgAction::Set, default_value = "false")]
    #[serde(rename = "svgf_reinhard")]
    pub reinhard: bool,
    /// Pixel footprints off the plane of the surface, for each pixel between, by which the weight of a tap falls to 1/e. More: less
    /// noise on curved surfaces, and light that leaks over edges.
    #[arg(id = "svgf_depth", long = "svgf-depth", value_name = "FOOTPRINTS", value_parser = text::parse_number, allow_negative_numbers = true, default_value = "1")]
    #[serde(rename = "svgf_depth")]
    pub depth_tolerance: f32,
    /// Exponent of the cosine between normals in the weight of a tap, 0 to 1,024. More: sharper edges and relief, and more noise
    /// there.
    #[arg(id = "svgf_normal", long = "svgf-normal", value_name = "EXPONENT", value_parser = text::parse_number, allow_negative_numbers = true, default_value = "128")]
    #[serde(rename = "svgf_normal")]
    pub normal_exponent: f32,
    /// Standard deviations of luminance by which the weight of a tap falls to 1/e. More: less noise, and softer edges of light.
    #[arg(id = "svgf_luminance", long = "svgf-luminance", value_name = "DEVIATIONS", value_parser = text::parse_number, allow_negative_numbers = true, default_value = "4")]
    #[serde(rename = "svgf_luminance")]
    pub luminance_tolerance: f32,
}

impl Default for SvgfSettings {
    /// Those of Schied et al. 2017 and, for times, of Falcor's SVGFPass, but for the moments, which are as long as the light's, as
    /// history is dropped in time, and for the history, which is not blurred.
    fn default() -> Self {
        Self {
            alpha: 0.05,
            moments_alpha: 0.05,
            longest_history: 32,
            clamp: 2.5,
            firefly: 10.0,
            levels: 4,
            feedback: 0,
            separable: false,
            adaptive: true,
            reinhard: false,
            depth_tolerance: 1.0,
            normal_exponent: 128.0,
            luminance_tolerance: 4.0,
        }
    }
}

impl SvgfSettings {
    /// How far from a pixel all levels of the filter reach, pixels.
    pub fn reach(&self) -> f32 {
        ((2 << self.levels) - 2) as f32
    }

    /// The ranges of the settings.
    pub(super) fn ranges(&self) -> [Range; 10] {
        let share = |setting, value: f32| Range::new(setting, value, (0.0..=1.0).contains(&value), "0 to 1");
        let above_0 = |setting, value: f32| {
            Range::new(setting, value, value.is_finite() && value > 0.0, "a finite number above 0")
        };
        let (history, normal) = (self.longest_history, self.normal_exponent);
        let at_least_0 = |setting, value: f32| {
            Range::new(setting, value, value.is_finite() && value >= 0.0, "a finite number of at least 0")
        };
        [
            share("svgf_alpha", self.alpha),
            share("svgf_moments_alpha", self.moments_alpha),
            Range::new("svgf_history", history, (1..=1024).contains(&history), "1 to 1024"),
            at_least_0("svgf_clamp", self.clamp),
            at_least_0("svgf_firefly", self.firefly),
            Range::new("svgf_levels", self.levels, self.levels <= 5, "0 to 5"),
            Range::new("svgf_feedback", self.feedback, self.feedback <= 4, "0 to 4"),
            above_0("svgf_depth", self.depth_tolerance),
            Range::new("svgf_normal", normal, (0.0..=1024.0).contains(&normal), "0 to 1024"),
            above_0("svgf_luminance", self.luminance_tolerance),
        ]
    }
}
