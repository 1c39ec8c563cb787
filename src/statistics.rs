//! What many measurements amount to: percentiles, spread, and how certain they are.

use serde::Serialize;

/// The smallest of `values` that at least the share `quantile` (0 to 1) of them does not exceed
/// (nearest rank, so it is always one of the values); none if there are none.
pub fn percentile<Value: Copy + PartialOrd>(
    values: impl IntoIterator<Item = Value>,
    quantile: f64,
) -> Option<Value> {
    let mut values: Vec<_> = values.into_iter().collect();
    values.sort_by(|a, b| a.partial_cmp(b).unwrap_or(std::cmp::Ordering::Equal));
    let rank = (quantile * values.len() as f64).ceil() as usize;
    values.get(rank.saturating_sub(1)).copied()
}

/// The mean; 0 of nothing.
pub fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

/// The variance of what `values` were drawn from; 0 of fewer than two.
pub fn variance(values: &[f64]) -> f64 {
    if values.len() < 2 {
        return 0.0;
    }
    let mean = mean(values);
    values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (values.len() - 1) as f64
}

/// How values are spread; percentiles by nearest rank.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Spread {
    /// Half of the values are at or below.
    pub median: f64,
    /// Their mean.
    pub mean: f64,
    /// 5 % of the values are at or below.
    pub p5: f64,
    /// 95 % of the values are at or below.
    pub p95: f64,
    /// The greatest, or the least where more is better.
    pub worst: f64,
}

impl Spread {
    /// The spread of `values`; none if there are none.
    pub fn of(values: &[f64], more_is_better: bool) -> Option<Self> {
        let at = |quantile| percentile(values.iter().copied(), quantile);
        let worst = if more_is_better { at(0.0) } else { at(1.0) };
        Some(Self { median: at(0.5)?, mean: mean(values), p5: at(0.05)?, p95: at(0.95)?, worst: worst? })
    }
}

/// Student's t: how many standard errors, estimated from a sample with `freedom` degrees of freedom, lie on
/// either side of a mean where a normal distribution would have `z`. By the expansion of Fisher and Cornish
/// (1960), which is within 3 % from two degrees on.
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
    fn the_worst_is_where_less_or_more_is_better() {
        let values: Vec<f64> = (1..=40).map(f64::from).collect();
        let times = Spread::of(&values, false).unwrap();
        assert_eq!(times, Spread { median: 20.0, mean: 20.5, p5: 2.0, p95: 38.0, worst: 40.0 });
        assert_eq!(Spread::of(&values, true).unwrap(), Spread { worst: 1.0, ..times });
        assert_eq!(Spread::of(&[], true), None);
    }

    #[test]
    fn variances_are_of_samples() {
        assert!((variance(&[1.0, 2.0, 3.0, 4.0]) - 5.0 / 3.0).abs() < 1e-12);
        assert_eq!(variance(&[1.0]), 0.0);
    }

    #[test]
    fn quantiles_of_student_are_those_of_the_tables() {
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
