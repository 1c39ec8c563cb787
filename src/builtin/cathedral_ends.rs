//! The west front of the cathedral, seen from inside, and its choir: apse, steps and altar.

use std::f32::consts::PI;

use glam::{Vec2, Vec3, vec2, vec3};

use super::cathedral_plan::{AISLE, AISLE_TOP, HALF_LENGTH, NAVE, Paints, RISE, SPRING, TOP};
use super::cathedral_windows::{lancet, rose};
use super::columns::along;
use super::part::Part;
use super::paths::points;
use super::shapes::{Ends, Frame, bevelled, block, cuboid, cushion, lathe, sweep};
use super::walls::{Opening, Panel, pierced};

/// Thickness of the end walls.
const THICK: f32 = 0.8;
/// Sides of the apse.
const SIDES: u32 = 5;
/// Level of the choir, and its extent into the nave.
const CHOIR: f32 = 0.45;

/// The west wall with its door and rose window.
pub(super) fn west(paints: &Paints) -> Part {
    let depth = [-THICK, 0.0];
    let lower = Panel { min: vec2(-NAVE, -0.1), max: vec2(NAVE, 6.6), depth };
    let upper = Panel { min: vec2(-NAVE, 6.6), max: vec2(NAVE, TOP), depth };
    let door = Opening { middle: 0.0, half: 1.35, sill: -0.1, spring: 2.6, rise: 1.9, steps: 24 };
    let order = points(&[[-0.02, -0.1], [0.2, -0.1], [0.2, 0.1], [0.12, 0.16], [0.04, 0.1], [-0.02, 0.1]]);
    let mut wall = pierced(&lower, &door, paints.wall)
        .and(door.moulding(&order, 0.0, paints.trim))
        .and(door.moulding(
            &order.iter().map(|p| vec2(p.x - 0.17, p.y - 0.23)).collect::<Vec<_>>(),
            0.0,
            paints.trim,
        ))
        .and(rose(paints, &upper, vec2(0.0, 10.1), 2.1));
    wall.push(door.filling(0.05, [-0.62, -0.5], paints.door));
    for side in [-1.0f32, 1.0] {
        let band = |y: f32| {
            let (a, b) = (0.05 * side, 1.3 * side);
            cuboid(vec3(a.min(b), y, -0.51), vec3(a.max(b), y + 0.09, -0.47), paints.gold)
        };
        wall.push(band(0.5).and(band(1.5)).and(band(2.5)));
    }
    wall.push(aisle_ends(paints, depth));
    wall.turned(90.0, Vec3::NEG_X * HALF_LENGTH)
}

/// The walls beside the end of the nave, each with a window.
fn aisle_ends(paints: &Paints, depth: [f32; 2]) -> Part {
    let mut all = Part::default();
    for side in [-1.0f32, 1.0] {
        let (inner, outer) = (side * NAVE, side * (AISLE + 0.6));
        let panel =
            Panel { min: vec2(inner.min(outer), -0.1), max: vec2(inner.max(outer), AISLE_TOP), depth };
        let middle = 0.5 * side * (NAVE + AISLE) + 0.2 * side;
        let opening = Opening { middle, half: 0.6, sill: 2.4, spring: 4.4, rise: 1.2, steps: 12 };
        all.push(lancet(paints, &panel, &opening));
    }
    all
}

/// The east wall, with the opening to the apse.
pub(super) fn east(paints: &Paints) -> Part {
    let depth = [-THICK, 0.0];
    let panel = Panel { min: vec2(-NAVE, -0.1), max: vec2(NAVE, TOP), depth };
    let opening = Opening { middle: 0.0, half: 3.5, sill: -0.1, spring: 7.6, rise: 4.9, steps: 28 };
    let order = points(&[
        [-0.2, -0.3],
        [0.25, -0.3],
        [0.25, 0.06],
        [0.15, 0.12],
        [0.05, 0.06],
        [-0.08, 0.0],
        [-0.2, -0.14],
    ]);
    let wall = pierced(&panel, &opening, paints.wall)
        .and(opening.moulding(&order, 0.0, paints.trim))
        .and(aisle_ends(paints, depth));
    wall.turned(-90.0, Vec3::X * HALF_LENGTH).and(apse(paints)).and(choir(paints))
}

/// Corners of the apse, from north to south, relative to its centre.
fn apse_corner(i: u32) -> Vec2 {
    let angle = PI * (0.5 - i as f32 / SIDES as f32);
    vec2(angle.cos(), -angle.sin()) * NAVE
}

fn apse_middle() -> Vec3 {
    vec3(HALF_LENGTH + THICK - 0.1, 0.0, 0.0)
}

/// Five walls with tall windows under half a dome with ribs.
fn apse(paints: &Paints) -> Part {
    let mut all = Part::default();
    let side = apse_corner(0).distance(apse_corner(1));
    let panel =
        Panel { min: vec2(-0.5 * side, -0.2), max: vec2(0.5 * side, SPRING + 0.1), depth: [-0.5, 0.0] };
    let opening = Opening { middle: 0.0, half: 0.62, sill: 3.0, spring: 7.2, rise: 1.2, steps: 14 };
    let wall = lancet(paints, &panel, &opening);
    for i in 0..SIDES {
        let middle = 0.5 * (apse_corner(i) + apse_corner(i + 1));
        let facing = 0.5 * PI - PI * (i as f32 + 0.5) / SIDES as f32;
        all.push(wall.turned(facing.to_degrees() - 90.0, vec3(middle.x, 0.0, middle.y)));
    }
    let shaft = lathe(
        &points(&[
            [0.26, -0.02],
            [0.26, CHOIR + 0.3],
            [0.2, CHOIR + 0.38],
            [0.15, CHOIR + 0.44],
            [0.15, SPRING - 0.5],
            [0.19, SPRING - 0.46],
            [0.16, SPRING - 0.4],
            [0.27, SPRING - 0.1],
            [0.29, SPRING + 0.03],
        ]),
        14,
        paints.trim,
    );
    all.push_at(&shaft, (0..=SIDES).map(|i| vec3(apse_corner(i).x, 0.0, apse_corner(i).y)));
    all.push(half_dome(paints));
    all.at(apse_middle())
}

/// Height of the dome over its springing, at a fraction of the distance from the wall to the centre.
fn meridian(share: f32) -> Vec2 {
    let angle = 0.5 * PI * share;
    vec2(NAVE * angle.cos(), SPRING + RISE * angle.sin())
}

fn half_dome(paints: &Paints) -> Part {
    const STEPS: u32 = 12;
    let inner = (0..=STEPS)
        .map(|i| if i == STEPS { vec2(0.0, SPRING + RISE) } else { meridian(i as f32 / STEPS as f32) });
    let mut profile = vec![vec2(NAVE + 0.5, SPRING), vec2(NAVE + 0.5, TOP + 0.1), vec2(0.0, TOP + 0.1)];
    let mut inside: Vec<Vec2> = inner.collect();
    inside.reverse();
    profile.extend(&inside);
    // Slices on the walls; the path runs against the angle.
    let slice = |i: u32| {
        let angle = PI * (0.5 - i as f32 / SIDES as f32);
        Frame { origin: Vec3::ZERO, right: vec3(angle.cos(), 0.0, -angle.sin()), up: Vec3::Y }
    };
    let slices: Vec<Frame> = (0..=SIDES).map(slice).collect();
    let mut all = sweep(&profile, &slices, Ends::Capped, paints.vault);
    let rib =
        points(&[[0.12, -0.08], [0.12, 0.06], [0.05, 0.2], [-0.05, 0.2], [-0.12, 0.06], [-0.12, -0.08]]);
    for frame in &slices[1..SIDES as usize] {
        let sideways = Vec3::Y.cross(frame.right);
        let foot = |i: u32| {
            let share = (i as f32 / STEPS as f32).min(0.985);
            let place = meridian(share);
            let normal = vec2(-place.x / NAVE / NAVE, -(place.y - SPRING) / RISE / RISE).normalize();
            Frame {
                origin: frame.right * place.x + Vec3::Y * place.y,
                right: sideways,
                up: frame.right * normal.x + Vec3::Y * normal.y,
            }
        };
        let way: Vec<Frame> = (0..=STEPS).map(foot).collect();
        all.push(sweep(&rib, &way, Ends::Capped, paints.trim));
    }
    let boss = lathe(&points(&[[0.15, -0.34], [0.3, -0.28], [0.38, -0.16], [0.38, 0.1]]), 20, paints.gold);
    all.and(boss.at(vec3(0.0, SPRING + RISE, 0.0)))
}

/// Steps, altar, candlesticks and a cross.
fn choir(paints: &Paints) -> Part {
    let mut all = Part::default();
    let end = HALF_LENGTH + NAVE + 1.0;
    let half = 3.72;
    for (i, from) in [15.9f32, 16.3, 16.7].into_iter().enumerate() {
        let top = 0.15 * (i + 1) as f32;
        let (half, end) = (half - 0.02 * i as f32, end - 0.02 * i as f32);
        all.push(bevelled(vec3(from, top - 0.3, -half), vec3(end, top, half), 0.015, paints.marble));
    }
    let altar = vec3(HALF_LENGTH + 2.6, CHOIR, 0.0);
    let body = block(vec3(1.0, 0.95, 2.6), paints.marble)
        .and(block(vec3(1.3, 0.12, 3.0), paints.trim).at(Vec3::NEG_Y * 0.02))
        .and(bevelled(vec3(-0.62, 0.93, -1.5), vec3(0.62, 1.05, 1.5), 0.02, paints.marble))
        .and(bevelled(vec3(-0.63, 0.6, -0.7), vec3(0.63, 1.06, 0.7), 0.005, paints.linen));
    all.push(body.at(altar));
    let candlestick = lathe(
        &points(&[
            [0.12, -0.01],
            [0.12, 0.03],
            [0.03, 0.09],
            [0.045, 0.16],
            [0.02, 0.22],
            [0.02, 0.4],
            [0.05, 0.44],
            [0.05, 0.46],
            [0.018, 0.46],
            [0.018, 0.72],
        ]),
        14,
        paints.gold,
    );
    let row = along(altar + vec3(0.25, 1.05, -1.3), altar + vec3(0.25, 1.05, 1.3), 6);
    all.push_at(&candlestick, row);
    let foot = altar + vec3(0.25, 1.05, 0.0);
    all.push(cuboid(foot + vec3(-0.03, 0.1, -0.035), foot + vec3(0.03, 1.25, 0.035), paints.gold));
    all.push(cuboid(foot + vec3(-0.026, 0.8, -0.34), foot + vec3(0.026, 0.87, 0.34), paints.gold));
    all.push(cushion(vec3(0.14, 0.12, 0.14), 1.0, [16, 10], paints.gold).at(foot + Vec3::Y * 0.08));
    all
}
