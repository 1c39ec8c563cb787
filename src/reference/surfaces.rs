//! Surface data of all triangles, in a layout with few cache misses a hit.
//!
//! In: a scene and its pose. Out: the surface at a hit.

use glam::Vec3;

use crate::bvh::Hit;
use crate::memory::{self, Pages};
use crate::scene::{Pose, Scene, Side, SidedSurface, SurfacePoint, SurfaceTransform, TriangleSurface};

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
    /// Index into the scene's meshes, if its vertices have more than a [`TriangleSurface`].
    detailed: Option<usize>,
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
            detailed: scene.meshes[instance.mesh].has_details().then_some(instance.mesh),
        });
        Self { instances: instances.collect(), triangles: Pages::new(triangles) }
    }

    /// Prefetches the data that [`Self::at`] reads.
    pub(super) fn prefetch(&self, hit: &Hit) {
        memory::prefetch(self.triangle(hit));
    }

    fn triangle(&self, hit: &Hit) -> &TriangleSurface {
        let placed = &self.instances[hit.instance as usize];
        &self.triangles[placed.first_triangle + hit.triangle as usize]
    }

    /// The surface on the side that a ray of this direction hit, and the index of its material.
    #[inline]
    pub(super) fn at(&self, scene: &Scene, hit: &Hit, direction: Vec3) -> (SidedSurface, usize) {
        let placed = &self.instances[hit.instance as usize];
        let triangle = self.triangle(hit);
        let material = triangle.material as usize;
        let mut local = triangle.interpolate(hit.barycentrics);
        if let Some(mesh) = placed.detailed {
            let point = SurfacePoint { triangle: hit.triangle, barycentrics: hit.barycentrics };
            scene.meshes[mesh].add_details(point, &mut local);
            scene.materials[material].map_normal(scene, &mut local);
        }
        (placed.placement.place(&local, Side::Facing(direction)), material)
    }
}
