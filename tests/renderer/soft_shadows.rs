//! Soft shadows by rays: their mean is that of the path tracer, and a still picture stands still.

use std::sync::Arc;

use glam::{Affine3A, Vec3};
use glowworm::metrics::{CompareOptions, Image, compare};
use glowworm::renderer::Renderer;
use glowworm::scene::{Pose, Scene};
use glowworm::settings::{
    Antialiasing, Denoise, Direct, EffectSettings, Indirect, Noise, Reflections, Settings, VplSettings,
};

use super::reference::reference;
use super::support::{Lab, layer, luminance, mean, plain, scene};

const SIZE: [u32; 2] = [112, 80];
/// Frames of a still scene until it is frozen, without an estimator.
const FRAMES: u32 = 64 + 1;

/// A floor, a wall, a slab above the floor, a glossy ball.
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
name = "ball"
primitive = "sphere"
size = [0.5, 0.5, 0.5]
subdivisions = 4
material = {{ albedo = [0.8, 0.6, 0.3], roughness = 0.4, metallic = 0.5 }}
[[instances]]
model = "floor"
[[instances]]
name = "slab"
model = "slab"
translation = [-0.6, 0.9, 0.2]
rotation = [0, 20, 0]
dynamic = true
[[instances]]
name = "ball"
model = "ball"
translation = [1.1, 0.6, 0.6]
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

fn settings(denoise: Denoise) -> Settings {
    Settings {
        size: SIZE,
        indirect: Indirect::None,
        direct: Direct::Rays,
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
    let [all, truth] = [ours, expected].map(|picture| mean(picture.iter().map(luminance)));
    let (ours, expected) = (blocks(ours), blocks(expected));
    let lit: Vec<f32> =
        ours.iter().zip(&expected).filter(|(_, truth)| **truth > 1e-3).map(|(a, b)| a / b).collect();
    let near = lit.iter().filter(|ratio| (**ratio - 1.0).abs() < 0.03).count();
    eprintln!("{what}: mean {}, {near} of {} blocks within 3 %", all / truth, lit.len());
    assert!((all / truth - 1.0).abs() < 0.01, "{what}: mean {}", all / truth);
    assert!(near as f32 >= 0.95 * lit.len() as f32, "{what}: {near} of {} blocks, {lit:?}", lit.len());
}

#[test]
fn the_mean_of_the_rays_is_that_of_the_path_tracer() {
    let Some(lab) = Lab::open() else { return };
    let suns = [0, 4, 20].map(|angle| (format!("sun of {angle} degrees"), sun(angle), "direct"));
    let others = [("bulb", BULB, "direct"), ("spot", SPOT, "direct"), ("panel", PANEL, "indirect")];
    for (what, light, part) in
        suns.into_iter().chain(others.map(|(what, light, part)| (what.to_owned(), light.to_owned(), part)))
    {
        let scene = yard(&light);
        let truth = reference(&scene, SIZE, 0, 256);
        let expected = match part {
            "direct" => layer(&truth, "direct"),
            // Area lights shine by what the path tracer calls indirect, and by the other lobe.
            _ => {
                let (e, albedo) = (layer(&truth, "indirect"), layer(&truth, "albedo"));
                let mirrored = layer(&truth, "reflected");
                let emitted = layer(&truth, "direct");
                (0..e.len())
                    .map(|at| {
                        [0, 1, 2].map(|i| {
                            emitted[at][i] + albedo[at][i] / std::f32::consts::PI * e[at][i] + mirrored[at][i]
                        })
                    })
                    .collect()
            }
        };
        let ours = direct(&lab.rendered(&scene, &settings(Denoise::None), FRAMES));
        assert_agree(&what, &ours, &expected);
    }
}

#[test]
fn white_noise_has_the_same_mean() {
    let Some(lab) = Lab::open() else { return };
    let scene = yard(&sun(4));
    let blue = settings(Denoise::None);
    let white = Settings { effects: EffectSettings { noise: Noise::White, ..blue.effects }, ..blue.clone() };
    let [blue, white] = [blue, white].map(|settings| direct(&lab.rendered(&scene, &settings, FRAMES)));
    assert_ne!(blue, white);
    let [a, b] = [&blue, &white].map(|picture| mean(picture.iter().map(luminance)));
    assert!((a / b - 1.0).abs() < 0.005, "{a}, {b}");
}

#[test]
fn a_hundred_lamps_take_one_ray() {
    let Some(lab) = Lab::open() else { return };
    let lamp = |i: usize| {
        let (x, z) = (i % 10, i / 10);
        let [x, z] = [x, z].map(|at| at as f32 * 0.7 - 3.1);
        let height = 1.6 + 0.1 * (i % 7) as f32;
        format!(
            "type = \"point\"\nposition = [{x}, {height}, {z}]\nintensity = [0.3, {}, 0.2]",
            0.1 + 0.004 * i as f32
        )
    };
    let lamps: Vec<String> = (0..100).map(lamp).collect();
    let scene = yard(&lamps.join("\n[[lights]]\n"));
    let expected = layer(&reference(&scene, SIZE, 0, 512), "direct");
    let ours = direct(&lab.rendered(&scene, &settings(Denoise::None), FRAMES));
    assert_agree("a hundred lamps", &ours, &expected);
    // Denoised, after 32 frames.
    let denoised = direct(&lab.rendered(&scene, &settings(Denoise::Svgf), 32));
    let ssim = ssim(&denoised, &expected);
    eprintln!("a hundred lamps, denoised: SSIM {ssim}");
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
fn denoised_stills_are_like_the_truth() {
    let Some(lab) = Lab::open() else { return };
    for angle in [4, 20] {
        let scene = yard(&sun(angle));
        let expected = layer(&reference(&scene, SIZE, 0, 256), "direct");
        let ssim = ssim(&direct(&lab.rendered(&scene, &settings(Denoise::Svgf), 32)), &expected);
        eprintln!("sun of {angle} degrees, denoised: SSIM {ssim}");
        assert!(ssim >= 0.98, "{angle} degrees: {ssim}");
    }
}

/// Settings with everything in use, and frames until the picture stands still.
fn all_in_use(antialiasing: Antialiasing, denoise: Denoise) -> (Settings, u32) {
    let vpl = VplSettings { slots: 64, temporal_sets: 4, budget: 16, ..VplSettings::default() };
    let settings = Settings {
        size: [64, 48],
        indirect: Indirect::Vpls,
        reflections: Reflections::Rays,
        antialiasing,
        vpl,
        ..settings(denoise)
    };
    let frames = vpl.slots.div_ceil(vpl.budget) + 2 * vpl.temporal_sets + 48 + 16;
    (settings, frames)
}

#[test]
fn a_still_picture_stands_still_and_depends_on_no_past() {
    let Some(lab) = Lab::open() else { return };
    let scene = yard(&format!("{}\n[[lights]]\n{PANEL}", sun(4)));
    let rest = scene.pose(0.0);
    for (antialiasing, denoise) in [
        (Antialiasing::Taa, Denoise::Svgf),
        (Antialiasing::Taa, Denoise::None),
        (Antialiasing::None, Denoise::Svgf),
    ] {
        let (settings, frames) = all_in_use(antialiasing, denoise);
        let wait = |renderer: &mut Renderer, frames: u32| {
            (0..frames).for_each(|_| renderer.render(&rest).unwrap());
            renderer.read_picture(false).unwrap()
        };
        let mut fresh = lab.renderer(&scene, &settings, &rest);
        let expected = wait(&mut fresh, frames);
        assert!(expected.colour.iter().flatten().all(|channel| channel.is_finite()));
        for more in [1, 6] {
            assert!(wait(&mut fresh, more) == expected, "{antialiasing:?}, {denoise:?}: {more} frames later");
        }
        let mut renderer = lab.renderer(&scene, &settings, &rest);
        for frame in 0..5 {
            let mut pose: Pose = rest.clone();
            pose.instances[1] = Affine3A::from_translation(Vec3::X * 0.2 * frame as f32) * pose.instances[1];
            pose.camera.eye.x += 0.1;
            pose.lights[0].direction = Vec3::new(0.1 * frame as f32, -1.0, 0.0).normalize();
            renderer.render(&pose).unwrap();
        }
        assert!(wait(&mut renderer, frames) == expected, "{antialiasing:?}, {denoise:?}: after motion");
    }
}

#[test]
fn a_light_that_goes_takes_its_light_along() {
    let Some(lab) = Lab::open() else { return };
    let scene = yard(&format!("{}\n[[lights]]\n{BULB}", sun(4)));
    let rest = scene.pose(0.0);
    let mut dark = rest.clone();
    dark.lights.remove(1);
    let settings = settings(Denoise::Svgf);
    let mut renderer = lab.rendered(&scene, &settings, 20);
    let before = mean(direct(&renderer).iter().map(luminance));
    let mut fresh = lab.renderer(&scene, &settings, &dark);
    (0..64).for_each(|_| fresh.render(&dark).unwrap());
    let after = mean(direct(&fresh).iter().map(luminance));
    for (frames, left) in [(4, 0.05), (12, 0.02)] {
        (0..frames).for_each(|_| renderer.render(&dark).unwrap());
        let share = (mean(direct(&renderer).iter().map(luminance)) - after) / (before - after);
        assert!(share.abs() <= left, "{share} of its light is left");
    }
}
