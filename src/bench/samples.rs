//! The samples of one run, by frame.

use indexmap::IndexMap;
use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize};

use crate::estimators;
use crate::report::FrameFigures;

/// One column per quantity, one value per frame. Times in ms.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Samples {
    /// Time from the start of a frame until the device has finished it.
    pub total_ms: Vec<f64>,
    /// Each pass, in the order of the frame.
    pub passes: Columns<f64>,
    /// The time between passes: recording, uploads, submission, waiting.
    pub other_ms: Vec<f64>,
    /// Counters of the method.
    pub counters: Columns<u64>,
}

/// Columns by name.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Columns<Value>(pub IndexMap<&'static str, Vec<Value>>);

impl<Value> Default for Columns<Value> {
    /// No columns.
    fn default() -> Self {
        Self(IndexMap::new())
    }
}

impl<'de, Value: Deserialize<'de>> Deserialize<'de> for Columns<Value> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let columns = IndexMap::<String, Vec<Value>>::deserialize(deserializer)?;
        let known = |(name, column): (String, Vec<Value>)| {
            let passes = estimators::passes().map(|(_, pass)| pass.name);
            let mut names = passes.chain(estimators::counters().map(|counter| counter.name));
            let name = names.find(|known| *known == name);
            Ok((name.ok_or_else(|| D::Error::custom("no pass and no counter has this name"))?, column))
        };
        Ok(Self(columns.into_iter().map(known).collect::<Result<_, D::Error>>()?))
    }
}

/// Unit of a quantity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    /// Milliseconds.
    Milliseconds,
    /// Frames per second.
    PerSecond,
    /// A count.
    Count,
}

impl Unit {
    /// Symbol in tables.
    pub fn symbol(self) -> &'static str {
        match self {
            Self::Milliseconds => "ms",
            Self::PerSecond => "1/s",
            Self::Count => "",
        }
    }
}

/// The whole frame.
pub const TOTAL: &str = "total";
/// Frames per second.
pub const FPS: &str = "fps";
/// The time between passes.
pub const OTHER: &str = "other";

impl Samples {
    /// Adds a frame that took `wall_ms` from its start until the device had finished it.
    pub fn push(&mut self, wall_ms: f64, figures: &FrameFigures) {
        let total = rounded(wall_ms);
        self.total_ms.push(total);
        let mut stages = 0.0;
        for (name, ms) in &figures.passes {
            let ms = rounded(*ms);
            stages += if estimators::is_part(name) { 0.0 } else { ms };
            self.passes.0.entry(name).or_default().push(ms);
        }
        self.other_ms.push(rounded(total - stages));
        for (name, count) in &figures.counters.0 {
            self.counters.0.entry(name).or_default().push(*count);
        }
    }

    /// Number of frames.
    pub fn len(&self) -> usize {
        self.total_ms.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.total_ms.is_empty()
    }

    /// Whether every column has `frames` values, times are finite, and frame times are positive.
    pub fn is_whole(&self, frames: usize) -> bool {
        let quantities = self.quantities();
        quantities.iter().all(|(_, _, column)| column.len() == frames && column.iter().all(|v| v.is_finite()))
            && self.total_ms.iter().all(|&ms| ms > 0.0)
    }

    /// Every quantity: name, unit, one value for each frame.
    pub fn quantities(&self) -> Vec<(&'static str, Unit, Vec<f64>)> {
        let ms = Unit::Milliseconds;
        let mut quantities = vec![(TOTAL, ms, self.total_ms.clone())];
        quantities.push((FPS, Unit::PerSecond, self.total_ms.iter().map(|ms| 1e3 / ms).collect()));
        quantities.extend(self.passes.0.iter().map(|(name, column)| (*name, ms, column.clone())));
        quantities.push((OTHER, ms, self.other_ms.clone()));
        let counts = |column: &Vec<u64>| column.iter().map(|&count| count as f64).collect();
        let counters = self.counters.0.iter();
        quantities.extend(counters.map(|(name, column)| (*name, Unit::Count, counts(column))));
        quantities
    }

    /// The names of all times.
    pub fn times(&self) -> impl Iterator<Item = &'static str> {
        let times = self.quantities().into_iter().filter(|(_, unit, _)| *unit == Unit::Milliseconds);
        times.map(|(name, ..)| name)
    }
}

/// Rounds to 0.1 us, the resolution of timers.
fn rounded(ms: f64) -> f64 {
    (ms * 1e4).round() / 1e4
}
