//! Whole pictures: the real scenes for plausibility, speed.

use super::support::{Lab, assets, luminance, mean, named_scene, skip};
use glowworm::settings::Settings;

#[test]
fn the_real_scenes_render() {
    let Some(lab) = Lab::open() else { return };
    let Some(assets) = assets() else { return };
    for name in ["sponza", "sibenik", "conference", "classroom", "living-room"] {
        let scene = named_scene(name, Some(&assets));
        let settings = Settings { size: [96, 54], vpls: 128, temporal_sets: 4, ..Settings::default() };
        let picture = lab.rendered(&scene, &settings, 5).read_picture(true).unwrap();
        assert!(picture.colour.iter().flatten().all(|value| value.is_finite()), "{name}");
        let brightness = mean(
            picture
                .display
                .iter()
                .map(|pixel| luminance(&[0, 1, 2].map(|channel| f32::from(pixel[channel]) / 255.0))),
        );
        assert!((0.15..0.85).contains(&brightness), "{name} is {brightness} bright");
    }
}

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
