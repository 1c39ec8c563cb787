//! The settings of soft shadows and reflections: `[settings.effects]`.

use super::setting::settings;
use super::value::{choice, choices, number, whole};
use super::{Direct, Reflections, Settings};

/// What makes a clean picture of a few rays a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Denoise {
    /// Spatiotemporal variance-guided filtering: about six passes each.
    Svgf,
    /// The noisy rays of each frame as they are, at no cost.
    None,
}

/// Source of the rays' random numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Noise {
    /// Blue noise over pixels and frames, which denoisers and eyes remove easily.
    Blue,
    /// Independent random numbers, for comparison.
    White,
}

choices!(Denoise, Noise);

settings! {
    /// Settings of `--direct soft` and `--reflections rays`.
    struct EffectSettings: Copy, table "settings.effects", "Soft shadows and reflections (--direct soft, --reflections rays)";
    at settings => settings.effects;
    used if effects_are_rendered;

    /// Denoiser of soft shadows and reflections.
    "denoise" denoise: Denoise = Denoise::Svgf, choice::<Denoise>();
    /// Random numbers of the rays. Either costs the same.
    "noise" noise: Noise = Noise::Blue, choice::<Noise>();
    /// Reflections of reflections: how many glossy surfaces a ray follows. More: mirrors in mirrors, at as many times more rays
    /// where there are any.
    "reflection_depth" reflection_depth: u32 = 2, whole("N", 1, 8);
    /// Roughness up to which surfaces mirror; rougher ones blend smoothly into their mean irradiance. More: truer rough surfaces,
    /// more rays.
    "reflection_roughness" reflection_roughness: f32 = 0.6, number("ROUGHNESS", 0.0, 1.0);
}

/// Whether frames have soft shadows or, in scenes with glossy surfaces, reflections.
pub(super) fn effects_are_rendered(settings: &Settings) -> bool {
    settings.direct == Direct::Soft || settings.reflections != Reflections::None
}
