//! Every setting of the renderer, grouped by method: for the command line, scene files and tests.
//!
//! [`Settings`] holds what all methods share, and one struct a method, whose clap group is the name of its table
//! in a scene file and whose heading is its title everywhere. [`Settings::resolve`] merges them in this order:
//! defaults, the scene file's `[settings]`, the options given on the command line.

mod effects;
mod error;
mod indirect;
mod svgf;
mod table;
pub(crate) mod text;
mod vpls;

use serde::Serialize;

pub use effects::{Denoise, EffectSettings, Noise};
pub use error::SettingsError;
pub use indirect::Indirect;
pub use svgf::SvgfSettings;
pub(crate) use table::{Group, flat, groups};
pub use vpls::{MissingSets, Sequence, VplSettings};

/// Where direct light comes from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Direct {
    /// A map of hard shadows for each light: lights have no extent, area lights shine by virtual point lights.
    #[default]
    Maps,
    /// Rays to random points of the lights, denoised: soft shadows.
    Rays,
}

/// Where the light comes from that glossy surfaces mirror.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Reflections {
    /// Rays, in scenes with glossy surfaces.
    #[default]
    Auto,
    /// Their irradiance: nothing is mirrored.
    None,
    /// Rays, denoised.
    Rays,
}

/// What smooths edges.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Antialiasing {
    /// Temporal antialiasing.
    #[default]
    Taa,
    /// Nothing: one sample in the middle of each pixel.
    None,
}

/// Which ray tracer the shaders use.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum TracerKind {
    /// The faster one on the device, by a short measurement.
    #[default]
    Auto,
    /// The two-level BVH traversed in a compute shader: every Vulkan 1.3 device.
    Software,
    /// Ray queries: devices with `VK_KHR_ray_query`.
    Hardware,
}

/// Stops, or none for automatic. The alias keeps clap from treating the `Option` as an optional argument.
type Exposure = Option<f32>;

/// The settings of one rendering. Every field, and every field of a group, is an option of the command line and a
/// key of a scene file's `[settings]`.
#[derive(Clone, Debug, PartialEq, Serialize, clap::Args)]
#[command(next_help_heading = "Settings")]
#[group(id = "settings")]
pub struct Settings {
    /// What computes indirect light. Vpls: virtual point lights; none: direct light only, which costs least.
    #[arg(long, value_enum, default_value = "vpls")]
    pub indirect: Indirect,
    /// Where direct light comes from. Maps: one ray a light, hard shadows; rays: one ray a pixel, soft shadows of lights with an
    /// extent, which are denoised.
    #[arg(long, value_enum, default_value = "maps")]
    pub direct: Direct,
    /// What glossy surfaces mirror. Rays: one or two rays a pixel, denoised; none: their mean irradiance; auto: rays in scenes
    /// with glossy surfaces.
    #[arg(long, value_enum, default_value = "auto")]
    pub reflections: Reflections,
    /// Smoothing of edges. Taa: over 16 frames, about a fifth of a millisecond at 1920x1080; none: one sample a pixel.
    #[arg(long, value_enum, default_value = "taa")]
    pub antialiasing: Antialiasing,
    /// Bounces of a light path, 1 to 16. More: light reaches further; slots are shared among more bounces.
    #[arg(long, value_name = "N", value_parser = text::parse_whole, allow_negative_numbers = true, default_value = "2")]
    pub bounces: u32,
    /// Width and height of the picture in pixels, 1 to 16,384 each. More: every pass on the GPU and the
    /// memory of all set buffers grow in proportion.
    #[arg(long, value_name = "WxH", value_parser = text::parse_size, allow_negative_numbers = true, default_value = "1280x720")]
    pub size: [u32; 2],
    /// Seed of the low-discrepancy sequence. Any value is as good as another and costs the same.
    #[arg(long, value_name = "N", value_parser = text::parse_whole, allow_negative_numbers = true, default_value = "0")]
    pub seed: u32,
    /// Seconds of animation from one frame to the next, such as 1/60 or 0.02. More: things move further
    /// between frames, so the temporal sets lag further behind.
    #[arg(long, value_name = "SECONDS", value_parser = text::parse_seconds, allow_negative_numbers = true, default_value = "1/60")]
    pub time_step: f64,
    /// Ray tracer of the indirect shadows. Software runs on every device, hardware on those with ray queries; the
    /// picture is the same. Auto: the faster one, by a short measurement that is kept for the device and its driver.
    #[arg(long, value_enum, default_value = "auto")]
    pub tracer: TracerKind,
    /// Exposure in stops (radiance is multiplied by 2^exposure), or auto: from the picture's
    /// log-average luminance. More: brighter. Either costs the same.
    #[arg(long, value_name = "EV|auto", value_parser = text::parse_exposure, allow_negative_numbers = true, default_value = "auto")]
    #[serde(serialize_with = "text::exposure_or_auto")]
    pub exposure: Exposure,
    /// Of `--direct rays` and `--reflections rays`.
    #[command(flatten)]
    #[serde(flatten)]
    pub effects: EffectSettings,
    /// Of `--denoise svgf`.
    #[command(flatten)]
    #[serde(flatten)]
    pub svgf: SvgfSettings,
    /// Of `--indirect vpls`.
    #[command(flatten)]
    #[serde(flatten)]
    pub vpl: VplSettings,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            indirect: Indirect::VPLS,
            direct: Direct::Maps,
            reflections: Reflections::Auto,
            antialiasing: Antialiasing::Taa,
            bounces: 2,
            size: [1280, 720],
            seed: 0,
            time_step: 1.0 / 60.0,
            tracer: TracerKind::Auto,
            exposure: None,
            effects: EffectSettings::default(),
            svgf: SvgfSettings::default(),
            vpl: VplSettings::default(),
        }
    }
}

/// A setting, its value, and whether it is in range.
struct Range {
    setting: &'static str,
    value: String,
    holds: bool,
    allowed: &'static str,
}

impl Range {
    fn new(setting: &'static str, value: impl ToString, holds: bool, allowed: &'static str) -> Self {
        Self { setting, value: value.to_string(), holds, allowed }
    }
}

impl Settings {
    /// The settings to use: the defaults, overridden by a scene file's `[settings]`, overridden by
    /// those fields of `cli` that `given` names. Fails where the scene file has an unknown key or
    /// the result is out of range.
    pub fn resolve(scene: &toml::Table, cli: &Settings, given: &[&str]) -> Result<Self, SettingsError> {
        let mut merged = flat(scene)?;
        // Report a mistake of the scene file even where an option overrides it.
        Self::from_table(&merged)?.check_ranges()?;
        merged.extend(cli.to_table().into_iter().filter(|(key, _)| given.contains(&key.as_str())));
        let settings = Self::from_table(&merged)?;
        settings.check().map_err(|error| error.blame(given))?;
        Ok(settings)
    }

    /// Checks the ranges of the options given on the command line, before a scene is loaded. Combinations with the
    /// scene's settings are checked by [`Self::resolve`].
    pub fn check_options(&self, given: &[&str]) -> Result<(), SettingsError> {
        self.check_ranges().map_err(|error| error.blame(given))
    }

    /// Whether every setting is in its range; the error names the first that is not, and the range.
    pub fn check(&self) -> Result<(), SettingsError> {
        self.check_ranges()?;
        self.vpl.check()
    }

    /// The command-line options, without their dashes, that turn the defaults into these settings, with their values.
    pub fn differing_options(&self) -> Vec<(String, String)> {
        let option = |(key, value): (String, toml::Value)| (key.replace('_', "-"), table::text_of(&value));
        self.differing().into_iter().map(option).collect()
    }

    /// The settings that are not at their defaults, as the `[settings]` of a scene file.
    pub fn differing(&self) -> toml::Table {
        let defaults = Self::default().to_table();
        self.to_table().into_iter().filter(|(key, value)| defaults.get(key) != Some(value)).collect()
    }

    /// All settings under their keys.
    pub(crate) fn to_table(&self) -> toml::Table {
        // Cannot fail: all values are numbers, strings or truth values.
        toml::Table::try_from(self).unwrap_or_default()
    }

    fn check_ranges(&self) -> Result<(), SettingsError> {
        let groups = self.effects.ranges().into_iter().chain(self.svgf.ranges()).chain(self.vpl.ranges());
        match self.ranges().into_iter().chain(groups).find(|range| !range.holds) {
            None => Ok(()),
            Some(Range { setting, value, allowed, .. }) => {
                Err(SettingsError::OutOfRange { setting, value, allowed, from_command_line: false })
            }
        }
    }

    /// The ranges of the shared settings.
    fn ranges(&self) -> [Range; 4] {
        let [width, height] = self.size;
        let side = 1..=16_384;
        let exposure = self.exposure.map_or_else(|| "auto".to_owned(), |stops| stops.to_string());
        [
            Range::new("bounces", self.bounces, (1..=16).contains(&self.bounces), "1 to 16"),
            Range::new(
                "size",
                format!("{width}x{height}"),
                side.contains(&width) && side.contains(&height),
                "1x1 to 16384x16384",
            ),
            Range::new(
                "time_step",
                self.time_step,
                (0.0..=1e9).contains(&self.time_step),
                "0 to 1e9 seconds",
            ),
            Range::new(
                "exposure",
                exposure,
                self.exposure.is_none_or(|stops| stops.abs() <= 64.0),
                "auto or -64 to 64",
            ),
        ]
    }
}

/// Names of the settings' fields that were given on the command line.
pub fn given_options(matches: &clap::ArgMatches) -> Vec<&str> {
    use clap::Args;
    let settings = Settings::augment_args(clap::Command::new("settings"));
    matches
        .ids()
        .map(clap::Id::as_str)
        .filter(|id| settings.get_arguments().any(|argument| argument.get_id() == *id))
        .filter(|id| matches.value_source(id) == Some(clap::parser::ValueSource::CommandLine))
        .collect()
}

#[cfg(test)]
mod tests;
