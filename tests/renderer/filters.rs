//! Path-space filters against the path tracer: energy, noise, fallback, and light that is gone.

use std::sync::Arc;

use glam::{Affine3A, Vec3};
use glowworm::renderer::Renderer;
use glowworm::scene::{Camera, Instance, LightKind, Material, Mesh, Scene};
use glowworm::settings::{
    CellSettings, Denoise, Direct, EffectSettings, Indirect, PathFilter, PathSettings, Reflections, Settings,
};

use super::paths::corner;
use super::support::depth::quick_or_all;
use super::support::golden::reference;
use super::support::{GpuFixture, layer, luminance, mean, named_scene, plain};

const SIDE: u32 = 48;
const BOUNCES: u32 = 2;
/// Bounces that stand for all of them.
const ALL_BOUNCES: u32 = 24;
/// The filters that have cells.
const CELLS: [PathFilter; 4] = [PathFilter::Hpsf, PathFilter::Nhpsf, PathFilter::ANhpsf, PathFilter::Cache];

fn by(filter: PathFilter, cells: CellSettings) -> Settings {
    Settings {
        size: [SIDE; 2],
        indirect: Indirect::PATHS,
        bounces: BOUNCES,
        effects: EffectSettings { denoise: Denoise::NONE, ..EffectSettings::default() },
        paths: PathSettings { filter, ..PathSettings::default() },
        cells: CellSettings { width: 4.0, ..cells },
        still_frames: 0,
        ..plain()
    }
}

fn irradiance(renderer: &Renderer) -> Vec<[f32; 3]> {
    layer(&renderer.read_picture(true).unwrap(), "indirect")
}

/// The mean of so many frames after the first `before`, of which the last is given as well.
fn frames(
    gpu: &GpuFixture,
    scene: &Arc<Scene>,
    settings: &Settings,
    [before, count]: [u32; 2],
) -> [Vec<[f32; 3]>; 2] {
    let pose = scene.pose(0.0);
    let mut renderer = gpu.renderer(scene, settings, &pose);
    let mut sum = vec![[0.0; 3]; (SIDE * SIDE) as usize];
    let mut last = Vec::new();
    for frame in 0..before + count {
        renderer.render(&pose).unwrap();
        if frame < before {
            continue;
        }
        last = irradiance(&renderer);
        for (sum, light) in sum.as_flattened_mut().iter_mut().zip(last.as_flattened()) {
            *sum += light / count as f32;
        }
    }
    [sum, last]
}

fn mean_light(light: &[[f32; 3]]) -> f32 {
    mean(light.iter().map(luminance))
}

fn rmse(light: &[[f32; 3]], expected: &[[f32; 3]]) -> f32 {
    mean(light.iter().zip(expected).map(|(a, b)| (luminance(a) - luminance(b)).powi(2))).sqrt()
}

#[test]
fn no_filter_loses_light_or_adds_any() {
    let Some(gpu) = GpuFixture::open() else { return };
    let scene = named_scene("cornell-box", None);
    let of = |bounces| layer(&reference("cornell-box", &scene, [SIDE; 2], bounces, 512), "indirect");
    let (expected, of_all) = (of(BOUNCES), of(ALL_BOUNCES));
    let raw =
        rmse(&frames(&gpu, &scene, &by(PathFilter::None, CellSettings::default()), [0, 1])[1], &expected);
    for (filter, expected, tolerance, noise) in [
        // A mean over windows of one surface weighs pixels near its edges more than others.
        (PathFilter::Sspsf, &expected, 0.03, 0.5),
        (PathFilter::Hpsf, &expected, 0.02, 0.35),
        (PathFilter::Nhpsf, &of_all, 0.03, 0.35),
        (PathFilter::ANhpsf, &of_all, 0.03, 0.35),
        // The noise of the first vertex is left to the denoiser.
        (PathFilter::Cache, &of_all, 0.02, 1.0),
    ] {
        let [average, last] =
            frames(&gpu, &scene, &by(filter, CellSettings::default()), [40, quick_or_all(24, 60)]);
        let (ratio, error) = (mean_light(&average) / mean_light(expected), rmse(&last, expected) / raw);
        println!("{filter:?}: mean {ratio}, error {error} of that of one path");
        assert!((ratio - 1.0).abs() < tolerance, "{filter:?}: the mean is {ratio} of the reference's");
        assert!(error < noise, "{filter:?}: {error} of the error of one path");
    }
}

/// A closed box whose walls emit a radiance of 1, seen from inside.
fn furnace(albedo: f32) -> Arc<Scene> {
    let mut scene = Scene::new("furnace");
    let wall = Material::lambertian("wall", Vec3::splat(albedo));
    scene.materials.push(Material { emission: Vec3::ONE, ..wall });
    scene.meshes.push(Mesh::cuboid("box", Vec3::new(2.0, 1.0, 3.0), 0).turned_inside_out().into());
    scene.instances.push(Instance::fixed("box", 0, Affine3A::IDENTITY));
    scene.add_area_light(0);
    scene.camera = Camera { vertical_fov: 1.5, ..Camera::looking(Vec3::new(0.5, 0.1, 1.0), Vec3::ZERO) };
    Arc::new(scene)
}

/// Irradiance over pi is the sum of the powers of the albedo: up to that of the bounces, or all of them.
#[test]
#[ignore = "long; no_filter_loses_light_or_adds_any is quicker"]
fn a_furnace_has_the_light_of_its_series() {
    let Some(gpu) = GpuFixture::open() else { return };
    const ALBEDO: f32 = 0.6;
    let scene = furnace(ALBEDO);
    let of_bounces = (0..=BOUNCES as i32).map(|k| ALBEDO.powi(k)).sum::<f32>();
    let of_all = 1.0 / (1.0 - ALBEDO);
    for (filter, expected) in [
        (PathFilter::Sspsf, of_bounces),
        (PathFilter::Hpsf, of_bounces),
        (PathFilter::Nhpsf, of_all),
        (PathFilter::ANhpsf, of_all),
        (PathFilter::Cache, of_all),
    ] {
        let [average, _] = frames(&gpu, &scene, &by(filter, CellSettings::default()), [40, 20]);
        let ratio = mean_light(&average) / (std::f32::consts::PI * expected);
        println!("{filter:?}: {ratio} of the series");
        assert!((ratio - 1.0).abs() < 0.02, "{filter:?}: {ratio} of the series");
    }
}

/// A lamp whose direct light other passes bring is in the cells of further vertices, and not in those of visible surfaces.
#[test]
#[ignore = "long; no_filter_loses_light_or_adds_any is quicker"]
fn direct_light_of_other_passes_counts_once() {
    let Some(gpu) = GpuFixture::open() else { return };
    let scene = corner("[[lights]]\ntype = \"point\"\nposition = [0.8, 1.6, 0.8]\nintensity = [4, 4, 4]");
    let expected =
        mean_light(&layer(&reference("corner-point", &scene, [SIDE; 2], ALL_BOUNCES, 512), "indirect"));
    for filter in [PathFilter::Nhpsf, PathFilter::ANhpsf, PathFilter::Cache] {
        let [average, _] = frames(&gpu, &scene, &by(filter, CellSettings::default()), [40, 20]);
        let ratio = mean_light(&average) / expected;
        println!("{filter:?}: {ratio} of the reference");
        assert!((ratio - 1.0).abs() < 0.03, "{filter:?}: {ratio} of the reference");
    }
}

#[test]
fn kept_paths_go_on_over_frames_by_two_rays() {
    let Some(gpu) = GpuFixture::open() else { return };
    let scene = furnace(0.6);
    let mut rays = Vec::new();
    for (filter, depth) in [(PathFilter::Nhpsf, 4), (PathFilter::ANhpsf, 4), (PathFilter::ANhpsf, 8)] {
        let settings = by(filter, CellSettings { depth, ..CellSettings::default() });
        let mut renderer = gpu.rendered(&scene, &settings, 24);
        let counters = renderer.finish().unwrap().pop().unwrap().figures.counters;
        rays.push(counters.get("rays"));
        // Paths are as long as they may be in a closed room, so kept ones have from two vertices more than these up to the most.
        let kept = |vertices: u32| counters.get(&format!("kept.{vertices}"));
        let (begun, all) = (BOUNCES + 2, (1..=16).map(kept).sum::<u64>());
        if filter == PathFilter::ANhpsf && depth > begun {
            let within = (begun + 1..=depth).map(kept).sum::<u64>();
            assert!(kept(depth) > 0 && within == all && all > 1500, "{counters:?}");
        }
    }
    let pixels = u64::from(SIDE * SIDE);
    // A light below the horizon needs no ray.
    for all in &rays[1..] {
        let more = (all - rays[0]) as f32 / pixels as f32;
        assert!((1.7..=2.0).contains(&more), "{more} rays a pixel more");
    }
}

/// A lamp that has gone elsewhere is forgotten: the picture is that of a fresh start.
#[test]
#[ignore = "long; light_that_is_switched_off_is_forgotten is quicker"]
fn what_moves_leaves_no_light_behind() {
    let Some(gpu) = GpuFixture::open() else { return };
    let scene = corner("");
    let mut lamp = Scene::clone(&scene);
    lamp.materials.push(Material { emission: Vec3::splat(6.0), ..Material::lambertian("lamp", Vec3::ZERO) });
    let mesh = lamp.meshes.len();
    lamp.meshes.push(Mesh::cuboid("lamp", Vec3::splat(0.15), lamp.materials.len() as u32 - 1).into());
    lamp.instances.push(Instance::fixed("lamp", mesh, Affine3A::from_translation(Vec3::new(0.9, 0.3, 0.9))));
    lamp.add_area_light(lamp.instances.len() - 1);
    let scene = Arc::new(lamp);
    let rest = scene.pose(0.0);
    let mut moved = rest.clone();
    *moved.instances.last_mut().unwrap() = Affine3A::from_translation(Vec3::new(-0.9, 1.5, 0.2));
    for filter in CELLS {
        let settings = by(filter, CellSettings::default());
        let after = |before: u32| {
            let mut renderer = gpu.renderer(&scene, &settings, &rest);
            for _ in 0..before {
                renderer.render(&rest).unwrap();
            }
            let mut sum = 0.0;
            for frame in 0..32 {
                renderer.render(&moved).unwrap();
                if frame >= 16 {
                    sum += mean_light(&irradiance(&renderer)) / 16.0;
                }
            }
            sum
        };
        let (fresh, left) = (after(0), after(24));
        println!("{filter:?}: {} of a fresh start", left / fresh);
        assert!((left / fresh - 1.0).abs() < 0.03, "{filter:?}: {} of a fresh start", left / fresh);
    }
}

/// Mirrors show the cache's light of what they hit, all direct light included, where the path tracer would go on with paths.
#[test]
#[ignore = "long; no_filter_loses_light_or_adds_any is quicker"]
fn mirrors_show_the_light_of_cells_by_fewer_rays() {
    let Some(gpu) = GpuFixture::open() else { return };
    let scene = corner("[[lights]]\ntype = \"point\"\nposition = [0.8, 1.6, 0.8]\nintensity = [4, 4, 4]");
    let pose = scene.pose(0.0);
    let run = |filter, bounces, probes| {
        let cells = CellSettings { probes, ..CellSettings::default() };
        let (direct, reflections) = (Direct::Paths, Reflections::Rays);
        let settings = Settings { bounces, direct, reflections, ..by(filter, cells) };
        let mut renderer = gpu.renderer(&scene, &settings, &pose);
        let mut light = 0.0;
        for frame in 0..48 {
            renderer.render(&pose).unwrap();
            if frame >= 24 {
                light += mean_light(&layer(&renderer.read_picture(true).unwrap(), "reflected")) / 24.0;
            }
        }
        let rays = renderer.finish().unwrap().pop().unwrap().figures.counters.get("rays");
        (light, rays)
    };
    let (traced, _) = run(PathFilter::None, 8, 16);
    let (_, many) = run(PathFilter::Cache, BOUNCES, 0);
    let (cached, few) = run(PathFilter::Cache, BOUNCES, 16);
    println!("{cached} of {traced}; {few} of {many} rays");
    assert!((cached / traced - 1.0).abs() < 0.05, "{cached}, not {traced}");
    assert!((few as f32) < 0.97 * many as f32, "{few} of {many} rays");
}

#[test]
fn without_probes_it_is_the_path_tracer() {
    let Some(gpu) = GpuFixture::open() else { return };
    let scene = named_scene("cornell-box", None);
    let cells = CellSettings { probes: 0, ..CellSettings::default() };
    let [_, expected] = frames(&gpu, &scene, &by(PathFilter::None, cells), [2, 1]);
    for filter in CELLS {
        assert!(frames(&gpu, &scene, &by(filter, cells), [2, 1])[1] == expected, "{filter:?}");
    }
}

#[test]
fn a_full_map_drops_counts_and_keeps_the_mean() {
    let Some(gpu) = GpuFixture::open() else { return };
    let scene = named_scene("cornell-box", None);
    let cells = CellSettings { capacity: 256, probes: 8, ..CellSettings::default() };
    let settings = Settings { cells: CellSettings { width: 1.0, ..cells }, ..by(PathFilter::Hpsf, cells) };
    let expected = layer(&reference("cornell-box", &scene, [SIDE; 2], BOUNCES, 512), "indirect");
    let [average, _] = frames(&gpu, &scene, &settings, [8, 48]);
    let ratio = mean_light(&average) / mean_light(&expected);
    assert!((ratio - 1.0).abs() < 0.03, "the mean is {ratio} of the reference's");
    let mut renderer = gpu.rendered(&scene, &settings, 4);
    let report = renderer.finish().unwrap().pop().unwrap();
    let count = |name: &str| report.figures.counters.get(name);
    assert!(count("cells.dropped") > 100 && count("cells.occupied") > 200, "{:?}", report.figures.counters);
}

#[test]
fn light_that_is_switched_off_is_forgotten_and_reruns_are_the_same() {
    let Some(gpu) = GpuFixture::open() else { return };
    let scene = corner("[[lights]]\ntype = \"point\"\nposition = [0.8, 1.6, 0.8]\nintensity = [4, 4, 4]");
    let (lit, mut dark) = (scene.pose(0.0), scene.pose(0.0));
    dark.lights[0].kind = LightKind::Point { intensity: Vec3::splat(4e-3) };
    for filter in CELLS {
        let settings = by(filter, CellSettings::default());
        let run = || {
            let mut renderer = gpu.renderer(&scene, &settings, &lit);
            for _ in 0..24 {
                renderer.render(&lit).unwrap();
            }
            let before = irradiance(&renderer);
            for _ in 0..9 {
                renderer.render(&dark).unwrap();
            }
            (before, irradiance(&renderer))
        };
        let (before, after) = run();
        let left = mean_light(&after) / mean_light(&before);
        println!("{filter:?}: {left} is left after 8 frames");
        assert!(left < 0.05, "{filter:?}: {left} of the light is left");
        assert!(run() == (before, after), "{filter:?}: another run has other bits");
    }
}

/// 2,000 frames of flight to random places need no more cells than the first ones and no more memory, and leave nothing behind.
#[test]
#[ignore = "long; light_that_is_switched_off_is_forgotten is quicker"]
fn a_long_flight_needs_no_more_cells_and_leaves_no_light() {
    let Some(gpu) = GpuFixture::open_alone() else { return };
    let scene = named_scene("cornell-box", None);
    let settings = Settings { size: [24; 2], ..by(PathFilter::Cache, CellSettings::default()) };
    let home = scene.pose(0.0);
    let rest = |renderer: &mut Renderer| {
        let mut sum = 0.0;
        for frame in 0..96 {
            renderer.render(&home).unwrap();
            if frame >= 32 {
                sum += mean_light(&irradiance(renderer)) / 64.0;
            }
        }
        sum
    };
    let mut renderer = gpu.renderer(&scene, &settings, &home);
    let fresh = rest(&mut renderer);
    let radius = home.camera.eye.distance(home.camera.target);
    let mut number = 0_u32;
    let mut place = || {
        number += 1;
        let offset = Vec3::from_array([0, 1, 2].map(|axis| sobol_burley::sample(number, axis, 2019)));
        0.8 * radius * (offset - Vec3::splat(0.5))
    };
    let (mut from, mut to) = (Vec3::ZERO, place());
    gpu.device.restart_memory_peak();
    let mut most = [0; 2];
    let mut memory = [0; 2];
    for frame in 0..2000_u32 {
        if frame % 40 == 0 {
            (from, to) = (to, place());
        }
        let offset = from.lerp(to, (frame % 40) as f32 / 40.0);
        let mut pose = home.clone();
        pose.camera = Camera { eye: home.camera.eye + offset, ..home.camera };
        renderer.render(&pose).unwrap();
        let half = (frame / 1000) as usize;
        for report in renderer.take_reports() {
            most[half] = most[half].max(report.figures.counters.get("cells.occupied"));
        }
        memory[half] = gpu.device.memory_peak();
    }
    println!("at most {most:?} cells, {memory:?} bytes");
    assert!(most[0] > 100 && most[1] * 10 <= most[0] * 11, "at most {most:?} cells");
    assert_eq!(memory[0], memory[1]);
    let left = rest(&mut renderer) / fresh;
    println!("{left} of a fresh start");
    assert!((left - 1.0).abs() < 0.02, "{left} of a fresh start");
}
