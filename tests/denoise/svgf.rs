//! Checks SVGF with signals whose answer is known (the checklist of its behaviour: constants, impulses, edges, grazing planes,
//! variance, numbers that are none).

use bytemuck::Zeroable;
use glam::{Vec3, Vec4, Vec4Swizzles};
use glowworm::denoise::Use;
use glowworm::denoise::svgf::Svgf;
use glowworm::settings::SvgfSettings;

use crate::bvh_support::Random;
use crate::gpu::GpuFixture;
use crate::support::{Bench, HEIGHT, Pixel, WIDTH, pixels, plane_depth, wall};

fn spread(texels: &[Vec4]) -> f32 {
    let mean = texels.iter().map(|texel| texel.y).sum::<f32>() / texels.len() as f32;
    (texels.iter().map(|texel| (texel.y - mean).powi(2)).sum::<f32>() / texels.len() as f32).sqrt()
}

#[test]
fn a_constant_stays_as_it_is() {
    let Some(gpu) = GpuFixture::open() else { return };
    for separable in [false, true] {
        let mut bench = Bench::new(
            &gpu.device,
            &SvgfSettings { separable, history_rejection: 1.0, ..SvgfSettings::default() },
        );
        let colour = Vec3::new(0.5, 3.0, 120.0);
        for _ in 0..5 {
            bench.denoise(&wall(|_| colour));
        }
        for texel in bench.output() {
            assert!((texel.xyz() / colour - 1.0).abs().max_element() < 1e-3, "{texel}");
        }
    }
}

#[test]
fn noise_goes_and_its_mean_stays() {
    let Some(gpu) = GpuFixture::open() else { return };
    let mut bench = Bench::new(&gpu.device, &SvgfSettings::default());
    let mut numbers = Random::new(3);
    let mut noisy = || Vec3::splat(if numbers.unit() < 0.5 { 0.0 } else { 2.0 });
    bench.denoise(&wall(|_| noisy()));
    let first = spread(&bench.output());
    for _ in 0..31 {
        bench.denoise(&wall(|_| noisy()));
    }
    let output = bench.output();
    let mean = output.iter().map(|texel| texel.y).sum::<f32>() / output.len() as f32;
    assert!((mean - 1.0).abs() < 0.03, "{mean}");
    assert!(first < 0.3 && spread(&output) < 0.05, "{first}, then {}", spread(&output));
}

#[test]
fn alpha_is_one_over_the_length_of_the_history() {
    let Some(gpu) = GpuFixture::open() else { return };
    let settings = SvgfSettings {
        levels: 1,
        history_rejection: 0.0,
        firefly: 0.0,
        longest_history: 100,
        ..SvgfSettings::default()
    };
    let mut bench = Bench::new(&gpu.device, &settings);
    // A history that was filtered is not the mean; from the fourth frame on it is not.
    for frame in 0..12 {
        bench.denoise(&wall(|_| Vec3::splat(frame as f32)));
        let expected = 0.5 * frame as f32;
        let found = bench.read(|svgf| svgf.history())[WIDTH * HEIGHT / 2];
        assert!((found.x - expected).abs() <= 2e-3 * expected.max(1.0), "frame {frame}: {found}");
        assert_eq!(bench.read(|svgf| svgf.moments())[0].z, frame as f32 + 1.0);
    }
}

#[test]
fn variance_is_that_of_the_noise_and_guides_the_blur() {
    let Some(gpu) = GpuFixture::open() else { return };
    let settings = SvgfSettings {
        moments_alpha: 0.0,
        history_rejection: 0.0,
        longest_history: 1000,
        ..SvgfSettings::default()
    };
    let mut bench = Bench::new(&gpu.device, &settings);
    let mut numbers = Random::new(9);
    for _ in 0..200 {
        // Uniform on 1 +- 0.5: standard deviation 1 / sqrt(12).
        bench.denoise(&wall(|_| Vec3::splat(0.5 + numbers.unit())));
    }
    let moments = bench.read(|svgf| svgf.moments());
    let mean = moments.iter().map(|texel| texel.y * texel.y).sum::<f32>() / moments.len() as f32;
    assert!((mean * 12.0 - 1.0).abs() < 0.03, "{mean}");

    // A step of light on one wall blurs where noise explains it, and does not where there is none.
    let step = |index: usize| if index % WIDTH < WIDTH / 2 { 1.0 } else { 1.5 };
    let edge = |noise: f32| {
        let mut bench = Bench::new(&gpu.device, &SvgfSettings { alpha: 0.0, ..settings });
        let mut numbers = Random::new(1);
        for _ in 0..32 {
            bench.denoise(&wall(|index| Vec3::splat(step(index) + noise * (numbers.unit() - 0.5))));
        }
        let output = bench.output();
        let column = |x: usize| (0..HEIGHT).map(|y| output[y * WIDTH + x].x).sum::<f32>() / HEIGHT as f32;
        column(WIDTH / 2) - column(WIDTH / 2 - 1)
    };
    // The first three frames, whose variance is not known, are a tenth of the mean and blurred anyway.
    let (sharp, blurred) = (edge(0.0), edge(12.0));
    assert!(sharp > 0.44 && blurred < 0.2, "{sharp}, {blurred}");
}

#[test]
fn edges_of_surfaces_keep_light_apart() {
    let Some(gpu) = GpuFixture::open() else { return };
    // Normals in checks; depths in checks: each kind of square has its light, with noise on it.
    for by_normal in [true, false] {
        let mut bench = Bench::new(&gpu.device, &SvgfSettings::default());
        let mut numbers = Random::new(4);
        let bright = |x: i32, y: i32| (x / 8 + y / 8) % 2 == 0;
        for _ in 0..8 {
            bench.denoise(&pixels(|at| {
                let light = Vec3::splat(if bright(at.x, at.y) { 2.0 } else { 0.0 } * numbers.unit());
                match (bright(at.x, at.y), by_normal) {
                    (true, true) => Pixel::stationary(light, Vec3::new(0.6, 0.0, 0.8), 4.0),
                    (true, false) => Pixel::stationary(light, Vec3::Z, 8.0),
                    (false, _) => Pixel::stationary(light, Vec3::Z, 4.0),
                }
            }));
        }
        for (index, texel) in bench.output().iter().enumerate() {
            let lit = bright((index % WIDTH) as i32, (index / WIDTH) as i32);
            assert!(
                if lit { texel.x > 0.3 } else { texel.x < 1e-3 },
                "{index}: {texel}, by normal: {by_normal}"
            );
        }
    }
}

#[test]
fn grazing_planes_are_filtered() {
    let Some(gpu) = GpuFixture::open() else { return };
    let mut bench = Bench::new(&gpu.device, &SvgfSettings::default());
    let mut numbers = Random::new(8);
    let normal = Vec3::new(0.0, 1.0, 0.06).normalize();
    let floor = |numbers: &mut Random| {
        pixels(|at| {
            let depth = plane_depth(at, Vec3::new(0.0, -1.0, -3.0), normal).filter(|&depth| depth < 100.0);
            let light = Vec3::splat(2.0 * numbers.unit());
            depth.map_or(Pixel::zeroed(), |depth| Pixel::stationary(light, normal, depth))
        })
    };
    let seen: Vec<bool> = floor(&mut numbers).iter().map(|pixel| pixel.depth > 0.0).collect();
    bench.denoise(&floor(&mut numbers));
    let lit: Vec<Vec4> =
        bench.output().into_iter().zip(&seen).filter(|(_, seen)| **seen).map(|(texel, _)| texel).collect();
    assert!(lit.len() > 500);
    // Unfiltered: 1 / sqrt(3).
    assert!(spread(&lit) < 0.15, "{}", spread(&lit));
}

#[test]
fn what_is_not_a_number_never_reaches_the_history() {
    let Some(gpu) = GpuFixture::open() else { return };
    for history_rejection in [0.0, 2.0] {
        let mut bench =
            Bench::new(&gpu.device, &SvgfSettings { history_rejection, ..SvgfSettings::default() });
        for bad in [f32::NAN, f32::INFINITY, -f32::INFINITY] {
            let mut pixels = wall(|_| Vec3::ONE);
            for index in [0, 700, 701, WIDTH * HEIGHT - 1] {
                pixels[index].noisy = [bad; 4];
            }
            bench.denoise(&pixels);
            bench.denoise(&wall(|_| Vec3::ONE));
            assert!(
                bench.output().iter().all(|texel| (texel.x - 1.0).abs() < 0.3),
                "{bad}, history rejection {history_rejection}"
            );
            assert!(bench.read(|svgf| svgf.moments()).iter().all(|texel| texel.is_finite()));
        }
    }
}

/// How many columns the light of a single pixel reaches in one frame.
fn reach_of_a_pixel(
    gpu: &GpuFixture,
    usage: Use,
    is_rough: bool,
    light_is_wide: bool,
    widened: bool,
) -> usize {
    let settings = SvgfSettings {
        widened,
        adaptive: false,
        history_rejection: 0.0,
        firefly: 0.0,
        luminance_tolerance: 1e6,
        ..SvgfSettings::default()
    };
    let extent = [WIDTH as u32, HEIGHT as u32];
    let denoiser = Svgf::new(&gpu.device, usage, extent, &settings).unwrap();
    let mut bench = Bench::of(&gpu.device, extent, denoiser);
    (bench.is_rough, bench.light_is_wide) = (is_rough, light_is_wide);
    let middle = HEIGHT / 2 * WIDTH;
    bench.denoise(&wall(|index| Vec3::splat(if index == middle { 6e4 } else { 0.0 })));
    bench.output()[middle..middle + WIDTH].iter().take_while(|texel| texel.y > 0.0).count() - 1
}

/// Granja 2021, section 3.6: steps of 2, 4, 8, 16 pixels on rough surfaces, of 2, 4, 8, 8 in the penumbrae of wide lights, else of
/// 1, 2, 4, 8. A level reaches two steps; the estimate of the variance, before them, 3 pixels.
#[test]
fn a_widened_blur_follows_roughness_and_penumbra() {
    let Some(gpu) = GpuFixture::open() else { return };
    for (usage, is_rough, light_is_wide, reach) in [
        (Use::Reflections, true, false, 3 + 2 * (2 + 4 + 8 + 16)),
        (Use::Reflections, false, false, 3 + 2 * (1 + 2 + 4 + 8)),
        (Use::SoftShadows, true, true, 3 + 2 * (2 + 4 + 8 + 8)),
        (Use::SoftShadows, true, false, 3 + 2 * (1 + 2 + 4 + 8)),
    ] {
        let found = reach_of_a_pixel(&gpu, usage, is_rough, light_is_wide, true);
        assert_eq!(found, reach, "{usage:?}, rough: {is_rough}, wide: {light_is_wide}");
        assert_eq!(reach_of_a_pixel(&gpu, usage, is_rough, light_is_wide, false), 33);
    }
}
