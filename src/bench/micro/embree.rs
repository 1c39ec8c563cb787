//! Embree 3 on the CPU, as a baseline; in builds with the feature `embree` only.
//!
//! A static scene of medium build quality, `rtcOccluded1` and `rtcIntersect1`, single rays in tasks on the same thread
//! pool as our own tracer.

use embree::{
    CommittedScene, Device, Geometry, IntersectContext, Ray as Segment, RayHit, Scene, TriangleMesh,
};

use super::super::BenchError;
use super::contender::{Cast, Contender, Query};
use super::cpu::{cast_all, world_triangles};
use super::rays::RaySet;
use crate::bvh::Ray;
use crate::scene::Pose;

/// Calls `with` with Embree over all triangles in world space, or with none if the scene has alpha masks, which it does
/// not support.
pub fn with_embree<T>(
    scene: &crate::scene::Scene,
    pose: &Pose,
    with: impl FnOnce(Option<&mut dyn Contender>) -> T,
) -> T {
    let Some(triangles) = world_triangles(scene, pose) else { return with(None) };
    let device = Device::new();
    let mut mesh = TriangleMesh::unanimated(&device, triangles.len(), 3 * triangles.len());
    {
        let (mut vertices, mut indices) = (mesh.vertex_buffer.map(), mesh.index_buffer.map());
        for (index, corners) in triangles.iter().enumerate() {
            for (corner, place) in corners.iter().enumerate() {
                vertices[3 * index + corner] = cgmath::Vector4::new(place.x, place.y, place.z, 0.0);
            }
            let first = 3 * index as u32;
            indices[index] = cgmath::Vector3::new(first, first + 1, first + 2);
        }
    }
    let mut geometry = Geometry::Triangle(mesh);
    geometry.commit();
    let mut world = Scene::new(&device);
    world.attach_geometry(geometry);
    let committed = world.commit();
    with(Some(&mut Embree(&committed)))
}

struct Embree<'a>(&'a CommittedScene<'a>);

impl Contender for Embree<'_> {
    fn name(&self) -> &str {
        "Embree 3, CPU"
    }

    fn cast(&mut self, set: &RaySet, query: Query) -> Result<Cast, BenchError> {
        let world = self.0;
        Ok(match query {
            Query::Occluded => cast_all(&set.rays, |ray| {
                let mut segment = segment(ray);
                world.occluded(&mut IntersectContext::incoherent(), &mut segment);
                if segment.tfar < 0.0 { 0.0 } else { -1.0 }
            }),
            Query::Closest => cast_all(&set.rays, |ray| {
                let mut found = RayHit::new(segment(ray));
                world.intersect(&mut IntersectContext::incoherent(), &mut found);
                if found.hit.hit() { found.ray.tfar } else { -1.0 }
            }),
        })
    }
}

fn segment(ray: &Ray) -> Segment {
    let vector = |v: glam::Vec3| cgmath::Vector3::new(v.x, v.y, v.z);
    Segment::segment(vector(ray.origin), vector(ray.direction), ray.t_min, ray.t_max)
}
