//! Every setting of the renderer, declared once: key, type, default, range, help, group.
//!
//! A group of settings is a file of this folder that declares its struct by the macro of `setting.rs`. From that come the options
//! of the command line, the `[settings]` of scene files, the JSON of reports, the window's panel and docs/OPTIONS.md. To add a
//! setting, add its lines to its group; to add a group, add a file and its field of [`Settings`] and entry of `GROUPS` below.
//! [`Settings::resolve`] merges in this order: defaults, the scene file's `[settings]`, the options given on the command line. In both
//! a preset comes before all others.

mod bmfr;
mod bmfr_features;
mod effects;
mod error;
mod indirect;
mod options;
mod paths;
mod preset;
mod registered;
mod setting;
mod svgf;
mod table;
mod value;
mod vpls;

pub use bmfr::BmfrSettings;
pub use bmfr_features::BmfrFeatures;
pub use effects::{Denoise, EffectSettings, Noise, SecondReflections};
pub use error::SettingsError;
pub use indirect::Indirect;
pub use options::{GivenDenoising, GivenSettings};
pub use paths::{CellNormal, CellSettings, PathFilter, PathSettings};
pub use preset::Preset;
pub use svgf::{HistoryClamp, SvgfSettings};
pub use vpls::{MissingSets, Sequence, SetResolution, VplSettings};

pub(crate) use options::parser_of;
pub(crate) use registered::Registry;
pub(crate) use setting::{Group, Setting};
pub(crate) use table::flat;
pub(crate) use value::{Kind, read_seconds, read_whole};

use setting::settings;
use value::{choice, choices, number, whole};

/// Shadows of direct light.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Direct {
    /// Soft where a light has a radius or an angle, hard otherwise. Area lights, whose shadows are soft in any case, shine by the
    /// estimator, or, where it gives no light, as with soft.
    Auto,
    /// One ray to each light, as if it had no extent; area lights shine by the estimator alone.
    Hard,
    /// Soft shadows of lights with an extent: one ray a pixel, to a random point of the lights, denoised.
    Soft,
    /// Part of the light of --indirect paths, noisy and denoised with it. Highlights of lights without a mesh are part of reflections.
    Paths,
}

/// Where the light comes from that glossy surfaces mirror.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Reflections {
    /// Rays, in scenes with glossy surfaces.
    Auto,
    /// Their mean irradiance: nothing is mirrored.
    None,
    /// One or two rays a pixel, denoised.
    Rays,
}

/// Smoothing of edges.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Antialiasing {
    /// Temporal antialiasing over 16 frames: about 0.4 ms at 1920x1080 where 500 GB/s move.
    Taa,
    /// One sample in the middle of each pixel.
    None,
}

/// The curve from exposed radiance to what is shown. Their numbers have twins in shaders/include/tone_map.glsl.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum ToneMap {
    /// A fit of the film-like curve of ACES: rich contrast, highlights that roll off to white.
    Aces,
    /// Like AgX: soft contrast, bright colours that fade to white and keep their hue.
    Agx,
    /// None: what is brighter than white is cut off.
    None,
}

/// Which ray tracer the shaders use.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum TracerKind {
    /// Hardware on a GPU that has it, software otherwise.
    Auto,
    /// The two-level BVH traversed in a compute shader, on every device.
    Software,
    /// Ray queries, on devices with `VK_KHR_ray_query`.
    Hardware,
}

choices!(Indirect, Denoise, Direct, Reflections, Antialiasing, ToneMap, TracerKind);

/// Automatic exposure, or stops within this range.
const STOPS: Kind = number("EV", -64.0, 64.0);

settings! {
    /// The settings of one rendering.
    struct Settings, table "settings", "Settings";
    at settings => settings;
    used if |_| true;

    /// Settings as a whole, which the others given beside it change.
    "preset" preset: Preset = Preset::Default, choice::<Preset>();
    /// Method of indirect light.
    "indirect" indirect: Indirect = Indirect::VPLS, choice::<Indirect>();
    /// Shadows of direct light.
    "direct" direct: Direct = Direct::Auto, choice::<Direct>();
    /// Reflections in glossy surfaces.
    "reflections" reflections: Reflections = Reflections::Auto, choice::<Reflections>();
    /// Smoothing of edges.
    "antialiasing" antialiasing: Antialiasing = Antialiasing::Taa, choice::<Antialiasing>();
    /// Still frames whose raw light is averaged; then the picture is that mean, and freezes; 0: no frame is averaged. More: less
    /// noise in the end, which takes longer; then frames cost nothing.
    "still_frames" still_frames: u32 = 1024, whole("N", 0, 1_000_000);
    /// Bounces of a light path. More: light reaches further; slots are shared among more bounces.
    "bounces" bounces: u32 = 2, whole("N", 1, 16);
    /// Width and height of the picture in pixels; without it the picture of the window follows the window. More: every pass on the
    /// GPU and the memory of all set buffers grow in proportion.
    "size" size: [u32; 2] = [1280, 720], Kind::Size { most: 16_384 }, fixed;
    /// Frames a second that the window keeps by fewer pixels where it must, unless --size is given; 0: as many pixels as it has.
    /// More: coarser pictures. render and bench ignore it.
    "target_fps" target_fps: u32 = 30, whole("N", 0, 1000);
    /// Seed of the low-discrepancy sequence. Any value is as good as another and costs the same.
    "seed" seed: u32 = 0, whole("N", 0, u32::MAX);
    /// Animation from one frame to the next, such as 1/60 or 0.02. More: things move further between frames, so the temporal sets
    /// lag further behind.
    "time_step" time_step: f64 = 1.0 / 60.0, Kind::Seconds { most: 1e9 };
    /// Ray tracer of the shaders. The picture is the same.
    "tracer" tracer: TracerKind = TracerKind::Auto, choice::<TracerKind>();
    /// Exposure in stops (radiance is multiplied by 2^exposure), or auto: the picture's median becomes middle grey, less where more
    /// than 2 % of its pixels would be white; in the window over about half a second. More: brighter. Either costs the same.
    "exposure" exposure: Option<f32> = None, Kind::Auto(&STOPS);
    /// Tone curve of what is shown. Any costs the same.
    "tone_map" tone_map: ToneMap = ToneMap::Aces, choice::<ToneMap>();

    groups {
        /// Settings of soft shadows and reflections.
        effects: EffectSettings,
        /// Settings of SVGF.
        svgf: SvgfSettings,
        /// Settings of BMFR.
        bmfr: BmfrSettings,
        /// Settings of virtual point lights.
        vpl: VplSettings,
        /// Settings of path tracing.
        paths: PathSettings,
        /// Settings of path-space filters.
        cells: CellSettings,
    }
}

/// All groups, the shared one first.
pub(crate) const GROUPS: [Group; 7] = [
    Settings::GROUP,
    EffectSettings::GROUP,
    SvgfSettings::GROUP,
    BmfrSettings::GROUP,
    VplSettings::GROUP,
    PathSettings::GROUP,
    CellSettings::GROUP,
];

/// The key of the setting that sets others.
const PRESET: &str = "preset";

/// Every setting, in the order of the groups.
pub(crate) fn all() -> impl Iterator<Item = &'static Setting> {
    GROUPS.into_iter().flat_map(|group| group.settings)
}

/// The setting of a key.
pub(crate) fn find(key: &str) -> Option<&'static Setting> {
    all().find(|setting| setting.key == key)
}

impl Settings {
    /// The settings to use: the defaults, overridden by a scene file's `[settings]`, overridden by those `given` on the command
    /// line.
    ///
    /// # Errors
    /// If a key is unknown, a value out of range, or two do not go together.
    pub fn resolve(scene: &toml::Table, given: &GivenSettings) -> Result<Self, SettingsError> {
        let mut settings = Self::from_table(scene)?;
        settings.set_given(given)?;
        settings.check_conflicts(given)?;
        Ok(settings)
    }

    /// Whether every setting is in its range and goes with the others.
    ///
    /// # Errors
    /// The first that is not, and what is allowed.
    pub fn check(&self) -> Result<(), SettingsError> {
        match all().find(|setting| !setting.kind.admits(&setting.value(self))) {
            Some(wrong) => Err(SettingsError::option(wrong, &wrong.text(self))),
            None => self.check_conflicts(&GivenSettings::default()),
        }
    }

    fn set_given(&mut self, given: &GivenSettings) -> Result<(), SettingsError> {
        // The preset first, whatever the order.
        let preset = given.table().iter().filter(|(key, _)| *key == PRESET);
        for (key, value) in preset.chain(given.table().iter().filter(|(key, _)| *key != PRESET)) {
            let unknown = || SettingsError::Option(format!("--{}: unknown setting", key.replace('_', "-")));
            let (setting, text) = (find(key).ok_or_else(unknown)?, value::text_of(value));
            setting.set(self, &text).map_err(|_| SettingsError::option(setting, &text))?;
        }
        Ok(())
    }

    fn check_conflicts(&self, given: &GivenSettings) -> Result<(), SettingsError> {
        match GROUPS.iter().find_map(|group| (group.conflict)(self)) {
            Some(conflict) => Err(SettingsError::Conflict {
                is_usage: conflict.keys.iter().any(|key| given.has(key)),
                message: conflict.message,
            }),
            None => Ok(()),
        }
    }

    /// The command-line options, without their dashes, that make these settings, with their values.
    pub fn differing_options(&self) -> Vec<(String, String)> {
        self.differing_settings().map(|setting| (setting.option(), setting.text(self))).collect()
    }

    /// The settings that are not those of their preset, as the `[settings]` of a scene file.
    pub fn differing(&self) -> toml::Table {
        self.differing_settings().map(|setting| (setting.key.to_owned(), setting.value(self))).collect()
    }

    fn differing_settings(&self) -> impl Iterator<Item = &'static Setting> {
        let base = Self { preset: Preset::Default, ..Self::default().with_preset(self.preset) };
        all().filter(move |setting| setting.value(self) != setting.value(&base))
    }
}

#[cfg(test)]
mod tests;
