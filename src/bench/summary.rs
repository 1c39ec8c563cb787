//! What the samples of a run amount to, and how certain that is.
//!
//! In: the samples of all rounds. Out: for each quantity its spread, and of times the interval in which the median
//! of another run is to be expected. Runs differ by more than their frames do (clocks, caches, other programs),
//! so the interval comes from how rounds of the same setting differ: the variance of the logarithm of their
//! medians, pooled over all settings of the report.

use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};

use super::report::Run;
use super::samples::{FPS, Samples, TOTAL, Unit};
use crate::statistics::{Spread, mean, percentile, student_t, variance};

/// Standard errors on either side of a mean that hold 95 % of a normal distribution.
const Z_95: f64 = 1.959_964;

/// The relative standard deviation between rounds that is assumed where there is one round only.
pub const ASSUMED_NOISE: f64 = 0.05;

/// A machine of which rounds differ by more than this share is not a quiet one.
const BUSY: f64 = 0.1;

/// How much rounds of one setting differ: of each time, relative to itself.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Noise {
    quantities: Vec<(&'static str, QuantityNoise)>,
}

/// That of one quantity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QuantityNoise {
    /// Variance of the logarithm of a round's median.
    pub variance: f64,
    /// Degrees of freedom of this estimate; none: it is an assumption.
    pub freedom: Option<f64>,
}

impl QuantityNoise {
    /// Relative half-width of the interval that holds the share that `z` stands for of medians of `rounds` rounds.
    pub fn half_width(&self, z: f64, rounds: usize) -> f64 {
        let factor = self.freedom.map_or(z, |freedom| student_t(z, freedom));
        factor * (self.variance / rounds.max(1) as f64).sqrt()
    }
}

impl Noise {
    /// That of all `runs`.
    pub fn of(runs: &[Run]) -> Self {
        let names =
            Samples::default().quantities().into_iter().filter(|(_, unit, _)| *unit == Unit::Milliseconds);
        Self { quantities: names.map(|(name, ..)| (name, pooled(runs, name))).collect() }
    }

    /// What to say where rounds differ so much that something else must have kept the machine busy.
    pub fn warning(&self) -> Option<String> {
        let noise = self.quantity(TOTAL)?;
        let share = noise.variance.sqrt();
        (noise.freedom.is_some() && share > BUSY).then(|| {
            format!(
                "Rounds of one setting differ by {:.0} % (standard deviation): other programs or a changing clock have \
                 disturbed the measurement, and figures are as uncertain as the intervals say.",
                100.0 * share
            )
        })
    }

    /// That of the quantity `name`; frames a second have that of the frame.
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
        // What takes no time at all has no relative variance.
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

/// The figures of one run.
#[derive(Clone, Debug, PartialEq)]
pub struct Summary {
    /// Every quantity, in the order of [`Samples::quantities`].
    pub figures: Vec<Figure>,
}

/// One quantity of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Figure {
    /// Its name.
    pub name: &'static str,
    /// What it is counted in.
    pub unit: Unit,
    /// Over the frames of all rounds.
    pub spread: Spread,
    /// Mean over the middle half of the frames, ordered by their time as a whole: what slow frames of a busy machine
    /// do not touch, and what the stages of a frame add up to.
    pub midmean: f64,
    /// Of times: where the median of another run is to be expected, with 95 % confidence.
    pub interval: Option<[f64; 2]>,
}

impl Summary {
    /// Sums up a run; none before its first round.
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

/// The numbers of the frames that are neither among the fastest nor among the slowest quarter.
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
        serializer.collect_map(self.figures.iter().map(|figure| (figure.name, Entry(figure))))
    }
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
