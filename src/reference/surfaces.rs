//! The surfaces that rays may hit, laid out so that a hit costs few cache misses.
//!
//! In: a scene and its pose. Out: for a hit, what its triangle's corners say and where its instance stands.

use crate::bvh::Hit;
use crate::memory::{self, Pages};
use crate::scene::{Pose, Scene, SurfaceTransform, TriangleSurface};

#[derive(Debug)]
pub(super) struct Surfaces {
    /// Those of all meshes, one mesh after the other.
    triangles: Pages<TriangleSurface>,
    instances: Vec<PlacedMesh>,
}

#[derive(Debug)]
struct PlacedMesh {
    first_triangle: usize,
    placement: SurfaceTransform,
}

impl Surfaces {
    pub(super) fn new(scene: &Scene, pose: &Pose) -> Self {
        let mut triangles = Vec::with_capacity(scene.meshes.iter().map(|mesh| mesh.triangles.len()).sum());
        let mut firsts = Vec::with_capacity(scene.meshes.len());
        for mesh in &scene.meshes {
            firsts.push(triangles.len());
            triangles
                .extend((0..mesh.triangles.len() as u32).map(|triangle| mesh.triangle_surface(triangle)));
        }
        let instances = scene.instances.iter().zip(&pose.instances).map(|(instance, transform)| PlacedMesh {
            first_triangle: firsts[instance.mesh],
            placement: SurfaceTransform::new(transform),
        });
        Self { instances: instances.collect(), triangles: Pages::new(triangles) }
    }

    /// Asks for what [`Self::of`] will read soon.
    pub(super) fn prefetch(&self, hit: &Hit) {
        memory::prefetch(self.of(hit).0);
    }

    #[inline]
    pub(super) fn of(&self, hit: &Hit) -> (&TriangleSurface, &SurfaceTransform) {
        let placed = &self.instances[hit.instance as usize];
        (&self.triangles[placed.first_triangle + hit.triangle as usize], &placed.placement)
    }
}
