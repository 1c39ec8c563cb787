//! Where the paths of directional lights are worth starting.
//!
//! In: a scene. Out: a disc that covers it, with a core where its detail is. A few large triangles (a
//! ground plane, a backdrop) often make a scene's bounds many times as wide as the part that anyone looks
//! at, and paths spread evenly over the bounds would hardly ever reach that part. So the core gets an even
//! share, and the ring around it a density that falls with the square of the distance, for which each ring
//! of VPLs adds as much to the light in the core as the next. Weights keep the estimate unbiased.

use glam::{Vec2, Vec3};

use crate::sampling;
use crate::scene::{BoundingSphere, Scene};

/// Most triangles looked at.
const MOST_TRIANGLES: usize = 1 << 16;

/// The sphere about nine tenths of the triangles, by their middles at rest; none without triangles.
pub(super) fn focus_at_rest(scene: &Scene) -> Option<BoundingSphere> {
    let stride = scene.triangle_count().div_ceil(MOST_TRIANGLES).max(1);
    let visible = scene.instances.iter().filter(|instance| instance.visible);
    let middles: Vec<Vec3> = visible
        .flat_map(|instance| {
            let mesh = &scene.meshes[instance.mesh];
            (0..mesh.triangles.len() as u32).map(move |triangle| (instance, mesh, triangle))
        })
        .step_by(stride)
        .map(|(instance, mesh, triangle)| {
            let middle = mesh.triangle_positions(triangle).iter().sum::<Vec3>() / 3.0;
            instance.transform.transform_point3(middle)
        })
        .collect();
    if middles.is_empty() {
        return None;
    }
    let median = |axis: usize| {
        let values = middles.iter().map(|middle| middle[axis]).collect();
        quantile(values, 0.5)
    };
    let center = Vec3::new(median(0), median(1), median(2));
    let distances = middles.iter().map(|middle| middle.distance(center)).collect();
    Some(BoundingSphere { center, radius: quantile(distances, 0.9) })
}

fn quantile(mut values: Vec<f32>, part: f32) -> f32 {
    let index = ((values.len() - 1) as f32 * part) as usize;
    *values.select_nth_unstable_by(index, f32::total_cmp).1
}

/// A disc across a light's direction, densest in its core.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct FocusedDisc {
    /// Covers the scene, and is what the light's flux counts.
    pub(super) bounds: BoundingSphere,
    /// Radius of the even core, at most that of the bounds.
    core: f32,
}

impl FocusedDisc {
    /// Covers `bounds` with its core on `focus`, unless that is most of it anyway.
    pub(super) fn new(bounds: &BoundingSphere, focus: Option<&BoundingSphere>) -> Self {
        let narrow = focus.filter(|f| f.radius > 0.0 && f.radius < 0.5 * bounds.radius);
        let Some(focus) = narrow else {
            return Self { bounds: *bounds, core: bounds.radius };
        };
        let radius = bounds.radius + bounds.center.distance(focus.center);
        Self { bounds: BoundingSphere { center: focus.center, radius }, core: focus.radius }
    }

    /// Share of the points that fall into the core.
    fn core_share(&self) -> f32 {
        1.0 / (1.0 + 2.0 * (self.bounds.radius / self.core).ln())
    }

    /// Density of the whole disc, were it even, over that of the core: how much of the light's flux is
    /// worth paths.
    pub(super) fn worth(&self) -> f32 {
        (self.core / self.bounds.radius).powi(2) / self.core_share()
    }

    /// A point of the disc in units of the bounds' radius, and the weight that makes up for its density.
    pub(super) fn sample(&self, u: Vec2) -> (Vec2, f32) {
        let even = sampling::disc(u);
        if self.core == self.bounds.radius {
            return (even, 1.0);
        }
        let share = self.core_share();
        let inside = even.length_squared();
        // The radius in units of the core's, by the inverse of its distribution.
        let radius =
            if inside <= share { (inside / share).sqrt() } else { (0.5 * (inside / share - 1.0)).exp() };
        let direction = even.normalize_or_zero();
        let place = direction * (radius * self.core / self.bounds.radius);
        (place, self.worth() * radius.max(1.0).powi(2))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_make_up_for_density() {
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
