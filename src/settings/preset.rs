//! Presets: settings as a whole. A thesis's preset follows it, where it says; elsewhere it follows the thesis's sources.
//!
//! A preset sets all that decides how light is computed, and leaves the picture's size, exposure, seed and time step.

use super::value::choices;
use super::{
    Antialiasing, BmfrSettings, CellSettings, Denoise, Direct, EffectSettings, HistoryClamp, Indirect,
    MissingSets, PathFilter, PathSettings, Reflections, Settings, SvgfSettings, VplSettings,
};

/// Settings as a whole.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Preset {
    /// The defaults.
    Default,
    /// Instant radiosity with temporal sets (Tonna 2019): a shadow ray to every VPL of a pixel's class, full-resolution sets, a raw
    /// position cut-off; sets that lack a surface stay dark there.
    Tonna,
    /// Soft shadows and reflections (Granja 2021): one ray a pixel each, SVGF with its four extensions, no indirect light.
    Granja,
    /// All light by one path a pixel of four surfaces, denoised by BMFR (Flatval 2020); with --denoise svgf by its SVGF.
    Flatval,
    /// All light by one path a pixel of one bounce, shared in hashed cells at every vertex (nHPSF, Meijer 2019), not denoised.
    Meijer,
    /// Few VPLs, one bounce: for slow devices.
    Draft,
    /// Many VPLs, four bounces, a large budget: for fast devices.
    Fine,
}

choices!(Preset);

impl Settings {
    /// The settings of a preset, with those of size, time and looks kept.
    #[must_use]
    pub fn with_preset(&self, preset: Preset) -> Self {
        let Self { size, target_fps, seed, time_step, tracer, exposure, tone_map, .. } = *self;
        let settings = match preset {
            Preset::Default => Self::default(),
            Preset::Tonna => tonna(),
            Preset::Granja => granja(),
            Preset::Flatval => flatval(),
            Preset::Meijer => meijer(),
            Preset::Draft => {
                let vpl = VplSettings { slots: 128, budget: 32, ..VplSettings::default() };
                Self { bounces: 1, vpl, ..Self::default() }
            }
            Preset::Fine => {
                let vpl = VplSettings { slots: 4096, budget: 512, clamp: 1600.0, ..VplSettings::default() };
                Self { bounces: 4, vpl, ..Self::default() }
            }
        };
        Self { preset, size, target_fps, seed, time_step, tracer, exposure, tone_map, ..settings }
    }
}

/// None of the theses averages still frames.
fn of_thesis() -> Settings {
    Settings { still_frames: 0, ..Settings::default() }
}

/// Tonna 2019, section 6: 512 VPLs, 4x4 interleaving, 16 sets, one shadow ray a light.
fn tonna() -> Settings {
    Settings {
        indirect: Indirect::TONNA,
        direct: Direct::Hard,
        reflections: Reflections::None,
        antialiasing: Antialiasing::None,
        effects: EffectSettings { denoise: Denoise::NONE, ..EffectSettings::default() },
        vpl: VplSettings { missing_sets: MissingSets::Dark, ..VplSettings::default() },
        ..of_thesis()
    }
}

/// Granja 2021, chapter 3, all extensions on. Moments, length of history and depth tolerance are Falcor's, its yardstick.
fn granja() -> Settings {
    Settings {
        indirect: Indirect::NONE,
        direct: Direct::Soft,
        reflections: Reflections::Rays,
        effects: EffectSettings {
            reflection_depth: 2,
            reflection_roughness: Some(1.0),
            ..EffectSettings::default()
        },
        svgf: SvgfSettings {
            alpha: 0.05,
            moving_alpha: Some(0.2),
            moments_alpha: 0.2,
            history_clamp: HistoryClamp::Clamp,
            feedback: 1,
            separable: true,
            widened: true,
            reinhard: true,
            luminance_tolerance: 10.0,
            ..plain_svgf()
        },
        ..of_thesis()
    }
}

/// Flatval 2020, tables of chapter 4: BMFR with the features and shares of Koskela et al. 2019; SVGF with its own.
fn flatval() -> Settings {
    Settings {
        indirect: Indirect::PATHS,
        direct: Direct::Paths,
        bounces: 3,
        effects: EffectSettings { denoise: Denoise::BMFR, ..EffectSettings::default() },
        svgf: SvgfSettings {
            alpha: 0.15,
            moments_alpha: 0.2,
            longest_history: 1024,
            feedback: 1,
            luminance_tolerance: 10.0,
            ..plain_svgf()
        },
        bmfr: BmfrSettings::default(),
        ..of_thesis()
    }
}

/// Meijer 2019, chapter 5: cells of 16 pixels, a jitter of 0.6, two bits of the normal. Cells last as long as they are used.
fn meijer() -> Settings {
    Settings {
        indirect: Indirect::PATHS,
        direct: Direct::Paths,
        reflections: Reflections::None,
        antialiasing: Antialiasing::None,
        bounces: 1,
        effects: EffectSettings { denoise: Denoise::NONE, ..EffectSettings::default() },
        paths: PathSettings { filter: PathFilter::Nhpsf, ..PathSettings::default() },
        cells: CellSettings {
            width: 16.0,
            jitter: 0.6,
            normal_bits: 2,
            levels: 1,
            window: 0,
            life: 1,
            ..CellSettings::default()
        },
        ..of_thesis()
    }
}

/// SVGF without what glowworm adds to it.
fn plain_svgf() -> SvgfSettings {
    SvgfSettings { history_rejection: 0.0, firefly: 0.0, adaptive: false, ..SvgfSettings::default() }
}
