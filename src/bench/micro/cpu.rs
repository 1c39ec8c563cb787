//! Tracers on the CPU: the two-level BVH, and obvhs's own compressed wide BVH over all triangles of the world.

use std::time::{Duration, Instant};

use glam::Vec3A;
use obvhs::BvhBuildParams;
use obvhs::cwbvh::{CwBvh, builder::build_cwbvh_from_tris};
use obvhs::ray::RayHit;
use obvhs::triangle::Triangle;
use rayon::prelude::*;

use super::super::BenchError;
use super::contender::{Cast, Contender, Query};
use super::rays::RaySet;
use crate::bvh::{Ray, TwoLevelBvh};
use crate::scene::{Material, Pose, Scene};

/// Rays per task, for tracers without batches of their own.
pub(super) const RAYS_PER_TASK: usize = 256;

/// [`TwoLevelBvh`], as the VPL manager and the path tracer use it.
pub struct OwnTracer<'a>(pub &'a TwoLevelBvh);

impl Contender for OwnTracer<'_> {
    fn name(&self) -> &str {
        "glowworm, CPU"
    }

    fn cast(&mut self, set: &RaySet, query: Query) -> Result<Cast, BenchError> {
        let begun = Instant::now();
        Ok(match query {
            Query::Occluded => {
                let occluded = self.0.occluded_batch(&set.rays);
                let seconds = begun.elapsed().as_secs_f64();
                let answer = |&occluded: &bool| if occluded { 0.0 } else { -1.0 };
                Cast { seconds, answers: occluded.iter().map(answer).collect() }
            }
            Query::Closest => {
                let hits = self.0.intersect_batch(&set.rays);
                let seconds = begun.elapsed().as_secs_f64();
                Cast { seconds, answers: hits.iter().map(|hit| hit.map_or(-1.0, |hit| hit.t)).collect() }
            }
        })
    }
}

/// The triangles of all visible instances, world space; none if the scene has alpha masks or thin surfaces.
pub(super) fn world_triangles(scene: &Scene, pose: &Pose) -> Option<Vec<[Vec3A; 3]>> {
    if !scene.alpha_masks.is_empty() || scene.materials.iter().any(Material::is_thin_surface) {
        return None;
    }
    let placed = scene.instances.iter().zip(&pose.instances).filter(|(instance, _)| instance.visible);
    let triangles = placed.flat_map(|(instance, transform)| {
        let mesh = &scene.meshes[instance.mesh];
        let corner = move |vertex: u32| transform.transform_point3a(mesh.positions[vertex as usize].into());
        mesh.triangles.iter().map(move |triangle| triangle.map(corner))
    });
    Some(triangles.collect())
}

/// Casts rays on all cores; `cast` returns a result as in [`Cast`].
pub(super) fn cast_all(rays: &[Ray], cast: impl Fn(&Ray) -> f32 + Sync) -> Cast {
    let begun = Instant::now();
    let answers = rays.par_chunks(RAYS_PER_TASK).flat_map_iter(|rays| rays.iter().map(&cast)).collect();
    Cast { seconds: begun.elapsed().as_secs_f64(), answers }
}

/// obvhs with its own builder, traversal and triangle test.
pub struct Obvhs {
    bvh: CwBvh,
    /// In the order of the leaves.
    triangles: Vec<Triangle>,
}

impl Obvhs {
    /// None if the scene has alpha masks, which it does not support.
    pub fn new(scene: &Scene, pose: &Pose) -> Option<Self> {
        let triangles: Vec<Triangle> =
            world_triangles(scene, pose)?.into_iter().map(|[v0, v1, v2]| Triangle { v0, v1, v2 }).collect();
        let bvh = build_cwbvh_from_tris(&triangles, BvhBuildParams::medium_build(), &mut Duration::default());
        let triangles = bvh.primitive_indices.iter().map(|&index| triangles[index as usize]).collect();
        Some(Self { bvh, triangles })
    }
}

impl Contender for Obvhs {
    fn name(&self) -> &str {
        "obvhs CwBvh, CPU"
    }

    fn cast(&mut self, set: &RaySet, query: Query) -> Result<Cast, BenchError> {
        let Self { bvh, triangles } = self;
        let ray =
            |ray: &Ray| obvhs::ray::Ray::new(ray.origin.into(), ray.direction.into(), ray.t_min, ray.t_max);
        Ok(match query {
            Query::Occluded => cast_all(&set.rays, |asked| {
                let missed = bvh.ray_traverse_miss(ray(asked), |ray, index| triangles[index].intersect(ray));
                if missed { -1.0 } else { 0.0 }
            }),
            Query::Closest => cast_all(&set.rays, |asked| {
                let mut hit = RayHit::none();
                let met =
                    bvh.ray_traverse(ray(asked), &mut hit, |ray, index| triangles[index].intersect(ray));
                if met { hit.t } else { -1.0 }
            }),
        })
    }
}
