//! History is dropped where the last frames contradict it, and nowhere else; fireflies are taken down.

use glam::{Vec3, Vec4, Vec4Swizzles};
use glowworm::metrics::{CompareOptions, Image, compare};
use glowworm::settings::SvgfSettings;

use crate::bvh_support::Random;
use crate::gpu::GpuFixture;
use crate::support::{Bench, HEIGHT, Pixel, WIDTH, wall};

/// A wall on which each pixel's light is random, given the column's share of the width.
fn random_wall(numbers: &mut Random, light: impl Fn(f32, f32) -> f32) -> Vec<Pixel> {
    wall(|index| Vec3::splat(light((index % WIDTH) as f32 / (WIDTH - 1) as f32, numbers.unit())))
}

fn mean(texels: &[Vec4]) -> f32 {
    texels.iter().map(|texel| texel.y).sum::<f32>() / texels.len() as f32
}

/// The light that is left after 4 and after 16 frames of one that was switched off after 60, as a share.
fn left(gpu: &GpuFixture, settings: &SvgfSettings, light: impl Fn(f32, f32) -> f32) -> [f32; 2] {
    let mut bench = Bench::new(&gpu.device, settings);
    let mut numbers = Random::new(31);
    for _ in 0..60 {
        bench.denoise(&random_wall(&mut numbers, &light));
    }
    let before = mean(&bench.output());
    [4, 12].map(|frames| {
        for _ in 0..frames {
            bench.denoise(&random_wall(&mut numbers, |_, _| 0.0));
        }
        mean(&bench.output()) / before
    })
}

fn shadow(seen: f32, random: f32) -> f32 {
    if random < seen { 1.0 } else { 0.0 }
}

#[test]
fn a_light_that_is_switched_off_is_forgotten() {
    let Some(gpu) = GpuFixture::open() else { return };
    let settings = SvgfSettings::default();
    // One ray a pixel to a light of which half is seen; a penumbra as wide as the picture; a rough reflection; a mirror.
    let half = left(&gpu, &settings, |_, random| shadow(0.5, random));
    let penumbra = left(&gpu, &settings, shadow);
    let rough = left(&gpu, &settings, |_, random| -4.0 * (1.0 - random).max(1e-6).ln());
    let mirror = left(&gpu, &settings, |x, _| 1.0 + x);
    println!(
        "left after 4 and 16 frames: half {half:?}, penumbra {penumbra:?}, rough {rough:?}, mirror {mirror:?}"
    );
    for [after_4, after_16] in [half, rough, mirror] {
        assert!(after_4 < 0.05 && after_16 < 1e-3, "{after_4}, {after_16}");
    }
    // Where less than a tenth of the light arrives, 16 rays in 25 pixels tell little.
    assert!(penumbra[0] < 0.05 && penumbra[1] < 0.02, "{penumbra:?}");
    let never =
        left(&gpu, &SvgfSettings { history_rejection: 0.0, ..settings }, |_, random| shadow(0.5, random));
    assert!(never[0] > 0.75 && never[1] > 0.35, "{never:?}");
}

#[test]
fn a_light_that_is_switched_on_shows() {
    let Some(gpu) = GpuFixture::open() else { return };
    let mut numbers = Random::new(32);
    for (before, after) in [(0.0, 0.5), (0.1, 0.8)] {
        let mut bench = Bench::new(&gpu.device, &SvgfSettings::default());
        for _ in 0..60 {
            bench.denoise(&random_wall(&mut numbers, |_, random| shadow(before, random)));
        }
        for _ in 0..4 {
            bench.denoise(&random_wall(&mut numbers, |_, random| shadow(after, random)));
        }
        let share = (mean(&bench.output()) - before) / (after - before);
        assert!((0.93..1.07).contains(&share), "{before} to {after}: {share}");
    }
}

/// Whether random numbers are those of the effects' table, or independent.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Noise {
    Blue,
    White,
}

/// Light of which a sample reaches a pixel now and then.
#[derive(Clone, Copy, Debug)]
struct Rare {
    noise: Noise,
    chance: f32,
}

/// Mean luminance over a part of the width.
fn signal(x: f32) -> f32 {
    1.0 + (x * 20.0).sin().signum() * 0.5
}

/// Limits of still noise: its mean, and SSIM of a frame with the reference, means over the frames from 40 to 100.
fn converged(gpu: &GpuFixture, settings: &SvgfSettings, rare: Rare) -> [f64; 2] {
    let table = include_bytes!("../../src/gpu_scene/blue_noise.bin");
    let mut bench = Bench::new(&gpu.device, settings);
    let mut numbers = Random::new(33);
    let image = |texels: &dyn Fn(usize) -> f32| {
        let pixels = (0..WIDTH * HEIGHT).map(|index| [(texels(index) / 4.0).min(1.0); 3]).collect();
        Image::from_display("picture", [WIDTH, HEIGHT], pixels).unwrap()
    };
    let part = |index: usize| (index % WIDTH) as f32 / (WIDTH - 1) as f32;
    let reference = image(&|index| signal(part(index)));
    let mut sums = [0.0; 2];
    for frame in 0..100 {
        let mut random = |index: usize| {
            let [x, y] = [index % WIDTH + frame / 32 * 29, index / WIDTH + frame / 32 * 41].map(|at| at % 64);
            let byte = f32::from(table[((frame % 32 * 64 + y) * 64 + x) * 2]);
            let white = numbers.unit();
            if rare.noise == Noise::Blue { (byte + white) / 256.0 } else { white }
        };
        let mut light =
            |index| if random(index) < rare.chance { signal(part(index)) / rare.chance } else { 0.0 };
        bench.denoise(&wall(|index| Vec3::splat(light(index))));
        if frame >= 40 {
            let output = bench.output();
            let picture = image(&|index| output[index].y);
            let ssim = compare(&picture, &reference, &CompareOptions::default()).unwrap().metrics.ssim;
            for (sum, value) in sums.iter_mut().zip([f64::from(mean(&output)), ssim]) {
                *sum += value / 60.0;
            }
        }
    }
    sums
}

#[test]
fn rare_light_keeps_its_energy() {
    let Some(gpu) = GpuFixture::open() else { return };
    let settings = SvgfSettings { firefly: 0.0, ..SvgfSettings::default() };
    for chance in [0.02, 0.5] {
        let rare = Rare { noise: Noise::White, chance };
        let [filtered, noisy] =
            [settings.levels, 0].map(|levels| converged(&gpu, &SvgfSettings { levels, ..settings }, rare));
        println!("{rare:?}: mean and SSIM {filtered:?}, without a filter {noisy:?}");
        assert!((filtered[0] / noisy[0] - 1.0).abs() < 0.01, "{filtered:?}, {noisy:?}");
        assert!(filtered[1] > noisy[1] + 0.1, "{filtered:?}, {noisy:?}");
    }
}

#[test]
fn what_is_at_rest_is_kept() {
    let Some(gpu) = GpuFixture::open() else { return };
    let default = SvgfSettings::default();
    let never = SvgfSettings { history_rejection: 0.0, firefly: 0.0, ..default };
    // Rare samples of 50 times the mean; a shadow's, of noise as effects have it and of independent numbers.

    for (noise, chance, darker, less_alike) in [
        (Noise::White, 0.02, 0.01, 0.005),
        (Noise::Blue, 0.5, 0.002, 0.005),
        (Noise::White, 0.5, 0.002, 0.01),
    ] {
        let rare = Rare { noise, chance };
        let without = converged(&gpu, &never, rare);
        for (settings, of_mean) in [
            (SvgfSettings { history_rejection: default.history_rejection, ..never }, 0.005),
            (SvgfSettings { firefly: default.firefly, ..never }, darker),
            (default, darker),
        ] {
            let with = converged(&gpu, &settings, rare);
            println!(
                "{rare:?}, history rejection {}, firefly {}: mean and SSIM {with:?}, without {without:?}",
                settings.history_rejection, settings.firefly
            );
            assert!((with[0] / without[0] - 1.0).abs() < of_mean, "mean {with:?}, not {without:?}");
            assert!((with[1] - without[1]).abs() < less_alike, "SSIM {with:?}, not {without:?}");
        }
    }
}

/// How far a firefly of 1000 times the mean is off at once and after 8 frames, where a blur of `reach` is of use.
fn firefly(gpu: &GpuFixture, settings: &SvgfSettings, reach: f32) -> [f32; 2] {
    let [mut bench, mut calm] = [(); 2].map(|()| Bench::new(&gpu.device, settings));
    let mut numbers = Random::new(34);
    let mut most = [0.0; 2];
    for frame in 0..39 {
        let mut pixels = random_wall(&mut numbers, |_, random| 2.0 * random);
        pixels.iter_mut().for_each(|pixel| pixel.noisy[3] = reach);
        calm.denoise(&pixels);
        if frame == 30 {
            pixels[HEIGHT / 2 * WIDTH + WIDTH / 2].noisy = [1000.0, 1000.0, 1000.0, reach];
        }
        bench.denoise(&pixels);
        if frame == 30 || frame == 38 {
            let (found, expected) = (bench.output(), calm.output());
            let off = found.iter().zip(&expected).map(|(a, b)| (a - b).xyz().abs().max_element());
            most[usize::from(frame == 38)] = off.fold(0.0, f32::max);
        }
    }
    most
}

#[test]
fn a_firefly_is_gone_in_8_frames() {
    let Some(gpu) = GpuFixture::open() else { return };
    let without = SvgfSettings { firefly: 0.0, ..SvgfSettings::default() };
    let with = SvgfSettings { firefly: 10.0, ..without };
    for (reach, most) in [(1.0, 0.02), (0.25, 0.05), (0.0, 0.3)] {
        let [found, free] = [with, without].map(|settings| firefly(&gpu, &settings, reach));
        println!(
            "blur {reach}: off by the firefly at once and after 8 frames {found:?}, without a limit {free:?}"
        );
        assert!(found[1] < most, "{reach}: {found:?}");
        assert!(free[1] > 2.0 * found[1], "{reach}: {free:?}");
    }
}
