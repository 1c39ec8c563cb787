//! What has become faster or slower since another report, beyond noise.
//!
//! In: two reports. Out: those times of runs that both have whose difference cannot be chance. Frame i shows the same
//! moment in both, so frames are compared in pairs: over blocks of neighbouring frames, which are not independent of
//! each other, the medians are taken and subtracted. How uncertain the mean of these differences is, is told by how far
//! they differ from block to block, and by how far whole runs differ, which the rounds of both reports show; the larger
//! of the two counts. A time has changed if the interval of 99 % about that mean, less a margin, leaves 0 out.

use super::plan::Axis;
use super::report::{Report, Run};
use super::samples::{Samples, TOTAL, Unit};
use super::summary::{Noise, QuantityNoise};
use crate::statistics::{mean, percentile, student_t, variance};

/// Standard errors on either side of a mean that hold 99 % of a normal distribution.
const Z_99: f64 = 2.575_829;
/// Less than this share of the quantity itself is never a change: another process has its memory elsewhere.
const MARGIN: f64 = 0.02;
/// Nor is less than this share of the whole frame.
const MARGIN_OF_FRAME: f64 = 0.005;
/// Nor is less than this, milliseconds: what a thread needs to wake up.
const MARGIN_MS: f64 = 0.005;

/// A time that is another one now.
#[derive(Clone, Debug, PartialEq)]
pub struct Change {
    /// Scene and settings.
    pub run: String,
    /// The frame, a pass, or what lies between.
    pub quantity: &'static str,
    /// Its median before, milliseconds.
    pub old_ms: f64,
    /// Its median now, milliseconds.
    pub new_ms: f64,
    /// By how many milliseconds it has grown: the least and the most, with 99 % confidence.
    pub growth_ms: [f64; 2],
}

impl Change {
    /// Whether it takes longer now.
    pub fn is_slower(&self) -> bool {
        self.growth_ms[0] > 0.0
    }
}

impl std::fmt::Display for Change {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let word = if self.is_slower() { "slower" } else { "faster" };
        let Self { run, quantity, old_ms, new_ms, growth_ms: [low, high] } = self;
        write!(f, "{word}  {run}: {quantity} {old_ms:.3} -> {new_ms:.3} ms, ")?;
        if *old_ms > 0.0 {
            let share = |ms: f64| 100.0 * ms / old_ms;
            write!(f, "{:+.1} % ({:+.1} to {:+.1})", share(new_ms - old_ms), share(*low), share(*high))
        } else {
            write!(f, "{:+.3} ms ({low:+.3} to {high:+.3})", new_ms - old_ms)
        }
    }
}

/// Two reports beside each other.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Comparison {
    /// What has changed beyond noise.
    pub changes: Vec<Change>,
    /// Runs that both have.
    pub compared: usize,
    /// Runs that only one has.
    pub unmatched: usize,
    /// What makes their times incomparable, if anything does.
    pub other_machine: Option<&'static str>,
}

/// Compares those runs that both reports have with the same settings.
pub fn compare_reports(old: &Report, new: &Report) -> Comparison {
    let noise = [Noise::of(&old.runs), Noise::of(&new.runs)];
    let is_same = |a: &Run, b: &Run| a.scene == b.scene && a.settings == b.settings;
    let mut comparison =
        Comparison { other_machine: old.machine.difference(&new.machine), ..Comparison::default() };
    for run in &new.runs {
        let before = old.runs.iter().find(|before| is_same(before, run));
        let Some(before) = before.filter(|before| !before.rounds.is_empty() && !run.rounds.is_empty()) else {
            comparison.unmatched += 1;
            continue;
        };
        comparison.compared += 1;
        comparison.changes.extend(changes([before, run], [&noise[0], &noise[1]]));
    }
    let lost = |run: &&Run| !new.runs.iter().any(|now| is_same(run, now));
    comparison.unmatched += old.runs.iter().filter(lost).count();
    comparison
}

fn changes(runs: [&Run; 2], noise: [&Noise; 2]) -> Vec<Change> {
    let frame_ms = median(&column(runs[0], TOTAL));
    let names =
        Samples::default().quantities().into_iter().filter(|(_, unit, _)| *unit == Unit::Milliseconds);
    let change = |(quantity, ..): (&'static str, Unit, Vec<f64>)| {
        let [old, new] = runs.map(|run| column(run, quantity));
        let noise = [noise[0].quantity(quantity)?, noise[1].quantity(quantity)?];
        let growth_ms = growth([&old, &new], noise)?;
        let [old_ms, new_ms] = [median(&old), median(&new)];
        let margin = (MARGIN * old_ms.min(new_ms)).max(MARGIN_OF_FRAME * frame_ms).max(MARGIN_MS);
        let is_change = growth_ms[0] > margin || growth_ms[1] < -margin;
        let run = Axis::ALL.map(|axis| axis.phrase(&runs[1].settings)).join(", ");
        let run = format!("{}, {run}", runs[1].scene);
        is_change.then_some(Change { run, quantity, old_ms, new_ms, growth_ms })
    };
    names.filter_map(change).collect()
}

/// The samples of a quantity, round by round.
fn column(run: &Run, name: &str) -> Vec<Vec<f64>> {
    let of = |samples: &Samples| {
        let found = samples.quantities().into_iter().find(|(known, ..)| *known == name);
        found.map(|(_, _, column)| column).unwrap_or_default()
    };
    run.rounds().map(of).collect()
}

fn median(rounds: &[Vec<f64>]) -> f64 {
    percentile(rounds.iter().flatten().copied(), 0.5).unwrap_or(0.0)
}

/// The interval in which the growth of a quantity lies, milliseconds; none without frames.
fn growth(rounds: [&[Vec<f64>]; 2], noise: [&QuantityNoise; 2]) -> Option<[f64; 2]> {
    let frames = rounds.iter().flat_map(|rounds| rounds.iter().map(Vec::len)).min()?;
    let [old, new] = rounds.map(|rounds| blocks(rounds, frames));
    let differences: Vec<f64> = old.iter().zip(&new).map(|(old, new)| new - old).collect();
    if differences.is_empty() {
        return None;
    }
    // How far blocks differ; of a single one that is unknown, and only the rounds tell.
    let freedom = differences.len() as f64 - 1.0;
    let of_blocks = student_t(Z_99, freedom) * (variance(&differences) / differences.len() as f64).sqrt();
    // How far whole runs differ.
    let of_runs = [(old, rounds[0], noise[0]), (new, rounds[1], noise[1])]
        .map(|(blocks, rounds, noise)| noise.half_width(Z_99, rounds.len()) * mean(&blocks));
    // What differs between blocks is a part of what differs between runs, so the two are not added.
    let half = of_runs[0].hypot(of_runs[1]).max(of_blocks);
    let growth = mean(&differences);
    Some([growth - half, growth + half])
}

/// Medians over blocks of neighbouring frames, about as many as a block has frames; means over the rounds.
fn blocks(rounds: &[Vec<f64>], frames: usize) -> Vec<f64> {
    let length = (frames as f64).sqrt().ceil() as usize;
    let starts = (0..frames).step_by(length.max(1));
    let block = |start: usize| {
        let medians = rounds
            .iter()
            .filter_map(|round| percentile(round[start..(start + length).min(frames)].iter().copied(), 0.5));
        mean(&medians.collect::<Vec<_>>())
    };
    starts.map(block).collect()
}
