//! Surface data of all triangles, in a layout with few cache misses a hit.
//!
//! In: a scene and its pose. Out: for a hit, the vertex data of its triangle and the transform of its instance.

use crate::bvh::Hit;
use crate::memory::{self, Pages};
use crate::scene::{Pose, Scene, SurfaceTransform, TriangleSurface};

#[derive(Debug)]
pub(super) struct Surfaces {
    /// The triangles of all meshes, mesh by mesh.
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

    /// Prefetches the data that [`Self::at`] reads.
    pub(super) fn prefetch(&self, hit: &Hit) {
        memory::prefetch(self.at(hit).0);
    }

    /// Triangle and instance transform of a hit.
    #[inline]
    pub(super) fn at(&self, hit: &Hit) -> (&TriangleSurface, &SurfaceTransform) {
        let placed = &self.instances[hit.instance as usize];
        (&self.triangles[placed.first_triangle + hit.triangle as usize], &placed.placement)
    }
}
