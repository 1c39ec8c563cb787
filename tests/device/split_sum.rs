//! The environment by roughness, on a device with validation: against integrals over the GGX lobe.

use std::f64::consts::PI;
use std::sync::Arc;

use crate::support::GpuFixture;
use glam::{DVec3, Vec3};
use glowworm::bsdf::Bsdf;
use glowworm::bvh::TwoLevelBvh;
use glowworm::effects::split_sum::{LEVEL_SIZE, LEVELS, SplitSum};
use glowworm::gpu_scene::GpuScene;
use glowworm::gpu_scene::structs::FrameUniforms;
use glowworm::gpu_scene::tracer::RayTracer;
use glowworm::scene::{Environment, EnvironmentMap, Scene};
use glowworm::vulkan::Frames;

const MAP: [usize; 2] = [64, 32];

/// Rows and columns of directions.
const STEPS: [usize; 2] = [512, 1024];

/// A white ground under a blue sky with a bright side, too wide for a sun.
fn map() -> Arc<EnvironmentMap> {
    let texel = |i: usize| match (i % MAP[0], i / MAP[0]) {
        (36..48, 6..13) => Vec3::new(8.0, 6.0, 3.0),
        (_, y) if y < 16 => Vec3::new(0.3, 0.6, 1.0),
        _ => Vec3::splat(0.4),
    };
    Arc::new(EnvironmentMap::new(MAP[0], MAP[1], (0..MAP[0] * MAP[1]).map(texel).collect()))
}

/// Direction of a place in an equirectangular map.
fn direction_of(u: f64, v: f64) -> DVec3 {
    let ((sin_azimuth, cos_azimuth), (sin, cos)) = ((2.0 * PI * (u - 0.5)).sin_cos(), (PI * v).sin_cos());
    DVec3::new(sin * sin_azimuth, cos, -sin * cos_azimuth)
}

/// The mean of the environment over the lobe of a white metal, seen along its normal.
fn integrated(environment: &Environment, normal: DVec3, roughness: f32) -> DVec3 {
    let metal = Bsdf { base: Vec3::ONE, metallic: 1.0, roughness, f0: Vec3::ZERO, f90: 0.0 };
    let reflection = metal.prepare(normal.as_vec3(), normal.as_vec3());
    let (mut sum, mut weights) = (DVec3::ZERO, 0.0);
    for row in 0..STEPS[0] {
        for column in 0..STEPS[1] {
            let v = (row as f64 + 0.5) / STEPS[0] as f64;
            let light = direction_of((column as f64 + 0.5) / STEPS[1] as f64, v);
            let cosine = normal.dot(light);
            if cosine > 0.0 {
                let lobe = f64::from(reflection.evaluate(light.as_vec3()).reflected.x);
                let weight = lobe * cosine * (PI * v).sin();
                sum += weight * environment.radiance(light.as_vec3()).as_dvec3();
                weights += weight;
            }
        }
    }
    sum / weights
}

#[test]
fn levels_are_the_means_over_the_lobes_of_their_roughness() {
    let Some(gpu) = GpuFixture::open() else { return };
    let device = &gpu.device;
    let environment = Environment { radiance: Vec3::ONE, map: Some(map()), rotation: 0.0 };
    let scene = Scene { environment: Some(environment.clone()), ..Scene::new("sky") };
    let pose = scene.pose(0.0);
    let bvh = TwoLevelBvh::build(&scene, &pose.instances);
    let mut gpu_scene = GpuScene::new(device, &scene, RayTracer::Software, &bvh).unwrap();
    let mut split_sum = SplitSum::new(device).unwrap();
    let mut frames = Frames::new(device).unwrap();
    let (mut frame, _) = frames.begin().unwrap();
    let uploads = gpu_scene.upload(&mut frame, (&scene, &pose), &bvh).unwrap();
    let set = gpu_scene.set(&mut frame, &uploads).unwrap();
    let uniforms = frame.upload(&[FrameUniforms::default()]).unwrap();
    split_sum.follow(&mut frame, (&uniforms, &set), Some(&environment)).unwrap();
    frame.submit().unwrap();
    let halves: Vec<u16> = bytemuck::pod_collect_to_vec(&split_sum.image().read_layer(device, 0, 8).unwrap());

    let [width, height] = LEVEL_SIZE.map(|side| side as usize);
    for level in 0..LEVELS as usize {
        let roughness = (level + 1) as f32 / LEVELS as f32;
        // Within the bright side, at its edge, in the sky, near the pole, on the ground.
        for [x, y] in [[84, 18], [72, 26], [20, 20], [10, 1], [60, 50]] {
            let texel = 4 * ((level * height + y) * width + x);
            let found =
                [0, 1, 2].map(|i| f64::from(exr::prelude::f16::from_bits(halves[texel + i]).to_f32()));
            let normal = direction_of((x as f64 + 0.5) / width as f64, (y as f64 + 0.5) / height as f64);
            let expected = integrated(&environment, normal, roughness);
            let error = (DVec3::from(found) / expected - 1.0).abs().max_element();
            // Few samples lie in the long tails of GGX.
            assert!(error < 0.03, "roughness {roughness} at {x}, {y}: {found:?}, not {expected}");
        }
    }
}
