//! Settings and scenes that change while the renderer runs: no garbage on the way, and in the end what a fresh
//! renderer shows.

use std::sync::Arc;

use glam::Vec3;
use glowworm::output::Picture;
use glowworm::renderer::{PreparedScene, RenderError, Renderer};
use glowworm::scene::{Environment, EnvironmentMap, LightKind, Material, Scene};
use glowworm::settings::{Sequence, Settings, TracerKind, VplSettings};

use super::materials::floor;
use super::still::frozen;
use super::support::depth::quick_or_all;
use super::support::{GpuFixture, assets, indirect, layer, luminance, mean, named_scene, plain, scene};
use super::views::STUDIO;

fn start() -> Settings {
    Settings {
        size: [72, 48],
        still_frames: 16,
        vpl: VplSettings { slots: 128, temporal_sets: 4, interleave: 2, ..VplSettings::default() },
        ..plain()
    }
}

type Change = fn(&mut Settings);

/// The frozen picture of a renderer made with these settings.
fn fresh(gpu: &GpuFixture, scene: &Arc<Scene>, settings: &Settings) -> Picture {
    let pose = scene.pose(0.0);
    frozen(&mut gpu.renderer(scene, settings, &pose), &pose)
}

fn brightness(renderer: &Renderer) -> f32 {
    mean(indirect(renderer).iter().map(luminance))
}

#[test]
fn changed_settings_end_as_a_fresh_renderer_bit_for_bit() {
    let Some(gpu) = GpuFixture::open() else { return };
    let scene = scene(STUDIO);
    let pose = scene.pose(0.0);
    let changes: [(&str, Change); 9] = [
        ("more sets", |settings| settings.vpl.temporal_sets = 7),
        ("one set", |settings| settings.vpl.temporal_sets = 1),
        ("VPLs", |settings| settings.vpl.slots = 160),
        ("bounces", |settings| settings.bounces = 4),
        ("interleave", |settings| settings.vpl.interleave = 3),
        ("clamp, cut-off, exposure", |settings| {
            (settings.vpl.clamp, settings.vpl.position_cutoff, settings.exposure) = (3.0, 0.05, Some(1.0));
        }),
        ("size", |settings| settings.size = [40, 56]),
        ("seed, sequence, budget", |settings| {
            (settings.seed, settings.vpl.sequence, settings.vpl.budget) = (5, Sequence::Random, 3);
        }),
        ("everything", |settings| {
            let budget = 9;
            *settings = Settings {
                size: [33, 65],
                vpl: VplSettings { slots: 300, budget, interleave: 4, ..start().vpl },
                ..start()
            };
        }),
    ];
    // One after the other: history of an earlier change must not show either.
    let mut settings = start();
    let mut renderer = gpu.rendered(&scene, &settings, 5);
    // In a quick run more sets, interleaving and everything.
    for (what, change) in changes.into_iter().step_by(quick_or_all(4, 1)) {
        change(&mut settings);
        let before = brightness(&renderer);
        renderer.set_settings(&settings, &pose).unwrap();
        for frame in 0..settings.vpl.temporal_sets + 1 {
            renderer.render(&pose).unwrap();
            let now = brightness(&renderer);
            assert!((0.6..1.5).contains(&(now / before)), "{what}, frame {frame}: {before} becomes {now}");
        }
        assert!(frozen(&mut renderer, &pose) == fresh(&gpu, &scene, &settings), "{what}");
    }
}

#[test]
fn nothing_is_seen_of_other_sets_until_all_are_there() {
    let Some(gpu) = GpuFixture::open() else { return };
    let scene = scene(STUDIO);
    let pose = scene.pose(0.0);
    let mut renderer = gpu.rendered(&scene, &start(), 4);
    let before = indirect(&renderer);
    // Changed again on the way, as by a slider.
    for temporal_sets in [6, 9, 8] {
        renderer
            .set_settings(&Settings { vpl: VplSettings { temporal_sets, ..start().vpl }, ..start() }, &pose)
            .unwrap();
        for _ in 0..3 {
            renderer.render(&pose).unwrap();
            assert!(indirect(&renderer) == before);
        }
    }
    let settings = Settings { vpl: VplSettings { temporal_sets: 8, ..start().vpl }, ..start() };
    assert!(frozen(&mut renderer, &pose) == fresh(&gpu, &scene, &settings));
}

/// The camera turns, so that each frame shows what no set of before has seen.
#[test]
#[ignore = "long; a_window_that_is_dragged_larger_stays_lit is quicker"]
fn nothing_that_comes_into_view_is_black_whatever_changes() {
    const FRAMES: u32 = 120;
    let Some(gpu) = GpuFixture::open() else { return };
    let scene = scene(STUDIO);
    let mut random = 1u32;
    let mut dice = |sides: u32| {
        random = random.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        (random >> 16) % sides
    };
    let pose = |frame: u32| {
        let mut pose = scene.pose(0.0);
        let (sin, cos) = (0.2 * frame as f32).sin_cos();
        pose.camera.eye = Vec3::ZERO;
        pose.camera.target = Vec3::new(sin, -0.15, cos);
        pose
    };
    let many = VplSettings { slots: 1024, temporal_sets: 1, ..VplSettings::default() };
    let mut settings = Settings { vpl: VplSettings { slots: 512, ..many }, ..start() };
    let mut renderer = gpu.renderer(&scene, &settings, &pose(0));
    let mut reference = gpu.renderer(&scene, &Settings { vpl: many, ..start() }, &pose(0));
    let (mut changes, mut dark, mut pixels) = (0, 0, 0);
    for frame in 0..FRAMES {
        if dice(2) == 0 {
            match dice(3) {
                0 => settings.size = [60 + dice(3) * 12, 40 + dice(3) * 8],
                1 => settings.vpl.interleave = 2 + 2 * dice(2),
                _ => settings.vpl.temporal_sets = [1, 4, 8, 16][dice(4) as usize],
            }
            renderer.set_settings(&settings, &pose(frame)).unwrap();
            let like = Settings { vpl: many, ..settings.clone() };
            reference.set_settings(&like, &pose(frame)).unwrap();
            changes += 1;
        }
        for renderer in [&mut renderer, &mut reference] {
            renderer.render(&pose(frame)).unwrap();
        }
        pixels += (settings.size[0] * settings.size[1]) as usize;
        let both = indirect(&renderer).into_iter().zip(indirect(&reference));
        dark += both.filter(|(ours, full)| luminance(ours) < 0.25 * luminance(full)).count();
    }
    assert!(changes >= 45, "{changes} changes");
    // A single set may be as dark as that by chance; pixels that no set saw would be a tenth of each picture.
    assert!(1000 * dark < pixels, "{dark} of {pixels} pixels are below a quarter of the reference");
}

#[test]
fn a_window_that_is_dragged_larger_stays_lit() {
    let Some(gpu) = GpuFixture::open() else { return };
    let scene = scene(STUDIO);
    let pose = scene.pose(0.0);
    let mut renderer = gpu.rendered(&scene, &start(), 4);
    for step in 1..=10 {
        let settings = Settings { size: [72 + 3 * step, 48 + 2 * step], ..start() };
        renderer.set_settings(&settings, &pose).unwrap();
        renderer.render(&pose).unwrap();
        let expected = brightness(&gpu.rendered(&scene, &settings, 4));
        let ratio = brightness(&renderer) / expected;
        assert!((ratio - 1.0).abs() < 0.05, "step {step}: {ratio}");
        let dark = indirect(&renderer).iter().filter(|pixel| luminance(pixel) == 0.0).count();
        let pixels = settings.size[0] * settings.size[1];
        assert!(dark as u32 * 50 < pixels, "step {step}: {dark} of {pixels} pixels are black");
    }
}

#[test]
fn settings_that_the_device_cannot_do_change_nothing() {
    let Some(gpu) = GpuFixture::open() else { return };
    let scene = scene(STUDIO);
    let pose = scene.pose(0.0);
    let mut renderer = gpu.rendered(&scene, &start(), 4);
    if !gpu.device.info().ray_query {
        let hardware = Settings { tracer: TracerKind::Hardware, ..start() };
        let error = renderer.set_settings(&hardware, &pose).unwrap_err();
        assert!(matches!(error, RenderError::NoHardwareTracer { .. }), "{error}");
    }
    let huge =
        Settings { size: [16_384, 16_384], vpl: VplSettings { temporal_sets: 64, ..start().vpl }, ..start() };
    let error = renderer.set_settings(&huge, &pose).unwrap_err().to_string();
    assert!(!error.contains('\n'), "{error}");
    assert_eq!(renderer.settings(), &start());
    assert!(frozen(&mut renderer, &pose) == fresh(&gpu, &scene, &start()));
}

#[test]
fn another_scene_is_drawn_as_by_a_fresh_renderer() {
    let Some(gpu) = GpuFixture::open() else { return };
    let first = scene(STUDIO);
    let second = named_scene("cornell-box", None);
    let mut renderer = gpu.rendered(&first, &start(), 4);
    // Prepared elsewhere, while the first one is still drawn.
    let prepared = std::thread::scope(|scope| {
        let elsewhere = scope.spawn(|| PreparedScene::new(&second));
        renderer.render(&first.pose(0.0)).unwrap();
        elsewhere.join().unwrap()
    });
    renderer.replace_scene(prepared, &start(), &second.pose(0.0)).unwrap();
    assert!(frozen(&mut renderer, &second.pose(0.0)) == fresh(&gpu, &second, &start()));
    let frames: Vec<u64> = renderer.finish().unwrap().iter().map(|report| report.frame).collect();
    assert!(frames.into_iter().eq(0..5 + 16), "every frame is reported once");
}

/// The scene with another material, whose index is given.
fn edited(scene: &Scene, index: usize, edit: impl Fn(&mut Material)) -> Arc<Scene> {
    let mut edited = scene.clone();
    edit(&mut edited.materials[index]);
    edited.lights.retain(|light| !matches!(light.kind, LightKind::Area { .. }));
    for instance in 0..edited.instances.len() {
        edited.add_area_light(instance);
    }
    Arc::new(edited)
}

fn map(colour: Vec3) -> Option<Arc<EnvironmentMap>> {
    let texel = |i: usize| colour * if i < 16 { 4.0 } else { 0.5 };
    Some(Arc::new(EnvironmentMap::new(8, 4, (0..32).map(texel).collect())))
}

#[test]
fn edited_scenes_end_as_a_fresh_renderer_bit_for_bit() {
    let Some(gpu) = GpuFixture::open() else { return };
    // Fewer paths a frame than there are, so that some await their turn.
    let settings = Settings { vpl: VplSettings { budget: 16, ..start().vpl }, ..start() };
    let cornell = named_scene("cornell-box", None);
    let red = cornell.materials.iter().position(|material| material.name == "red").unwrap();
    let grey = edited(&cornell, red, |wall| wall.base_colour = Vec3::splat(0.3));
    let metal = edited(&grey, red, |wall| {
        (wall.metallic, wall.roughness, wall.f0, wall.f90) = (1.0, 0.3, Vec3::splat(0.04), 1.0);
    });
    let glowing = edited(&metal, red, |wall| wall.emission = Vec3::new(0.0, 2.0, 3.0));
    let brighter = edited(&glowing, red, |wall| wall.emission *= 5.0);
    let dark = edited(&brighter, red, |wall| wall.emission = Vec3::ZERO);
    let sky = |colour: Vec3| Environment { radiance: Vec3::ONE, map: map(colour), rotation: 0.5 };
    let under = |environment| Arc::new(Scene { environment, ..(*dark).clone() });
    let scenes = [
        ("base colour", grey),
        ("metal", metal),
        ("becomes emissive", glowing),
        ("more emissive", brighter),
        ("no longer emissive", dark.clone()),
        ("a map", under(Some(sky(Vec3::new(0.2, 0.4, 1.0))))),
        ("another map", under(Some(sky(Vec3::new(1.0, 0.4, 0.1))))),
        ("one colour", under(Some(Environment::constant(Vec3::ONE)))),
        ("no environment", under(None)),
    ];
    let mut renderer = gpu.rendered(&cornell, &settings, 5);
    let mut before = renderer.read_picture(false).unwrap();
    // In a quick run a light that comes, a map, and no environment.
    for (what, scene) in scenes.into_iter().skip(quick_or_all(2, 0)).step_by(quick_or_all(3, 1)) {
        let pose = scene.pose(0.0);
        assert!(scene.same_geometry_and_bindings(renderer.scene()), "{what}");
        renderer.set_scene(&scene, &pose).unwrap();
        renderer.render(&pose).unwrap();
        assert!(renderer.read_picture(false).unwrap() != before, "{what}: not seen in the next frame");
        let picture = frozen(&mut renderer, &pose);
        assert!(picture == fresh(&gpu, &scene, &settings), "{what}");
        before = picture;
    }
    let frames: Vec<u64> = renderer.finish().unwrap().iter().map(|report| report.frame).collect();
    assert!(frames.is_sorted() && frames.first() == Some(&0), "the renderer has gone on");
}

#[test]
fn textured_materials_are_edited_without_their_textures() {
    let Some(gpu) = GpuFixture::open() else { return };
    let mut scenes = vec![Arc::new(floor())];
    scenes.extend(assets().map(|assets| named_scene("damaged-helmet", Some(&assets))));
    for scene in scenes {
        let edited = edited(&scene, 0, |material| {
            (material.metallic, material.roughness, material.normal_scale) = (0.2, 0.9, 0.3);
            (material.base_colour, material.emission) = (Vec3::new(0.9, 0.5, 0.4), material.emission * 3.0);
        });
        let (pose, settings) = (edited.pose(0.0), start());
        let mut renderer = gpu.rendered(&scene, &settings, 5);
        renderer.set_scene(&edited, &pose).unwrap();
        let picture = frozen(&mut renderer, &pose);
        assert!(picture == fresh(&gpu, &edited, &settings), "{}", scene.name);
        assert!(picture != fresh(&gpu, &scene, &settings), "{}", scene.name);
    }
}

#[test]
fn a_scene_of_other_meshes_is_built_anew() {
    let Some(gpu) = GpuFixture::open() else { return };
    let (first, second) = (scene(STUDIO), named_scene("cornell-box", None));
    assert!(!second.same_geometry_and_bindings(&first));
    let mut renderer = gpu.rendered(&first, &start(), 4);
    renderer.set_scene(&second, &second.pose(0.0)).unwrap();
    assert!(frozen(&mut renderer, &second.pose(0.0)) == fresh(&gpu, &second, &start()));
}

#[test]
fn an_area_light_that_changes_or_goes_is_seen_to() {
    let Some(gpu) = GpuFixture::open() else { return };
    let scene = named_scene("cornell-box", None);
    let brightest = |change: fn(&mut Vec<glowworm::scene::Light>)| {
        let mut pose = scene.pose(0.0);
        change(&mut pose.lights);
        let mut renderer = gpu.renderer(&scene, &start(), &pose);
        for _ in 0..4 {
            renderer.render(&pose).unwrap();
        }
        let picture = renderer.read_picture(true).unwrap();
        let direct = layer(&picture, "direct").iter().map(luminance).fold(0.0, f32::max);
        (direct, brightness(&renderer))
    };
    let (punctual, room) = brightest(|_| {});
    let (brighter_punctual, brighter_room) = brightest(|lights| {
        for light in lights {
            let LightKind::Area { triangles, .. } = &mut light.kind else { continue };
            triangles.iter_mut().for_each(|emitter| emitter.radiance *= 3.0);
        }
    });
    assert!(punctual > 0.0 && room > 0.0);
    assert!((brighter_punctual / punctual - 3.0).abs() < 1e-3 && (brighter_room / room - 3.0).abs() < 1e-2);
    assert_eq!(brightest(Vec::clear), (0.0, 0.0));
}
