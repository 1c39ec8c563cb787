//! Carved stone: fluted shafts, capitals with leaves, medallions with a lion's head.

use std::f32::consts::{PI, TAU};

use glam::{Vec2, vec2};

use super::columns::Column;
use super::noise::ramp;
use super::part::Part;
use super::paths::{arc, circle, way};
use super::shapes::{Ends, lathe_shaped, loft_open, sweep};

/// Relief height of a row of `leaves` at an angle, relative to the radius; `t` from 0 at their base to 1 at their
/// tips.
fn leaf_row(angle: f32, t: f32, leaves: f32, turn: f32) -> f32 {
    if !(0.0..=1.0).contains(&t) {
        return 0.0;
    }
    let around = (leaves * angle / TAU + turn).rem_euclid(1.0) - 0.5;
    let width = 0.47 * (PI * (0.25 + 0.7 * t)).sin();
    let across = (around / width).abs();
    if across >= 1.0 {
        return 0.0;
    }
    let curl = 0.07 + 0.26 * t * t;
    let rib = 0.02 * ramp(0.25, 0.0, across);
    (curl + rib) * (1.0 - across * across).sqrt() * (1.0 - 0.35 * ramp(0.85, 1.0, t))
}

/// A column with a fluted shaft and two rows of leaves on its capital; `details` are the segments around the
/// capital and the rings up it.
pub(super) fn carved_column(column: &Column, flutes: u32, [segments, rings]: [u32; 2]) -> Part {
    let r = column.radius;
    let top = column.height - 0.4 * r;
    let foot = column.capital_foot();
    let rise = top - foot;
    let fluted = |angle: f32, y: f32| {
        let ends = ramp(0.6 * r, 1.6 * r, y - 0.8 * r) * ramp(0.1 * r, 0.5 * r, foot - y);
        1.0 - 0.035 * (1.0 - (flutes as f32 * angle).cos()) * ends
    };
    let mut bell = arc(vec2(0.88 * r, foot + 0.05 * r), 0.1 * r, [-90.0, 60.0], 3);
    bell.insert(0, vec2(0.7 * r, foot - 0.05 * r));
    for i in 0..=rings {
        let t = i as f32 / rings as f32;
        bell.push(vec2(r * (0.84 + 0.5 * t.powi(5)), foot + 0.16 * r + (rise - 0.2 * r) * t));
    }
    bell.push(vec2(1.2 * r, top + 0.01));
    let carved = |angle: f32, y: f32| {
        let t = (y - foot - 0.16 * r) / (rise - 0.2 * r);
        let lower = leaf_row(angle, t / 0.52, 8.0, 0.0);
        let upper = leaf_row(angle, (t - 0.25) / 0.62, 8.0, 0.5);
        let volute =
            0.2 * ramp(0.72, 0.86, t) * ramp(1.0, 0.93, t) * ramp(0.4, 0.95, (2.0 * angle).sin().abs());
        1.0 + lower.max(upper).max(volute)
    };
    column
        .shaft(4 * flutes, fluted)
        .and(lathe_shaped(&bell, segments, column.materials[1], carved))
        .and(column.abacus())
}

/// Relief height of a lion's head at a point in the unit disc.
fn lion(place: Vec2) -> f32 {
    let (radius, angle) = (place.length(), place.y.atan2(place.x));
    let bump = |x: f32, y: f32, width: f32, height: f32| {
        let offset = vec2(place.x.abs() - x, place.y - y) / vec2(width, height);
        (-offset.length_squared()).exp()
    };
    let locks = 0.055 * (15.0 * angle + 5.0 * radius).cos() + 0.04 * (24.0 * angle - 9.0 * radius).cos();
    let mane = (0.3 + locks) * ramp(0.97, 0.7, radius) * ramp(0.3, 0.5, radius);
    let face = 0.34 * ramp(0.66, 0.35, (place / vec2(0.9, 1.1)).length());
    let brow = 0.1 * bump(0.2, 0.2, 0.16, 0.07);
    let nose = 0.17 * bump(0.0, 0.02, 0.09, 0.24) + 0.12 * bump(0.0, -0.14, 0.12, 0.07);
    let muzzle = 0.17 * bump(0.11, -0.24, 0.13, 0.12) + 0.1 * bump(0.0, -0.42, 0.13, 0.08);
    let eyes = 0.06 * bump(0.2, 0.1, 0.055, 0.035) - 0.08 * bump(0.2, 0.1, 0.11, 0.07);
    let mouth = -0.1 * bump(0.0, -0.35, 0.2, 0.03);
    let ears = 0.14 * bump(0.4, 0.42, 0.09, 0.1) - 0.08 * bump(0.4, 0.42, 0.045, 0.05);
    mane + face + brow + nose + muzzle + eyes + mouth + ears
}

/// A round relief in a moulded frame, in front of the wall z = 0.
pub(super) fn medallion(radius: f32, [segments, rings]: [u32; 2], material: u32) -> Part {
    let ring = |share: f32, depth: Option<f32>| {
        let corner = |i: u32| {
            let place = share * Vec2::from_angle(TAU * i as f32 / segments as f32);
            let height = depth.unwrap_or_else(|| 0.04 + 0.5 * lion(place));
            (place * radius).extend(height * radius)
        };
        (0..segments).map(corner).collect::<Vec<_>>()
    };
    let mut all_rings = vec![ring(0.0, Some(-0.05)), ring(1.0, Some(-0.05))];
    all_rings.extend((1..=rings).rev().map(|i| ring(i as f32 / rings as f32, None)));
    all_rings.push(ring(0.0, None));
    // x points inwards from the rim.
    let profile = [[0.0, -0.08], [0.24, -0.08], [0.24, 0.12], [0.15, 0.1], [0.08, 0.16], [0.0, 0.08]];
    let rim = way(&circle(Vec2::ZERO, 1.2 * radius, 64), true);
    let frame = sweep(&profile.map(|p| vec2(p[0], p[1]) * radius), &rim, Ends::Joined, material);
    loft_open(&all_rings, material).and(frame)
}
