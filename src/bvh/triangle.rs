//! The ray-triangle test, after Woop, Benthin, Wald 2013, "Watertight Ray/Triangle Intersection".
//!
//! In: a ray in object space and a triangle in leaf order. Out: t and barycentrics. Two triangles that
//! share an edge compute the same edge function with opposite sign, so that with inclusive edges no ray
//! slips between them. `shaders/include/tracer_software.glsl` repeats these operations in this order.

use glam::{DVec3, Vec2, Vec3};

use super::gpu::GpuTriangle;

/// A ray in object space, sheared so that it runs along one axis.
#[derive(Clone, Copy, Debug)]
pub(super) struct TriangleRay {
    origin: Vec3,
    /// The axis of the largest direction component and the two after it, as indices.
    axes: [usize; 3],
    /// Direction of the other two axes over that of the main one, and 1 over that of the main one.
    shear: Vec3,
}

/// Where a ray meets a triangle's plane, within its edges.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TriangleHit {
    pub(super) t: f32,
    pub(super) barycentrics: Vec2,
}

impl TriangleRay {
    /// Prepares a ray; the direction may have any length, and t is in units of it.
    pub(super) fn new(origin: Vec3, direction: Vec3) -> Self {
        let size = direction.abs();
        let main = if size.x > size.y && size.x > size.z {
            0
        } else if size.y > size.z {
            1
        } else {
            2
        };
        let axes = [(main + 1) % 3, (main + 2) % 3, main];
        let along = direction[main];
        let shear = Vec3::new(direction[axes[0]] / along, direction[axes[1]] / along, 1.0 / along);
        Self { origin, axes, shear }
    }

    /// Meets the plane within the edges, both sides, at any t. A degenerate triangle is never hit.
    #[inline(always)]
    pub(super) fn intersect(&self, triangle: &GpuTriangle) -> Option<TriangleHit> {
        // Move the vertices into the frame of the ray.
        let [ax, ay, az] = self.shear_vertex(triangle.v0);
        let [bx, by, bz] = self.shear_vertex(triangle.v1);
        let [cx, cy, cz] = self.shear_vertex(triangle.v2);

        // Evaluate the three edge functions; inclusive edges, either winding.
        let u = cx * by - cy * bx;
        let v = ax * cy - ay * cx;
        let w = bx * ay - by * ax;
        let outside = u.min(v).min(w) < 0.0 && u.max(v).max(w) > 0.0;
        let det = u + v + w;
        if outside || det == 0.0 {
            return None;
        }

        // Interpolate the distance along the main axis.
        let scale = 1.0 / det;
        let t = (u * az + v * bz + w * cz) * scale * self.shear.z;
        Some(TriangleHit { t, barycentrics: Vec2::new(v * scale, w * scale) })
    }

    #[inline(always)]
    fn shear_vertex(&self, vertex: Vec3) -> [f32; 3] {
        let relative = vertex - self.origin;
        let along = relative[self.axes[2]];
        [relative[self.axes[0]] - self.shear.x * along, relative[self.axes[1]] - self.shear.y * along, along]
    }
}

/// Whether a triangle has no area worth hitting: a corner that is not finite, or a height below what
/// its own coordinates can resolve.
pub(super) fn is_degenerate(v0: Vec3, v1: Vec3, v2: Vec3) -> bool {
    if !(v0.is_finite() && v1.is_finite() && v2.is_finite()) {
        return true;
    }
    let [a, b, c] = [v0, v1, v2].map(DVec3::from);
    let longest = (b - a).length_squared().max((c - a).length_squared()).max((c - b).length_squared());
    let doubled_area = (b - a).cross(c - a).length();
    doubled_area <= longest * f64::from(f32::EPSILON)
}
