//! Points on surfaces, in the world.
//!
//! In: an instance, a place on its mesh and the side that was hit. Out: where that is now, and which way
//! it faces.

use glam::{Affine3A, Vec2, Vec3};

use super::{Pose, Scene, SurfacePoint};

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

impl Scene {
    /// The surface at `point` of `instance`, where `pose` has it.
    pub(crate) fn surface_at(&self, pose: &Pose, instance: u32, point: SurfacePoint, side: Side) -> Found {
        let transform = &pose.instances[instance as usize];
        let local = self.meshes[self.instances[instance as usize].mesh].interpolate(point);
        let front_normal = world_normal(transform, local.geometric_normal, Vec3::Y);
        let front = match side {
            Side::Front(front) => front,
            Side::Facing(direction) => front_normal.dot(direction) < 0.0,
        };
        let geometric_normal = if front { front_normal } else { -front_normal };
        // The G-buffer too turns vertex normals to the side that is seen.
        let shading = world_normal(transform, local.normal, front_normal);
        let normal = if shading.dot(geometric_normal) >= 0.0 { shading } else { -shading };
        let position = transform.transform_point3(local.position);
        Found { front, surface: WorldSurface { position, geometric_normal, normal }, uv: local.uv }
    }
}

/// Normals transform by the inverse transpose, up to its length the signed cofactor matrix, which
/// flattened instances have too.
fn world_normal(transform: &Affine3A, normal: Vec3, fallback: Vec3) -> Vec3 {
    let m = &transform.matrix3;
    let cofactor = m.y_axis.cross(m.z_axis) * normal.x
        + m.z_axis.cross(m.x_axis) * normal.y
        + m.x_axis.cross(m.y_axis) * normal.z;
    let mirrored = m.x_axis.dot(m.y_axis.cross(m.z_axis)) < 0.0;
    let turned = Vec3::from(if mirrored { -cofactor } else { cofactor });
    // Small scenes have small cofactors: normalise in steps, lest the squares underflow.
    (turned / turned.abs().max_element()).normalize_or(fallback)
}
