//! What temporal sets are for. A test of its own, so that nothing else runs beside it.

#![allow(clippy::unwrap_used)]

mod support;

use glowworm::settings::Settings;
use support::{Lab, assets, named_scene, skip};

#[test]
fn temporal_sets_are_faster() {
    let Some(lab) = Lab::open() else { return };
    let Some(assets) = assets() else { return };
    if lab.device.info().kind != "cpu" {
        return skip("measured on a CPU device only, where frames take long enough to compare");
    }
    let scene = named_scene("sponza", Some(&assets));
    let median = |temporal_sets: u32, frames: u32| {
        let settings = Settings { size: [512, 512], temporal_sets, ..Settings::default() };
        let mut times: Vec<f64> = lab
            .rendered(&scene, &settings, frames)
            .finish()
            .unwrap()
            .iter()
            .map(|report| report.figures.total_ms)
            .collect();
        times.sort_by(f64::total_cmp);
        times[times.len() / 2]
    };
    let (one, sixteen) = (median(1, 3), median(16, 9));
    println!(
        "sponza 512x512, 512 VPLs, 4x4, {}: T = 1 {one:.0} ms, T = 16 {sixteen:.0} ms",
        lab.device.info().name
    );
    assert!(one >= 5.0 * sixteen, "T = 16 is only {} times as fast", one / sixteen);
}
