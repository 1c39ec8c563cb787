//! The two-level BVH: one bottom-level CWBVH per mesh (obvhs), a top level over instance bounds.
//!
//! In: a scene's meshes and instance transforms. Out: closest hits, occlusion answers, single and in
//! batches over all cores, and the same structure in the layout that shaders traverse
//! (Ylitie et al. 2017, "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs").

use glam::{Affine3A, Vec2, Vec3};

use crate::scene::Scene;

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

/// Two-level BVH over the visible instances of a scene.
pub struct TwoLevelBvh {}

impl TwoLevelBvh {
    /// Builds the bottom levels and both top levels with every instance at `transforms` (object to world).
    pub fn build(_scene: &Scene, _transforms: &[Affine3A]) -> Self {
        todo!()
    }

    /// Moves the dynamic instances. Returns the indices of those whose transform changed.
    pub fn update(&mut self, _transforms: &[Affine3A]) -> Vec<u32> {
        todo!()
    }

    /// The closest hit along `ray`.
    pub fn intersect(&self, _ray: &Ray) -> Option<Hit> {
        todo!()
    }

    /// Whether anything lies on the segment.
    pub fn occluded(&self, _ray: &Ray) -> bool {
        todo!()
    }

    /// [`Self::intersect`] for many rays, over all cores, answers in the order of the rays.
    pub fn intersect_batch(&self, _rays: &[Ray]) -> Vec<Option<Hit>> {
        todo!()
    }

    /// [`Self::occluded`] for many rays, over all cores, answers in the order of the rays.
    pub fn occluded_batch(&self, _rays: &[Ray]) -> Vec<bool> {
        todo!()
    }

    /// World-space bounds (min, max) of all visible instances; a unit box about the origin when there are none.
    pub fn bounds(&self) -> (Vec3, Vec3) {
        todo!()
    }
}
