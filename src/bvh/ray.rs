//! Rays and what they meet.

use glam::{Vec2, Vec3};

/// Rays of one parallel task: fewer would not pay for its overhead.
pub(super) const RAYS_PER_TASK: usize = 256;

/// A ray segment: points `origin + t * direction` with `t_min < t < t_max`. The direction need not be
/// of unit length; t is in units of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// World-space start.
    pub origin: Vec3,
    /// World-space direction, of any length but zero.
    pub direction: Vec3,
    /// Open lower bound of t.
    pub t_min: f32,
    /// Open upper bound of t, may be infinite.
    pub t_max: f32,
}

/// The closest surface along a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Ray parameter, in units of the ray's direction.
    pub t: f32,
    /// Index into `Scene::instances`.
    pub instance: u32,
    /// Index into that instance's `Mesh::triangles`.
    pub triangle: u32,
    /// Weights of the triangle's second and third vertex.
    pub barycentrics: Vec2,
}

/// Occlusion of a segment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Occlusion {
    /// Nothing.
    Clear,
    /// Thin surfaces alone.
    ThinSurfaces,
    /// Something opaque.
    Opaque,
}
