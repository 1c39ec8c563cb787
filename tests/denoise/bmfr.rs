//! Checks BMFR with signals whose answer is known, and its fit against one by 64-bit numbers.

use glam::{DVec3, IVec2, Vec3, Vec4, Vec4Swizzles};
use glowworm::denoise::bmfr::Bmfr;
use glowworm::settings::{BmfrFeatures, BmfrSettings};

use crate::bvh_support::Random;
use crate::gpu::GpuFixture;
use crate::support::{Bench, HEIGHT, Pixel, WIDTH, pixels, plane_depth, position_at, wall};

const SIDE: i32 = 32;

fn bench(gpu: &GpuFixture, settings: &BmfrSettings) -> Bench<Bmfr> {
    let extent = [WIDTH as u32, HEIGHT as u32];
    Bench::of(&gpu.device, extent, Bmfr::new(&gpu.device, extent, settings, false).unwrap())
}

/// A bumpy wall that recedes; `light` by place of the pixel, position and normal.
fn bumpy(mut light: impl FnMut(IVec2, Vec3, Vec3) -> Vec3) -> Vec<Pixel> {
    pixels(|at| {
        let depth = plane_depth(at, Vec3::new(0.0, 0.0, -5.0), Vec3::new(0.4, 0.2, 1.0).normalize()).unwrap();
        let (x, y) = (at.x as f32, at.y as f32);
        let normal = Vec3::new(0.4 * (0.31 * x).sin(), 0.3 * (0.23 * y + 0.1 * x).cos(), 1.0).normalize();
        let mut pixel = Pixel::stationary(Vec3::ZERO, normal, depth);
        // As it is packed.
        let noisy = light(at, position_at(at, depth), pixel.geometric());
        pixel.noisy = noisy.extend(1.0).to_array();
        pixel
    })
}

#[test]
fn a_constant_stays_and_every_texel_is_fitted() {
    let Some(gpu) = GpuFixture::open() else { return };
    let mut bench = bench(&gpu, &BmfrSettings { alpha: 1.0, ..BmfrSettings::default() });
    for frame in 0..17 {
        // Other light each frame, so that what an offset leaves out is found.
        let colour = Vec3::new(0.5, 3.0, 120.0) * (1.0 + frame as f32);
        bench.denoise(&bumpy(|_, _, _| colour));
        for (place, texel) in bench.read(Bmfr::fitted).iter().enumerate() {
            let error = (texel.xyz() / colour - 1.0).abs().max_element();
            assert!(error < 1e-3, "frame {frame}, texel {place}: {texel}");
        }
    }
}

#[test]
fn light_that_is_linear_in_the_features_comes_back() {
    let Some(gpu) = GpuFixture::open() else { return };
    let mut bench = bench(&gpu, &BmfrSettings::default());
    let light = |_: IVec2, p: Vec3, n: Vec3| {
        Vec3::new(
            2.0 + 0.2 * p.x - 0.1 * p.z,
            1.0 + 0.4 * n.x - 0.3 * n.y,
            1.5 + 0.03 * p.y * p.y + 0.2 * n.z,
        )
    };
    let seen = bumpy(light);
    for frame in 0..3 {
        bench.denoise(&seen);
        for (place, (texel, pixel)) in bench.read(Bmfr::fitted).iter().zip(&seen).enumerate() {
            let expected = Vec4::from(pixel.noisy).xyz();
            let error = (texel.xyz() - expected).abs() / expected;
            // The signal and its fit are both half floats.
            assert!(
                error.max_element() < 1e-3 + 2.0f32.powi(-11),
                "frame {frame}, texel {place}: {texel}, not {expected}"
            );
        }
    }
}

/// The default features of a surface at a place from -1 to 1 in its block.
fn features(n: DVec3, w: DVec3) -> [f64; 10] {
    [1.0, n.x, n.y, n.z, w.x, w.y, w.z, w.x * w.x, w.y * w.y, w.z * w.z]
}

/// Weight of the squared coefficients, for each texel. Twin: shaders/denoise/bmfr_fit.comp.
const PENALTY: f64 = 1e-6;

/// Least squares by the normal equations, in 64 bits.
fn least_squares(rows: &[([f64; 10], DVec3)]) -> [DVec3; 10] {
    let mut a = [[0.0; 10]; 10];
    let mut b = [DVec3::ZERO; 10];
    for (row, light) in rows {
        for i in 0..10 {
            (0..10).for_each(|j| a[i][j] += row[i] * row[j]);
            b[i] += row[i] * *light;
        }
    }
    (1..10).for_each(|i| a[i][i] += PENALTY * rows.len() as f64);
    for k in 0..10 {
        let pivot = (k..10).max_by(|&i, &j| a[i][k].abs().total_cmp(&a[j][k].abs())).unwrap();
        a.swap(k, pivot);
        b.swap(k, pivot);
        for i in k + 1..10 {
            let factor = a[i][k] / a[k][k];
            (k..10).for_each(|j| a[i][j] -= factor * a[k][j]);
            let above = b[k];
            b[i] -= factor * above;
        }
    }
    for k in (0..10).rev() {
        for j in k + 1..10 {
            let known = b[j];
            b[k] -= a[k][j] * known;
        }
        b[k] /= a[k][k];
    }
    b
}

/// The first frame's fit of these pixels.
fn twin(seen: &[Pixel]) -> Vec<Vec3> {
    let mut fitted = vec![Vec3::ZERO; seen.len()];
    let (width, height) = (WIDTH as i32, HEIGHT as i32);
    for (block_y, block_x) in
        (0..(height + 31) / SIDE + 1).flat_map(|y| (0..(width + 31) / SIDE + 1).map(move |x| (y, x)))
    {
        let first = IVec2::new(block_x, block_y) * SIDE - 14 - SIDE / 2;
        let texels: Vec<IVec2> = (0..SIDE * SIDE)
            .map(|row| first + IVec2::new(row % SIDE, row / SIDE))
            .filter(|at| at.cmpge(IVec2::ZERO).all() && at.x < width && at.y < height)
            .collect();
        let pixel = |at: IVec2| &seen[(at.y * width + at.x) as usize];
        let place = |at: IVec2| position_at(at, pixel(at).depth).as_dvec3();
        let low = texels.iter().fold(DVec3::MAX, |low, at| low.min(place(*at)));
        let high = texels.iter().fold(DVec3::MIN, |high, at| high.max(place(*at)));
        let scaled = |at| (place(at) - low) * 2.0 / (high - low).max(DVec3::splat(1e-20)) - 1.0;
        let of = |at| features(pixel(at).geometric().as_dvec3(), scaled(at));
        let light = |at: IVec2| Vec4::from(pixel(at).noisy).xyz().as_dvec3();
        let rows: Vec<_> = texels.iter().map(|&at| (of(at), light(at))).collect();
        if rows.is_empty() {
            continue;
        }
        let weights = least_squares(&rows);
        for &at in &texels {
            let sum: DVec3 = of(at).iter().zip(weights).map(|(feature, weight)| *feature * weight).sum();
            fitted[(at.y * width + at.x) as usize] = sum.as_vec3().max(Vec3::ZERO);
        }
    }
    fitted
}

#[test]
fn the_fit_is_that_of_least_squares_in_64_bits() {
    let Some(gpu) = GpuFixture::open() else { return };
    let mut numbers = Random::new(11);
    let mut noise = |scale: f32| {
        let light = Vec3::new(numbers.unit(), numbers.unit(), numbers.unit()) * scale;
        Vec4::from(Pixel::stationary(light, Vec3::Z, 1.0).noisy).xyz()
    };
    // The second is flat: its normal and one of its positions are constants, like the first feature.
    for (name, seen) in [
        ("bumpy", bumpy(|_, _, _| noise(4.0))),
        ("flat", wall(|_| noise(4.0))),
        ("bright", bumpy(|_, _, _| noise(30_000.0))),
    ] {
        let mut bench = bench(&gpu, &BmfrSettings::default());
        bench.denoise(&seen);
        // As it was fitted, without fireflies.
        let mut seen = seen;
        for (pixel, texel) in seen.iter_mut().zip(bench.read(Bmfr::noisy)) {
            pixel.noisy = texel.to_array();
        }
        let scale = seen.iter().map(|pixel| pixel.noisy[1]).sum::<f32>() / seen.len() as f32;
        for (place, (texel, expected)) in bench.read(Bmfr::fitted).iter().zip(twin(&seen)).enumerate() {
            let error = (texel.xyz() - expected).abs().max_element() / scale;
            assert!(
                error < 5e-3,
                "{name}, texel ({}, {}): {texel}, not {expected}",
                place % WIDTH,
                place / WIDTH
            );
        }
    }
}

#[test]
fn the_newest_frame_counts_one_over_n() {
    let Some(gpu) = GpuFixture::open() else { return };
    let mut bench = bench(&gpu, &BmfrSettings::default());
    let mut expected = 0.0;
    for frame in 1..=9 {
        let light = if frame % 3 == 0 { 4.0 } else { 1.0 };
        expected += (light - expected) * f32::max(1.0 / frame as f32, 0.2);
        bench.denoise(&wall(|_| Vec3::splat(light)));
        for texel in bench.read(Bmfr::noisy) {
            assert!((texel.y / expected - 1.0).abs() < 2e-3 && texel.w == frame as f32, "{frame}: {texel}");
        }
    }
}

#[test]
fn history_of_which_one_texel_shows_the_surface_counts_in_full() {
    let Some(gpu) = GpuFixture::open() else { return };
    let mut bench = bench(&gpu, &BmfrSettings::default());
    bench.denoise(&wall(|_| Vec3::ONE));
    let mut moved = wall(|_| Vec3::ONE);
    // Of the four texels around, the last alone.
    moved.iter_mut().for_each(|pixel| pixel.reprojected = [0.5, 0.25, 8.0, 0.0]);
    bench.denoise(&moved);
    for texel in bench.read(Bmfr::noisy) {
        assert!((texel.y - 1.0).abs() < 2e-3 && texel.w == 2.0, "{texel}");
    }
}

#[test]
fn a_firefly_is_gone_and_numbers_stay_numbers() {
    let Some(gpu) = GpuFixture::open() else { return };
    let features = BmfrFeatures::parse("1,nx,nx,wx,wx,wx*wx*wx,sqrt(wy),d,d*nx").unwrap();
    for settings in [BmfrSettings::default(), BmfrSettings { features, ..BmfrSettings::default() }] {
        let mut bench = bench(&gpu, &settings);
        let middle = HEIGHT / 2 * WIDTH + WIDTH / 2;
        for frame in 0..11 {
            let mut count = 0;
            bench.denoise(&wall(|place| {
                count += 1;
                match frame {
                    2 if place == middle => Vec3::splat(1000.0),
                    5 if count % 50 == 0 => Vec3::splat(f32::NAN),
                    6 if count % 50 == 0 => Vec3::splat(f32::INFINITY),
                    _ => Vec3::ONE,
                }
            }));
            let least = bench.read(Bmfr::output).iter().fold(f32::MAX, |least, texel| {
                assert!(texel.is_finite(), "frame {frame}");
                least.min(texel.xyz().min_element())
            });
            assert!(least >= 0.0);
        }
        for texel in bench.read(Bmfr::output) {
            assert!((texel.y - 1.0).abs() < 0.03, "{texel}");
        }
    }
}
