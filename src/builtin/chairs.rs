//! Chairs of the meeting room.
//!
//! In: materials. Out: chairs on y = 0 around the y axis, facing +z.

use std::f32::consts::{PI, TAU};

use glam::{Affine3A, Vec3, vec2, vec3};

use super::meeting_paints::Paints;
use super::part::Part;
use super::paths::points;
use super::shapes::{bevelled, curved_slab, cushion, lathe, loft_open, rod};

/// A padded swivel chair on five castors.
pub(super) fn swivel_chair(paints: &Paints) -> Part {
    let mut all = base(paints);
    let seat = cushion(vec3(0.26, 0.055, 0.25), 0.45, [56, 26], paints.leather);
    all.push(seat.at(vec3(0.0, 0.49, 0.0)));
    let shell = cushion(vec3(0.24, 0.03, 0.23), 0.3, [32, 8], paints.plastic);
    all.push(shell.at(vec3(0.0, 0.43, 0.0)));
    all.push(back(paints));
    let spine = [
        vec3(0.0, 0.42, -0.1),
        vec3(0.0, 0.41, -0.25),
        vec3(0.0, 0.46, -0.31),
        vec3(0.0, 0.6, -0.33),
        vec3(0.0, 0.78, -0.36),
    ];
    all.push(rod(&spine, 0.025, 10, paints.steel));
    for side in [-1.0, 1.0] {
        let arm = [[0.2, 0.43, 0.02], [0.29, 0.44, 0.0], [0.315, 0.5, -0.02], [0.315, 0.66, -0.03]];
        all.push(rod(&arm.map(|[x, y, z]| vec3(side * x, y, z)), 0.016, 10, paints.steel));
        let pad = cushion(vec3(0.035, 0.018, 0.14), 0.5, [24, 10], paints.plastic);
        all.push(pad.at(vec3(side * 0.315, 0.675, 0.0)));
    }
    all
}

/// The back: a cushion, curved around the sitter, with horizontal ribs.
fn back(paints: &Paints) -> Part {
    const SEGMENTS: u32 = 48;
    const RINGS: u32 = 52;
    let ring = |j: u32| {
        let share = j as f32 / RINGS as f32;
        let latitude = PI * (share - 0.5);
        let width = if j == 0 || j == RINGS { 0.0 } else { latitude.cos().powf(0.28) };
        let height = latitude.sin().abs().powf(0.5).copysign(latitude);
        // Bulges between horizontal stitches.
        let swell = 1.0 + 0.22 * (9.0 * PI * height).cos() * (1.0 - height * height);
        let corner = |i: u32| {
            let (sin, cos) = (TAU * i as f32 / SEGMENTS as f32).sin_cos();
            let x = 0.235 * width * cos.abs().powf(0.5).copysign(cos);
            let depth = 0.034 * width * swell * sin.abs().powf(0.6).copysign(sin);
            // Bent forwards at the sides, and backwards towards the top.
            let lean = -0.3 - 0.09 * (height + 1.0) - 0.03 * height * height + 1.1 * x * x;
            vec3(x, 0.86 + 0.3 * height, lean - depth)
        };
        (0..SEGMENTS).map(corner).collect::<Vec<_>>()
    };
    loft_open(&(0..=RINGS).map(ring).collect::<Vec<_>>(), paints.leather)
}

/// Gas spring, five feet and their castors.
fn base(paints: &Paints) -> Part {
    let column = [[0.035, 0.1], [0.035, 0.24], [0.028, 0.245], [0.028, 0.36], [0.05, 0.37], [0.08, 0.42]];
    let mut all = lathe(&points(&column), 20, paints.steel);
    let hub = points(&[[0.05, 0.07], [0.055, 0.09], [0.055, 0.13], [0.04, 0.15]]);
    all.push(lathe(&hub, 20, paints.steel));
    let leg = [vec3(0.03, 0.115, 0.0), vec3(0.15, 0.105, 0.0), vec3(0.3, 0.085, 0.0)];
    let wheel = lathe(
        &[
            vec2(0.012, -0.011),
            vec2(0.026, -0.011),
            vec2(0.029, -0.007),
            vec2(0.029, 0.007),
            vec2(0.026, 0.011),
            vec2(0.012, 0.011),
        ],
        20,
        paints.plastic,
    );
    let axle = Affine3A::from_rotation_x(0.5 * PI);
    let mut foot = rod(&leg, 0.02, 10, paints.steel);
    for side in [-0.016, 0.016] {
        foot.push(wheel.placed(&(Affine3A::from_translation(vec3(0.3, 0.03, side)) * axle)));
    }
    foot.push(cushion(vec3(0.026, 0.02, 0.02), 0.7, [14, 8], paints.plastic).at(vec3(0.295, 0.062, 0.0)));
    for i in 0..5 {
        all.push(foot.turned(36.0 + 72.0 * i as f32, Vec3::ZERO));
    }
    all
}

/// A cantilever chair of bent steel tube for visitors along the walls.
pub(super) fn visitor_chair(paints: &Paints) -> Part {
    let side = [
        [0.24, 0.62, 0.2],
        [0.24, 0.64, 0.0],
        [0.24, 0.62, -0.16],
        [0.24, 0.58, -0.2],
        [0.24, 0.44, -0.21],
        [0.24, 0.42, -0.18],
        [0.24, 0.42, 0.16],
        [0.24, 0.4, 0.22],
        [0.24, 0.34, 0.245],
        [0.24, 0.06, 0.245],
        [0.24, 0.025, 0.22],
        [0.24, 0.016, 0.16],
        [0.24, 0.016, -0.16],
        [0.22, 0.016, -0.2],
        [0.16, 0.016, -0.215],
        [0.0, 0.016, -0.215],
    ];
    let mut all = Part::default();
    let right = side.map(|[x, y, z]| vec3(x, y, z));
    let left = side.iter().rev().skip(1).map(|[x, y, z]| vec3(-x, *y, *z));
    let tube: Vec<Vec3> = right.into_iter().chain(left).collect();
    all.push(rod(&tube, 0.0125, 10, paints.steel));
    let seat = |u: f32, v: f32| {
        let bow = 0.02 * (2.0 * u - 1.0).powi(2);
        vec3(0.46 * (u - 0.5), 0.445 + bow - 0.03 * v, 0.24 - 0.46 * v)
    };
    all.push(curved_slab([10, 12], 0.022, paints.fabric, |s| seat(s.x, s.y)));
    let rest = |u: f32, v: f32| {
        let bow = 0.12 * (u - 0.5) * (u - 0.5);
        vec3(0.46 * (u - 0.5), 0.88 - 0.3 * v, -0.27 + 0.07 * v + bow)
    };
    all.push(curved_slab([10, 10], 0.022, paints.fabric, |s| rest(s.x, s.y)));
    for x in [-0.2, 0.2] {
        let post = [vec3(x, 0.43, -0.2), vec3(x, 0.55, -0.225), vec3(x, 0.8, -0.27)];
        all.push(rod(&post, 0.0125, 8, paints.steel));
        let pad = bevelled(vec3(-0.02, 0.0, -0.16), vec3(0.02, 0.02, 0.16), 0.006, paints.plastic);
        all.push(pad.at(vec3(x * 1.2, 0.645, 0.02)));
    }
    all
}
