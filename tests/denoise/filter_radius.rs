//! How far the filter blurs, and in what form light is averaged.

use glam::{Vec3, Vec4, Vec4Swizzles};
use glowworm::settings::SvgfSettings;

use crate::bvh_support::Random;
use crate::gpu::GpuFixture;
use crate::support::{Bench, HEIGHT, Pixel, WIDTH, wall};

/// Root mean square of how far along x a pixel's light is spread, if a blur of `reach` is of use.
fn width(gpu: &GpuFixture, settings: &SvgfSettings, reach: f32) -> f32 {
    // Any noise is tolerated, so that nothing but the kernel counts.
    let settings = SvgfSettings { luminance_tolerance: 1e5, ..*settings };
    let middle = HEIGHT / 2 * WIDTH + WIDTH / 2;
    let [with, without] = [1000.0, 0.0].map(|light| {
        let mut bench = Bench::new(&gpu.device, &settings);
        let mut numbers = Random::new(40);
        bench.denoise(&wall_of_reach(reach, |index| {
            numbers.unit() + if index == middle { light } else { 0.0 }
        }));
        bench.output()
    });
    let (mut sum, mut squares) = (0.0, 0.0);
    for (index, (with, without)) in with.iter().zip(&without).enumerate() {
        let off = (index % WIDTH) as f32 - (WIDTH / 2) as f32;
        sum += with.x - without.x;
        squares += off * off * (with.x - without.x);
    }
    (squares / sum).max(0.0).sqrt()
}

fn wall_of_reach(reach: f32, mut light: impl FnMut(usize) -> f32) -> Vec<Pixel> {
    let mut pixels = wall(|index| Vec3::splat(light(index)));
    pixels.iter_mut().for_each(|pixel| pixel.noisy[3] = reach);
    pixels
}

#[test]
fn blur_is_as_wide_as_is_of_use() {
    let Some(gpu) = GpuFixture::open() else { return };
    for separable in [false, true] {
        let settings = SvgfSettings { separable, ..SvgfSettings::default() };
        assert_eq!(settings.filter_radius(), 30.0);
        let widths = [0.0, 1.0, 2.0, 4.0, 8.0, 15.0, 22.0, 30.0]
            .map(|pixels| (pixels, width(&gpu, &settings, pixels / 30.0)));
        println!("separable {separable}: pixels of use, and spread: {widths:?}");
        assert!(widths.windows(2).all(|pair| pair[0].1 < pair[1].1), "{widths:?}");
        assert!(widths.iter().all(|(pixels, width)| *width <= 1.2 * pixels), "{widths:?}");
        assert_eq!(widths[0].1, 0.0, "a mirror stays sharp");
        // Variances of the levels' splines, 1, 4, 16, 64, and of the 7 pixels over which the first frame is averaged.
        assert!((widths[7].1 / 89.0f32.sqrt() - 1.0).abs() < 0.1, "{widths:?}");
        let same = SvgfSettings { adaptive: false, ..settings };
        assert_eq!(width(&gpu, &same, 0.0), widths[7].1);
    }
}

#[test]
fn noise_where_no_blur_is_of_use_is_the_mean_over_time() {
    let Some(gpu) = GpuFixture::open() else { return };
    let settings =
        SvgfSettings { alpha: 0.0, history_rejection: 0.0, firefly: 0.0, ..SvgfSettings::default() };
    let mut bench = Bench::new(&gpu.device, &settings);
    let mut numbers = Random::new(41);
    let mut sums = vec![0.0; WIDTH * HEIGHT];
    for _ in 0..16 {
        let pixels = wall_of_reach(0.0, |_| numbers.unit());
        sums.iter_mut().zip(&pixels).for_each(|(sum, pixel)| *sum += pixel.noisy[0] / 16.0);
        bench.denoise(&pixels);
    }
    for (found, sum) in bench.output().iter().zip(&sums) {
        assert!((found.x - sum).abs() < 2e-3, "{found}, not {sum}");
    }
}

#[test]
fn compressed_light_comes_back() {
    let Some(gpu) = GpuFixture::open() else { return };
    let settings = SvgfSettings { reinhard: true, ..SvgfSettings::default() };
    let colours = [Vec3::ZERO, Vec3::new(0.5, 0.25, 4.0), Vec3::new(10.0, 50.0, 0.0)];
    for colour in colours {
        let mut bench = Bench::new(&gpu.device, &settings);
        for _ in 0..6 {
            bench.denoise(&wall(|_| colour));
        }
        for texel in bench.output() {
            // Half floats resolve the compressed light by 1 in 2,048, which counts as many times as the light is bright.
            let tolerance = 1e-3 * (1.0 + colour.max_element()) * colour.max_element().max(1e-3);
            assert!((texel.xyz() - colour).abs().max_element() <= tolerance, "{texel}, not {colour}");
        }
    }
}

#[test]
fn compressed_light_flickers_less_and_is_darker() {
    let Some(gpu) = GpuFixture::open() else { return };
    let run = |reinhard: bool| {
        let settings = SvgfSettings { reinhard, firefly: 0.0, ..SvgfSettings::default() };
        let mut bench = Bench::new(&gpu.device, &settings);
        let mut numbers = Random::new(42);
        let (mut last, mut flicker, mut sum) = (Vec::<Vec4>::new(), 0.0, 0.0);
        for frame in 0..60 {
            bench.denoise(&wall(|_| Vec3::splat(if numbers.unit() < 0.1 { 10.0 } else { 0.0 })));
            let output = bench.output();
            if frame >= 40 {
                let change = |(a, b): (&Vec4, &Vec4)| (a.y - b.y).abs();
                flicker += last.iter().zip(&output).map(change).sum::<f32>();
                sum += output.iter().map(|texel| texel.y).sum::<f32>();
            }
            last = output;
        }
        [flicker, sum].map(|sum| sum / (20 * WIDTH * HEIGHT) as f32)
    };
    let (linear, compressed) = (run(false), run(true));
    println!("change from frame to frame and mean: {linear:?}, compressed {compressed:?}");
    assert!((linear[1] - 1.0).abs() < 0.02 && compressed[1] < 0.5, "{linear:?}, {compressed:?}");
    assert!(compressed[0] < 0.5 * linear[0], "{linear:?}, {compressed:?}");
}
