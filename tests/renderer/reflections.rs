//! Reflections by rays: mirrors show what is seen from the mirrored place, and the mean is that of the path tracer.

use std::f32::consts::PI;
use std::sync::Arc;

use glam::{Affine3A, Vec3};
use glowworm::metrics::{CompareOptions, Image, compare};
use glowworm::output::Picture;
use glowworm::renderer::Renderer;
use glowworm::scene::{Camera, Pose, Scene};
use glowworm::settings::{
    Denoise, Direct, EffectSettings, Indirect, Reflections, SecondReflections, Settings, SvgfSettings,
};

use super::environment::sky;
use super::support::golden::reference;
use super::support::{GpuFixture, channel, layer, luminance, mean, plain, scene};

pub(super) const SIZE: [u32; 2] = [96, 64];
/// Frames of a still scene until it is frozen.
pub(super) const FRAMES: u32 = 64;

/// Boxes, one of which glows, before an upright surface at z = -2 that faces them.
pub(super) fn stage(material: &str, more: &str) -> Arc<Scene> {
    scene(&format!(
        r#"
[[models]]
name = "mirror"
primitive = "box"
size = [12, 8, 0.2]
material = {{ {material} }}
[[models]]
name = "floor"
primitive = "box"
size = [12, 0.2, 12]
material = {{ albedo = [0.6, 0.55, 0.5] }}
[[models]]
name = "red"
primitive = "box"
size = [0.8, 1.6, 0.8]
material = {{ albedo = [0.8, 0.15, 0.1] }}
[[models]]
name = "lamp"
primitive = "box"
size = [0.5, 0.5, 0.5]
material = {{ albedo = [0, 0, 0], emission = [2, 1.5, 1] }}
[[instances]]
model = "mirror"
translation = [0, 3, -2.1]
[[instances]]
model = "floor"
translation = [0, -0.1, 3]
[[instances]]
name = "red"
model = "red"
translation = [-1, 0.8, 0]
rotation = [0, 25, 0]
dynamic = true
[[instances]]
model = "lamp"
translation = [1.1, 0.9, 0.3]
[[lights]]
type = "directional"
direction = [0.4, -1, -0.5]
irradiance = [3, 3, 3]
{more}
[camera]
eye = [0.8, 1.8, 4.5]
target = [0.2, 1.2, -2]
vfov_deg = 40
"#
    ))
}

pub(super) const SKY: &str = "[environment]\ncolour = [0.2, 0.3, 0.5]\n";

pub(super) fn settings(denoise: Denoise) -> Settings {
    let effects = EffectSettings { denoise, reflection_roughness: Some(1.0), ..EffectSettings::default() };
    let (direct, reflections) = (Direct::Soft, Reflections::Rays);
    Settings { size: SIZE, indirect: Indirect::NONE, direct, reflections, effects, ..plain() }
}

pub(super) fn colour(renderer: &Renderer) -> Vec<[f32; 3]> {
    renderer.read_picture(false).unwrap().colour
}

pub(super) fn ssim(ours: &[[f32; 3]], expected: &[[f32; 3]]) -> f64 {
    let image = |name: &str, pixels: &[[f32; 3]]| {
        Image::from_linear(name, SIZE.map(|side| side as usize), pixels.to_vec()).unwrap()
    };
    let [ours, expected] = [image("ours", ours), image("expected", expected)];
    compare(&ours, &expected, &CompareOptions::default()).unwrap().metrics.ssim
}

#[test]
fn a_mirror_shows_what_is_seen_from_the_mirrored_place() {
    let Some(gpu) = GpuFixture::open() else { return };
    let scene = stage("albedo = [1, 1, 1], roughness = 0, metallic = 1", "");
    let pose = scene.pose(0.0);
    // Area lights take random points, so they are left out.
    let hard = Settings { direct: Direct::Hard, ..settings(Denoise::NONE) };
    let mut renderer = gpu.renderer(&scene, &hard, &pose);
    renderer.render(&pose).unwrap();
    let picture = renderer.read_picture(true).unwrap();
    let (reflected, instance) = (layer(&picture, "reflected"), channel(&picture, "instance"));

    // From behind the mirror's plane z = -2, with the mirror taken away.
    let flip = |at: Vec3| Vec3::new(at.x, at.y, -4.0 - at.z);
    let mut behind = pose.clone();
    let (eye, target) = (flip(pose.camera.eye), flip(pose.camera.target));
    behind.camera = Camera { eye, target, near: 0.01, far: 100.0, ..pose.camera };
    behind.instances[0] = Affine3A::from_translation(Vec3::Y * 1e3) * behind.instances[0];
    let plain = Settings { reflections: Reflections::None, ..hard };
    let mut seen = gpu.renderer(&scene, &plain, &behind);
    seen.render(&behind).unwrap();
    let seen = colour(&seen);

    let width = SIZE[0] as usize;
    let mirror: Vec<usize> = (0..reflected.len()).filter(|&at| instance[at] == 0.0).collect();
    assert!(mirror.len() > 1500, "{}", mirror.len());
    let differs = |&&at: &&usize| {
        // Left and right are swapped.
        let there = seen[at / width * width + width - 1 - at % width];
        (0..3).any(|i| (reflected[at][i] - there[i]).abs() > 0.02 * there[i].max(0.02))
    };
    let off = mirror.iter().filter(differs).count();
    // At edges rounding decides.
    assert!(off as f32 <= 0.01 * mirror.len() as f32, "{off} of {} pixels differ", mirror.len());
}

/// Direct and reflected radiance, without the light that comes back from the mirror.
fn seen(picture: &Picture) -> Vec<[f32; 3]> {
    let both = layer(picture, "direct").into_iter().zip(layer(picture, "reflected"));
    both.map(|(direct, reflected)| [0, 1, 2].map(|i| direct[i] + reflected[i])).collect()
}

/// [`seen`] of the path tracer, which counts the light of area lights as irradiance.
fn expected(name: &str, scene: &Scene, spp: u64) -> Vec<[f32; 3]> {
    let path_traced = reference(name, scene, SIZE, 0, spp);
    let (irradiance, albedo) = (layer(&path_traced, "indirect"), layer(&path_traced, "albedo"));
    let mut seen = seen(&reference(name, scene, SIZE, 1, spp));
    for ((pixel, e), albedo) in seen.iter_mut().zip(irradiance).zip(albedo) {
        (0..3).for_each(|i| pixel[i] += albedo[i] / PI * e[i]);
    }
    seen
}

#[test]
#[ignore = "long; denoised_stills_are_like_the_reference is quicker"]
fn the_mean_of_the_rays_is_that_of_the_path_tracer() {
    let Some(gpu) = GpuFixture::open() else { return };
    for (roughness, metallic) in [(0.0, 1), (0.2, 1), (0.6, 1), (0.0, 0), (0.2, 0), (0.6, 0)] {
        let scene =
            stage(&format!("albedo = [0.9, 0.8, 0.7], roughness = {roughness}, metallic = {metallic}"), "");
        let expected = expected(&format!("stage-{roughness}-{metallic}"), &scene, 512);
        let frames = if roughness == 0.0 { 64 } else { 192 };
        let ours = gpu.mean_of_frames(&scene, &settings(Denoise::NONE), frames, seen);
        assert_agree(&format!("roughness {roughness}, metallic {metallic}"), &ours, &expected, 0.05);
    }
}

#[test]
#[ignore = "long; denoised_stills_are_like_the_reference is quicker"]
fn lights_that_rays_do_not_meet_are_reflected() {
    let Some(gpu) = GpuFixture::open() else { return };
    let portal = "[[instances]]\nmodel = \"lamp\"\ntranslation = [-0.4, 2.4, 0.6]\nscale = [3, 2, 3]\nvisible = false\n";
    for roughness in [0.5, 0.8] {
        let scene =
            stage(&format!("albedo = [0.9, 0.8, 0.7], roughness = {roughness}, metallic = 1"), portal);
        // With so many bounces one more, which a hit's path has, does not count.
        let paths = Settings {
            bounces: 8,
            indirect: Indirect::PATHS,
            direct: Direct::Hard,
            ..settings(Denoise::NONE)
        };
        let ours = gpu.mean_of_frames(&scene, &paths, 192, |picture| layer(picture, "reflected"));
        let expected = layer(
            &reference(&format!("stage-portal-{roughness}"), &scene, SIZE, paths.bounces, 512),
            "reflected",
        );
        // The dimmest block shows the foot of the mirror, where irradiance that is read from the screen is coarse.
        assert_agree(&format!("roughness {roughness}"), &ours, &expected, 0.1);
    }
}

/// Compares means, and blocks of 16 x 16 pixels that are at least `dimmest` times as bright as the brightest.
fn assert_agree(what: &str, ours: &[[f32; 3]], expected: &[[f32; 3]], dimmest: f32) {
    let [all, reference] = [ours, expected].map(|picture| mean(picture.iter().map(luminance)));
    let blocks = |picture: &[[f32; 3]]| -> Vec<f32> {
        let mut sums = vec![0.0; 24];
        for (at, pixel) in picture.iter().enumerate() {
            sums[at / 96 / 16 * 6 + at % 96 / 16] += luminance(pixel) / 256.0;
        }
        sums
    };
    let (ours, expected) = (blocks(ours), blocks(expected));
    // In darker ones noise is more than that.
    let least = dimmest * expected.iter().copied().fold(0.0, f32::max);
    let lit: Vec<f32> =
        ours.iter().zip(&expected).filter(|(_, reference)| **reference > least).map(|(a, b)| a / b).collect();
    let near = lit.iter().filter(|ratio| (**ratio - 1.0).abs() < 0.03).count();
    eprintln!("{what}: mean {}, {near} of {} blocks within 3 %", all / reference, lit.len());
    assert!((all / reference - 1.0).abs() < 0.01, "{what}: mean {}", all / reference);
    assert!(near as f32 >= 0.95 * lit.len() as f32, "{what}: {near} of {} blocks: {lit:?}", lit.len());
}

#[test]
fn denoised_stills_are_like_the_reference() {
    let Some(gpu) = GpuFixture::open() else { return };
    let mut least: f64 = 1.0;
    for roughness in [0.0, 0.2, 0.4, 1.0] {
        let scene = stage(&format!("albedo = [0.9, 0.8, 0.7], roughness = {roughness}, metallic = 1"), "");
        let renderer = gpu.rendered(&scene, &settings(Denoise::SVGF), 32);
        let ours = seen(&renderer.read_picture(true).unwrap());
        let ssim = ssim(&ours, &expected(&format!("stage-{roughness}-1"), &scene, 1024));
        eprintln!("roughness {roughness}, denoised: SSIM {ssim}");
        least = least.min(ssim);
    }
    assert!(least >= 0.95, "{least}");
}

#[test]
fn a_ray_that_hits_nothing_sees_the_environment_but_no_background() {
    let Some(gpu) = GpuFixture::open() else { return };
    let material = "albedo = [1, 1, 1], roughness = 0, metallic = 1";
    for (sky, expected) in [(SKY, [0.2, 0.3, 0.5]), ("", [0.0; 3])] {
        let scene = stage(material, sky);
        let renderer = gpu.rendered(&scene, &settings(Denoise::NONE), 1);
        let picture = renderer.read_picture(true).unwrap();
        // The upper edge of the picture shows the mirror, and in it what lies above the boxes.
        for pixel in &layer(&picture, "reflected")[40..56] {
            assert!((0..3).all(|i| (pixel[i] - expected[i]).abs() < 5e-3), "{pixel:?}, not {expected:?}");
        }
    }
}

#[test]
fn a_mirror_in_a_mirror_takes_a_second_ray() {
    let Some(gpu) = GpuFixture::open() else { return };
    // Another mirror opposite: its image in the first shows the glowing sky only where a path goes on.
    let opposite = "[[instances]]\nmodel = \"mirror\"\ntranslation = [0, 3, 6.1]\n";
    let scene = stage("albedo = [1, 1, 1], roughness = 0, metallic = 1", &format!("{opposite}{SKY}"));
    let of_depth = |reflection_depth| {
        let base = settings(Denoise::NONE);
        let effects = EffectSettings { reflection_depth, ..base.effects };
        let renderer = gpu.rendered(&scene, &Settings { effects, ..base }, 2);
        mean(layer(&renderer.read_picture(true).unwrap(), "reflected").iter().map(luminance))
    };
    let [one, two, three] = [1, 2, 3].map(of_depth);
    assert!(two > 1.1 * one && three >= two, "{one}, {two}, {three}");
}

#[test]
fn the_split_sum_shows_the_environment_in_what_is_reflected() {
    let Some(gpu) = GpuFixture::open() else { return };
    for roughness in [0.0, 0.3, 0.7] {
        // A ball of metal behind the eye, in an upright mirror.
        let scene = scene(&format!(
            r#"
[[models]]
name = "mirror"
primitive = "box"
size = [1.6, 1.6, 0.2]
material = {{ albedo = [1, 1, 1], roughness = 0, metallic = 1 }}
[[models]]
name = "ball"
primitive = "sphere"
size = [3, 3, 3]
subdivisions = 5
material = {{ albedo = [0.9, 0.7, 0.5], roughness = {roughness}, metallic = 1 }}
[[instances]]
model = "mirror"
translation = [0, 0, -2.1]
[[instances]]
model = "ball"
translation = [0, 0, 6]
[camera]
eye = [0, 0, 1.5]
target = [0, 0, -2]
vfov_deg = 40
"#
        ));
        let scene = Scene { environment: Some(sky(0.4)), ..Scene::clone(&scene) };
        let scene = Arc::new(scene);
        let base = settings(Denoise::NONE);
        let effects = EffectSettings { second_reflections: SecondReflections::SplitSum, ..base.effects };
        let ours = gpu.mean_of_frames(&scene, &Settings { effects, ..base }, 16, seen);
        // Nothing is in the way of the sky but the mirror, which is small.
        let expected = expected(&format!("split-sum-{roughness}"), &scene, 512);
        let disc = |at: &usize| {
            let [x, y] = [at % 96, at / 96].map(|side| side as f32 + 0.5);
            (x - 48.0).hypot(y - 32.0) < 10.0
        };
        let of =
            |picture: &[[f32; 3]]| mean((0..picture.len()).filter(disc).map(|at| luminance(&picture[at])));
        let ratio = of(&ours) / of(&expected);
        eprintln!("roughness {roughness}: {ratio} of the reference's, SSIM {}", ssim(&ours, &expected));
        assert!((ratio - 1.0).abs() < 0.1, "roughness {roughness}: {ratio}");
    }
}

#[test]
fn reflections_are_traced_where_something_is_glossy() {
    let Some(gpu) = GpuFixture::open() else { return };
    let auto = Settings { reflections: Reflections::Auto, ..settings(Denoise::SVGF) };
    let auto =
        Settings { effects: EffectSettings { reflection_roughness: Some(0.6), ..auto.effects }, ..auto };
    let takes_time = |renderer: &mut Renderer, pose: &Pose| {
        renderer.render(pose).unwrap();
        renderer.finish().unwrap().last().unwrap().figures.passes["reflections_trace"] > 0.0
    };
    for (material, traced) in [
        ("albedo = [0.5, 0.5, 0.5]", false),
        ("albedo = [0.5, 0.5, 0.5], roughness = 0.9, metallic = 1", false),
        ("albedo = [0.5, 0.5, 0.5], roughness = 0.3, metallic = 0", true),
    ] {
        let scene = stage(material, "");
        let pose = scene.pose(0.0);
        let mut renderer = gpu.renderer(&scene, &auto, &pose);
        assert_eq!(takes_time(&mut renderer, &pose), traced, "{material}");
        let off = Settings { reflections: Reflections::None, ..auto.clone() };
        renderer.set_settings(&off, &pose).unwrap();
        assert!(!takes_time(&mut renderer, &pose));
        // An edit makes it glossy.
        renderer.set_settings(&auto, &pose).unwrap();
        let mut edited = Scene::clone(&scene);
        (edited.materials[0].roughness, edited.materials[0].metallic) = (0.1, 1.0);
        renderer.set_scene(&edited.into(), &pose).unwrap();
        assert!(takes_time(&mut renderer, &pose), "{material}, edited");
    }
}

#[test]
fn an_override_of_svgf_changes_the_picture_of_its_use_alone() {
    let Some(gpu) = GpuFixture::open() else { return };
    let scene = stage("albedo = [1, 1, 1], roughness = 0.2, metallic = 1", "");
    let shown = |svgf: SvgfSettings| {
        let settings = Settings { svgf, ..settings(Denoise::SVGF) };
        let picture = gpu.rendered(&scene, &settings, 2).read_picture(true).unwrap();
        ["shadow", "reflection"].map(|effect| layer(&picture, effect))
    };
    let [shadow, reflection] = shown(SvgfSettings::default());
    let unblurred = shown(SvgfSettings { soft_shadows_levels: Some(0), ..SvgfSettings::default() });
    assert!(unblurred[0] != shadow, "the override has an effect");
    let newest = shown(SvgfSettings { reflections_alpha: Some(1.0), ..SvgfSettings::default() });
    assert!(newest[0] == shadow && newest[1] != reflection);
}
