//! How fast each tracer is on a device: occlusion rays in a small world of its own.
//!
//! In: a device that offers both. Out: rays a second. Rays go from patches of one surface to a point of another, as
//! those of neighbouring pixels to a VPL do; about half of them are blocked.

use std::f32::consts::TAU;
use std::sync::Arc;

use glam::{Affine3A, Quat, Vec3, vec3};
use serde::{Deserialize, Serialize};

use crate::bvh::TwoLevelBvh;
use crate::passes::occlusion_rays::{OcclusionRay, OcclusionRays};
use crate::passes::tracer::{RayTracer, Tracer};
use crate::scene::{Camera, Instance, Material, Mesh, Scene};
use crate::vulkan::{Device, VulkanError};

/// Segments around the ring of a torus and around its body.
const SEGMENTS: [u32; 2] = [192, 96];
/// Tori.
const INSTANCES: u32 = 24;
/// Rays of a patch: a workgroup.
const PATCH: u32 = 64;
/// Patches.
const PATCHES: u32 = 1024;
/// Rays of the first try; each further one has so many times more.
const FIRST: u32 = 4096;
const MORE: u32 = 8;
/// Most rays of a try.
const MOST: u32 = FIRST * MORE * MORE * MORE * MORE;
/// A try that takes so long is long enough, milliseconds.
const ENOUGH_MS: f64 = 2.0;
/// Tries of that length; the fastest counts, since whatever else the machine does only costs time.
const ROUNDS: u32 = 3;
/// Share of rays about which the tracers may disagree: those that pass an edge.
const DISAGREEMENT: f64 = 1e-3;

/// Occlusion rays a second.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TracerRates {
    /// Of the software tracer.
    pub software: f64,
    /// Of the hardware tracer; 0 where its answers are wrong.
    pub hardware: f64,
}

impl TracerRates {
    /// The faster tracer.
    pub fn faster(&self) -> RayTracer {
        if self.hardware > self.software { RayTracer::Hardware } else { RayTracer::Software }
    }

    /// Measures both in turns; takes a fraction of a second.
    pub fn measure(device: &Arc<Device>) -> Result<Self, VulkanError> {
        let scene = tori();
        let transforms: Vec<Affine3A> = scene.instances.iter().map(|instance| instance.transform).collect();
        let bvh = TwoLevelBvh::build(&scene, &transforms);
        let rays = rays(&scene.meshes[0], &transforms);
        let run = |tracer| OcclusionRays::new(device, Tracer::new(device, tracer, &bvh)?, &rays);
        let mut runs = [run(RayTracer::Software)?, run(RayTracer::Hardware)?];

        // Find how many rays take long enough to be timed.
        let mut counts = [FIRST; 2];
        for (run, count) in runs.iter_mut().zip(&mut counts) {
            while run.cast(&bvh, *count)? < ENOUGH_MS && *count < MOST {
                *count *= MORE;
            }
        }

        // Compare what both have answered.
        let [software, hardware] = [runs[0].answers()?, runs[1].answers()?];
        let common = counts[0].min(counts[1]).min(PATCH * PATCHES) as usize;
        let differing = (0..common).filter(|&ray| software[ray] != hardware[ray]).count();
        let wrong = differing as f64 > DISAGREEMENT * common as f64;
        if wrong {
            log::warn!(
                "{}: its ray queries answer otherwise than the software tracer for {differing} of {common} rays",
                device.info().name
            );
        }

        let mut rates = [0.0f64; 2];
        for _ in 0..ROUNDS {
            for (run, (count, rate)) in runs.iter_mut().zip(counts.iter().zip(&mut rates)) {
                let ms = run.cast(&bvh, *count)?.max(1e-6);
                *rate = rate.max(f64::from(*count) / ms * 1e3);
            }
        }
        Ok(Self { software: rates[0], hardware: if wrong { 0.0 } else { rates[1] } })
    }
}

/// A spiral of tori with wrinkles.
fn tori() -> Scene {
    let instances = (0..INSTANCES)
        .map(|index| {
            let angle = index as f32 * 2.4;
            let away = 0.9 * (index as f32).sqrt();
            let place = vec3(away * angle.cos(), 0.8 * (angle * 1.7).sin(), away * angle.sin());
            Instance {
                name: String::new(),
                mesh: 0,
                transform: Affine3A::from_rotation_translation(Quat::from_rotation_x(angle), place),
                animation: None,
                dynamic: false,
                visible: true,
            }
        })
        .collect();
    Scene {
        recording: Arc::default(),
        name: String::new(),
        meshes: vec![torus()],
        materials: vec![Material::grey("")],
        textures: Vec::new(),
        alpha_masks: Vec::new(),
        instances,
        lights: Vec::new(),
        camera: Camera {
            eye: Vec3::ZERO,
            target: Vec3::NEG_Z,
            up: Vec3::Y,
            vertical_fov: 1.0,
            near: 0.1,
            far: 100.0,
        },
        camera_animation: None,
        background: Vec3::ZERO,
        settings: toml::Table::new(),
        warnings: Vec::new(),
    }
}

fn torus() -> Mesh {
    let [ring, body] = SEGMENTS;
    let point = |i: u32, j: u32| {
        let (along, around) = (TAU * i as f32 / ring as f32, TAU * j as f32 / body as f32);
        let thick = 0.3 + 0.03 * (11.0 * along).sin() * (7.0 * around).sin();
        let away = 1.0 + thick * around.cos();
        vec3(away * along.cos(), thick * around.sin(), away * along.sin())
    };
    let positions: Vec<Vec3> = (0..ring).flat_map(|i| (0..body).map(move |j| point(i, j))).collect();
    let at = |i: u32, j: u32| i % ring * body + j % body;
    let triangles: Vec<[u32; 3]> = (0..ring)
        .flat_map(|i| (0..body).map(move |j| (i, j)))
        .flat_map(|(i, j)| {
            [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]]
        })
        .collect();
    Mesh {
        name: String::new(),
        normals: vec![Vec3::Y; positions.len()],
        uvs: Vec::new(),
        triangle_materials: vec![0; triangles.len()],
        positions,
        triangles,
    }
}

/// From 8x8 neighbouring vertices of one torus to a vertex of another, patch by patch.
fn rays(mesh: &Mesh, transforms: &[Affine3A]) -> Vec<OcclusionRay> {
    let [ring, body] = SEGMENTS;
    // Any spread-out numbers will do.
    let spread = |patch: u32, salt: u32| patch.wrapping_mul(2_654_435_769).rotate_left(salt) >> 8;
    (0..PATCHES)
        .flat_map(|patch| {
            let instance = |salt| transforms[(spread(patch, salt) % INSTANCES) as usize];
            let [from, to] = [instance(0), instance(13)];
            let [first_i, first_j] = [spread(patch, 5), spread(patch, 19)];
            let target = mesh.positions[(spread(patch, 9) % (ring * body)) as usize];
            let end = to.transform_point3(target);
            (0..PATCH).map(move |index| {
                let [i, j] = [(first_i + index % 8) % ring, (first_j + index / 8) % body];
                let start = mesh.positions[(i * body + j) as usize];
                OcclusionRay::between(from.transform_point3(start), end)
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bvh::Ray;

    #[test]
    fn some_rays_are_blocked_and_some_are_not() {
        let scene = tori();
        let transforms: Vec<Affine3A> = scene.instances.iter().map(|instance| instance.transform).collect();
        let bvh = TwoLevelBvh::build(&scene, &transforms);
        let rays = rays(&scene.meshes[0], &transforms);
        assert_eq!(rays.len(), (PATCH * PATCHES) as usize);
        let rays: Vec<Ray> = rays.iter().map(OcclusionRay::as_ray).collect();
        let blocked = bvh.occluded_batch(&rays).into_iter().filter(|occluded| *occluded).count();
        let share = blocked as f64 / rays.len() as f64;
        assert!((0.2..0.95).contains(&share), "{share}");
    }

    #[test]
    fn the_faster_one_is_chosen() {
        assert_eq!(TracerRates { software: 2.0, hardware: 1.0 }.faster(), RayTracer::Software);
        assert_eq!(TracerRates { software: 1.0, hardware: 2.0 }.faster(), RayTracer::Hardware);
    }
}
