//! Every knob of the renderer: one struct, used by the command line, scene files and tests.
//!
//! [`Settings::resolve`] lays them over each other: defaults, then the scene file's `[settings]`,
//! then the options that were given on the command line.

pub(crate) mod text;

use serde::{Deserialize, Serialize};

/// Which ray tracer casts the occlusion rays of the shaders.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
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

/// Where light paths get their random numbers from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Sequence {
    /// An Owen-scrambled Sobol sequence: evenly spread.
    #[default]
    Sobol,
    /// Independent random numbers, to compare with.
    Random,
}

/// What a pixel does about set buffers that have never seen its surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum MissingSets {
    /// Scale the sets that have up by total flux over present flux: noisier, never darker.
    #[default]
    Scale,
    /// Leave their light out until they come round again, as in Tonna 2019, figures 18 and 27.
    Dark,
}

/// Stops, or none for automatic. The alias keeps clap from taking the `Option` for a missing value.
type Exposure = Option<f32>;

/// The knobs of one rendering. Every field is an option of the command line and a key of a scene
/// file's `[settings]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, clap::Args)]
#[serde(deny_unknown_fields, default)]
#[command(next_help_heading = "Settings")]
pub struct Settings {
    /// VPL slots, 1 to 65,536. More: smoother indirect light; shadow rays grow in proportion.
    #[arg(long, value_name = "N", value_parser = text::parse_whole, allow_negative_numbers = true, default_value = "512")]
    pub vpls: u32,
    /// Bounces of a light path, 1 to 16. More: light reaches further; slots are shared among more bounces.
    #[arg(long, value_name = "N", value_parser = text::parse_whole, allow_negative_numbers = true, default_value = "2")]
    pub bounces: u32,
    /// Interleave n, 1 to 8: each pixel handles 1/n^2 of the VPLs. More: n^2 fewer rays, softer contact shadows.
    #[arg(long, value_name = "N", value_parser = text::parse_whole, allow_negative_numbers = true, default_value = "4")]
    pub interleave: u32,
    /// Temporal sets T, 1 to 64 and at most the VPLs. More: T times fewer rays a frame, but T frames
    /// until changes are fully seen.
    #[arg(long, value_name = "N", value_parser = text::parse_whole, allow_negative_numbers = true, default_value = "16")]
    pub temporal_sets: u32,
    /// Most VPLs shot in one frame, at least 1. More: light follows changes faster, at more CPU time.
    #[arg(long, value_name = "N", value_parser = text::parse_whole, allow_negative_numbers = true, default_value = "64")]
    pub budget: u32,
    /// Upper bound of the geometry term 1/d^2, in units of one over the squared median distance from a VPL
    /// to its parent, so that it suits a scene of any size; 0 switches it off. Lower: fewer
    /// bright spots in corners, but more energy lost there.
    #[arg(long, value_name = "BOUND", value_parser = text::parse_number, allow_negative_numbers = true, default_value = "400")]
    pub clamp: f32,
    /// A VPL that brings a pixel less than this share of what is typical gets only some of its shadow rays, which
    /// count for more; 0: all of them. More: fewer rays, but noise in dark places.
    #[arg(long, value_name = "SHARE", value_parser = text::parse_number, allow_negative_numbers = true, default_value = "0.05")]
    pub roulette: f32,
    /// How far apart two positions may be and still count as one surface, as a fraction of view depth.
    /// Lower: holes and aliasing in motion; higher: after-images.
    #[arg(long, value_name = "FRACTION", value_parser = text::parse_number, allow_negative_numbers = true, default_value = "0.02")]
    pub position_cutoff: f32,
    /// Width and height of the picture in pixels, 1 to 16,384 each. More: every pass on the GPU and the
    /// memory of all set buffers grow in proportion.
    #[arg(long, value_name = "WxH", value_parser = text::parse_size, allow_negative_numbers = true, default_value = "1280x720")]
    pub size: [u32; 2],
    /// Seed of the low-discrepancy sequence. Any value is as good as another and costs the same.
    #[arg(long, value_name = "N", value_parser = text::parse_whole, allow_negative_numbers = true, default_value = "0")]
    pub seed: u32,
    /// Random numbers of the light paths. Sobol: evenly spread; random: independent, far noisier, to compare
    /// with. Either costs the same.
    #[arg(long, value_enum, default_value = "sobol")]
    pub sequence: Sequence,
    /// Seconds of animation from one frame to the next, such as 1/60 or 0.02. More: things move further
    /// between frames, so the temporal sets lag further behind.
    #[arg(long, value_name = "SECONDS", value_parser = text::parse_seconds, allow_negative_numbers = true, default_value = "1/60")]
    #[serde(deserialize_with = "text::seconds_from_number_or_text")]
    pub time_step: f64,
    /// Ray tracer of the indirect shadows. Software runs on every device, hardware on those with ray queries; the
    /// picture is the same. Auto: the faster one, by a short measurement that is kept for the device and its driver.
    #[arg(long, value_enum, default_value = "auto")]
    pub tracer: TracerKind,
    /// What to do where set buffers are missing. Scale: noisier for T frames, never darker; dark: calm,
    /// but too dark for T frames.
    #[arg(long, value_enum, default_value = "scale")]
    pub missing_sets: MissingSets,
    /// Exposure in stops (radiance is multiplied by 2^exposure), or auto: from the picture's
    /// log-average luminance. More: brighter. Either costs the same.
    #[arg(long, value_name = "EV|auto", value_parser = text::parse_exposure, allow_negative_numbers = true, default_value = "auto")]
    #[serde(with = "text::exposure_or_auto")]
    pub exposure: Exposure,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            vpls: 512,
            bounces: 2,
            interleave: 4,
            temporal_sets: 16,
            budget: 64,
            clamp: 400.0,
            roulette: 0.05,
            position_cutoff: 0.02,
            size: [1280, 720],
            seed: 0,
            sequence: Sequence::Sobol,
            time_step: 1.0 / 60.0,
            tracer: TracerKind::Auto,
            missing_sets: MissingSets::Scale,
            exposure: None,
        }
    }
}

/// Settings that cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SettingsError {
    /// The scene file's `[settings]` has an unknown key or a value of the wrong type.
    #[error("[settings]: {0}")]
    Table(String),
    /// A setting is out of its range.
    #[error("{}: must be {allowed}", assignment(setting, value, *from_command_line))]
    OutOfRange {
        /// The field's name.
        setting: &'static str,
        /// What it was set to.
        value: String,
        /// What it may be.
        allowed: &'static str,
        /// Whether an option of the command line is at fault, not the scene file.
        from_command_line: bool,
    },
    /// More temporal sets than VPLs to fill them.
    #[error(
        "--temporal-sets is {temporal_sets}, but must be at most --vpls, which is {vpls}; lower the one or raise the other"
    )]
    MoreSetsThanVpls {
        /// The temporal sets.
        temporal_sets: u32,
        /// The VPL slots.
        vpls: u32,
        /// Whether an option of the command line is at fault, not the scene file.
        from_command_line: bool,
    },
}

impl SettingsError {
    /// Whether the command line is at fault (wrong usage), not the scene file.
    pub fn is_usage(&self) -> bool {
        match self {
            Self::Table(_) => false,
            Self::OutOfRange { from_command_line, .. } | Self::MoreSetsThanVpls { from_command_line, .. } => {
                *from_command_line
            }
        }
    }
}

/// A setting as it was written: `--temporal-sets 600` or `[settings] temporal_sets = 600`.
fn assignment(setting: &str, value: &str, on_command_line: bool) -> String {
    if on_command_line {
        format!("--{} {value}", setting.replace('_', "-"))
    } else {
        format!("[settings] {setting} = {value}")
    }
}

impl Settings {
    /// The settings to use: the defaults, overridden by a scene file's `[settings]`, overridden by
    /// those fields of `cli` that `given` names. Fails where the scene file has an unknown key or
    /// the result is out of range.
    pub fn resolve(scene: &toml::Table, cli: &Settings, given: &[&str]) -> Result<Self, SettingsError> {
        let table_error = |error: toml::de::Error| SettingsError::Table(one_line(&error.to_string()));
        // A mistake of the scene file is one even where an option overrides it.
        scene.clone().try_into::<Settings>().map_err(table_error)?.check_ranges()?;
        let options = toml::Table::try_from(cli).map_err(|error| SettingsError::Table(error.to_string()))?;
        let mut merged = scene.clone();
        merged.extend(options.into_iter().filter(|(key, _)| given.contains(&key.as_str())));
        let settings = merged.try_into::<Settings>().map_err(table_error)?;
        settings.check().map_err(|error| error.blame(given))?;
        Ok(settings)
    }

    /// Checks the options given on the command line as far as that can be done before a scene is
    /// loaded, whose settings may be in the way of some of them.
    pub fn check_options(&self, given: &[&str]) -> Result<(), SettingsError> {
        self.check_ranges().map_err(|error| error.blame(given))
    }

    /// Whether every setting is in its range; the error names the first that is not, and the range.
    pub fn check(&self) -> Result<(), SettingsError> {
        self.check_ranges()?;
        if self.temporal_sets > self.vpls {
            return Err(SettingsError::MoreSetsThanVpls {
                temporal_sets: self.temporal_sets,
                vpls: self.vpls,
                from_command_line: false,
            });
        }
        Ok(())
    }

    /// The options of the command line, without their dashes, that make these settings out of the defaults,
    /// each with its value.
    pub fn differing_options(&self) -> Vec<(String, String)> {
        let written = |value: toml::Value| match value {
            toml::Value::String(text) => text,
            toml::Value::Array(sides) => sides.iter().map(ToString::to_string).collect::<Vec<_>>().join("x"),
            number => number.to_string(),
        };
        self.differing().into_iter().map(|(name, value)| (name.replace('_', "-"), written(value))).collect()
    }

    /// The settings that are not at their defaults, as the `[settings]` of a scene file.
    pub fn differing(&self) -> toml::Table {
        let table = |settings: &Self| toml::Table::try_from(settings).unwrap_or_default();
        let defaults = table(&Self::default());
        table(self).into_iter().filter(|(name, value)| defaults.get(name) != Some(value)).collect()
    }

    fn check_ranges(&self) -> Result<(), SettingsError> {
        let [width, height] = self.size;
        let side = 1..=16_384;
        let in_range = [
            ("vpls", self.vpls.to_string(), (1..=65_536).contains(&self.vpls), "1 to 65536"),
            ("bounces", self.bounces.to_string(), (1..=16).contains(&self.bounces), "1 to 16"),
            ("interleave", self.interleave.to_string(), (1..=8).contains(&self.interleave), "1 to 8"),
            (
                "temporal_sets",
                self.temporal_sets.to_string(),
                (1..=64).contains(&self.temporal_sets),
                "1 to 64, and at most --vpls",
            ),
            ("budget", self.budget.to_string(), self.budget >= 1, "at least 1"),
            (
                "clamp",
                self.clamp.to_string(),
                self.clamp.is_finite() && self.clamp >= 0.0,
                "a finite number of at least 0",
            ),
            ("roulette", self.roulette.to_string(), (0.0..=1.0).contains(&self.roulette), "0 to 1"),
            (
                "position_cutoff",
                self.position_cutoff.to_string(),
                self.position_cutoff.is_finite() && self.position_cutoff > 0.0,
                "a finite number above 0",
            ),
            (
                "size",
                format!("{width}x{height}"),
                side.contains(&width) && side.contains(&height),
                "1x1 to 16384x16384",
            ),
            (
                "time_step",
                self.time_step.to_string(),
                (0.0..=1e9).contains(&self.time_step),
                "0 to 1e9 seconds",
            ),
            (
                "exposure",
                self.exposure.map_or_else(|| "auto".to_owned(), |stops| stops.to_string()),
                self.exposure.is_none_or(|stops| stops.abs() <= 64.0),
                "auto or -64 to 64",
            ),
        ];
        match in_range.into_iter().find(|(_, _, in_range, _)| !in_range) {
            None => Ok(()),
            Some((setting, value, _, allowed)) => {
                Err(SettingsError::OutOfRange { setting, value, allowed, from_command_line: false })
            }
        }
    }
}

impl SettingsError {
    /// Notes whether one of the options `given` on the command line is at fault.
    fn blame(mut self, given: &[&str]) -> Self {
        match &mut self {
            Self::Table(_) => {}
            Self::OutOfRange { setting, from_command_line, .. } => {
                *from_command_line = given.contains(setting);
            }
            Self::MoreSetsThanVpls { from_command_line, .. } => {
                *from_command_line = given.contains(&"temporal_sets") || given.contains(&"vpls");
            }
        }
        self
    }
}

/// Which settings were given on the command line, not left at their defaults: names of fields.
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

/// A parser's message of several lines as one.
fn one_line(message: &str) -> String {
    message.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests;
