//! Significant changes of frame and pass times, and of errors, since an earlier report.
//!
//! In: two reports. Out: the times of their common runs whose difference is significant, and the errors that differ. Frame
//! i shows the same moment in both, so frames are compared in pairs: the medians of blocks of adjacent frames, which are
//! correlated, are subtracted. The standard error of the mean difference is the larger of two estimates: from the variance
//! between blocks, and from that between rounds. A time has changed if the 99 % confidence interval of the mean difference
//! lies outside of a margin around 0.

use super::axis::Axis;
use super::report::Report;
use super::run::Run;
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

/// Relative and absolute margin of an error: drivers round differently.
const ERROR_MARGINS: [f64; 2] = [0.02, 0.001];
/// The error against the path tracer.
const FLIP: &str = "FLIP error";

/// A significant change of a time or an error.
#[derive(Clone, Debug, PartialEq)]
pub struct Change {
    /// Scene and settings.
    pub run: String,
    /// The frame, a pass, the time between passes, or an error.
    pub quantity: &'static str,
    /// Earlier median in ms, or earlier error.
    pub old: f64,
    /// Current one.
    pub new: f64,
    /// 99 % confidence interval of the increase.
    pub growth: [f64; 2],
}

impl Change {
    /// Whether it became slower or worse.
    pub fn is_regression(&self) -> bool {
        self.growth[0] > 0.0
    }
}

impl std::fmt::Display for Change {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { run, quantity, old, new, growth: [low, high] } = self;
        if *quantity == FLIP {
            let word = if self.is_regression() { "worse" } else { "better" };
            return write!(f, "{word}  {run}: {quantity} {old:.4} -> {new:.4}");
        }
        let word = if self.is_regression() { "slower" } else { "faster" };
        write!(f, "{word}  {run}: {quantity} {old:.3} -> {new:.3} ms, ")?;
        if *old > 0.0 {
            let share = |ms: f64| 100.0 * ms / old;
            write!(f, "{:+.1} % ({:+.1} to {:+.1})", share(new - old), share(*low), share(*high))
        } else {
            write!(f, "{:+.3} ms ({low:+.3} to {high:+.3})", new - old)
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
        let growth = growth([&old, &new], noise)?;
        let [old, new] = [median(&old), median(&new)];
        let margin = (MARGIN * old.min(new)).max(MARGIN_OF_FRAME * frame_ms).max(MARGIN_MS);
        let is_change = growth[0] > margin || growth[1] < -margin;
        is_change.then_some(Change { run: described(runs[1]), quantity, old, new, growth })
    };
    names.filter_map(change).chain(error_change(runs)).collect()
}

/// Errors of one build on one device are the same each time, so that they have no confidence interval.
fn error_change(runs: [&Run; 2]) -> Option<Change> {
    let error = |run: &Run| Some(run.quality.as_ref()?.mean(|frame| frame.flip));
    let [old, new] = [error(runs[0])?, error(runs[1])?];
    let [relative, absolute] = ERROR_MARGINS;
    let is_change = (new - old).abs() > (relative * old).max(absolute);
    is_change.then(|| Change { run: described(runs[1]), quantity: FLIP, old, new, growth: [new - old; 2] })
}

/// Scene, method and settings.
fn described(run: &Run) -> String {
    format!("{}, {}", run.scene, Axis::of(run).map(|axis| axis.phrase(run)).collect::<Vec<_>>().join(", "))
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
