//! Importance sampling of the start of directional lights' paths.
//!
//! In: a scene. Out: a disc that covers it, with a core around its detail. A few large triangles (a ground
//! plane, a backdrop) often make the bounds much wider than the interesting part, which a uniform density over
//! the bounds would seldom hit. So the density is uniform in the core and falls with the squared distance
//! outside, where all rings of VPLs then contribute equally to the core. Weights keep the estimate unbiased.

use glam::{Vec2, Vec3};

use crate::sampling;
use crate::scene::{BoundingSphere, Scene};

/// Triangles sampled at most.
const MAX_TRIANGLES: usize = 1 << 16;

/// The sphere around 90 % of the triangle centroids at rest; none without triangles.
pub(super) fn focus_at_rest(scene: &Scene) -> Option<BoundingSphere> {
    let stride = scene.triangle_count().div_ceil(MAX_TRIANGLES).max(1);
    let visible = scene.instances.iter().filter(|instance| instance.visible);
    let centroids: Vec<Vec3> = visible
        .flat_map(|instance| {
            let mesh = &scene.meshes[instance.mesh];
            (0..mesh.triangles.len() as u32).map(move |triangle| (instance, mesh, triangle))
        })
        .step_by(stride)
        .map(|(instance, mesh, triangle)| {
            let centroid = mesh.triangle_positions(triangle).iter().sum::<Vec3>() / 3.0;
            instance.transform.transform_point3(centroid)
        })
        .collect();
    if centroids.is_empty() {
        return None;
    }
    let median = |axis: usize| {
        let values = centroids.iter().map(|centroid| centroid[axis]).collect();
        quantile(values, 0.5)
    };
    let center = Vec3::new(median(0), median(1), median(2));
    let distances = centroids.iter().map(|centroid| centroid.distance(center)).collect();
    Some(BoundingSphere { center, radius: quantile(distances, 0.9) })
}

fn quantile(mut values: Vec<f32>, fraction: f32) -> f32 {
    let index = ((values.len() - 1) as f32 * fraction) as usize;
    *values.select_nth_unstable_by(index, f32::total_cmp).1
}

/// A disc perpendicular to a light's direction, with the highest sample density in its core.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct FocusedDisc {
    /// Covers the scene; the light's flux is that through this disc.
    pub(super) bounds: BoundingSphere,
    /// Radius of the core of uniform density, at most that of the bounds.
    core: f32,
}

impl FocusedDisc {
    /// Covers `bounds`, with its core at `focus`; uniform if the focus is not much smaller than the bounds.
    pub(super) fn new(bounds: &BoundingSphere, focus: Option<&BoundingSphere>) -> Self {
        let narrow = focus.filter(|f| f.radius > 0.0 && f.radius < 0.5 * bounds.radius);
        let Some(focus) = narrow else {
            return Self { bounds: *bounds, core: bounds.radius };
        };
        let radius = bounds.radius + bounds.center.distance(focus.center);
        Self { bounds: BoundingSphere { center: focus.center, radius }, core: focus.radius }
    }

    /// Fraction of the samples that fall into the core.
    fn core_share(&self) -> f32 {
        1.0 / (1.0 + 2.0 * (self.bounds.radius / self.core).ln())
    }

    /// Weight of a sample in the core: the uniform density of the whole disc over the density of the core.
    pub(super) fn core_weight(&self) -> f32 {
        self.core_area() / self.core_share()
    }

    /// Share of the disc's area that the core has.
    pub(super) fn core_area(&self) -> f32 {
        (self.core / self.bounds.radius).powi(2)
    }

    /// Samples a point of the disc, in units of the bounds' radius, with its weight (uniform density / density).
    pub(super) fn sample(&self, u: Vec2) -> (Vec2, f32) {
        let uniform = sampling::disc(u);
        if self.core == self.bounds.radius {
            return (uniform, 1.0);
        }
        let share = self.core_share();
        let area = uniform.length_squared();
        // Radius in units of the core's, by inversion of its distribution.
        let radius = if area <= share { (area / share).sqrt() } else { (0.5 * (area / share - 1.0)).exp() };
        let direction = uniform.normalize_or_zero();
        let position = direction * (radius * self.core / self.bounds.radius);
        (position, self.core_weight() * radius.max(1.0).powi(2))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weighted_density_is_uniform() {
        let sphere = |radius| BoundingSphere { center: Vec3::ZERO, radius };
        for core in [0.01, 0.1, 0.4, 0.9] {
            let disc = FocusedDisc::new(&sphere(1.0), Some(&sphere(core)));
            let mut flux = [0.0f64; 16];
            let points = 65_536;
            let mut in_core = 0;
            for index in 0..points {
                let (p, weight) = disc.sample(sampling::sequence_point(index, 0, 1));
                // Rings of equal area.
                let ring = ((p.length_squared() * 16.0) as usize).min(15);
                flux[ring] += f64::from(weight) / f64::from(points);
                in_core += u32::from(p.length() <= core);
                assert!(p.length() < 1.0 + 1e-5);
            }
            for flux in flux {
                assert!((flux * 16.0 - 1.0).abs() < 0.02, "core {core}: {}", flux * 16.0);
            }
            let expected = if core < 0.5 { 1.0 / (1.0 - 2.0 * core.ln()) } else { core * core };
            assert!((in_core as f32 / points as f32 - expected).abs() < 0.01, "core {core}");
        }
    }
}
