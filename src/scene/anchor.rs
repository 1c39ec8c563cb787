//! Scenes far from the origin, such as georeferenced scans: floats are too coarse there, so a renderer works in coordinates about
//! an anchor in the scene.
//!
//! In: a scene in its own coordinates. Out: meshes about their own middle, and poses relative to the anchor.

use std::borrow::Cow;
use std::sync::Arc;

use glam::{Affine3A, Vec3};

use super::bounds::BoundingSphere;
use super::contents::{Pose, Scene};

/// A middle this many radii from the origin is far.
const FAR: f32 = 16.0;

/// The middle of what is far from the origin, else the origin.
fn far_middle(bounds: &BoundingSphere) -> Vec3 {
    let is_far = bounds.center.is_finite() && bounds.center.length() > FAR * bounds.radius;
    if !is_far || bounds.radius <= 0.0 {
        return Vec3::ZERO;
    }
    // Multiples of a power of two, so that subtracting it is exact and neighbouring meshes keep their distances.
    let step = bounds.radius.log2().ceil().exp2();
    (bounds.center / step).round() * step
}

impl Scene {
    /// Moves the vertices of meshes that are far from their origin, so that rays meet them as exactly as others.
    /// [`Self::pose`] moves their instances.
    pub(crate) fn anchor_meshes(&mut self) {
        for mesh in &mut self.meshes {
            let bounds = mesh
                .positions
                .iter()
                .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), &at| (low.min(at), high.max(at)));
            let middle = far_middle(&BoundingSphere::around(bounds));
            if middle != Vec3::ZERO {
                let mesh = Arc::make_mut(mesh);
                mesh.positions.iter_mut().for_each(|at| *at -= middle);
                mesh.anchor += middle;
            }
        }
    }

    /// Object to world of an instance's mesh where the instance stands at `transform`.
    pub(super) fn placed(&self, mesh: usize, transform: Affine3A) -> Affine3A {
        match self.meshes[mesh].anchor {
            Vec3::ZERO => transform,
            anchor => transform * Affine3A::from_translation(anchor),
        }
    }

    /// The point about which a renderer of this scene works; the origin unless the scene is far from it.
    pub fn anchor(&self) -> Vec3 {
        far_middle(&self.bounding_sphere(&self.pose(0.0)))
    }
}

impl Pose {
    /// The pose in coordinates about `anchor`.
    pub fn about(&self, anchor: Vec3) -> Cow<'_, Self> {
        if anchor == Vec3::ZERO {
            return Cow::Borrowed(self);
        }
        let mut pose = self.clone();
        pose.camera.eye -= anchor;
        pose.camera.target -= anchor;
        pose.lights.iter_mut().for_each(|light| light.position -= anchor);
        pose.instances.iter_mut().for_each(|placed| placed.translation -= glam::Vec3A::from(anchor));
        Cow::Owned(pose)
    }
}
