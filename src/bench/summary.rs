//! Statistics of a run, with confidence intervals.
//!
//! In: the samples of all rounds. Out: the spread of each quantity, and for times the confidence interval of the median
//! of another run. Runs vary more than their frames (clocks, caches, other programs), so the interval comes from the
//! variance between rounds of the same setting: that of the logarithm of their medians, pooled over all settings of
//! the report.

use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};

use super::run::Run;
use super::samples::{FPS, Samples, TOTAL, Unit};
use crate::statistics::{Spread, mean, percentile, student_t, variance};

/// Normal quantile of a two-sided 95 % confidence interval.
const Z_95: f64 = 1.959_964;

/// Assumed relative standard deviation between rounds if there is one round only.
pub const ASSUMED_NOISE: f64 = 0.05;

/// Relative standard deviation between rounds above which the machine counts as busy.
const BUSY: f64 = 0.1;

/// Relative variation between rounds of one setting, for each time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Noise {
    quantities: Vec<(&'static str, QuantityNoise)>,
}

/// The noise of one quantity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QuantityNoise {
    /// Variance of the logarithm of a round's median.
    pub variance: f64,
    /// Degrees of freedom of this estimate; none: it is an assumption.
    pub freedom: Option<f64>,
}

impl QuantityNoise {
    /// Relative half-width of the confidence interval, with normal quantile `z`, of the median of `rounds` rounds.
    pub fn half_width(&self, z: f64, rounds: usize) -> f64 {
        let factor = self.freedom.map_or(z, |freedom| student_t(z, freedom));
        factor * (self.variance / rounds.max(1) as f64).sqrt()
    }
}

impl Noise {
    /// Estimates the noise of `runs`.
    pub fn of(runs: &[Run]) -> Self {
        let mut names: Vec<&'static str> = Vec::new();
        for samples in runs.iter().filter_map(|run| run.rounds().next()) {
            let missing: Vec<_> = samples.times().filter(|name| !names.contains(name)).collect();
            names.extend(missing);
        }
        Self { quantities: names.into_iter().map(|name| (name, pooled(runs, name))).collect() }
    }

    /// A warning if rounds differ so much that the machine must have been busy.
    pub fn warning(&self) -> Option<String> {
        let noise = self.quantity(TOTAL)?;
        let share = noise.variance.sqrt();
        (noise.freedom.is_some() && share > BUSY).then(|| {
            format!(
                "Rounds of one setting differ by {:.0} % (standard deviation): other programs or clock changes disturbed \
                 the measurement; see the confidence intervals.",
                100.0 * share
            )
        })
    }

    /// The noise of quantity `name`; frames per second have that of the frame time.
    pub fn quantity(&self, name: &str) -> Option<&QuantityNoise> {
        let name = if name == FPS { TOTAL } else { name };
        self.quantities.iter().find(|(known, _)| *known == name).map(|(_, noise)| noise)
    }
}

/// Pools the variances between the rounds of each run.
fn pooled(runs: &[Run], name: &str) -> QuantityNoise {
    let (mut squares, mut freedom) = (0.0, 0.0);
    for run in runs {
        let medians: Option<Vec<f64>> = run.rounds().map(|samples| median_of(samples, name)).collect();
        // Zero times have no relative variance.
        let Some(medians) = medians.filter(|medians| medians.len() > 1 && medians.iter().all(|m| *m > 0.0))
        else {
            continue;
        };
        let logarithms: Vec<f64> = medians.iter().map(|median| median.ln()).collect();
        let degrees = (medians.len() - 1) as f64;
        squares += variance(&logarithms) * degrees;
        freedom += degrees;
    }
    if freedom > 0.0 {
        QuantityNoise { variance: squares / freedom, freedom: Some(freedom) }
    } else {
        QuantityNoise { variance: ASSUMED_NOISE.powi(2), freedom: None }
    }
}

fn median_of(samples: &Samples, name: &str) -> Option<f64> {
    let (_, _, column) = samples.quantities().into_iter().find(|(known, ..)| *known == name)?;
    percentile(column, 0.5)
}

impl Serialize for Noise {
    /// A map from quantity to its relative standard deviation between rounds.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.quantities.iter().map(|(name, noise)| (name, noise.variance.sqrt())))
    }
}

/// The statistics of one run.
#[derive(Clone, Debug, PartialEq)]
pub struct Summary {
    /// Every quantity, in the order of [`Samples::quantities`].
    pub figures: Vec<Figure>,
}

/// One quantity of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Figure {
    /// Name.
    pub name: &'static str,
    /// Unit.
    pub unit: Unit,
    /// Spread over the frames of all rounds.
    pub spread: Spread,
    /// Interquartile mean: over the middle half of the frames, ordered by frame time. Robust against slow frames, and the
    /// stages add up to it.
    pub midmean: f64,
    /// 95 % confidence interval of the median of another run, for times.
    pub interval: Option<[f64; 2]>,
}

impl Summary {
    /// Summarises a run; none before its first round.
    pub fn of(run: &Run, noise: &Noise) -> Option<Self> {
        let mut quantities = run.rounds.first()?.samples.quantities();
        for samples in run.rounds().skip(1) {
            for ((_, _, all), (_, _, more)) in quantities.iter_mut().zip(samples.quantities()) {
                all.extend(more);
            }
        }
        let middle = middle_half(&quantities.first()?.2);
        let figure = |(name, unit, values): (&'static str, Unit, Vec<f64>)| {
            let spread = Spread::of(&values, unit == Unit::PerSecond)?;
            let interval = noise.quantity(name).filter(|_| spread.median > 0.0).map(|noise| {
                let factor = noise.half_width(Z_95, run.rounds.len()).exp();
                [spread.median / factor, spread.median * factor]
            });
            let midmean = mean(&middle.iter().map(|&frame| values[frame]).collect::<Vec<_>>());
            Some(Figure { name, unit, spread, midmean, interval })
        };
        Some(Self { figures: quantities.into_iter().filter_map(figure).collect() })
    }

    /// The figure of that name.
    pub fn figure(&self, name: &str) -> Option<&Figure> {
        self.figures.iter().find(|figure| figure.name == name)
    }

    /// The median of a quantity; 0 where there is none.
    pub fn median(&self, name: &str) -> f64 {
        self.figure(name).map_or(0.0, |figure| figure.spread.median)
    }

    /// The mean of a quantity; 0 where there is none.
    pub fn mean(&self, name: &str) -> f64 {
        self.figure(name).map_or(0.0, |figure| figure.spread.mean)
    }

    /// See [`Figure::midmean`]; 0 where there is none.
    pub fn midmean(&self, name: &str) -> f64 {
        self.figure(name).map_or(0.0, |figure| figure.midmean)
    }
}

/// Indices of the frames between the first and third quartile.
fn middle_half(totals: &[f64]) -> Vec<usize> {
    let mut frames: Vec<usize> = (0..totals.len()).collect();
    frames.sort_by(|a, b| totals[*a].total_cmp(&totals[*b]));
    let quarter = totals.len() / 4;
    frames[quarter..totals.len() - quarter].to_vec()
}

impl Figure {
    /// Each statistic with its name, as in files.
    pub fn statistics(&self) -> Vec<(&'static str, f64)> {
        let Spread { median, mean, p5, p95, worst } = self.spread;
        let mut statistics =
            vec![("median", median), ("mean", mean), ("midmean", self.midmean), ("p5", p5), ("p95", p95)];
        statistics.push(("worst", worst));
        if let Some([low, high]) = self.interval {
            statistics.extend([("low", low), ("high", high)]);
        }
        statistics
    }
}

impl Serialize for Summary {
    /// A map from quantity to its unit and statistics.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        struct Entry<'a>(&'a Figure);
        impl Serialize for Entry<'_> {
            fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                let mut map = serializer.serialize_map(None)?;
                map.serialize_entry("unit", self.0.unit.symbol())?;
                for (name, value) in self.0.statistics() {
                    map.serialize_entry(name, &value)?;
                }
                map.end()
            }
        }
        serializer.collect_map(self.figures.iter().map(|figure| (key(figure.name), Entry(figure))))
    }
}

/// A quantity's name as a key in JSON and CSV.
pub(super) fn key(name: &str) -> String {
    name.replace('.', "_")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slow_frames_do_not_touch_the_middle_half() {
        assert_eq!(middle_half(&[3.0, 1.0, 900.0, 2.0]), [3, 0]);
        assert_eq!(middle_half(&[5.0, 4.0, 6.0]), [1, 0, 2]);
        assert_eq!(middle_half(&[1.0]), [0]);
    }

    #[test]
    fn unknown_noise_is_assumed() {
        let unknown = pooled(&[], "total");
        assert_eq!((unknown.variance.sqrt(), unknown.freedom), (ASSUMED_NOISE, None));
        let unknown_total =
            Noise { quantities: vec![(TOTAL, QuantityNoise { variance: 1.0, freedom: None })] };
        assert_eq!(unknown_total.warning(), None);
        let busy = Noise { quantities: vec![(TOTAL, QuantityNoise { variance: 0.04, freedom: Some(3.0) })] };
        assert!(busy.warning().unwrap().contains("differ by 20 %"));
        assert!((unknown.half_width(2.0, 4) - ASSUMED_NOISE).abs() < 1e-12);
    }
}
