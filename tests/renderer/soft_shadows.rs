//! Soft shadows by rays: their mean is that of the path tracer.

use std::sync::Arc;

use glowworm::metrics::{CompareOptions, Image, compare};
use glowworm::output::Picture;
use glowworm::renderer::Renderer;
use glowworm::scene::Scene;
use glowworm::settings::{
    Antialiasing, Denoise, Direct, EffectSettings, Indirect, Noise, Reflections, Settings,
};

use super::still::{self, check_stillness};
use super::support::golden::reference;
use super::support::{GpuFixture, layer, luminance, mean, plain, scene};

const SIZE: [u32; 2] = [112, 80];

/// A floor, a wall, a slab above the floor, two glossy balls: a metal, a dielectric.
fn yard(light: &str) -> Arc<Scene> {
    scene(&format!(
        r#"
[[models]]
name = "floor"
primitive = "box"
size = [8, 0.2, 8]
material = {{ albedo = [0.7, 0.65, 0.6] }}
[[models]]
name = "slab"
primitive = "box"
size = [1.5, 0.1, 1.2]
material = {{ albedo = [0.3, 0.4, 0.7] }}
[[models]]
name = "wall"
primitive = "box"
size = [8, 3, 0.2]
material = {{ albedo = [0.6, 0.6, 0.6] }}
[[models]]
name = "metal"
primitive = "sphere"
size = [0.5, 0.5, 0.5]
subdivisions = 4
material = {{ albedo = [0.8, 0.6, 0.3], roughness = 0.3, metallic = 1 }}
[[models]]
name = "dielectric"
primitive = "sphere"
size = [0.4, 0.4, 0.4]
subdivisions = 4
material = {{ albedo = [0.2, 0.4, 0.3], roughness = 0.3, metallic = 0 }}
[[instances]]
model = "floor"
[[instances]]
name = "slab"
model = "slab"
translation = [-0.6, 0.9, 0.2]
rotation = [0, 20, 0]
dynamic = true
[[instances]]
model = "wall"
translation = [0, 1.5, -1.6]
[[instances]]
model = "metal"
translation = [1.1, 0.6, 0.6]
[[instances]]
model = "dielectric"
translation = [0.1, 0.5, 1.2]
[camera]
eye = [0.6, 2.6, 4.2]
target = [0, 0.4, 0]
vfov_deg = 45
[[lights]]
{light}
"#
    ))
}

fn sun(half_angle: u32) -> String {
    format!(
        "type = \"directional\"\ndirection = [0.5, -1, -0.3]\nirradiance = [3, 2.8, 2.5]\nangle_deg = {half_angle}"
    )
}

const BULB: &str = "type = \"point\"\nposition = [-1.2, 2.4, 1]\nintensity = [9, 9, 9]\nradius = 0.35";
const SPOT: &str = "type = \"spot\"\nposition = [-1.2, 3, 1]\ndirection = [0.4, -1, -0.3]\nintensity = [20, 18, 15]\nouter_deg = 35\nradius = 0.2";
const PANEL: &str = "type = \"area\"\npolygon = [[-1.4, 2.6, 0.4], [-0.2, 2.6, 0.4], [-0.2, 2.6, 1.8], [-1.4, 2.6, 1.8]]\nradiance = [6, 6, 5]";

const GLOBE: &str = r#"type = "area"
instance = "globe"
radiance = [5, 6, 6]
[[models]]
name = "globe"
primitive = "sphere"
size = [0.35, 0.35, 0.35]
subdivisions = 2
[[instances]]
name = "globe"
model = "globe"
translation = [-0.9, 1.9, 0.8]"#;
/// Before the sun, out of sight.
const PANE: &str = r#"
[[models]]
name = "pane"
primitive = "quad"
size = [1.6, 1, 1.6]
material = { albedo = [0.9, 0.4, 0.2] }
[[materials]]
name = "pane"
transmission = 0.8
[[instances]]
model = "pane"
translation = [-1.4, 3, 0.8]"#;

fn settings(denoise: Denoise) -> Settings {
    Settings {
        size: SIZE,
        indirect: Indirect::NONE,
        direct: Direct::Soft,
        effects: EffectSettings { denoise, ..EffectSettings::default() },
        ..plain()
    }
}

fn direct(renderer: &Renderer) -> Vec<[f32; 3]> {
    layer(&renderer.read_picture(true).unwrap(), "direct")
}

/// Mean luminance of blocks of 16 x 16 pixels.
fn blocks(picture: &[[f32; 3]]) -> Vec<f32> {
    let [width, height] = SIZE.map(|side| side as usize);
    let mut sums = vec![0.0; width / 16 * (height / 16)];
    for (at, pixel) in picture.iter().enumerate() {
        sums[at / width / 16 * (width / 16) + at % width / 16] += luminance(pixel) / 256.0;
    }
    sums
}

/// Compares means, and blocks where there is any light.
fn assert_agree(what: &str, ours: &[[f32; 3]], expected: &[[f32; 3]]) {
    let [all, reference] = [ours, expected].map(|picture| mean(picture.iter().map(luminance)));
    let (ours, expected) = (blocks(ours), blocks(expected));
    let lit: Vec<f32> =
        ours.iter().zip(&expected).filter(|(_, reference)| **reference > 1e-3).map(|(a, b)| a / b).collect();
    let near = lit.iter().filter(|ratio| (**ratio - 1.0).abs() < 0.03).count();
    eprintln!("{what}: mean {}, {near} of {} blocks within 3 %", all / reference, lit.len());
    assert!((all / reference - 1.0).abs() < 0.01, "{what}: mean {}", all / reference);
    assert!(near as f32 >= 0.95 * lit.len() as f32, "{what}: {near} of {} blocks, {lit:?}", lit.len());
}

/// Direct light with that of area lights by both lobes, as the path tracer has it.
fn expected_direct(name: &str, scene: &Scene, spp: u64) -> Vec<[f32; 3]> {
    let reference = reference(name, scene, SIZE, 0, spp);
    let [direct, irradiance, reflected, albedo] =
        ["direct", "indirect", "reflected", "albedo"].map(|name| layer(&reference, name));
    let sum = |at: usize, i: usize| {
        direct[at][i] + albedo[at][i] / std::f32::consts::PI * irradiance[at][i] + reflected[at][i]
    };
    (0..direct.len()).map(|at| [0, 1, 2].map(|i| sum(at, i))).collect()
}

/// The mean of 128 frames without a denoiser.
fn mean_of_rays(gpu: &GpuFixture, scene: &Arc<Scene>) -> Vec<[f32; 3]> {
    gpu.mean_of_frames(scene, &settings(Denoise::NONE), 128, |picture| layer(picture, "direct"))
}

#[test]
#[ignore = "long; a_hundred_lamps_take_one_ray is quicker"]
fn the_mean_of_the_rays_is_that_of_the_path_tracer() {
    let Some(gpu) = GpuFixture::open() else { return };
    let suns = [0, 4, 20].map(|angle| (format!("sun of {angle} degrees"), sun(angle)));
    let others = [("bulb", BULB), ("spot", SPOT), ("panel", PANEL), ("globe", GLOBE)]
        .map(|(what, light)| (what.to_owned(), light.to_owned()));
    let pane = ("sun behind a pane".to_owned(), format!("{}\n{PANE}", sun(4)));
    for (what, light) in suns.into_iter().chain(others).chain([pane]) {
        let scene = yard(&light);
        assert_agree(
            &what,
            &mean_of_rays(&gpu, &scene),
            &expected_direct(&format!("yard-{}", what.replace(' ', "-")), &scene, 256),
        );
    }
}

/// Rays along a lobe meet the lights that shadow rays sample, but for invisible ones.
#[test]
#[ignore = "long; a_hundred_lamps_take_one_ray is quicker"]
fn area_lights_count_once_beside_reflections() {
    let Some(gpu) = GpuFixture::open() else { return };
    let portal = format!("{PANEL}\nvisible = false");
    for (what, light) in [("panel", PANEL), ("globe", GLOBE), ("portal", &portal)] {
        let scene = yard(light);
        let lit = expected_direct(&format!("yard-{what}"), &scene, 512);
        let [none, one] = [0, 1].map(|bounces| {
            layer(&reference(&format!("yard-{what}"), &scene, SIZE, bounces, 512), "reflected")
        });
        // At the balls' roughness half of the light is mirrored.
        for (limit, share) in [(1.0, 1.0), (0.3, 0.5)] {
            let expected: Vec<[f32; 3]> = (0..lit.len())
                .map(|at| [0, 1, 2].map(|i| lit[at][i] + share * (one[at][i] - none[at][i])))
                .collect();
            let plain = settings(Denoise::NONE);
            let effects =
                EffectSettings { reflection_roughness: Some(limit), reflection_depth: 1, ..plain.effects };
            let settings = Settings { effects, reflections: Reflections::Rays, ..plain };
            let ours = gpu.mean_of_frames(&scene, &settings, 128, |picture| picture.colour.clone());
            assert_agree(&format!("{what}, mirrored by {share}"), &ours, &expected);
        }
    }
}

#[test]
fn lights_without_extent_have_hard_shadows() {
    let Some(gpu) = GpuFixture::open() else { return };
    let sharp = |light: &str| light.split("\nradius").next().unwrap().to_owned();
    for light in [sun(0), sharp(BULB), sharp(SPOT)] {
        let scene = yard(&light);
        let [hard, soft] = [Direct::Hard, Direct::Soft].map(|kind| {
            direct(&gpu.rendered(&scene, &Settings { direct: kind, ..settings(Denoise::NONE) }, 1))
        });
        let dark = hard.iter().filter(|pixel| **pixel == [0.0; 3]).count();
        assert!((100..hard.len() - 100).contains(&dark), "{dark} pixels are dark");
        let differs =
            |(a, b): &(&[f32; 3], &[f32; 3])| (0..3).any(|i| (a[i] - b[i]).abs() > 1e-3 * a[i].max(b[i]));
        let off = hard.iter().zip(&soft).filter(differs).count();
        // Where rounding decides whether a ray passes an edge.
        assert!(off <= hard.len() / 1000, "{off} pixels differ");
    }
}

#[test]
#[ignore = "long; a_hundred_lamps_take_one_ray is quicker"]
fn white_noise_has_the_same_mean() {
    let Some(gpu) = GpuFixture::open() else { return };
    let scene = yard(&sun(4));
    let blue = settings(Denoise::NONE);
    let white = Settings { effects: EffectSettings { noise: Noise::White, ..blue.effects }, ..blue.clone() };
    let direct = |picture: &Picture| layer(picture, "direct");
    let [blue, white] = [blue, white].map(|settings| gpu.mean_of_frames(&scene, &settings, 64, direct));
    assert_ne!(blue, white);
    let [a, b] = [&blue, &white].map(|picture| mean(picture.iter().map(luminance)));
    assert!((a / b - 1.0).abs() < 0.005, "{a}, {b}");
}

#[test]
fn a_hundred_lamps_take_one_ray() {
    let Some(gpu) = GpuFixture::open() else { return };
    let light = |i: usize| {
        let (x, z) = (i % 10, i / 10);
        let [x, z] = [x, z].map(|at| at as f32 * 0.7 - 3.1);
        let height = 1.6 + 0.1 * (i % 7) as f32;
        format!(
            "type = \"point\"\nposition = [{x}, {height}, {z}]\nintensity = [0.3, {}, 0.2]",
            0.1 + 0.004 * i as f32
        )
    };
    let lights: Vec<String> = (0..100).map(light).collect();
    let scene = yard(&lights.join("\n[[lights]]\n"));
    let expected = layer(&reference("yard-hundred", &scene, SIZE, 0, 512), "direct");
    let ours = gpu.mean_of_frames(&scene, &settings(Denoise::NONE), 64, |picture| layer(picture, "direct"));
    assert_agree("a hundred lights", &ours, &expected);
    // Denoised, after 32 frames.
    let denoised = direct(&gpu.rendered(&scene, &settings(Denoise::SVGF), 32));
    let ssim = ssim(&denoised, &expected);
    eprintln!("a hundred lights, denoised: SSIM {ssim}");
    assert!(ssim >= 0.9, "{ssim}");
}

fn ssim(ours: &[[f32; 3]], expected: &[[f32; 3]]) -> f64 {
    let image = |name: &str, pixels: &[[f32; 3]]| {
        Image::from_linear(name, SIZE.map(|side| side as usize), pixels.to_vec()).unwrap()
    };
    let [ours, expected] = [image("ours", ours), image("expected", expected)];
    compare(&ours, &expected, &CompareOptions::default()).unwrap().metrics.ssim
}

#[test]
fn denoised_stills_are_like_the_reference() {
    let Some(gpu) = GpuFixture::open() else { return };
    for angle in [4, 20] {
        let scene = yard(&sun(angle));
        let expected = layer(&reference(&format!("yard-sun-{angle}"), &scene, SIZE, 0, 256), "direct");
        let ssim = ssim(&direct(&gpu.rendered(&scene, &settings(Denoise::SVGF), 32)), &expected);
        eprintln!("sun of {angle} degrees, denoised: SSIM {ssim}");
        assert!(ssim >= 0.98, "{angle} degrees: {ssim}");
    }
}

#[test]
#[ignore = "long; still::what_freezes_depends_on_no_past is quicker"]
fn a_frozen_picture_depends_on_no_past() {
    let scene = yard(&format!("{}\n[[lights]]\n{PANEL}", sun(4)));
    for (direct, antialiasing, denoise) in [
        (Direct::Soft, Antialiasing::Taa, Denoise::SVGF),
        (Direct::Soft, Antialiasing::None, Denoise::NONE),
        (Direct::Hard, Antialiasing::None, Denoise::SVGF),
    ] {
        eprintln!("{direct:?}, {antialiasing:?}, {denoise:?}");
        let effects = settings(denoise).effects;
        check_stillness(&scene, &Settings { direct, antialiasing, effects, ..still::settings() });
    }
}

#[test]
fn a_light_that_goes_takes_its_light_along() {
    let Some(gpu) = GpuFixture::open() else { return };
    let scene = yard(&format!("{}\n[[lights]]\n{BULB}", sun(4)));
    let rest = scene.pose(0.0);
    let mut dark = rest.clone();
    dark.lights.remove(1);
    let settings = settings(Denoise::SVGF);
    let mut renderer = gpu.rendered(&scene, &settings, 20);
    let before = mean(direct(&renderer).iter().map(luminance));
    let mut fresh = gpu.renderer(&scene, &settings, &dark);
    (0..64).for_each(|_| fresh.render(&dark).unwrap());
    let after = mean(direct(&fresh).iter().map(luminance));
    for (frames, left) in [(4, 0.05), (12, 0.02)] {
        (0..frames).for_each(|_| renderer.render(&dark).unwrap());
        let share = (mean(direct(&renderer).iter().map(luminance)) - after) / (before - after);
        assert!(share.abs() <= left, "{share} of its light is left");
    }
}
