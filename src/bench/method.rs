//! Methods to light a scene, by short names: `vpls`, `vpls@T=1`, `none@direct=soft`, `reference@4`.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use crate::estimators::{self, Method as Estimator, methods};
use crate::settings::{GivenSettings, Settings, SettingsError};

/// The setting of the estimator.
const INDIRECT: &str = "indirect";
/// The path tracer's name.
const REFERENCE: &str = "reference";
/// All of them.
const ALL: &str = "all";
/// The path tracers that [`ALL`] stands for, besides each estimator and its variants.
const REFERENCES: [&str; 3] = ["reference@1", "reference@4", "reference@16"];

/// A method with settings, which lights the pictures of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Method {
    name: String,
    /// Samples a pixel of the path tracer; none: the renderer.
    samples: Option<u32>,
    /// The settings that its name states.
    settings: toml::Table,
}

impl Method {
    /// The estimator of `settings`.
    pub fn of(settings: &Settings) -> Self {
        let mut table = settings.to_table();
        table.retain(|key, _| key == INDIRECT);
        let name = table.get(INDIRECT).and_then(toml::Value::as_str).unwrap_or_default().to_owned();
        Self { name, samples: None, settings: table }
    }

    /// The path tracer with `samples` samples a pixel.
    pub fn reference(samples: u32) -> Self {
        let name = format!("{REFERENCE}@{samples}");
        Self { name, samples: Some(samples), settings: toml::Table::new() }
    }

    /// The methods of an item of `--methods`: one, or all.
    ///
    /// # Errors
    /// Errors are those of [`Self::from_str`].
    pub fn list(item: &str) -> Result<Vec<Self>, String> {
        if item != ALL {
            return Ok(vec![item.parse()?]);
        }
        let estimators = methods().iter().flat_map(|method| [&[method.name()], method.variants].concat());
        estimators.chain(REFERENCES).map(str::parse).collect()
    }

    /// Short name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Samples a pixel of the path tracer; none: the renderer.
    pub fn samples(&self) -> Option<u32> {
        self.samples
    }

    /// The settings that its name states, by key.
    pub fn settings(&self) -> &toml::Table {
        &self.settings
    }

    /// The number that its name states for a setting.
    pub fn states(&self, setting: &str) -> Option<u32> {
        self.settings.get(setting)?.as_str()?.parse().ok()
    }

    /// Checks the values of its settings.
    fn check(&self) -> Result<(), SettingsError> {
        GivenSettings::from(self.settings.clone()).check()
    }
}

impl FromStr for Method {
    type Err = String;

    /// Reads `NAME[@OPTION=VALUE]...` or `reference@SAMPLES`. An option may have the short form that its axis names, such as `T`.
    fn from_str(text: &str) -> Result<Self, String> {
        let mut parts = text.split('@');
        let base = parts.next().unwrap_or_default();
        if base == REFERENCE {
            let samples: Vec<&str> = parts.collect();
            let [samples] = samples.as_slice() else {
                return Err(format!("must be {REFERENCE}@N with N samples a pixel"));
            };
            let number = samples.parse().ok().filter(|number| *number > 0);
            return Ok(Self::reference(
                number.ok_or_else(|| format!("{samples}: samples must be at least 1"))?,
            ));
        }
        let known: Vec<&str> = methods().iter().map(Estimator::name).collect();
        if !known.contains(&base) {
            return Err(format!("{base}: must be {}, {REFERENCE}@N or {ALL}", known.join(", ")));
        }
        let mut method = Self { name: text.to_owned(), samples: None, settings: toml::Table::new() };
        method.settings.insert(INDIRECT.to_owned(), base.into());
        for part in parts {
            let (key, value) = part.split_once('=').ok_or_else(|| format!("{part}: must be OPTION=VALUE"))?;
            let axis = estimators::axes().find(|axis| axis.short == Some(key));
            let key = axis.map_or_else(|| key.replace('-', "_"), |axis| axis.setting.to_owned());
            method.settings.insert(key, value.into());
        }
        method.check().map_err(|error| error.to_string())?;
        Ok(method)
    }
}

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.name)
    }
}

impl From<Method> for String {
    fn from(method: Method) -> Self {
        method.name
    }
}

impl TryFrom<String> for Method {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        text.parse()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn method(text: &str) -> Method {
        text.parse().unwrap()
    }

    #[test]
    fn names_state_settings() {
        let one = method("vpls@T=1@direct=soft");
        let settings = Settings::from_table(one.settings()).unwrap();
        assert_eq!((settings.vpl.temporal_sets, settings.direct), (1, crate::settings::Direct::Soft));
        assert_eq!((one.samples(), one.to_string().as_str()), (None, "vpls@T=1@direct=soft"));
        assert_eq!(method("reference@4").samples(), Some(4));
        assert_eq!(Method::of(&Settings::default()), method("vpls"));
    }

    #[test]
    fn all_are_those_that_are_registered_and_the_path_tracer() {
        let all = Method::list(ALL).unwrap();
        for name in methods().iter().map(Estimator::name).chain(["vpls@T=1", "reference@4"]) {
            assert!(all.iter().any(|method| method.name() == name), "{name}");
        }
    }

    #[test]
    fn what_is_wrong_is_said() {
        for (text, says) in [
            ("vpl", "vpl: must be vpls, paths, tonna, none, reference@N or all"),
            ("vpls@", "must be OPTION=VALUE"),
            ("vpls@T=0", "temporal-sets 0: must be a whole number, 1 to 64"),
            ("vpls@colour=3", "colour"),
            ("vpls@direct=lamps", "lamps"),
            ("reference", "reference@N"),
            ("reference@0", "at least 1"),
            ("reference@x", "x: samples"),
        ] {
            let error = text.parse::<Method>().unwrap_err();
            assert!(error.contains(says), "{text}: {error}");
        }
    }
}
