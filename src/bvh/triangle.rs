//! The watertight ray-triangle test (Woop, Benthin, Wald 2013, "Watertight Ray/Triangle Intersection"), on four
//! triangles at once.
//!
//! In: a ray in object space and four triangles in SIMD layout. Out: t and barycentrics. Two triangles that share
//! an edge compute the same edge function with opposite sign, so with inclusive edges no ray passes between them.
//! `shaders/include/tracer_software.glsl` repeats these operations in this order.

use glam::{DVec3, Vec3, Vec3A, Vec4};

use super::gpu::GpuTriangle;

/// Triangles per test.
pub(super) const LANES: usize = 4;

/// Up to four triangles in SIMD layout.
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C, align(64))]
pub(super) struct TriangleBlock {
    /// Coordinates by axis and corner. Unused lanes hold a degenerate triangle, which is never hit.
    corners: [[Vec4; 3]; 3],
    /// Indices into the mesh's triangles.
    pub(super) ids: [u32; LANES],
    /// As in [`GpuTriangle::masked`].
    pub(super) masked: [u32; LANES],
    /// Pads to three cache lines.
    padding: [u32; 4],
}

impl TriangleBlock {
    /// A block of degenerate triangles at `position`.
    pub(super) fn empty(position: Vec3) -> Self {
        Self {
            corners: position.to_array().map(|coordinate| [Vec4::splat(coordinate); 3]),
            ids: [0; LANES],
            masked: [0; LANES],
            padding: [0; 4],
        }
    }

    /// Stores a triangle in a lane.
    pub(super) fn set(&mut self, lane: usize, triangle: &GpuTriangle) {
        let corners = [triangle.v0, triangle.v1, triangle.v2];
        for (axis, planes) in self.corners.iter_mut().enumerate() {
            for (corner, plane) in planes.iter_mut().enumerate() {
                plane[lane] = corners[corner][axis];
            }
        }
        self.ids[lane] = triangle.id;
        self.masked[lane] = triangle.masked;
    }
}

/// For each main axis: the next two axes, then itself.
static AXES: [[usize; 3]; 3] = [[1, 2, 0], [2, 0, 1], [0, 1, 2]];

/// A ray in object space with the shear that aligns it with its main axis.
#[derive(Clone, Copy, Debug)]
pub(super) struct TriangleRay {
    /// The row of [`AXES`] for the main axis, that of the largest direction component.
    axes: [usize; 3],
    /// In the order of `axes`.
    origin: [Vec4; 3],
    /// The other two direction components over the main one, and 1 over the main one.
    shear: [Vec4; 3],
}

/// Intersections of a ray with a block's triangles.
#[derive(Clone, Copy, Debug)]
pub(super) struct BlockHits {
    /// Bit mask of the triangles hit.
    pub(super) mask: u32,
    pub(super) t: Vec4,
    /// Weights of the second and of the third corner.
    pub(super) barycentrics: [Vec4; 2],
}

impl TriangleRay {
    /// Prepares a ray; the direction need not be of unit length, and t is in units of it.
    #[inline(always)]
    pub(super) fn new(origin: Vec3A, direction: Vec3A) -> Self {
        let size = direction.abs();
        // Without branches, which would be unpredictable: evaluating both sides costs less than a misprediction.
        let main = if (size.x > size.y) & (size.x > size.z) { 0 } else { 2 - usize::from(size.y > size.z) };
        let axes = AXES[main];
        let (origin, direction) = (origin.to_array(), direction.to_array());
        let [x, y, along] = axes.map(|axis| direction[axis]);
        let shear = Vec3A::new(x, y, 1.0) / along;
        Self {
            axes,
            origin: axes.map(|axis| Vec4::splat(origin[axis])),
            shear: shear.to_array().map(Vec4::splat),
        }
    }

    /// Intersects both sides of the triangles where t_min < t <= t_max. Degenerate triangles are never hit.
    #[inline(always)]
    pub(super) fn intersect(&self, block: &TriangleBlock, t_min: Vec4, t_max: f32) -> Option<BlockHits> {
        // Transform the vertices into the sheared ray space.
        let [ax, ay, az] = self.shear_corner(block, 0);
        let [bx, by, bz] = self.shear_corner(block, 1);
        let [cx, cy, cz] = self.shear_corner(block, 2);

        // Evaluate the three edge functions; inclusive edges, either winding.
        let u = cx * by - cy * bx;
        let v = ax * cy - ay * cx;
        let w = bx * ay - by * ax;
        let outside = u.min(v).min(w).cmplt(Vec4::ZERO) & u.max(v).max(w).cmpgt(Vec4::ZERO);
        let det = u + v + w;
        let inside = !outside & det.cmpne(Vec4::ZERO);
        if !inside.any() {
            return None;
        }

        // Interpolate the distance along the main axis.
        let scale = 1.0 / det;
        let t = (u * az + v * bz + w * cz) * scale * self.shear[2];
        let mask = (inside & t.cmpgt(t_min) & t.cmple(Vec4::splat(t_max))).bitmask();
        (mask != 0).then(|| BlockHits { mask, t, barycentrics: [v * scale, w * scale] })
    }

    #[inline(always)]
    fn shear_corner(&self, block: &TriangleBlock, corner: usize) -> [Vec4; 3] {
        let relative = |i: usize| block.corners[self.axes[i]][corner] - self.origin[i];
        let along = relative(2);
        [relative(0) - self.shear[0] * along, relative(1) - self.shear[1] * along, along]
    }
}

/// Whether a triangle is degenerate: a corner is not finite, or its height is below f32 precision relative to its
/// longest edge.
pub(super) fn is_degenerate(v0: Vec3, v1: Vec3, v2: Vec3) -> bool {
    if !(v0.is_finite() && v1.is_finite() && v2.is_finite()) {
        return true;
    }
    let [a, b, c] = [v0, v1, v2].map(DVec3::from);
    let longest = (b - a).length_squared().max((c - a).length_squared()).max((c - b).length_squared());
    let doubled_area = (b - a).cross(c - a).length();
    doubled_area <= longest * f64::from(f32::EPSILON)
}
