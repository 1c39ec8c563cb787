//! The parts of a renderer that a scene needs before it has a device.

use std::sync::Arc;
use std::time::Instant;

use glam::Vec3;

use crate::bvh::TwoLevelBvh;
use crate::scene::Scene;

/// A scene with what can be worked out without a device, on any thread.
#[derive(Clone)]
pub struct PreparedScene {
    pub(crate) scene: Arc<Scene>,
    pub(super) anchor: Vec3,
    pub(crate) bvh: TwoLevelBvh,
    pub(super) bvh_ms: f64,
}

impl PreparedScene {
    /// Builds the BVH; takes a second or so for a million triangles.
    pub fn new(scene: &Arc<Scene>) -> Self {
        let begun = Instant::now();
        let anchor = scene.anchor();
        let bvh = TwoLevelBvh::build(scene, &scene.pose(0.0).about(anchor).instances);
        let bvh_ms = begun.elapsed().as_secs_f64() * 1e3;
        log::info!("{}: built the BVH in {bvh_ms:.0} ms", scene.name);
        Self { scene: Arc::clone(scene), anchor, bvh, bvh_ms }
    }

    /// The BVH of the scene without animation.
    pub fn bvh(&self) -> &TwoLevelBvh {
        &self.bvh
    }

    /// How long building the BVH took, milliseconds.
    pub fn bvh_ms(&self) -> f64 {
        self.bvh_ms
    }
}
