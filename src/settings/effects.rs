//! The settings of soft shadows and reflections: `[settings.effects]`.

use super::registered::registered;
use super::setting::settings;
use super::value::{Kind, choice, choices, number, whole};
use super::{Direct, Indirect, Reflections, Settings};

registered! {
    /// The values of `--denoise`: names of the denoisers, which register themselves in `denoise/mod.rs`.
    struct Denoise;

    /// The default.
    SVGF = "svgf", "Spatiotemporal variance-guided filtering: about six passes each";
    /// BMFR of indirect light; other signals get SVGF.
    BMFR = "bmfr", "Blockwise multi-order feature regression of indirect light: three passes; other signals get SVGF";
    /// No denoiser.
    NONE = "none", "The noisy rays of each frame as they are, at no cost";
}

/// Source of the rays' random numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Noise {
    /// Blue noise over pixels and frames, which denoisers and eyes remove easily.
    Blue,
    /// Independent random numbers, for comparison.
    White,
}

choices!(Noise);

/// Reflections in glossy surfaces that reflection rays hit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum SecondReflections {
    /// Whatever further rays hit, up to --reflection-depth surfaces; then their mean irradiance.
    Rays,
    /// The environment alone, filtered ahead by roughness (split sum, Karis 2013): nothing is in its way, for comparison.
    SplitSum,
}

choices!(SecondReflections);

settings! {
    /// Settings of `--direct soft` and `--reflections rays`.
    struct EffectSettings: Copy, table "settings.effects", "Soft shadows and reflections (--direct soft, --reflections rays)";
    at settings => settings.effects;
    used if effects_are_rendered;

    /// Denoiser of soft shadows, of reflections, and of the irradiance of a method whose frames are noisy.
    "denoise" denoise: Denoise = Denoise::SVGF, choice::<Denoise>();
    /// Random numbers of the rays. Either costs the same.
    "noise" noise: Noise = Noise::Blue, choice::<Noise>();
    /// Reflections of reflections: how many glossy surfaces a ray follows. More: mirrors in mirrors, at as many times more rays
    /// where there are any.
    "reflection_depth" reflection_depth: u32 = 2, whole("N", 1, 8);
    /// Reflections in glossy surfaces that reflection rays hit. The split sum saves the further rays.
    "second_reflections" second_reflections: SecondReflections = SecondReflections::Rays, choice::<SecondReflections>();
    /// Roughness up to which surfaces mirror; rougher ones blend smoothly into their mean irradiance; auto: 1 with --indirect paths,
    /// else 0.6. More: truer rough surfaces, more rays.
    "reflection_roughness" reflection_roughness: Option<f32> = None, Kind::Auto(&ROUGHNESS);
    /// Whether history is only of the same instance; for comparison. Costs nothing.
    "reprojection_instance" reprojection_instance: bool = true, Kind::Flag;
    /// Whether history is only of surfaces whose normals differ by less than 45 degrees; for comparison. Costs nothing.
    "reprojection_normal" reprojection_normal: bool = true, Kind::Flag;
    /// Whether history is only of surfaces as far from the eye as is expected; for comparison. Costs nothing.
    "reprojection_depth" reprojection_depth: bool = true, Kind::Flag;
}

impl EffectSettings {
    /// Which tests reprojected history must pass. Twin: `TESTS` in shaders/include/reprojected_surface.glsl.
    pub fn reprojection_tests(&self) -> u32 {
        let tests = [self.reprojection_instance, self.reprojection_normal, self.reprojection_depth];
        tests.iter().enumerate().map(|(bit, &is_on)| u32::from(is_on) << bit).sum()
    }
}

/// The range of roughness.
const ROUGHNESS: Kind = number("ROUGHNESS", 0.0, 1.0);

impl Settings {
    /// Roughness up to which surfaces mirror. The paths of glossy surfaces are those of reflections.
    pub(crate) fn reflection_roughness(&self) -> f32 {
        let auto = if self.indirect == Indirect::PATHS { 1.0 } else { 0.6 };
        self.effects.reflection_roughness.unwrap_or(auto)
    }
}

/// Whether frames have soft shadows or, in scenes with glossy surfaces, reflections.
pub(super) fn effects_are_rendered(settings: &Settings) -> bool {
    settings.direct != Direct::Hard || settings.reflections != Reflections::None
}
