//! What temporal sets are for. A test of its own, so that nothing else runs beside it.

#![allow(clippy::unwrap_used)]

mod support;

use glowworm::renderer::Renderer;
use glowworm::settings::{Antialiasing, Reflections, Settings, VplSettings};
use support::{Lab, assets, named_scene, skip};

#[test]
fn temporal_sets_are_faster() {
    let Some(lab) = Lab::open_to_measure() else { return };
    let Some(assets) = assets() else { return };
    if lab.device.info().kind != "cpu" {
        return skip("measured on a CPU device only, where frames take long enough to compare");
    }
    let scene = named_scene("sponza", Some(&assets));
    let pose = scene.pose(0.0);
    let renderer = |temporal_sets: u32| {
        let settings = Settings {
            size: [512, 512],
            vpl: VplSettings { temporal_sets, ..VplSettings::default() },
            // What all sets share is not the question.
            antialiasing: Antialiasing::None,
            reflections: Reflections::None,
            ..Settings::default()
        };
        lab.renderer(&scene, &settings, &pose)
    };
    let (mut one, mut sixteen) = (renderer(1), renderer(16));
    let frame_ms = |renderer: &mut Renderer, frames: u32| {
        for _ in 0..frames {
            renderer.render(&pose).unwrap();
        }
        let reports = renderer.finish().unwrap();
        median(reports.iter().map(|report| report.figures.total_ms).collect())
    };
    frame_ms(&mut one, 1);
    frame_ms(&mut sixteen, 16);
    // In turns, so that a machine that is slow for a while is slow for both.
    let rounds: Vec<[f64; 2]> = (0..5).map(|_| [frame_ms(&mut one, 3), frame_ms(&mut sixteen, 16)]).collect();
    let ratio = median(rounds.iter().map(|[one, sixteen]| one / sixteen).collect());
    let [one, sixteen] = [0, 1].map(|which| median(rounds.iter().map(|round| round[which]).collect()));
    println!(
        "sponza 512x512, 512 VPLs, 4x4, {}: T = 1 {one:.0} ms, T = 16 {sixteen:.0} ms, ratio {ratio:.2}",
        lab.device.info().name
    );
    assert!(ratio >= 5.0, "T = 16 is only {ratio} times as fast");
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}
