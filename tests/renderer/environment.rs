//! Environments: VPLs at infinity and those after them against analytic irradiance and the path tracer.

use std::sync::Arc;

use glam::Vec3;
use glowworm::scene::{Environment, EnvironmentMap, Scene};
use glowworm::settings::Settings;

use super::reference::check_against_reference;
use super::support::golden::reference;
use super::support::{GpuFixture, exact, indirect, layer, luminance, mean, plain, quantile, scene};
use super::{forgetting, support};

/// A blue sky over a brown ground, with a sun that gives about half of the light, too wide to be cut out of the map.
pub(super) fn sky(rotation: f32) -> Environment {
    let texel = |i: usize| match (i % 64, i / 64) {
        (39..43, 7..11) => Vec3::new(225.0, 200.0, 150.0),
        (_, y) if y < 16 => Vec3::new(0.5, 0.8, 1.2) * (0.5 + y as f32 / 16.0),
        _ => Vec3::new(0.2, 0.15, 0.1),
    };
    let map = EnvironmentMap::new(64, 32, (0..64 * 32).map(texel).collect());
    Environment { radiance: Vec3::ONE, map: Some(Arc::new(map)), rotation }
}

fn under(environment: Environment, text: &str) -> Arc<Scene> {
    Arc::new(Scene { environment: Some(environment), ..(*scene(text)).clone() })
}

/// A court without a roof, with a table in it.
const COURT: &str = r#"
[[models]]
name = "box"
primitive = "box"
size = [1, 1, 1]
material = { albedo = [0.7, 0.6, 0.5] }
[[instances]]
model = "box"
translation = [0, -0.1, 0]
scale = [5, 0.2, 5]
[[instances]]
model = "box"
translation = [-2, 1, 0]
scale = [0.2, 2, 4]
[[instances]]
model = "box"
translation = [2, 1, 0]
scale = [0.2, 2, 4]
[[instances]]
model = "box"
translation = [0, 1, -2]
scale = [4, 2, 0.2]
[[instances]]
name = "table"
model = "box"
translation = [0.3, 0.7, -0.3]
scale = [1.6, 0.1, 1.2]
dynamic = true
[camera]
eye = [-0.6, 1.9, 3.6]
target = [0, 0.6, 0]
vfov_deg = 50
"#;

#[test]
fn a_convex_object_under_a_constant_sky_receives_pi_l() {
    let Some(gpu) = GpuFixture::open() else { return };
    let sphere = r#"
        [[models]]
        name = "sphere"
        primitive = "sphere"
        size = [1, 1, 1]
        subdivisions = 5
        material = { albedo = [0.5, 0.5, 0.5] }
        [[instances]]
        model = "sphere"
        [camera]
        eye = [0, 1, 4]
        target = [0, 0, 0]
        vfov_deg = 40
    "#;
    let scene = under(Environment::constant(Vec3::new(1.0, 2.0, 4.0)), sphere);
    let mut settings = exact([32; 2]);
    (settings.bounces, settings.vpl.slots, settings.vpl.pool) = (2, 6144, 6144);
    let drawn = gpu.rendered(&scene, &settings, 1).read_picture(true).unwrap();
    let seen = |pixel: &[f32; 3]| luminance(pixel) > 0.0;
    let lit: Vec<[f32; 3]> = layer(&drawn, "indirect").into_iter().filter(seen).collect();
    assert!(lit.len() > 300, "{} pixels", lit.len());
    for (channel, radiance) in [1.0, 2.0, 4.0].into_iter().enumerate() {
        let expected = std::f32::consts::PI * radiance;
        let errors: Vec<f32> = lit.iter().map(|pixel| (pixel[channel] / expected - 1.0).abs()).collect();
        let worst = quantile(errors, 1.0);
        assert!(worst < 0.01, "off by {worst}");
    }
    // The sky is seen beside it.
    assert_eq!(layer(&drawn, "direct")[0], [1.0, 2.0, 4.0]);
}

#[test]
#[ignore = "long; a_sun_in_the_map_makes_no_fireflies is quicker"]
fn a_court_under_a_sunny_sky_is_lit_as_in_the_reference() {
    check_against_reference("court", &under(sky(0.4), COURT), 1, 32_768);
}

#[test]
fn the_map_is_seen_as_in_the_reference() {
    let Some(gpu) = GpuFixture::open() else { return };
    let empty = under(sky(1.0), "[camera]\neye = [0, 0, 0]\ntarget = [-0.1, 0.5, -1]\nvfov_deg = 100\n");
    let drawn = gpu.rendered(&empty, &exact([48; 2]), 1).read_picture(true).unwrap();
    let reference = reference("sky", &empty, [48; 2], 2, 1);
    for (a, b) in layer(&drawn, "direct").iter().zip(layer(&reference, "direct")) {
        // Texels have mantissas of nine bits.
        let most = b.iter().copied().fold(0.0, f32::max);
        assert!((0..3).all(|i| (a[i] - b[i]).abs() < 0.005 * most + 1e-4), "{a:?} {b:?}");
    }
    assert!(
        layer(&drawn, "direct").iter().any(|pixel| luminance(pixel) > 100.0),
        "the sun is in the picture"
    );
}

#[test]
fn a_sun_in_the_map_makes_no_fireflies() {
    let Some(gpu) = GpuFixture::open() else { return };
    let scene = under(sky(0.4), COURT);
    let settings = Settings { size: [64, 48], ..plain() };
    let drawn = indirect(&gpu.rendered(&scene, &settings, 16));
    let reference = layer(&reference("court", &scene, settings.size, settings.bounces, 512), "indirect");
    let usual = mean(reference.iter().map(luminance));
    for (pixel, reference) in drawn.iter().zip(&reference) {
        let most = 10.0 * luminance(reference).max(0.05 * usual);
        assert!(luminance(pixel) < most, "{pixel:?} where {reference:?} is right");
    }
}

#[test]
fn a_sky_that_has_turned_is_forgotten() {
    forgetting::check_in(&under(sky(0.0), COURT), |pose, time| {
        pose.environment.as_mut().unwrap().rotation = 0.8 * time;
    });
}

#[test]
fn a_sky_that_has_dimmed_is_forgotten() {
    forgetting::check_in(&under(sky(0.0), COURT), |pose, time| {
        pose.environment.as_mut().unwrap().radiance = Vec3::new(1.0, 1.0 - 0.5 * time, 1.0);
    });
}

#[test]
fn a_table_that_has_moved_under_a_sky_is_forgotten() {
    forgetting::check_in(&under(sky(0.0), COURT), |pose, time| {
        pose.instances[4].translation.x -= 0.9 * time;
    });
}

#[test]
fn the_sky_may_come_and_go() {
    let whole = under(sky(0.0), COURT);
    forgetting::check_in(&whole, |pose, time| {
        if (0.2..0.9).contains(&time) {
            pose.environment = None;
        }
    });
    let Some(gpu) = support::GpuFixture::open() else { return };
    let mut pose = whole.pose(0.0);
    let mut renderer = gpu.renderer(&whole, &exact([32; 2]), &pose);
    pose.environment = None;
    renderer.render(&pose).unwrap();
    assert!(indirect(&renderer).iter().all(|pixel| luminance(pixel) == 0.0));
}
