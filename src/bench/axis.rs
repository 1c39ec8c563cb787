//! Runs differ in these: the method, and the settings that are swept.

use super::run::Run;
use crate::estimators;
use crate::settings::Settings;

/// Bounces of a light path, which all methods share.
const BOUNCES: estimators::Axis = estimators::Axis {
    setting: "bounces",
    short: None,
    label: "bounces",
    phrase: "{} bounces",
    default_sweep: None,
    divides_work: false,
    get: |settings| settings.bounces,
    set: |settings, bounces| settings.bounces = bounces.clamp(1, 16),
    half: None,
};

/// The method or a setting, which can be swept.
#[derive(Clone, Copy, Debug)]
pub enum Axis {
    /// The method.
    Method,
    /// Width and height.
    Size,
    /// A whole number among the settings.
    Number(&'static estimators::Axis),
}

impl PartialEq for Axis {
    fn eq(&self, other: &Self) -> bool {
        self.key() == other.key()
    }
}

impl Axis {
    /// All axes. The first with several values is that of the tables' columns.
    pub fn all() -> Vec<Self> {
        let mut axes = vec![Self::Method];
        for axis in estimators::axes().map(Self::Number).chain([Self::Size, Self::Number(&BOUNCES)]) {
            if !axes.contains(&axis) {
                axes.push(axis);
            }
        }
        axes
    }

    /// The axes along which the method of a run changes.
    pub fn of(run: &Run) -> impl Iterator<Item = Self> {
        let own = estimators::method(&run.settings).axes;
        let others = |key| {
            !own.iter().any(|axis| axis.setting == key) && estimators::axes().any(|axis| axis.setting == key)
        };
        Self::all().into_iter().filter(move |axis| !others(axis.key()))
    }

    /// Whether it means anything to the estimator that `settings` name, if they name one.
    pub fn concerns(self, settings: &toml::Table) -> bool {
        let Self::Number(axis) = self else { return true };
        let named = Settings::from_table(settings).ok().filter(|_| settings.contains_key("indirect"));
        let is_of = |method: &estimators::Method| method.axes.iter().any(|own| own.setting == axis.setting);
        named
            .is_none_or(|named| is_of(estimators::method(&named)) || !estimators::methods().iter().any(is_of))
    }

    /// The first axis of the method of a run, if it has any: tables name it where nothing varies.
    pub fn main(run: &Run) -> Option<Self> {
        estimators::method(&run.settings).axes.first().map(Self::Number)
    }

    /// Key of the setting.
    pub fn key(self) -> &'static str {
        match self {
            Self::Method => "method",
            Self::Size => "size",
            Self::Number(axis) => axis.setting,
        }
    }

    /// Label in plots and tables.
    pub fn label(self) -> &'static str {
        match self {
            Self::Method => "method",
            Self::Size => "size in pixels",
            Self::Number(axis) => axis.label,
        }
    }

    /// Value of the axis for `run` as a coordinate of a plot; for a size the number of pixels; none for a method.
    pub fn value(self, run: &Run) -> Option<f64> {
        match self {
            Self::Method => None,
            Self::Size => Some(run.settings.size.map(f64::from).iter().product()),
            Self::Number(axis) => Some((axis.get)(&run.settings).into()),
        }
    }

    /// Value of the axis for `run` as text.
    pub fn text(self, run: &Run) -> String {
        match self {
            Self::Method => run.method.to_string(),
            Self::Size => run.settings.size.map(|side| side.to_string()).join("x"),
            Self::Number(axis) => axis.text(&run.settings),
        }
    }

    /// Value of the axis for `run` as a phrase.
    pub fn phrase(self, run: &Run) -> String {
        match self {
            Self::Number(axis) => axis.phrase((axis.get)(&run.settings)) + axis.note(&run.settings),
            _ => self.text(run),
        }
    }
}
