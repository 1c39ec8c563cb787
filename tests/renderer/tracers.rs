//! Both tracers draw the same picture, and can be exchanged while the renderer runs.

use std::path::Path;
use std::sync::Arc;

use glowworm::estimators::vpls::{SlotState, VplDebugView};
use glowworm::output::Picture;
use glowworm::renderer::DebugView;
use glowworm::scene::Scene;
use glowworm::settings::{Settings, TracerKind, VplSettings};

use super::still::frozen;
use super::support::{GpuFixture, assets, layer, luminance, mean, named_scene, plain, skip, vpls};

/// Seconds from frame to frame: objects move far.
const STEP: f64 = 0.1;

fn settings(tracer: TracerKind) -> Settings {
    Settings {
        size: [120, 80],
        tracer,
        vpl: VplSettings { slots: 128, temporal_sets: 4, interleave: 2, ..VplSettings::default() },
        ..plain()
    }
}

/// A device with both tracers.
fn open() -> Option<GpuFixture> {
    let gpu = GpuFixture::open()?;
    if !gpu.device.info().ray_query {
        skip("the device has no ray queries");
        return None;
    }
    Some(gpu)
}

/// Something of every kind: masks, mirrored and stretched instances, objects that move.
fn all_kinds() -> Arc<Scene> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/scene-files/all-kinds.toml");
    named_scene(file.to_str().unwrap(), None)
}

/// Some frames of an animated scene.
fn frames(gpu: &GpuFixture, scene: &Arc<Scene>, tracer: TracerKind) -> Vec<Picture> {
    let mut renderer = gpu.renderer(scene, &settings(tracer), &scene.pose(0.0));
    (0..8)
        .map(|frame| {
            renderer.render(&scene.pose(f64::from(frame) * STEP)).unwrap();
            renderer.read_picture(true).unwrap()
        })
        .collect()
}

/// Fails unless almost all pixels agree: a ray that passes an edge may be decided otherwise.
fn compare(name: &str, software: &Picture, hardware: &Picture) {
    let [ours, expected] = [hardware, software].map(|picture| layer(picture, "indirect"));
    let differing = ours
        .iter()
        .zip(&expected)
        .filter(|(a, b)| (luminance(a) - luminance(b)).abs() > 1e-3 * luminance(b).max(1e-6))
        .count();
    assert!(differing * 200 <= ours.len(), "{name}: {differing} of {} pixels differ", ours.len());
    let [ours, expected] = [ours, expected].map(|pixels| mean(pixels.iter().map(luminance)));
    assert!(expected > 0.0, "{name} is black");
    assert!((ours / expected - 1.0).abs() < 1e-3, "{name}: {ours} is not {expected}");
    let steps = hardware.display.iter().flatten().zip(software.display.iter().flatten());
    let steps = mean(steps.map(|(a, b)| f32::from(a.abs_diff(*b))));
    assert!(steps < 0.02, "{name}: {steps} of 255 apart");
}

fn draw_the_same(gpu: &GpuFixture, scene: &Arc<Scene>) {
    let [software, hardware] =
        [TracerKind::Software, TracerKind::Hardware].map(|tracer| frames(gpu, scene, tracer));
    for (number, (software, hardware)) in software.iter().zip(&hardware).enumerate() {
        compare(&format!("{}, frame {number}", scene.name), software, hardware);
    }
}

#[test]
fn both_draw_the_cornell_box() {
    let Some(gpu) = open() else { return };
    draw_the_same(&gpu, &named_scene("cornell-box", None));
}

#[test]
fn both_draw_masks_and_what_moves() {
    let Some(gpu) = open() else { return };
    draw_the_same(&gpu, &all_kinds());
}

#[test]
fn both_draw_a_real_scene() {
    let Some(gpu) = open() else { return };
    let Some(assets) = assets() else { return };
    draw_the_same(&gpu, &named_scene("sponza", Some(&assets)));
}

#[test]
fn one_takes_the_place_of_the_other() {
    let Some(gpu) = open() else { return };
    let scene = all_kinds();
    let pose = scene.pose(0.0);
    let settings = |tracer| Settings { still_frames: 8, ..settings(tracer) };
    let fresh = |tracer| frozen(&mut gpu.renderer(&scene, &settings(tracer), &pose), &pose);
    let mut renderer = gpu.rendered(&scene, &settings(TracerKind::Software), 4);
    for tracer in [TracerKind::Hardware, TracerKind::Software] {
        renderer.set_settings(&settings(tracer), &pose).unwrap();
        assert!(frozen(&mut renderer, &pose) == fresh(tracer), "{tracer:?}");
    }
}

#[test]
fn views_follow_the_tracer() {
    let Some(gpu) = open() else { return };
    let scene = all_kinds();
    let pose = scene.pose(0.0);
    // Automatic exposure follows the noise of the frames.
    let settings = |tracer| Settings { exposure: Some(1.0), ..settings(tracer) };
    let mut renderer = gpu.rendered(&scene, &settings(TracerKind::Software), 4);
    let valid = vpls(&renderer).slots().position(|slot| slot.state == SlotState::Valid && slot.bounce == 1);
    let options = VplDebugView { single_vpl: Some(valid.unwrap() as u32), ..VplDebugView::default() };
    let view = DebugView::default().with_options(&options);
    renderer.set_view(&view).unwrap();
    let mut shown = [TracerKind::Software, TracerKind::Hardware].map(|tracer| {
        renderer.set_settings(&settings(tracer), &pose).unwrap();
        renderer.render(&pose).unwrap();
        renderer.read_picture(false).unwrap().display
    });
    let [software, hardware] = &mut shown;
    let lit = software.iter().filter(|pixel| pixel[0] > 20).count();
    assert!(lit * 10 > software.len(), "the VPL lights {lit} pixels");
    let differing = software.iter().zip(hardware).filter(|(a, b)| a != b).count();
    assert!(differing * 100 <= software.len(), "{differing} pixels differ");
}

#[test]
fn a_frame_takes_no_memory() {
    let Some(gpu) = open().and_then(|_| GpuFixture::open_alone()) else { return };
    let scene = all_kinds();
    let mut renderer = gpu.renderer(&scene, &settings(TracerKind::Hardware), &scene.pose(0.0));
    let mut draw = |frames: std::ops::Range<u32>| {
        for frame in frames {
            renderer.render(&scene.pose(f64::from(frame) * STEP)).unwrap();
        }
        gpu.device.memory_peak()
    };
    draw(0..4);
    gpu.device.restart_memory_peak();
    let settled = gpu.device.memory_peak();
    assert_eq!(draw(4..12), settled);
}
