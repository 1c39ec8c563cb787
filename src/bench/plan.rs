//! The plan of a benchmark: scenes, settings, frames.
//!
//! In: the options. Out: for each scene, every combination of the swept settings.

use serde::{Deserialize, Serialize};

use crate::settings::{Settings, SettingsError, VplSettings};

/// What a benchmark measures. Reports can be resumed or compared only as far as their plans agree.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plan {
    /// Names or files of the scenes, in order.
    pub scenes: Vec<String>,
    /// Measured frames of each run.
    pub frames: u32,
    /// Measurements of each setting.
    pub rounds: u32,
    /// Whether to compare pictures with converged ones.
    pub quality: bool,
    /// Settings with several values.
    pub sweep: Sweep,
    /// Other settings, which override those of the scene files.
    pub settings: toml::Table,
}

/// Values to measure, in all combinations. An empty list: the scene's value, or the default.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sweep {
    /// Temporal sets T.
    pub temporal_sets: Vec<u32>,
    /// Width and height in pixels.
    pub size: Vec<[u32; 2]>,
    /// VPL slots.
    pub vpls: Vec<u32>,
    /// Bounces of a light path.
    pub bounces: Vec<u32>,
    /// Interleave n.
    pub interleave: Vec<u32>,
}

/// A setting that can be swept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axis {
    /// Temporal sets T.
    TemporalSets,
    /// Width and height.
    Size,
    /// VPL slots.
    Vpls,
    /// Bounces.
    Bounces,
    /// Interleave n.
    Interleave,
}

impl Axis {
    /// All axes; the first is that of the tables' columns.
    pub const ALL: [Self; 5] = [Self::TemporalSets, Self::Size, Self::Vpls, Self::Bounces, Self::Interleave];

    /// Key of the setting.
    pub fn key(self) -> &'static str {
        match self {
            Self::TemporalSets => "temporal_sets",
            Self::Size => "size",
            Self::Vpls => "vpls",
            Self::Bounces => "bounces",
            Self::Interleave => "interleave",
        }
    }

    /// Label in plots and tables.
    pub fn label(self) -> &'static str {
        match self {
            Self::TemporalSets => "temporal sets T",
            Self::Size => "size in pixels",
            Self::Vpls => "VPLs",
            Self::Bounces => "bounces",
            Self::Interleave => "interleave n",
        }
    }

    /// Its value in `settings` as a coordinate of a plot; for a size the number of pixels.
    pub fn value(self, settings: &Settings) -> f64 {
        match self {
            Self::TemporalSets => settings.vpl.temporal_sets.into(),
            Self::Size => f64::from(settings.size[0]) * f64::from(settings.size[1]),
            Self::Vpls => settings.vpl.slots.into(),
            Self::Bounces => settings.bounces.into(),
            Self::Interleave => settings.vpl.interleave.into(),
        }
    }

    /// Its value in `settings` as text.
    pub fn text(self, settings: &Settings) -> String {
        match self {
            Self::Size => format!("{}x{}", settings.size[0], settings.size[1]),
            _ => self.value(settings).to_string(),
        }
    }

    /// Its value in `settings` as a phrase.
    pub fn phrase(self, settings: &Settings) -> String {
        let text = self.text(settings);
        match self {
            Self::TemporalSets => format!("T = {text}"),
            Self::Size => text,
            Self::Vpls => format!("{text} VPLs"),
            Self::Bounces if settings.bounces == 1 => "1 bounce".to_owned(),
            Self::Bounces => format!("{text} bounces"),
            Self::Interleave => format!("n = {text}"),
        }
    }
}

impl Plan {
    /// The settings to measure a scene with; `scene_settings` are those of its file. Temporal sets vary fastest.
    ///
    /// # Errors
    /// If a combination is invalid.
    pub fn combinations(&self, scene_settings: &toml::Table) -> Result<Vec<Settings>, SettingsError> {
        let given = Settings::from_table(&self.settings)?;
        let mut names: Vec<&str> = self.settings.keys().map(String::as_str).collect();
        names.extend(self.sweep.names());
        let base = Settings::resolve(scene_settings, &self.sweep.first(&given), &names)?;
        let or = |list: &[u32], base: u32| if list.is_empty() { vec![base] } else { list.to_vec() };
        let sizes = if self.sweep.size.is_empty() { vec![base.size] } else { self.sweep.size.clone() };
        let mut combinations = Vec::new();
        for size in sizes {
            for vpls in or(&self.sweep.vpls, base.vpl.slots) {
                for bounces in or(&self.sweep.bounces, base.bounces) {
                    for interleave in or(&self.sweep.interleave, base.vpl.interleave) {
                        for temporal_sets in or(&self.sweep.temporal_sets, base.vpl.temporal_sets) {
                            let cli = Settings {
                                size,
                                bounces,
                                vpl: VplSettings { slots: vpls, interleave, temporal_sets, ..given.vpl },
                                ..given.clone()
                            };
                            combinations.push(Settings::resolve(scene_settings, &cli, &names)?);
                        }
                    }
                }
            }
        }
        Ok(combinations)
    }

    /// The option in which `other` differs, if any.
    pub fn difference(&self, other: &Self) -> Option<&'static str> {
        let differing = [
            ("list of scenes", self.scenes != other.scenes),
            ("--frames", self.frames != other.frames),
            ("--rounds", self.rounds != other.rounds),
            ("--quality", self.quality != other.quality),
            ("--temporal-sets", self.sweep.temporal_sets != other.sweep.temporal_sets),
            ("--size", self.sweep.size != other.sweep.size),
            ("--vpls", self.sweep.vpls != other.sweep.vpls),
            ("--bounces", self.sweep.bounces != other.sweep.bounces),
            ("--interleave", self.sweep.interleave != other.sweep.interleave),
            ("set of other settings", self.settings != other.settings),
        ];
        differing.into_iter().find(|(_, differs)| *differs).map(|(name, _)| name)
    }
}

impl Sweep {
    /// `settings` with the first value of each list.
    fn first(&self, settings: &Settings) -> Settings {
        let first = |list: &[u32], else_: u32| list.first().copied().unwrap_or(else_);
        Settings {
            size: self.size.first().copied().unwrap_or(settings.size),
            bounces: first(&self.bounces, settings.bounces),
            vpl: VplSettings {
                temporal_sets: first(&self.temporal_sets, settings.vpl.temporal_sets),
                slots: first(&self.vpls, settings.vpl.slots),
                interleave: first(&self.interleave, settings.vpl.interleave),
                ..settings.vpl
            },
            ..settings.clone()
        }
    }

    fn names(&self) -> Vec<&'static str> {
        let given = [
            (Axis::TemporalSets, self.temporal_sets.is_empty()),
            (Axis::Size, self.size.is_empty()),
            (Axis::Vpls, self.vpls.is_empty()),
            (Axis::Bounces, self.bounces.is_empty()),
            (Axis::Interleave, self.interleave.is_empty()),
        ];
        given.into_iter().filter(|(_, empty)| !empty).map(|(axis, _)| axis.key()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plan() -> Plan {
        Plan {
            scenes: vec!["cornell-box".to_owned()],
            frames: 4,
            rounds: 1,
            quality: false,
            sweep: Sweep {
                temporal_sets: vec![1, 4],
                size: vec![[8, 4]],
                vpls: vec![16, 64],
                ..Sweep::default()
            },
            settings: toml::toml! { budget = 7 },
        }
    }

    #[test]
    fn all_combinations_are_measured() {
        let combinations = plan().combinations(&toml::toml! { budget = 3 bounces = 5 vpls = 9 }).unwrap();
        let values: Vec<_> = combinations
            .iter()
            .map(|s| (s.vpl.slots, s.vpl.temporal_sets, s.bounces, s.vpl.budget))
            .collect();
        assert_eq!(values, [(16, 1, 5, 7), (16, 4, 5, 7), (64, 1, 5, 7), (64, 4, 5, 7)]);
        assert!(combinations.iter().all(|settings| settings.size == [8, 4] && settings.vpl.interleave == 4));
    }

    #[test]
    fn invalid_combinations_are_rejected() {
        let mut plan = plan();
        plan.sweep.temporal_sets = vec![1, 32];
        let error = plan.combinations(&toml::Table::new()).unwrap_err();
        assert!(error.is_usage() && error.to_string().contains("--temporal-sets is 32"), "{error}");
    }

    #[test]
    fn a_difference_is_named_by_its_option() {
        let mut other = plan();
        assert_eq!(plan().difference(&other), None);
        other.sweep.interleave.push(2);
        assert_eq!(plan().difference(&other), Some("--interleave"));
    }
}
