//! The plan of a benchmark: scenes, methods, settings, frames.
//!
//! In: the options. Out: for each scene, every combination of the methods and the swept settings.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use toml::{Table, Value};

use super::axis::Axis;
use super::method::Method;
use crate::settings::{Settings, SettingsError};

/// The measurements of a benchmark. Reports can be resumed or compared only as far as their plans agree.
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
    /// Samples a pixel of the path tracer's pictures; 0: the pictures of a scene's first run stand in for them.
    pub spp: u32,
    /// Settings with several values.
    pub sweep: Sweep,
    /// Other settings, which override those of the scene files.
    pub settings: toml::Table,
}

/// Values to measure, in all combinations.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Sweep {
    /// Methods; none: that of the settings.
    pub methods: Vec<Method>,
    /// Lists of values by the key of their setting. A setting without a list has the scene's value, or the default.
    #[serde(flatten)]
    pub settings: BTreeMap<String, Vec<toml::Value>>,
}

impl Plan {
    /// The runs of a scene; `scene_settings` are those of its file. The first of [`Axis::all`] varies fastest, but methods slowest. Undivided
    /// work is measured at the half resolution of divided work, too.
    ///
    /// # Errors
    /// If a combination is invalid.
    pub fn combinations(
        &self,
        scene_settings: &toml::Table,
    ) -> Result<Vec<(Method, Settings)>, SettingsError> {
        if self.sweep.methods.is_empty() {
            let all = self.combinations_of(scene_settings, None)?;
            return Ok(all.into_iter().map(|settings| (Method::of(&settings), settings)).collect());
        }
        let mut combinations = Vec::new();
        for method in &self.sweep.methods {
            let all = self.combinations_of(scene_settings, Some(method))?;
            combinations.extend(all.into_iter().map(|settings| (method.clone(), settings)));
        }
        Ok(combinations)
    }

    /// Every combination of the swept settings, except of those that the method states or knows nothing of.
    fn combinations_of(
        &self,
        scene_settings: &toml::Table,
        method: Option<&Method>,
    ) -> Result<Vec<Settings>, SettingsError> {
        let fixed = method.map(Method::settings).cloned().unwrap_or_default();
        let mut own = self.settings.clone();
        own.extend(fixed.clone());
        let mut tables = vec![own];
        let is_swept = |axis: &Axis| !fixed.contains_key(axis.key()) && axis.concerns(&fixed);
        for axis in Axis::all().into_iter().rev().filter(is_swept) {
            let Some(values) = self.sweep.settings.get(axis.key()) else { continue };
            let with = |table: &Table| {
                let of = |value: &Value| {
                    let mut table = table.clone();
                    table.insert(axis.key().to_owned(), value.clone());
                    table
                };
                values.iter().map(of).collect::<Vec<_>>()
            };
            tables = tables.iter().flat_map(with).collect();
        }
        let resolved = |own: Table| Settings::resolve(scene_settings, &own.into());
        let all = tables.into_iter().map(resolved).collect::<Result<Vec<_>, _>>()?;
        if method.is_some_and(|method| method.samples().is_some()) {
            return Ok(all);
        }
        let compares =
            |axis: &Axis| self.sweep.settings.get(axis.key()).is_some_and(|values| values.len() > 1);
        let half = Axis::all().into_iter().filter(is_swept).filter(compares).find_map(|axis| match axis {
            Axis::Number(axis) => axis.half,
            _ => None,
        });
        let with_half = |settings: Settings| {
            let at_half = half.and_then(|half| (half.of)(&settings));
            std::iter::once(settings).chain(at_half)
        };
        Ok(all.into_iter().flat_map(with_half).collect())
    }

    /// The option in which `other` differs, if any.
    pub fn difference(&self, other: &Self) -> Option<String> {
        let differing = [
            ("list of scenes", self.scenes != other.scenes),
            ("--frames", self.frames != other.frames),
            ("--rounds", self.rounds != other.rounds),
            ("--quality", self.quality != other.quality),
            ("--spp", self.spp != other.spp),
            ("--methods", self.sweep.methods != other.sweep.methods),
            ("set of other settings", self.settings != other.settings),
        ];
        let differing = differing.into_iter().find(|(_, differs)| *differs).map(|(name, _)| name.to_owned());
        let lists = [&self.sweep.settings, &other.sweep.settings];
        let swept =
            || lists[0].keys().chain(lists[1].keys()).find(|key| lists[0].get(*key) != lists[1].get(*key));
        differing.or_else(|| Some(format!("--{}", swept()?.replace('_', "-"))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::SetResolution;

    fn plan() -> Plan {
        Plan {
            scenes: vec!["cornell-box".to_owned()],
            frames: 4,
            rounds: 1,
            quality: false,
            spp: 16,
            sweep: Sweep {
                methods: Vec::new(),
                settings: BTreeMap::from([
                    ("temporal_sets".to_owned(), vec![1.into(), 4.into()]),
                    ("size".to_owned(), vec![vec![8, 4].into()]),
                    ("vpls".to_owned(), vec![16.into(), 64.into()]),
                ]),
            },
            settings: toml::toml! { budget = 7 },
        }
    }

    #[test]
    fn all_combinations_are_measured() {
        let combinations = plan().combinations(&toml::toml! { budget = 3 bounces = 5 vpls = 9 }).unwrap();
        let values: Vec<_> = combinations
            .iter()
            .map(|(_, s)| (s.vpl.slots, s.vpl.temporal_sets, s.vpl.set_resolution, s.bounces, s.vpl.budget))
            .collect();
        let expected = [16, 64].map(|vpls| {
            [(1, SetResolution::Auto), (1, SetResolution::Half), (4, SetResolution::Auto)]
                .map(|(sets, resolution)| (vpls, sets, resolution, 5, 7))
        });
        assert_eq!(values, expected.concat());
        assert!(
            combinations.iter().all(|(_, settings)| settings.size == [8, 4] && settings.vpl.interleave == 4)
        );
        assert!(combinations.iter().all(|(method, _)| method.name() == "vpls"));
    }

    #[test]
    fn a_method_is_measured_with_what_it_states() {
        let mut plan = plan();
        plan.sweep.methods =
            ["vpls", "vpls@T=2@vpls=8", "reference@4", "none"].map(|name| name.parse().unwrap()).into();
        let combinations = plan.combinations(&toml::Table::new()).unwrap();
        let of = |name: &str| {
            let found = combinations.iter().filter(|(method, _)| method.name() == name);
            found.map(|(_, s)| (s.vpl.slots, s.vpl.temporal_sets)).collect::<Vec<_>>()
        };
        let all = [(16, 1), (16, 1), (16, 4), (64, 1), (64, 1), (64, 4)];
        assert_eq!((of("vpls"), of("vpls@T=2@vpls=8")), (all.into(), vec![(8, 2)]));
        assert_eq!((of("reference@4").len(), of("none").len()), (4, 1));
    }

    #[test]
    fn invalid_combinations_are_rejected() {
        let mut plan = plan();
        plan.sweep.settings.insert("temporal_sets".to_owned(), vec![1.into(), 32.into()]);
        let error = plan.combinations(&toml::Table::new()).unwrap_err();
        assert!(error.is_usage() && error.to_string().contains("--temporal-sets is 32"), "{error}");
    }

    #[test]
    fn a_difference_is_named_by_its_option() {
        let mut other = plan();
        assert_eq!(plan().difference(&other), None);
        other.sweep.settings.insert("interleave".to_owned(), vec![2.into()]);
        assert_eq!(plan().difference(&other), Some("--interleave".to_owned()));
    }
}
