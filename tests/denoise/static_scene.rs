//! A static scene: the converged output of SVGF depends on the static frames alone.

use glam::{Vec3, Vec4, Vec4Swizzles};
use glowworm::passes::clock::StaticFrame;
use glowworm::settings::SvgfSettings;

use crate::bvh_support::Random;
use crate::gpu::GpuFixture;
use crate::support::{Bench, Pixel, pixels};

/// A wall that is lit at random.
fn noisy(numbers: &mut Random, brightness: f32) -> Vec<Pixel> {
    pixels(|at| {
        let light = if numbers.unit() < 0.5 { 0.0 } else { 2.0 * brightness };
        Pixel::stationary(Vec3::new(light, light * at.x as f32 / 60.0, 0.5), Vec3::Z, 4.0)
    })
}

/// The frames of a static scene, of which the last `shown` are shown.
fn accumulate(bench: &mut Bench, brightness: f32, frames: u32, shown: u32) -> Vec<Vec4> {
    let mut numbers = Random::new(77);
    let mut sum = vec![Vec4::ZERO; noisy(&mut Random::new(0), 1.0).len()];
    for index in 0..frames {
        let pixels = noisy(&mut numbers, brightness);
        for (sum, pixel) in sum.iter_mut().zip(&pixels) {
            *sum += Vec4::from(pixel.noisy) / frames as f32;
        }
        bench.denoise_at(&pixels, Some(StaticFrame { index, shown: index + shown >= frames }));
    }
    sum
}

fn bits(texels: &[Vec4]) -> Vec<[u32; 4]> {
    texels.iter().map(|texel| texel.to_array().map(f32::to_bits)).collect()
}

#[test]
fn what_is_shown_in_the_end_does_not_depend_on_what_came_before() {
    let Some(gpu) = GpuFixture::open() else { return };
    let settings = SvgfSettings::default();
    let mut fresh = Bench::new(&gpu.device, &settings);
    let mean = accumulate(&mut fresh, 1.0, 48, 1);
    for (found, mean) in fresh.read(|svgf| svgf.history()).iter().zip(&mean) {
        assert!((found - mean).xyz().abs().max_element() < 4e-3, "{found}, not {mean}");
    }

    // After motion, after a broken frame, after a rest that was shown and one that was not.
    let mut bench = Bench::new(&gpu.device, &settings);
    let mut numbers = Random::new(1);
    for shown in [None, Some(true), Some(false), None] {
        for index in 0..5 {
            let mut garbage = noisy(&mut numbers, 100.0);
            garbage[index * 7].noisy = [f32::NAN; 4];
            let at = shown.map(|shown| StaticFrame { index: index as u32, shown: shown && index > 2 });
            bench.denoise_at(&garbage, at);
        }
    }
    let before = bench.output();
    accumulate(&mut bench, 1.0, 48, 1);
    assert_ne!(bits(&before), bits(&bench.output()));
    assert_eq!(bits(&fresh.output()), bits(&bench.output()));
    assert_eq!(bits(&fresh.read(|svgf| svgf.moments())), bits(&bench.read(|svgf| svgf.moments())));
}

#[test]
fn until_then_the_picture_is_that_of_a_scene_that_changes() {
    let Some(gpu) = GpuFixture::open() else { return };
    let mut numbers = Random::new(2);
    let [mut moving, mut converging] = [(); 2].map(|()| Bench::new(&gpu.device, &SvgfSettings::default()));
    for index in 0..12 {
        let pixels = noisy(&mut numbers, 1.0);
        moving.denoise(&pixels);
        converging.denoise_at(&pixels, Some(StaticFrame { index, shown: false }));
        assert_eq!(bits(&moving.output()), bits(&converging.output()));
    }
    // A rest that was never shown is dropped.
    let pixels = noisy(&mut numbers, 1.0);
    moving.denoise(&pixels);
    converging.denoise(&pixels);
    assert_eq!(bits(&moving.output()), bits(&converging.output()));
}

#[test]
fn motion_continues_from_the_converged_output() {
    let Some(gpu) = GpuFixture::open() else { return };
    let mut bench = Bench::new(&gpu.device, &SvgfSettings::default());
    let mut numbers = Random::new(3);
    for _ in 0..4 {
        bench.denoise(&noisy(&mut numbers, 100.0));
    }
    accumulate(&mut bench, 1.0, 48, 16);
    let before = bench.output();
    bench.denoise(&noisy(&mut numbers, 1.0));
    // The noise of one frame is 1; that of the mean over 48 frames, blurred, is far less.
    let most = |a: &[Vec4], b: &[Vec4]| {
        a.iter().zip(b).map(|(a, b)| (a - b).xyz().abs().max_element()).fold(0.0, f32::max)
    };
    assert!(most(&before, &bench.output()) < 0.15, "{}", most(&before, &bench.output()));
    assert!(bench.read(|svgf| svgf.moments()).iter().all(|texel| texel.z == 32.0), "the history goes on");
}
