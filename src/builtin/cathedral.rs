//! The cathedral: a nave of seven vaulted bays between aisles, with clerestory windows and a choir.
//!
//! In: materials. Out: the building. x runs from the west door to the altar, y up; metres.

use glam::{Vec2, Vec3, vec2, vec3};

use super::cathedral_ends as ends;
use super::cathedral_plan::{
    AISLE, AISLE_TOP, BAY, BAYS, HALF_LENGTH, HALF_WALL, NAVE, PIER, Paints, RISE, SPRING, TOP,
};
use super::cathedral_windows::{self as windows, lancet};
use super::palette::Palette;
use super::part::Part;
use super::paths::{points, strip};
use super::shapes::{cuboid, lathe, lathe_shaped};
use super::vault::Vault;
use super::walls::{Opening, Panel, pierced, straight};

/// Levels of the two string courses.
const COURSES: [f32; 2] = [8.3, 9.9];

/// The whole model.
pub(super) fn model(palette: &mut Palette) -> Part {
    let paints = Paints::new(palette);
    let mut side = arcade(&paints);
    side.push(aisle(&paints));
    let mut all = floor(&paints);
    // The south side is the north side rotated by 180 degrees: a side is symmetric.
    all.push(side.turned(180.0, Vec3::ZERO));
    all.push(side);
    all.push(nave_vault(&paints));
    all.push(ends::west(&paints));
    all.push(ends::east(&paints));
    all
}

/// Centres of the bays, along x.
fn bay_middles() -> impl Iterator<Item = f32> {
    (0..BAYS).map(|i| BAY * (i as f32 + 0.5) - HALF_LENGTH)
}

/// Boundaries of the bays, including both ends.
fn bay_edges() -> impl Iterator<Item = f32> {
    (0..=BAYS).map(|i| BAY * i as f32 - HALF_LENGTH)
}

fn floor(paints: &Paints) -> Part {
    let end = HALF_LENGTH + 0.5;
    let split = NAVE + HALF_WALL;
    let aisle = |from: f32, to: f32| cuboid(vec3(-end, -0.4, from), vec3(end, 0.0, to), paints.aisle);
    // The carpet's pattern runs across x before the rotation.
    let half = 1.55;
    let carpet =
        super::shapes::bevelled(vec3(0.0, -0.01, -14.8), vec3(2.0 * half, 0.025, 15.9), 0.008, paints.carpet);
    let mut carpet = carpet;
    for uv in carpet.pieces.iter_mut().flat_map(|piece| &mut piece.uvs) {
        uv.x *= 2.6 / (2.0 * half);
    }
    let east = HALF_LENGTH + NAVE + 1.4;
    cuboid(vec3(-end, -0.4, -split), vec3(east, 0.0, split), paints.floor)
        .and(aisle(split, AISLE + 0.5))
        .and(aisle(-AISLE - 0.5, -split))
        .and(carpet.turned(-90.0, vec3(0.0, 0.0, -half)))
}

/// Radius of a pier at an angle: a round core with eight shafts.
fn cluster(angle: f32) -> f32 {
    let shaft = |turn: f32, away: f32, radius: f32| {
        let step = std::f32::consts::FRAC_PI_2;
        let off = (angle - turn + 0.5 * step).rem_euclid(step) - 0.5 * step;
        let across = away * off.sin();
        if across.abs() < radius {
            away * off.cos() + (radius * radius - across * across).sqrt()
        } else {
            0.0
        }
    };
    let diagonal = std::f32::consts::FRAC_PI_4;
    0.48f32.max(shaft(0.0, 0.46, 0.17)).max(shaft(diagonal, 0.44, 0.13))
}

fn pier(paints: &Paints) -> Part {
    let mut profile = points(&[[1.22, 0.36], [1.22, 0.44]]);
    profile.extend(points(&[[1.18, 0.5], [1.06, 0.54], [1.1, 0.6], [1.0, 0.66], [1.0, 4.02]]));
    profile.extend(points(&[[1.07, 4.05], [1.0, 4.1], [1.04, 4.25], [1.18, 4.38], [1.2, 4.44]]));
    let octagon = |list: &[[f32; 2]]| lathe(&points(list), 8, paints.trim).turned(22.5, Vec3::ZERO);
    octagon(&[[0.98, -0.02], [0.98, 0.26], [0.92, 0.34], [0.9, 0.38]])
        .and(lathe_shaped(&profile, 32, paints.trim, |angle, _| cluster(angle)))
        .and(octagon(&[[0.84, 4.42], [0.9, 4.48], [0.9, PIER + 0.04], [0.84, PIER + 0.1]]))
}

/// One wall of the nave with its piers: arcade, blind arches, clerestory. At z = -NAVE, facing the nave.
fn arcade(paints: &Paints) -> Part {
    let mut all = Part::default();
    let wall = vec3(0.0, 0.0, -NAVE);
    all.push_at(&pier(paints), bay_edges().map(|x| wall + Vec3::X * x));
    let shaft = wall_shaft(paints);
    all.push_at(&shaft, bay_edges().map(|x| wall + vec3(x, 0.0, HALF_WALL)));
    let bay = arcade_bay(paints).and(blind_arches(paints)).and(windows::clerestory(paints, COURSES[1]));
    all.push_at(&bay, bay_middles().map(|x| wall + Vec3::X * x));
    let course = points(&[
        [-0.1, -0.12],
        [0.04, -0.12],
        [0.1, -0.02],
        [0.13, 0.0],
        [0.13, 0.06],
        [0.0, 0.12],
        [-0.1, 0.12],
    ]);
    let straight = straight(-HALF_LENGTH, HALF_LENGTH, &course, paints.trim);
    all.push_at(&straight, COURSES.map(|y| wall + vec3(0.0, y, HALF_WALL)));
    all
}

fn arcade_bay(paints: &Paints) -> Part {
    let opening = Opening { middle: 0.0, half: 1.9, sill: PIER, spring: PIER, rise: 2.7, steps: 16 };
    let panel = Panel {
        min: vec2(-0.5 * BAY, PIER),
        max: vec2(0.5 * BAY, COURSES[0]),
        depth: [-HALF_WALL, HALF_WALL],
    };
    let profile =
        points(&[[-0.16, -0.32], [0.3, -0.32], [0.3, 0.06], [0.17, 0.04], [0.0, -0.1], [-0.12, -0.14]]);
    let back = points(&[[-0.16, -0.06], [0.3, -0.06], [0.3, 0.34], [-0.16, 0.34]]);
    pierced(&panel, &opening, paints.wall)
        .and(opening.moulding(&profile, HALF_WALL, paints.trim))
        .and(opening.moulding(&back, -HALF_WALL, paints.trim))
}

/// Four blind arches a bay between the string courses, in front of a wall.
fn blind_arches(paints: &Paints) -> Part {
    let [low, high] = COURSES;
    let half = 0.5 * BAY;
    let mut all = cuboid(vec3(-half, low, -HALF_WALL), vec3(half, high, 0.15), paints.wall);
    let width = BAY / 4.0;
    let opening =
        Opening { middle: 0.0, half: 0.4, sill: low + 0.25, spring: low + 0.85, rise: 0.5, steps: 6 };
    let panel =
        Panel { min: vec2(-0.5 * width, low), max: vec2(0.5 * width, high), depth: [0.15, HALF_WALL] };
    let arch = pierced(&panel, &opening, paints.trim);
    all.push_at(&arch, (0..4).map(|i| vec3(width * (i as f32 - 1.5), 0.0, 0.0)));
    all
}

/// A slender shaft from the pier up to the vault.
fn wall_shaft(paints: &Paints) -> Part {
    let head = SPRING;
    let mut profile = points(&[[0.19, PIER + 0.02], [0.19, PIER + 0.12]]);
    profile.push(vec2(0.21, PIER + 0.16));
    profile.extend(points(&[
        [0.13, PIER + 0.22],
        [0.13, head - 0.5],
        [0.17, head - 0.46],
        [0.14, head - 0.4],
    ]));
    profile.extend(points(&[[0.16, head - 0.25], [0.27, head - 0.09], [0.27, head + 0.03]]));
    lathe(&profile, 10, paints.trim)
}

const RIB: [[f32; 2]; 6] =
    [[0.0, -0.22], [0.08, -0.16], [0.12, -0.06], [0.12, 0.08], [-0.12, 0.08], [-0.12, -0.06]];

fn rib() -> Vec<Vec2> {
    points(&RIB)
}

fn nave_vault(paints: &Paints) -> Part {
    let vault = Vault { half: vec2(0.5 * BAY, NAVE), spring: SPRING, rise: RISE, point: 1.25, steps: 12 };
    let broad = strip(vec2(-0.22, -0.2), vec2(0.22, 0.1));
    let boss = lathe(&points(&[[0.12, -0.34], [0.24, -0.28], [0.3, -0.16], [0.3, 0.1]]), 20, paints.gold);
    let bay = vault
        .block(TOP + 0.05, paints.vault)
        .and(vault.groin_ribs(&rib(), 16, paints.trim))
        .and(boss.at(Vec3::Y * (SPRING + RISE)));
    let mut all = Part::default();
    all.push_at(&bay, bay_middles().map(|x| Vec3::X * x));
    all.push_at(&vault.cross_rib(&broad, 20, paints.trim), bay_edges().map(|x| Vec3::X * x));
    all
}

/// The north aisle: vaults, and the outer wall with its windows.
fn aisle(paints: &Paints) -> Part {
    let depth = AISLE - NAVE;
    let vault =
        Vault { half: vec2(0.5 * BAY, 0.5 * depth), spring: PIER - 0.1, rise: 2.75, point: 1.2, steps: 8 };
    let bay = vault.block(AISLE_TOP - 0.1, paints.vault).and(vault.groin_ribs(&rib(), 12, paints.trim));
    let middle = vec3(0.0, 0.0, -0.5 * (NAVE + AISLE));
    let mut all = Part::default();
    all.push_at(&bay, bay_middles().map(|x| middle + Vec3::X * x));
    let broad = vault.cross_rib(&strip(vec2(-0.2, -0.16), vec2(0.2, 0.1)), 14, paints.trim);
    all.push_at(&broad, bay_edges().map(|x| middle + Vec3::X * x));
    let opening = Opening { middle: 0.0, half: 0.7, sill: 2.2, spring: 4.4, rise: 1.35, steps: 14 };
    let panel = Panel { min: vec2(-0.5 * BAY, -0.1), max: vec2(0.5 * BAY, AISLE_TOP), depth: [-0.6, 0.0] };
    let window = lancet(paints, &panel, &opening);
    let respond = lathe(
        &points(&[
            [0.42, -0.02],
            [0.42, 0.3],
            [0.34, 0.36],
            [0.3, 0.42],
            [0.24, 0.5],
            [0.24, 4.0],
            [0.28, 4.04],
            [0.25, 4.1],
            [0.36, 4.36],
            [0.4, 4.4],
            [0.4, 4.64],
        ]),
        10,
        paints.trim,
    );
    all.push_at(&window, bay_middles().map(|x| vec3(x, 0.0, -AISLE)));
    all.push_at(&respond, bay_edges().map(|x| vec3(x, 0.0, -AISLE)));
    let plinth = points(&[[-0.05, -0.02], [0.14, -0.02], [0.14, 0.5], [0.05, 0.62], [-0.05, 0.62]]);
    all.push(straight(-HALF_LENGTH, HALF_LENGTH, &plinth, paints.trim).at(vec3(0.0, 0.0, -AISLE)));
    all
}
