//! Presets of theses: each runs its method, by its passes and rays, and has the light of the path tracer where it is unbiased.

use std::sync::Arc;

use glam::Vec3;
use glowworm::report::FrameReport;
use glowworm::scene::Scene;
use glowworm::settings::{MissingSets, Preset, Settings, VplSettings};

use super::paths::corner;
use super::support::golden::reference;
use super::support::{GpuFixture, indirect, layer, luminance, mean, named_scene};

const SIDE: u32 = 64;
const PIXELS: f32 = (SIDE * SIDE) as f32;

fn preset(preset: Preset) -> Settings {
    Settings { size: [SIDE; 2], ..Settings::default() }.with_preset(preset)
}

/// The report of the last of `frames` frames of the Cornell box, and the mean radiance of the second half.
fn frames(gpu: &GpuFixture, scene: &Arc<Scene>, settings: &Settings, frames: u32) -> (FrameReport, f32) {
    let pose = scene.pose(0.0);
    let mut renderer = gpu.renderer(scene, settings, &pose);
    let mut sum = 0.0;
    for frame in 0..frames {
        renderer.render(&pose).unwrap();
        if frame >= frames / 2 {
            sum += mean_light(&renderer.read_picture(false).unwrap().colour);
        }
    }
    (renderer.finish().unwrap().pop().unwrap(), sum / (frames - frames / 2) as f32)
}

fn mean_light(light: &[[f32; 3]]) -> f32 {
    mean(light.iter().map(luminance))
}

/// Fails unless exactly these of some passes took time.
fn check_passes(report: &FrameReport, run: &[&str], not_run: &[&str]) {
    let ms = |name: &&str| report.figures.passes.get(*name).copied().unwrap_or(0.0);
    let idle: Vec<_> = run.iter().filter(|name| ms(name) == 0.0).collect();
    let busy: Vec<_> = not_run.iter().filter(|name| ms(name) > 0.0).collect();
    assert!(idle.is_empty() && busy.is_empty(), "did not run: {idle:?}; ran: {busy:?}");
}

fn rays(report: &FrameReport, counter: &str) -> f32 {
    report.figures.counters.get(counter) as f32 / PIXELS
}

#[test]
fn tonna_casts_a_ray_to_every_vpl_of_a_class() {
    let Some(gpu) = GpuFixture::open() else { return };
    let scene = named_scene("cornell-box", None);
    let expected = layer(&reference("cornell-box", &scene, [SIDE; 2], 2, 512), "indirect");
    for (temporal_sets, interleave) in [(1, 4), (16, 4), (4, 2)] {
        let settings = preset(Preset::Tonna);
        let vpl = VplSettings { temporal_sets, interleave, ..settings.vpl };
        let settings = Settings { vpl, ..settings };
        let mut renderer = gpu.rendered(&scene, &settings, 2 * temporal_sets);
        let ratio = mean_light(&indirect(&renderer)) / mean_light(&expected);
        let report = renderer.finish().unwrap().pop().unwrap();
        check_passes(
            &report,
            &["class_gathering", "class_filter", "camera_reprojection"],
            &[
                "vpl_sampling",
                "bias_compensation",
                "set_reprojection",
                "indirect_spatial_filter",
                "taa",
                "still",
            ],
        );
        // Rays go to VPLs that a pixel faces and that face it: about half.
        let (all, cast) =
            (512.0 / (temporal_sets * interleave * interleave) as f32, rays(&report, "shadow_rays"));
        assert!(cast > 0.3 * all && cast <= all, "{cast} rays a pixel of {all}");
        assert_eq!(report.figures.counters.get("vpls.slots"), 512, "a pool");
        assert!((ratio - 1.0).abs() < 0.03, "{temporal_sets} sets: the mean is {ratio} of the reference's");
    }
}

#[test]
fn tonna_leaves_dark_what_its_sets_have_not_seen() {
    let Some(gpu) = GpuFixture::open() else { return };
    let scene = named_scene("cornell-box", None);
    let light_after_a_move = |position_cutoff: f32, missing_sets: MissingSets| {
        let settings = preset(Preset::Tonna);
        let vpl = VplSettings { position_cutoff, missing_sets, ..settings.vpl };
        let mut pose = scene.pose(0.0);
        let mut renderer = gpu.renderer(&scene, &Settings { vpl, ..settings }, &pose);
        for _ in 0..32 {
            renderer.render(&pose).unwrap();
        }
        pose.camera.eye += Vec3::new(0.03, 0.02, 0.0);
        renderer.render(&pose).unwrap();
        mean_light(&indirect(&renderer))
    };
    let usual = light_after_a_move(0.02, MissingSets::Dark);
    // No texel lies exactly there: only the set of this frame does.
    let holes = light_after_a_move(1e-4, MissingSets::Dark);
    let scaled = light_after_a_move(1e-4, MissingSets::Scale);
    assert!(holes < 0.4 * usual, "{holes} of {usual}");
    assert!((scaled / usual - 1.0).abs() < 0.15, "{scaled} of {usual}");
}

#[test]
fn granja_casts_one_ray_for_shadows_and_accumulates_by_its_shares() {
    let Some(gpu) = GpuFixture::open() else { return };
    let scene = corner(
        "[[lights]]\ntype = \"directional\"\ndirection = [-0.5, -1, -0.4]\nirradiance = [3, 3, 3]\nangle_deg = 10",
    );
    let (report, _) = frames(&gpu, &scene, &preset(Preset::Granja), 4);
    check_passes(
        &report,
        &[
            "soft_shadows_trace",
            "soft_shadows_svgf_temporal",
            "soft_shadows_svgf_atrous",
            "reflections_trace",
            "reflections_svgf_temporal",
            "reflections_svgf_atrous",
            "taa",
        ],
        &["direct_shadows", "indirect_shadows", "paths_trace", "still"],
    );
    let expected = mean_light(&layer(&reference("corner-wide-sun", &scene, [SIDE; 2], 1, 256), "direct"));
    let renderer = gpu.rendered(&scene, &preset(Preset::Granja), 48);
    let ratio = mean_light(&layer(&renderer.read_picture(true).unwrap(), "direct")) / expected;
    // Clamped history and a curve that counts bright light less take some.
    assert!((0.9..1.05).contains(&ratio), "direct light is {ratio} of the reference's");
}

#[test]
fn flatval_traces_paths_of_four_surfaces_and_fits_features() {
    let Some(gpu) = GpuFixture::open() else { return };
    let scene = named_scene("cornell-box", None);
    let settings =
        Settings { antialiasing: glowworm::settings::Antialiasing::None, ..preset(Preset::Flatval) };
    let (report, light) = frames(&gpu, &scene, &settings, 32);
    check_passes(
        &report,
        &["paths_trace", "indirect_bmfr_accumulate", "indirect_bmfr_fit", "indirect_bmfr_filtered"],
        &["direct_shadows", "soft_shadows_trace", "cells_insert", "indirect_svgf_temporal", "still"],
    );
    let cast = rays(&report, "rays");
    assert!(cast > 3.0 && cast <= 8.0, "{cast} rays a pixel");
    let ratio = light / mean_light(&reference("cornell-box", &scene, [SIDE; 2], 3, 256).colour);
    assert!((ratio - 1.0).abs() < 0.03, "the mean is {ratio} of the reference's");
}

#[test]
fn meijer_shares_paths_of_one_bounce_at_every_vertex() {
    let Some(gpu) = GpuFixture::open() else { return };
    let scene = named_scene("cornell-box", None);
    let (report, light) = frames(&gpu, &scene, &preset(Preset::Meijer), 32);
    check_passes(
        &report,
        &["paths_trace", "cells_insert", "cells_resolve", "cells_read"],
        &["direct_shadows", "soft_shadows_trace", "indirect_svgf_temporal", "taa", "still"],
    );
    // Two surfaces, a ray on and one to a light from each.
    let cast = rays(&report, "rays");
    assert!(cast > 1.5 && cast <= 4.0, "{cast} rays a pixel");
    // Cells of the second vertex hold light of any number of bounces.
    let of = |bounces| mean_light(&reference("cornell-box", &scene, [SIDE; 2], bounces, 256).colour);
    let [one, all] = [1, 16].map(of);
    assert!((one..1.05 * all).contains(&light), "{light}, the reference's are {one} and {all}");
}
