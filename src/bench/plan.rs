//! The plan of a benchmark: scenes, methods, settings, frames.
//!
//! In: the options. Out: for each scene, every combination of the methods and the swept settings.

use serde::{Deserialize, Serialize};
use toml::{Table, Value};

use super::method::Method;
use super::report::Run;
use crate::settings::{Settings, SettingsError};

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
    /// Whether to compare pictures with the path tracer's.
    pub quality: bool,
    /// Samples a pixel of the path tracer's pictures.
    pub spp: u32,
    /// Settings with several values.
    pub sweep: Sweep,
    /// Other settings, which override those of the scene files.
    pub settings: toml::Table,
}

/// Values to measure, in all combinations. An empty list: the scene's value, or the default.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sweep {
    /// Methods.
    pub methods: Vec<Method>,
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

/// What can be swept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axis {
    /// The method.
    Method,
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
    /// All axes. The first with several values is that of the tables' columns.
    pub const ALL: [Self; 6] =
        [Self::Method, Self::TemporalSets, Self::Size, Self::Vpls, Self::Bounces, Self::Interleave];

    /// Key of the setting.
    pub fn key(self) -> &'static str {
        match self {
            Self::Method => "method",
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
            Self::Method => "method",
            Self::TemporalSets => "temporal sets T",
            Self::Size => "size in pixels",
            Self::Vpls => "VPLs",
            Self::Bounces => "bounces",
            Self::Interleave => "interleave n",
        }
    }

    /// Its value of `run` as a coordinate of a plot; for a size the number of pixels; none for a method.
    pub fn value(self, run: &Run) -> Option<f64> {
        let settings = &run.settings;
        match self {
            Self::Method => None,
            Self::TemporalSets => Some(settings.vpl.temporal_sets.into()),
            Self::Size => Some(f64::from(settings.size[0]) * f64::from(settings.size[1])),
            Self::Vpls => Some(settings.vpl.slots.into()),
            Self::Bounces => Some(settings.bounces.into()),
            Self::Interleave => Some(settings.vpl.interleave.into()),
        }
    }

    /// Its value of `run` as text.
    pub fn text(self, run: &Run) -> String {
        match self {
            Self::Size => format!("{}x{}", run.settings.size[0], run.settings.size[1]),
            _ => self.value(run).map_or_else(|| run.method.to_string(), |value| value.to_string()),
        }
    }

    /// Its value of `run` as a phrase.
    pub fn phrase(self, run: &Run) -> String {
        let text = self.text(run);
        match self {
            Self::TemporalSets => format!("T = {text}"),
            Self::Method | Self::Size => text,
            Self::Vpls => format!("{text} VPLs"),
            Self::Bounces if run.settings.bounces == 1 => "1 bounce".to_owned(),
            Self::Bounces => format!("{text} bounces"),
            Self::Interleave => format!("n = {text}"),
        }
    }
}

impl Plan {
    /// What to measure of a scene; `scene_settings` are those of its file. Temporal sets vary fastest, methods slowest.
    ///
    /// # Errors
    /// If a combination is invalid.
    pub fn combinations(
        &self,
        scene_settings: &toml::Table,
    ) -> Result<Vec<(Method, Settings)>, SettingsError> {
        if self.sweep.methods.is_empty() {
            let all = self.combinations_of(scene_settings, &toml::Table::new())?;
            return Ok(all.into_iter().map(|settings| (Method::of(&settings), settings)).collect());
        }
        let mut combinations = Vec::new();
        for method in &self.sweep.methods {
            let all = self.combinations_of(scene_settings, method.settings())?;
            combinations.extend(all.into_iter().map(|settings| (method.clone(), settings)));
        }
        Ok(combinations)
    }

    /// Every combination of the swept settings, except of those that `fixed` states.
    fn combinations_of(
        &self,
        scene_settings: &toml::Table,
        fixed: &toml::Table,
    ) -> Result<Vec<Settings>, SettingsError> {
        let mut own = self.settings.clone();
        own.extend(fixed.clone());
        let mut combinations = vec![own];
        // The last axis varies fastest.
        for (key, values) in self.sweep.lists().into_iter().filter(|(key, _)| !fixed.contains_key(*key)) {
            combinations = combinations.iter().flat_map(|own| with_each(own, key, &values)).collect();
        }
        let resolved = |own: Table| Settings::resolve(scene_settings, &own.into());
        combinations.into_iter().map(resolved).collect()
    }

    /// The option in which `other` differs, if any.
    pub fn difference(&self, other: &Self) -> Option<&'static str> {
        let differing = [
            ("list of scenes", self.scenes != other.scenes),
            ("--frames", self.frames != other.frames),
            ("--rounds", self.rounds != other.rounds),
            ("--quality", self.quality != other.quality),
            ("--spp", self.spp != other.spp),
            ("--methods", self.sweep.methods != other.sweep.methods),
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
    /// The values of each setting.
    fn lists(&self) -> [(&'static str, Vec<Value>); 5] {
        let numbers = |axis: Axis, list: &[u32]| {
            (axis.key(), list.iter().map(|value| i64::from(*value).into()).collect())
        };
        let sizes = self.size.iter().map(|size| size.map(i64::from).to_vec().into()).collect();
        [
            (Axis::Size.key(), sizes),
            numbers(Axis::Vpls, &self.vpls),
            numbers(Axis::Bounces, &self.bounces),
            numbers(Axis::Interleave, &self.interleave),
            numbers(Axis::TemporalSets, &self.temporal_sets),
        ]
    }
}

/// The table with each of the values, or as it is where there are none.
fn with_each(table: &Table, key: &str, values: &[Value]) -> Vec<Table> {
    let with = |value: &Value| {
        let mut table = table.clone();
        table.insert(key.to_owned(), value.clone());
        table
    };
    if values.is_empty() { vec![table.clone()] } else { values.iter().map(with).collect() }
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
            spp: 16,
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
            .map(|(_, s)| (s.vpl.slots, s.vpl.temporal_sets, s.bounces, s.vpl.budget))
            .collect();
        assert_eq!(values, [(16, 1, 5, 7), (16, 4, 5, 7), (64, 1, 5, 7), (64, 4, 5, 7)]);
        assert!(
            combinations.iter().all(|(_, settings)| settings.size == [8, 4] && settings.vpl.interleave == 4)
        );
        assert!(combinations.iter().all(|(method, _)| method.name() == "vpls"));
    }

    #[test]
    fn a_method_is_measured_with_what_it_states() {
        let mut plan = plan();
        plan.sweep.methods =
            ["vpls", "vpls@T=2@vpls=8", "reference@4"].map(|name| name.parse().unwrap()).into();
        let combinations = plan.combinations(&toml::Table::new()).unwrap();
        let of = |name: &str| {
            let found = combinations.iter().filter(|(method, _)| method.name() == name);
            found.map(|(_, s)| (s.vpl.slots, s.vpl.temporal_sets)).collect::<Vec<_>>()
        };
        let all = [(16, 1), (16, 4), (64, 1), (64, 4)];
        assert_eq!((of("vpls"), of("vpls@T=2@vpls=8")), (all.into(), vec![(8, 2)]));
        assert_eq!(of("reference@4").len(), 4);
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
