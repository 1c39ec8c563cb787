//! The settings of soft shadows and reflections: `[settings.effects]`.

use serde::Serialize;

use super::{Range, text};

/// What makes a clean picture of a few rays a pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Denoise {
    /// SVGF.
    #[default]
    Svgf,
    /// Nothing: the rays of each frame as they are.
    None,
}

/// Source of the rays' random numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Noise {
    /// Blue noise over pixels and frames.
    #[default]
    Blue,
    /// Independent random numbers, for comparison.
    White,
}

/// Settings of `--direct soft` and `--reflections rays`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, clap::Args)]
#[command(next_help_heading = "Soft shadows and reflections (--direct soft, --reflections rays)")]
#[group(id = "settings.effects")]
pub struct EffectSettings {
    /// What denoises soft shadows and reflections. Svgf: about six passes each; none: noise, at no cost.
    #[arg(long, value_enum, default_value = "svgf")]
    pub denoise: Denoise,
    /// Random numbers of the rays. Blue: noise that denoisers and eyes remove easily; white: independent, for comparison. Either
    /// costs the same.
    #[arg(long, value_enum, default_value = "blue")]
    pub noise: Noise,
    /// Reflections of reflections, 1 to 8: how many glossy surfaces a ray follows. More: mirrors in mirrors, at as many times more
    /// rays where there are any.
    #[arg(long, value_name = "N", value_parser = text::parse_whole, allow_negative_numbers = true, default_value = "2")]
    pub reflection_depth: u32,
    /// Roughness up to which surfaces mirror, 0 to 1; rougher ones blend smoothly into their mean irradiance. More: truer rough
    /// surfaces, more rays.
    #[arg(long, value_name = "ROUGHNESS", value_parser = text::parse_number, allow_negative_numbers = true, default_value = "0.6")]
    pub reflection_roughness: f32,
}

impl Default for EffectSettings {
    fn default() -> Self {
        Self { denoise: Denoise::Svgf, noise: Noise::Blue, reflection_depth: 2, reflection_roughness: 0.6 }
    }
}

impl EffectSettings {
    /// The ranges of the settings.
    pub(super) fn ranges(&self) -> [Range; 2] {
        let (depth, roughness) = (self.reflection_depth, self.reflection_roughness);
        [
            Range::new("reflection_depth", depth, (1..=8).contains(&depth), "1 to 8"),
            Range::new("reflection_roughness", roughness, (0.0..=1.0).contains(&roughness), "0 to 1"),
        ]
    }
}
