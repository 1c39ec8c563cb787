//! What casts rays in the benchmark, and how its answers are compared.

use serde::{Deserialize, Serialize};

use super::super::BenchError;
use super::rays::RaySet;

/// What is asked of a ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Query {
    /// Whether anything is met.
    Occluded,
    /// What is met first.
    Closest,
}

impl Query {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Occluded, Self::Closest];

    /// Its name in tables.
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
    /// What it took, without setting up and without looking at the answers.
    pub seconds: f64,
    /// A number for each ray: negative where nothing was met, else t of the closest hit, or 0 where any would do.
    pub answers: Vec<f32>,
}

/// Something that casts rays.
pub trait Contender {
    /// Its name in tables and files.
    fn name(&self) -> &str;

    /// Casts all rays of a set over all cores.
    ///
    /// # Errors
    /// Where a device fails.
    fn cast(&mut self, set: &RaySet, query: Query) -> Result<Cast, BenchError>;
}

/// How many answers differ: a hit for none, or hits that are not at the same t but for rounding, of t itself and of
/// where the ray begins.
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
