//! Points on surfaces, in the world.
//!
//! In: an instance, a place on its mesh and the side that was hit. Out: where that is now, and which way
//! it faces.

use glam::{Affine3A, Mat3A, Vec2, Vec3, Vec3A};

use super::{Pose, Scene, Surface, SurfacePoint};

/// How far along its normal a ray starts off the surface point `p`, so that it meets neither that
/// surface nor, from the other side, what lies behind it. Both terms are lengths of the scene, so the
/// answer scales with it: rounding errors of `p` grow with its components, and near the world's origin
/// with the size of the scene that stands about it.
pub fn ray_offset(p: Vec3, scene_radius: f32) -> f32 {
    2e-5 * p.abs().max_element().max(0.2 * scene_radius)
}

/// A surface seen from the side that was hit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WorldSurface {
    /// World position.
    pub position: Vec3,
    /// Unit normal of the flat triangle.
    pub geometric_normal: Vec3,
    /// Unit interpolated normal: VPLs shine and scatter about it.
    pub normal: Vec3,
}

impl WorldSurface {
    /// Where a ray off this surface starts, or one towards it ends.
    pub(crate) fn offset_position(&self, scene_radius: f32) -> Vec3 {
        self.position + self.geometric_normal * ray_offset(self.position, scene_radius)
    }
}

/// Which side of a surface to look at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Side {
    /// The one whose corners go counter-clockwise in object space, or the other.
    Front(bool),
    /// The one that a ray of this direction meets.
    Facing(Vec3),
}

/// A found surface: the side, how it lies, and its texture coordinates.
pub(crate) struct Found {
    pub(crate) front: bool,
    pub(crate) surface: WorldSurface,
    pub(crate) uv: Vec2,
}

/// A transform from object to world, ready to be applied to surfaces.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SurfaceTransform {
    transform: Affine3A,
    /// For normals: the inverse transpose, up to its length.
    normals: Mat3A,
}

impl SurfaceTransform {
    pub(crate) fn new(transform: &Affine3A) -> Self {
        let m = &transform.matrix3;
        // The signed cofactor matrix, which flattened instances have too.
        let [x, y, z] = [m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis)];
        let sign = if m.x_axis.dot(x) < 0.0 { -1.0 } else { 1.0 };
        // Small scenes have small cofactors: scale, lest the squares of normals underflow.
        let largest = x.abs().max(y.abs()).max(z.abs()).max_element();
        let scale = if largest > 0.0 { sign / largest } else { sign };
        Self { transform: *transform, normals: Mat3A::from_cols(x * scale, y * scale, z * scale) }
    }

    /// An object's surface in the world, from `side`.
    #[inline]
    pub(crate) fn place(&self, local: &Surface, side: Side) -> Found {
        let turn = |normal: Vec3| Vec3::from(self.normals * Vec3A::from(normal));
        let front_normal = turn(local.geometric_normal).normalize_or(Vec3::Y);
        let front = match side {
            Side::Front(front) => front,
            Side::Facing(direction) => front_normal.dot(direction) < 0.0,
        };
        let geometric_normal = if front { front_normal } else { -front_normal };
        // The G-buffer too turns vertex normals to the side that is seen.
        let shading = turn(local.normal).normalize_or(front_normal);
        let normal = if shading.dot(geometric_normal) >= 0.0 { shading } else { -shading };
        let position = self.transform.transform_point3a(local.position.into()).into();
        Found { front, surface: WorldSurface { position, geometric_normal, normal }, uv: local.uv }
    }
}

impl Scene {
    /// The surface at `point` of `instance`, where `pose` has it.
    pub(crate) fn surface_at(&self, pose: &Pose, instance: u32, point: SurfacePoint, side: Side) -> Found {
        let local = self.meshes[self.instances[instance as usize].mesh].interpolate(point);
        SurfaceTransform::new(&pose.instances[instance as usize]).place(&local, side)
    }
}
