//! The interface of tracers in the benchmark, and the comparison of their results.

use serde::{Deserialize, Serialize};

use super::super::BenchError;
use super::rays::RaySet;

/// Query of a ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Query {
    /// Any hit.
    Occluded,
    /// Closest hit.
    Closest,
}

impl Query {
    /// Both queries.
    pub const ALL: [Self; 2] = [Self::Occluded, Self::Closest];

    /// Name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Occluded => "occluded",
            Self::Closest => "closest",
        }
    }
}

/// All rays of a set, cast once.
#[derive(Clone, Debug, Default)]
pub struct Cast {
    /// Time without set-up and without reading the results, seconds.
    pub seconds: f64,
    /// Result of each ray: negative for a miss, else t of the closest hit, or 0 for any hit.
    pub answers: Vec<f32>,
}

/// A tracer under test.
pub trait Contender {
    /// Name in tables and files.
    fn name(&self) -> &str;

    /// Casts all rays of a set, on all cores.
    ///
    /// # Errors
    /// If the device fails.
    fn cast(&mut self, set: &RaySet, query: Query) -> Result<Cast, BenchError>;
}

/// Number of results that differ: hit against miss, or hits whose t differ beyond the rounding of t and of the
/// ray's origin.
pub fn differing(a: &[f32], b: &[f32]) -> usize {
    let differs = |(&a, &b): (&f32, &f32)| {
        let other_hit = (a - b).abs() > 1e-4 * a.abs().max(b.abs()) + 1e-5;
        (a < 0.0) != (b < 0.0) || (a >= 0.0 && other_hit)
    };
    a.iter().zip(b).filter(|pair| differs(*pair)).count() + a.len().abs_diff(b.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn answers_differ_beyond_rounding() {
        assert_eq!(differing(&[1.0, -1.0, 0.0, 2e-6], &[1.00005, -1.0, 0.0, 4e-6]), 0);
        assert_eq!(differing(&[1.0, 1.0, 0.0, -1.0], &[1.001, -1.0, -1.0, 1.0]), 4);
        assert_eq!(differing(&[1.0, 1.0], &[1.0]), 1);
    }
}
