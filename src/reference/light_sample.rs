//! A light sample, and its weight beside scattered rays.

use std::f32::consts::PI;

use glam::Vec3;

/// A light sample at a point, before the visibility test.
#[derive(Clone, Copy, Debug)]
pub(super) struct LightSample {
    /// Unit direction to the light.
    pub(super) direction: Vec3,
    /// End of the shadow ray.
    pub(super) end: ShadowEnd,
    /// Irradiance perpendicular to the direction over the probability of the light, W/m^2, and over the pdf of the
    /// direction where it is one of many.
    pub(super) irradiance: Vec3,
    /// Pdf of the direction over solid angle, 1/sr; none if no scattered ray can hit the light.
    pub(super) pdf: Option<f32>,
}

/// Where a shadow ray ends.
#[derive(Clone, Copy, Debug)]
pub(super) enum ShadowEnd {
    /// A point, offset from the light's surface if it has one.
    Point(Vec3),
    /// After this distance along the direction; infinite where nothing is behind the light.
    Distance(f32),
}

impl LightSample {
    /// Its weight beside scattered rays that have this density in its direction: 1 if none can hit the light.
    pub(super) fn share(&self, density: f32) -> f32 {
        self.pdf.map_or(1.0, |pdf| power_heuristic(pdf, density))
    }
}

/// The power heuristic (Veach 1997, equation 9.18, exponent 2): the weight of a sample with pdf `own` where
/// the other technique has pdf `other`.
pub(super) fn power_heuristic(own: f32, other: f32) -> f32 {
    let ratio = other / own;
    1.0 / (1.0 + ratio * ratio)
}

/// Pdf of a cosine-weighted direction, 1/sr.
pub(super) fn cosine_pdf(cosine: f32) -> f32 {
    cosine / PI
}
