//! Bounds of points.

use glam::Vec3;

/// Largest magnitude of a coordinate: products of larger ones could overflow.
pub(crate) const MAX_COORDINATE: f32 = 1e9;

/// A bounding sphere, world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoundingSphere {
    /// Centre.
    pub center: Vec3,
    /// Radius, > 0.
    pub radius: f32,
}

impl BoundingSphere {
    /// The bounding sphere of the box (min, max).
    pub fn around((min, max): (Vec3, Vec3)) -> Self {
        let radius = 0.5 * min.distance(max);
        Self { center: 0.5 * (min + max), radius: radius.max(f32::MIN_POSITIVE) }
    }
}

/// Bounds (min, max) of `points`; none for no points.
pub(crate) fn bounds_of(points: impl Iterator<Item = Vec3>) -> Option<(Vec3, Vec3)> {
    points.fold(None, |bounds, point| match bounds {
        None => Some((point, point)),
        Some((min, max)) => Some((min.min(point), max.max(point))),
    })
}
