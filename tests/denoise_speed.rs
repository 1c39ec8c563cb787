//! What separate axes are for, and what the clamp costs. A test of its own, so that nothing else runs beside it.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

#[path = "support/mod.rs"]
mod lab;
#[path = "denoise/support.rs"]
mod support;

use glam::Vec3;
use glowworm::settings::SvgfSettings;
use support::{Bench, Pixel};

const SIDE: u32 = 512;

#[test]
fn separate_axes_are_faster() {
    let Some(lab) = lab::Lab::open_to_measure() else { return };
    let pixels: Vec<Pixel> =
        (0..SIDE * SIDE).map(|index| Pixel::at_rest(Vec3::splat((index % 7) as f32), Vec3::Z, 4.0)).collect();
    let default = SvgfSettings::default();
    let mut benches = [
        default,
        SvgfSettings { separable: true, ..default },
        SvgfSettings { clamp: 0.0, firefly: 0.0, ..default },
    ]
    .map(|settings| Bench::of_size(&lab.device, [SIDE, SIDE], &settings));
    for bench in &mut benches {
        (0..4).for_each(|_| bench.denoise(&pixels));
        bench.frames.finish().unwrap();
    }
    // In turns, so that a machine that is slow for a while is slow for all; the fastest of each, as other load only adds time.
    let mut times = [vec![], vec![], vec![]];
    for _ in 0..9 {
        for (bench, times) in benches.iter_mut().zip(&mut times) {
            bench.denoise(&pixels);
            times.extend(bench.frames.finish().unwrap());
        }
    }
    let ms = |which: usize, pass: &str| {
        let of_pass =
            |passes: &[(&str, f64)]| passes.iter().filter(|(name, _)| *name == pass).map(|(_, ms)| ms).sum();
        times[which].iter().map(|times| of_pass(&times.passes)).fold(f64::INFINITY, f64::min)
    };
    for pass in ["svgf_temporal", "svgf_variance", "svgf_atrous"] {
        println!(
            "{SIDE}x{SIDE}, {pass}: {:.1} ms, with separate axes {:.1} ms, without clamp {:.1} ms",
            ms(0, pass),
            ms(1, pass),
            ms(2, pass)
        );
    }
    let ratio = ms(0, "svgf_atrous") / ms(1, "svgf_atrous");
    println!("{}: separate axes are {ratio:.2} times as fast", lab.device.info().name);
    assert!(ratio >= 1.6, "{ratio}");
}
