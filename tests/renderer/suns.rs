//! Suns of environment maps: their shadows and reflections, against the path tracer, which knows the map alone.

use std::sync::Arc;

use glam::Vec3;
use glowworm::scene::{Environment, EnvironmentMap, Scene};
use glowworm::settings::{Antialiasing, Direct, Reflections, Settings};

use super::support::golden::reference;
use super::support::{GpuFixture, layer, luminance, mean, plain, scene};

const SIZE: [u32; 2] = [64, 48];
const BLOCK: usize = 8;

/// Two suns over a dim sky: one across the map's seam, a weaker one.
fn sky(rotation: f32) -> Environment {
    let texel = |i: usize| match (i % 256, i / 256) {
        (0 | 255, 36..38) => Vec3::new(900.0, 800.0, 700.0),
        (60, 30) => Vec3::new(1200.0, 600.0, 300.0),
        _ => Vec3::new(0.2, 0.25, 0.3),
    };
    let map = EnvironmentMap::new(256, 128, (0..256 * 128).map(texel).collect());
    Environment { radiance: Vec3::splat(1.5), map: Some(Arc::new(map)), rotation }
}

/// A box on a floor of this material.
fn yard(floor: &str, environment: Environment) -> Arc<Scene> {
    let scene = scene(&format!(
        r#"
[[models]]
name = "floor"
primitive = "quad"
size = [12, 1, 12]
material = {{ {floor} }}
[[models]]
name = "box"
primitive = "box"
size = [0.8, 1.2, 0.8]
material = {{ albedo = [0.6, 0.4, 0.3] }}
[[instances]]
model = "floor"
[[instances]]
model = "box"
translation = [0, 0.6, 0]
[camera]
eye = [0.5, 2.4, -4.5]
target = [0, 0.3, 0]
vfov_deg = 50
"#
    ));
    Arc::new(Scene { environment: Some(environment), ..(*scene).clone() })
}

/// Mean luminance of blocks of pixels.
fn blocks(pixels: &[[f32; 3]]) -> Vec<f32> {
    let [width, height] = SIZE.map(|side| side as usize);
    let mut sums = vec![0.0; width / BLOCK * (height / BLOCK)];
    for (at, pixel) in pixels.iter().enumerate() {
        sums[at / width / BLOCK * (width / BLOCK) + at % width / BLOCK] +=
            luminance(pixel) / (BLOCK * BLOCK) as f32;
    }
    sums
}

/// Compares the mean, and blocks; pixels brighter than `most`, as of a visible sun, are left out.
fn assert_agree(what: &str, drawn: &[[f32; 3]], expected: &[[f32; 3]], most: f32) {
    let dim = |pixels: &[[f32; 3]]| -> Vec<[f32; 3]> {
        let pairs = pixels.iter().zip(expected);
        pairs.map(|(pixel, expected)| if luminance(expected) > most { [0.0; 3] } else { *pixel }).collect()
    };
    let (drawn, expected) = (dim(drawn), dim(expected));
    let ratio = mean(drawn.iter().map(luminance)) / mean(expected.iter().map(luminance));
    let off = |(a, b): (f32, f32)| (a / b - 1.0).abs();
    let off: Vec<f32> = blocks(&drawn).into_iter().zip(blocks(&expected)).map(off).collect();
    let far = off.iter().filter(|off| **off > 0.05).count();
    eprintln!("{what}: mean {ratio}, {far} of {} blocks off by more than 5 %", off.len());
    assert!((ratio - 1.0).abs() < 0.01, "{what}: mean {ratio}");
    assert!(far * 20 <= off.len(), "{what}: {off:?}");
}

#[test]
#[ignore = "long; the_eye_sees_suns_in_the_sky is quicker"]
fn a_box_under_suns_has_its_shadows_as_in_the_reference() {
    let Some(gpu) = GpuFixture::open() else { return };
    let scene = yard("albedo = [0.7, 0.7, 0.7]", sky(0.5));
    let moving = Settings { size: SIZE, direct: Direct::Auto, ..plain() };
    let expected = reference("suns-box", &scene, SIZE, moving.bounces, 1024).colour;

    let still = Settings { still_frames: 128, ..moving.clone() };
    let renderer = gpu.rendered(&scene, &still, 200);
    assert_eq!(renderer.direct(), Direct::Soft);
    assert!(renderer.is_frozen());
    assert_agree("still", &renderer.read_picture(true).unwrap().colour, &expected, f32::INFINITY);

    // In motion the shadow is as dark, and where it is.
    let drawn = gpu.rendered(&scene, &moving, 24).read_picture(true).unwrap().colour;
    let lit = mean(expected.iter().map(luminance));
    let shadow = |pixels: &[[f32; 3]]| {
        let dark = pixels.iter().zip(&expected).filter(|(_, expected)| luminance(expected) < 0.4 * lit);
        mean(dark.map(|(pixel, _)| luminance(pixel)))
    };
    let [ours, theirs] = [shadow(&drawn), shadow(&expected)];
    eprintln!("shadows {ours}, {theirs} in the reference, {lit} everywhere");
    assert!((ours / theirs - 1.0).abs() < 0.1, "shadows {ours} where {theirs} is right");
    assert_agree("moving", &drawn, &expected, f32::INFINITY);
}

#[test]
#[ignore = "long; the_eye_sees_suns_in_the_sky is quicker"]
fn every_lobe_gets_the_light_of_suns_once() {
    let Some(gpu) = GpuFixture::open() else { return };
    for roughness in [0.0, 0.2, 0.5] {
        let floor = format!("albedo = [0.9, 0.9, 0.9], metallic = 1, roughness = {roughness}");
        let mut scene = (*yard(&floor, sky(0.5))).clone();
        // Light that a mirror sends to others is another matter.
        scene.instances.truncate(1);
        let scene = Arc::new(scene);
        let settings = Settings {
            size: SIZE,
            direct: Direct::Auto,
            reflections: Reflections::Rays,
            still_frames: 256,
            ..plain()
        };
        let drawn = gpu.rendered(&scene, &settings, 330).read_picture(true).unwrap();
        let expected = reference(&format!("suns-{roughness}"), &scene, SIZE, settings.bounces, 1024);
        let most = 20.0;
        assert_agree(&format!("roughness {roughness}"), &drawn.colour, &expected.colour, most);
        let seen = |pixels: &[[f32; 3]]| pixels.iter().filter(|pixel| luminance(pixel) > most).count();
        let [ours, theirs] = [seen(&drawn.colour), seen(&expected.colour)];
        eprintln!("{ours} pixels show a sun, {theirs} in the reference");
        assert!(
            roughness > 0.0 || (theirs > 0 && ours == theirs),
            "{ours} pixels show a sun, {theirs} should"
        );
    }
}

#[test]
fn the_eye_sees_suns_in_the_sky() {
    let Some(gpu) = GpuFixture::open() else { return };
    let empty = Scene {
        environment: Some(sky(0.0)),
        ..(*scene("[camera]\neye = [0, 0, 0]\ntarget = [0, 1.1, 1]\nvfov_deg = 60\n")).clone()
    };
    let settings = Settings { size: SIZE, antialiasing: Antialiasing::None, ..plain() };
    let drawn =
        layer(&gpu.rendered(&Arc::new(empty.clone()), &settings, 1).read_picture(true).unwrap(), "direct");
    let expected = layer(&reference("suns-sky", &empty, SIZE, 2, 1), "direct");
    let brightest = |pixels: &[[f32; 3]]| pixels.iter().map(luminance).fold(0.0, f32::max);
    let [ours, theirs] = [brightest(&drawn), brightest(&expected)];
    assert!(theirs > 500.0 && (ours / theirs - 1.0).abs() < 0.01, "{ours}, {theirs}");
}
