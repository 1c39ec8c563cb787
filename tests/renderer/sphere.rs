//! The integrating sphere: from a point light in the middle of a closed diffuse sphere, every VPL lights
//! every point alike, so the indirect irradiance is (I/R^2)(rho + ... + rho^B) everywhere.

use super::support::{GpuFixture, exact, indirect, luminance, mean, quantile, scene};

fn sphere(radius: f32, intensity: f32, albedo: f32) -> String {
    format!(
        r#"
        [[models]]
        name = "sphere"
        primitive = "sphere"
        size = [{radius}, {radius}, {radius}]
        subdivisions = 6
        material = {{ albedo = [{albedo}, {albedo}, {albedo}] }}
        [[instances]]
        model = "sphere"
        [[lights]]
        type = "point"
        position = [0, 0, 0]
        intensity = [{intensity}, {intensity}, {intensity}]
        [camera]
        eye = [{eye}, 0, 0]
        target = [-{radius}, {eye}, 0]
        vfov_deg = 70
        "#,
        eye = radius * 0.3
    )
}

fn check(radius: f32, bounces: u32, vpls: u32, interleave: u32) {
    const INTENSITY: f32 = 7.0;
    const ALBEDO: f32 = 0.6;
    let Some(gpu) = GpuFixture::open() else { return };
    let scene = scene(&sphere(radius, INTENSITY * radius * radius, ALBEDO));
    let mut settings = exact([64, 64]);
    (settings.bounces, settings.vpl.slots, settings.vpl.interleave) = (bounces, vpls, interleave);
    let found: Vec<f32> = indirect(&gpu.rendered(&scene, &settings, 1)).iter().map(luminance).collect();
    let expected: f32 = INTENSITY * (1..=bounces as i32).map(|bounce| ALBEDO.powi(bounce)).sum::<f32>();
    let average = mean(found.iter().copied());
    assert!((average / expected - 1.0).abs() < 0.005, "mean {average}, expected {expected}");
    let errors = found.iter().map(|found| (found / expected - 1.0).abs()).collect();
    let worst = quantile(errors, 0.99);
    assert!(worst < 0.02, "1 % of the pixels are off by more than {worst}");
}

#[test]
fn one_bounce() {
    check(2.0, 1, 256, 1);
}

#[test]
fn two_bounces() {
    check(2.0, 2, 512, 1);
}

#[test]
fn four_bounces_interleaved() {
    check(2.0, 4, 1024, 4);
}

#[test]
fn a_hundred_times_as_large() {
    check(200.0, 2, 512, 2);
}

#[test]
fn a_hundred_times_as_small() {
    check(0.02, 2, 512, 2);
}
