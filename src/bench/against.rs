//! Significant changes of frame and pass times since an earlier report.
//!
//! In: two reports. Out: the times of their common runs whose difference is significant. Frame i shows the same moment
//! in both, so frames are compared in pairs: the medians of blocks of adjacent frames, which are correlated, are
//! subtracted. The standard error of the mean difference is the larger of two estimates: from the variance between
//! blocks, and from that between rounds. A time has changed if the 99 % confidence interval of the mean difference
//! lies outside of a margin around 0.

use super::plan::Axis;
use super::report::{Report, Run};
use super::samples::{Samples, TOTAL};
use super::summary::{Noise, QuantityNoise};
use crate::statistics::{mean, percentile, student_t, variance};

/// Normal quantile of a two-sided 99 % confidence interval.
const Z_99: f64 = 2.575_829;
/// Margin relative to the quantity: memory layout differs between processes.
const MARGIN: f64 = 0.02;
/// Margin relative to the frame time.
const MARGIN_OF_FRAME: f64 = 0.005;
/// Absolute margin, ms: the latency of waking a thread.
const MARGIN_MS: f64 = 0.005;

/// A significant change of a time.
#[derive(Clone, Debug, PartialEq)]
pub struct Change {
    /// Scene and settings.
    pub run: String,
    /// The frame, a pass, or the time between passes.
    pub quantity: &'static str,
    /// Earlier median, ms.
    pub old_ms: f64,
    /// Current median, ms.
    pub new_ms: f64,
    /// 99 % confidence interval of the increase, ms.
    pub growth_ms: [f64; 2],
}

impl Change {
    /// Whether it became slower.
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

/// Comparison of two reports.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Comparison {
    /// Significant changes.
    pub changes: Vec<Change>,
    /// Number of common runs.
    pub compared: usize,
    /// Number of runs in one report only.
    pub unmatched: usize,
    /// The difference between the machines that makes times incomparable, if any.
    pub other_machine: Option<&'static str>,
}

/// Compares the runs with the same scene and settings in both reports.
pub fn compare_reports(old: &Report, new: &Report) -> Comparison {
    let noise = [Noise::of(&old.runs), Noise::of(&new.runs)];
    let mut comparison =
        Comparison { other_machine: old.machine.difference(&new.machine), ..Comparison::default() };
    for run in &new.runs {
        let before = old.runs.iter().find(|before| before.is_same(run));
        let Some(before) = before.filter(|before| !before.rounds.is_empty() && !run.rounds.is_empty()) else {
            comparison.unmatched += 1;
            continue;
        };
        comparison.compared += 1;
        comparison.changes.extend(changes([before, run], [&noise[0], &noise[1]]));
    }
    let lost = |run: &&Run| !new.runs.iter().any(|now| run.is_same(now));
    comparison.unmatched += old.runs.iter().filter(lost).count();
    comparison
}

fn changes(runs: [&Run; 2], noise: [&Noise; 2]) -> Vec<Change> {
    let frame_ms = median(&column(runs[0], TOTAL));
    let names = runs[0].rounds().next().into_iter().flat_map(Samples::times);
    let change = |quantity: &'static str| {
        let [old, new] = runs.map(|run| column(run, quantity));
        let noise = [noise[0].quantity(quantity)?, noise[1].quantity(quantity)?];
        let growth_ms = growth([&old, &new], noise)?;
        let [old_ms, new_ms] = [median(&old), median(&new)];
        let margin = (MARGIN * old_ms.min(new_ms)).max(MARGIN_OF_FRAME * frame_ms).max(MARGIN_MS);
        let is_change = growth_ms[0] > margin || growth_ms[1] < -margin;
        let run = Axis::ALL.map(|axis| axis.phrase(runs[1])).join(", ");
        let run = format!("{}, {run}", runs[1].scene);
        is_change.then_some(Change { run, quantity, old_ms, new_ms, growth_ms })
    };
    names.filter_map(change).collect()
}

/// The samples of a quantity, by round.
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

/// 99 % confidence interval of the increase of a quantity, ms; none without frames.
fn growth(rounds: [&[Vec<f64>]; 2], noise: [&QuantityNoise; 2]) -> Option<[f64; 2]> {
    let frames = rounds.iter().flat_map(|rounds| rounds.iter().map(Vec::len)).min()?;
    let [old, new] = rounds.map(|rounds| blocks(rounds, frames));
    let differences: Vec<f64> = old.iter().zip(&new).map(|(old, new)| new - old).collect();
    if differences.is_empty() {
        return None;
    }
    // Error from the variance between blocks; unknown for a single block.
    let freedom = differences.len() as f64 - 1.0;
    let of_blocks = student_t(Z_99, freedom) * (variance(&differences) / differences.len() as f64).sqrt();
    // Error from the variance between runs.
    let of_runs = [(old, rounds[0], noise[0]), (new, rounds[1], noise[1])]
        .map(|(blocks, rounds, noise)| noise.half_width(Z_99, rounds.len()) * mean(&blocks));
    // The variance between runs includes that between blocks, so take the larger one.
    let half = of_runs[0].hypot(of_runs[1]).max(of_blocks);
    let growth = mean(&differences);
    Some([growth - half, growth + half])
}

/// Medians over sqrt(frames) blocks of adjacent frames, averaged over the rounds.
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
