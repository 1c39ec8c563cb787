//! Each stage of SVGF against its CPU twin, on random signals and surfaces.

use glam::{IVec2, Vec3, Vec4, Vec4Swizzles};
use glowworm::settings::SvgfSettings;

use crate::bvh_support::Random;
use crate::gpu::GpuFixture;
use crate::support::{Bench, HEIGHT, Pixel, WIDTH, pixels, plane_depth};
use crate::twin::{self, Before};

/// Two planes, one behind the other, a gap without surfaces, and motion to wherever there was one.
fn random_pixels(numbers: &mut Random) -> Vec<Pixel> {
    let normals = [Vec3::new(0.2, 0.1, 1.0).normalize(), Vec3::new(-0.6, 0.3, 0.7).normalize()];
    pixels(|at| {
        let side = usize::from(at.x + at.y / 3 > 30);
        let depth = plane_depth(at, Vec3::new(0.0, 0.0, -4.0 - 2.0 * side as f32), normals[side]);
        let mut pixel = Pixel::stationary(
            numbers.point(Vec3::ZERO, Vec3::ONE) * 4.0 * numbers.unit(),
            normals[side],
            depth.unwrap(),
        );
        pixel.noisy[3] = (numbers.unit() * 16.0).floor() / 16.0;
        if at.y == 20 || numbers.unit() < 0.02 {
            pixel.depth = 0.0;
        }
        let moved = IVec2::new((numbers.unit() * 5.0) as i32 - 2, (numbers.unit() * 5.0) as i32 - 2);
        let part = [0.25, 0.75].map(|part| if numbers.unit() < 0.5 { part } else { 0.0 });
        let motion = [moved.x as f32 + part[0], moved.y as f32 + part[1]];
        let (four, nine) = ((numbers.unit() * 16.0) as u32, (numbers.unit() * 512.0) as u32);
        // Only what lies in the picture may be read.
        let corner = |bits: u32, first: IVec2, side: i32| {
            (0..side * side).fold(0, |mask, tap| {
                let there = first + IVec2::new(tap % side, tap / side);
                let inside =
                    there.cmpge(IVec2::ZERO).all() && there.x < WIDTH as i32 && there.y < HEIGHT as i32;
                if inside { mask | bits & 1 << tap } else { mask }
            })
        };
        let place = at.as_vec2() - glam::Vec2::from(motion);
        let four = corner(four, place.floor().as_ivec2(), 2);
        let nine = if four == 0 { corner(nine, (place + 0.5).floor().as_ivec2() - 1, 3) } else { 0 };
        pixel.reprojected = [motion[0], motion[1], four as f32, nine as f32];
        pixel
    })
}

/// Within a thousandth, or what half floats round off beside 1.
fn assert_near(stage: &str, found: &[Vec4], expected: impl Fn(usize) -> Vec4) {
    for (pixel, found) in found.iter().enumerate() {
        let expected = expected(pixel);
        let tolerance = 1e-3 * expected.abs().max(Vec4::splat(0.02));
        assert!(
            (found - expected).abs().cmple(tolerance).all(),
            "{stage}, pixel ({}, {}): {found}, not {expected}",
            pixel % WIDTH,
            pixel / WIDTH
        );
    }
}

fn compare(settings: &SvgfSettings) {
    let Some(gpu) = GpuFixture::open() else { return };
    let mut bench = Bench::new(&gpu.device, settings);
    let mut numbers = Random::new(5);
    let mut before: Option<(Vec<Vec4>, Vec<Vec4>)> = None;
    for frame in 0..7 {
        let pixels = random_pixels(&mut numbers);
        bench.denoise(&pixels);
        // With one level nothing is written twice.
        let [history, moments] = [bench.read(|svgf| svgf.history()), bench.read(|svgf| svgf.moments())];
        let [estimated, filtered] = [bench.read(|svgf| svgf.light(0)), bench.output()];
        let last = |texel: Vec4| if settings.reinhard { twin::expanded(texel) } else { texel };
        let then = || before.as_ref().map(|(history, moments)| Before { history, moments });
        assert_near("light", &history, |pixel| twin::temporal(settings, &pixels, then(), pixel).0);
        assert_near("moments", &moments, |pixel| twin::temporal(settings, &pixels, then(), pixel).1);
        assert_near("variance", &estimated, |pixel| {
            twin::variance(settings, &pixels, &history, &moments, pixel)
        });
        assert_near("a-trous", &filtered, |pixel| {
            last(twin::atrous(settings, &pixels, &estimated, (1, [2, 2]), pixel))
        });
        assert!(filtered.iter().all(|texel| texel.is_finite()), "frame {frame}");
        before = Some((history, moments));
    }
    let lengths = before.unwrap().1;
    let share =
        |frames: f32| lengths.iter().filter(|texel| texel.z == frames).count() as f32 / lengths.len() as f32;
    println!("histories of 1 frame {}, of 7 {}", share(1.0), share(7.0));
    assert!(share(1.0) > 0.0 && share(7.0) > 0.0);
}

#[test]
fn stages_are_those_of_the_twin() {
    compare(&SvgfSettings { levels: 1, ..SvgfSettings::default() });
}

#[test]
fn stages_are_those_of_the_twin_with_other_settings() {
    let settings = SvgfSettings { levels: 1, ..SvgfSettings::default() };
    compare(&SvgfSettings { history_rejection: 0.0, firefly: 0.0, adaptive: false, ..settings });
    // Much is dropped and taken down.
    compare(&SvgfSettings { history_rejection: 0.7, firefly: 0.5, moments_alpha: 0.1, ..settings });
    compare(&SvgfSettings { reinhard: true, ..settings });
}

#[test]
fn the_level_that_feeds_back_becomes_history() {
    let Some(gpu) = GpuFixture::open() else { return };
    let settings = SvgfSettings { levels: 2, feedback: 1, ..SvgfSettings::default() };
    let mut bench = Bench::new(&gpu.device, &settings);
    let mut numbers = Random::new(6);
    let mut before: Option<(Vec<Vec4>, Vec<Vec4>)> = None;
    for _ in 0..3 {
        let pixels = random_pixels(&mut numbers);
        bench.denoise(&pixels);
        let then = || before.as_ref().map(|(history, moments)| Before { history, moments });
        let all = || 0..pixels.len();
        let light: Vec<Vec4> =
            all().map(|pixel| twin::temporal(&settings, &pixels, then(), pixel).0).collect();
        let moments = bench.read(|svgf| svgf.moments());
        let estimated: Vec<Vec4> =
            all().map(|pixel| twin::variance(&settings, &pixels, &light, &moments, pixel)).collect();
        let history = bench.read(|svgf| svgf.history());
        assert_near("history", &history, |pixel| {
            twin::atrous(&settings, &pixels, &estimated, (1, [2, 2]), pixel)
        });
        assert_near("output", &bench.output(), |pixel| {
            twin::atrous(&settings, &pixels, &history, (2, [2, 2]), pixel)
        });
        before = Some((history, moments));
    }
}

#[test]
fn separate_axes_are_those_of_the_twin() {
    let Some(gpu) = GpuFixture::open() else { return };
    let mut numbers = Random::new(11);
    let pixels = random_pixels(&mut numbers);
    let settings = SvgfSettings { levels: 2, feedback: 1, ..SvgfSettings::default() };
    let mut whole = Bench::new(&gpu.device, &settings);
    whole.denoise(&pixels);

    let settings = SvgfSettings { levels: 1, separable: true, ..settings };
    let mut bench = Bench::new(&gpu.device, &settings);
    bench.denoise(&pixels);
    // Variance, along x, along y, in turns: the first is overwritten.
    let (history, moments) = (bench.read(|svgf| svgf.history()), bench.read(|svgf| svgf.moments()));
    let estimated: Vec<Vec4> = (0..pixels.len())
        .map(|pixel| twin::variance(&settings, &pixels, &history, &moments, pixel))
        .collect();
    let parts = [estimated, bench.read(|svgf| svgf.light(1)), bench.output()];
    for (part, radii) in [[2, 0], [0, 2]].into_iter().enumerate() {
        assert_near("axis", &parts[part + 1], |pixel| {
            twin::atrous(&settings, &pixels, &parts[part], (1, radii), pixel)
        });
    }
    let level = whole.read(|svgf| svgf.history());
    assert!(parts[2].iter().zip(&level).any(|(a, b)| a.xyz() != b.xyz()), "both ways differ somewhere");
}
