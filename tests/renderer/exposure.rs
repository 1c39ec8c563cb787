//! Automatic exposure that adapts frame by frame.

use glowworm::scene::{LightKind, Pose};
use glowworm::settings::{Indirect, Settings};

use crate::support::{GpuFixture, exact, named_scene};

const PACE: f32 = 0.25;
/// So many frames take 4 stops to less than the last step, .02 stops: 4 * .75^n.
const FRAMES: u32 = 20;

/// Mean of what is shown, 0 to 255.
fn brightness(display: &[[u8; 4]]) -> f64 {
    display.iter().map(|pixel| f64::from(pixel[1])).sum::<f64>() / display.len() as f64
}

/// `pose` with 16 times the light.
fn brighter(pose: &Pose) -> Pose {
    let mut pose = pose.clone();
    for light in &mut pose.lights {
        match &mut light.kind {
            LightKind::Point { intensity } | LightKind::Spot { intensity, .. } => *intensity *= 16.0,
            LightKind::Directional { irradiance } => *irradiance *= 16.0,
            LightKind::Area { .. } => {}
        }
    }
    pose
}

#[test]
fn it_follows_the_light_and_comes_to_rest_where_it_would_begin() {
    let Some(gpu) = GpuFixture::open() else { return };
    let scene = named_scene("playroom", None);
    let settings = Settings { indirect: Indirect::NONE, ..exact([96, 54]) };
    let dark = scene.pose(0.0);
    let bright = brighter(&dark);
    let mut fresh = gpu.renderer(&scene, &settings, &bright);
    fresh.render(&bright).unwrap();
    let expected = fresh.read_display().unwrap();

    let mut renderer = gpu.renderer(&scene, &settings, &dark);
    let mut shown = |pose: &Pose| {
        renderer.set_exposure_pace(PACE);
        renderer.render(pose).unwrap();
        renderer.read_display().unwrap()
    };
    let before = brightness(&shown(&dark));
    assert!((before - brightness(&expected)).abs() < 10.0, "exposure hides the change of light");
    let glare = brightness(&shown(&bright));
    assert!(glare > 1.4 * before, "{glare} after {before}: exposure jumps");
    let mut last = glare;
    for frame in 2..FRAMES {
        let now = brightness(&shown(&bright));
        assert!(now <= last, "frame {frame}: {now} after {last}");
        last = now;
    }
    assert!(shown(&bright) == expected, "it depends on the past");
}
