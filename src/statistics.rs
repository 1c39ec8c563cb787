//! Statistics of measurements: percentiles, spread, Student's t for confidence intervals.

use serde::Serialize;

/// The `quantile` (0 to 1) of `values` by nearest rank, so it is always one of them; none for no values.
pub fn percentile<Value: Copy + PartialOrd>(
    values: impl IntoIterator<Item = Value>,
    quantile: f64,
) -> Option<Value> {
    let mut values: Vec<_> = values.into_iter().collect();
    values.sort_by(|a, b| a.partial_cmp(b).unwrap_or(std::cmp::Ordering::Equal));
    let rank = (quantile * values.len() as f64).ceil() as usize;
    values.get(rank.saturating_sub(1)).copied()
}

/// The arithmetic mean; 0 for no values.
pub fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

/// The unbiased sample variance; 0 for fewer than two values.
pub fn variance(values: &[f64]) -> f64 {
    if values.len() < 2 {
        return 0.0;
    }
    let mean = mean(values);
    values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (values.len() - 1) as f64
}

/// The spread of values; percentiles by nearest rank.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Spread {
    /// 50th percentile.
    pub median: f64,
    /// Arithmetic mean.
    pub mean: f64,
    /// 5th percentile.
    pub p5: f64,
    /// 95th percentile.
    pub p95: f64,
    /// The maximum, or the minimum where more is better.
    pub worst: f64,
}

impl Spread {
    /// The spread of `values`; none for no values.
    pub fn of(values: &[f64], more_is_better: bool) -> Option<Self> {
        let at = |quantile| percentile(values.iter().copied(), quantile);
        let worst = if more_is_better { at(0.0) } else { at(1.0) };
        Some(Self { median: at(0.5)?, mean: mean(values), p5: at(0.05)?, p95: at(0.95)?, worst: worst? })
    }
}

/// The quantile of Student's t distribution with `freedom` degrees of freedom at the probability of the normal
/// quantile `z`: the half-width of a confidence interval in estimated standard errors. By the expansion of Fisher
/// and Cornish (1960); within 3 % for two or more degrees of freedom.
pub fn student_t(z: f64, freedom: f64) -> f64 {
    let n = freedom.max(1.0);
    let g1 = (z.powi(3) + z) / 4.0;
    let g2 = (5.0 * z.powi(5) + 16.0 * z.powi(3) + 3.0 * z) / 96.0;
    let g3 = (3.0 * z.powi(7) + 19.0 * z.powi(5) + 17.0 * z.powi(3) - 15.0 * z) / 384.0;
    let g4 = (79.0 * z.powi(9) + 776.0 * z.powi(7) + 1482.0 * z.powi(5) - 1920.0 * z.powi(3) - 945.0 * z)
        / 92160.0;
    z + g1 / n + g2 / n.powi(2) + g3 / n.powi(3) + g4 / n.powi(4)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_are_nearest_ranks() {
        let tenths = (1..=10).rev().map(f64::from);
        assert_eq!(percentile(tenths.clone(), 0.0), Some(1.0));
        assert_eq!(percentile(tenths.clone(), 0.5), Some(5.0));
        assert_eq!(percentile(tenths.clone(), 0.95), Some(10.0));
        assert_eq!(percentile(tenths, 1.0), Some(10.0));
        assert_eq!(percentile(1..=100, 0.95), Some(95));
        assert_eq!(percentile([3, 1, 2], 0.5), Some(2));
        assert_eq!(percentile([7], 0.95), Some(7));
        assert_eq!(percentile([0u8; 0], 0.5), None);
    }

    #[test]
    fn the_worst_depends_on_whether_more_is_better() {
        let values: Vec<f64> = (1..=40).map(f64::from).collect();
        let times = Spread::of(&values, false).unwrap();
        assert_eq!(times, Spread { median: 20.0, mean: 20.5, p5: 2.0, p95: 38.0, worst: 40.0 });
        assert_eq!(Spread::of(&values, true).unwrap(), Spread { worst: 1.0, ..times });
        assert_eq!(Spread::of(&[], true), None);
    }

    #[test]
    fn variance_is_unbiased() {
        assert!((variance(&[1.0, 2.0, 3.0, 4.0]) - 5.0 / 3.0).abs() < 1e-12);
        assert_eq!(variance(&[1.0]), 0.0);
    }

    #[test]
    fn student_t_matches_published_tables() {
        // Two-sided 95 % and 99 %.
        for (z, freedom, t) in [
            (1.959_964, 2.0, 4.303),
            (1.959_964, 5.0, 2.571),
            (1.959_964, 30.0, 2.042),
            (2.575_829, 4.0, 4.604),
            (2.575_829, 10.0, 3.169),
            (2.575_829, 1e9, 2.576),
        ] {
            let found = student_t(z, freedom);
            assert!((found / t - 1.0).abs() < 0.03, "{freedom}: {found} {t}");
        }
    }
}
