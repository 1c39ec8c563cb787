//! Table, sideboard and shelves of the meeting room, and objects on them.

use std::f32::consts::TAU;

use glam::{Affine3A, Vec2, Vec3, vec2, vec3};

use super::columns::{along, vase};
use super::meeting_paints::Paints;
use super::noise::chance;
use super::part::Part;
use super::paths::points;
use super::plants::Tuft;
use super::shapes::{Ends, bevelled, cuboid, lathe, loft, rod};

/// Height of the table.
pub(super) const TABLE: f32 = 0.74;
/// Half extents of its top.
pub(super) const TABLE_HALF: Vec2 = Vec2::new(3.0, 0.85);

/// A rounded outline, counter-clockwise seen from above, at a height.
fn plan(half: Vec2, y: f32) -> Vec<Vec3> {
    const CORNERS: u32 = 72;
    let corner = |i: u32| {
        let (sin, cos) = (TAU * i as f32 / CORNERS as f32).sin_cos();
        let round = |value: f32| value.abs().powf(0.45).copysign(value);
        vec3(half.x * round(cos), y, -half.y * round(sin))
    };
    (0..CORNERS).map(corner).collect()
}

/// A long table with rounded ends on two drums.
pub(super) fn table(paints: &Paints) -> Part {
    let edge = [(-0.045, 0.02), (-0.035, 0.0), (-0.008, 0.0), (0.0, 0.008)];
    let rings: Vec<_> = edge.iter().map(|(y, inset)| plan(TABLE_HALF - *inset, TABLE + y)).collect();
    let mut all = loft(&rings, Ends::Capped, paints.veneer);
    // Texture coordinates of the top follow the room.
    let inlay = TABLE_HALF - vec2(0.42, 0.42);
    all.push(loft(&[plan(inlay, TABLE - 0.01), plan(inlay, TABLE + 0.003)], Ends::Capped, paints.inlay));
    let drum = [[0.52, 0.0], [0.52, 0.03], [0.36, 0.06], [0.34, 0.1], [0.34, 0.6], [0.42, 0.66], [0.46, 0.7]];
    let drum = lathe(&points(&drum), 40, paints.veneer);
    all.push_at(&drum, [vec3(-1.7, 0.0, 0.0), vec3(1.7, 0.0, 0.0)]);
    all
}

/// Objects on the table in front of a person at z < 0 who faces +z.
pub(super) fn place_setting(paints: &Paints, seat: u32) -> Part {
    let pick = |i: u32| chance(seat, i, 501);
    let mut all = Part::default();
    let paper = cuboid(vec3(-0.105, 0.0, -0.148), vec3(0.105, 0.004, 0.148), paints.paper);
    all.push(paper.turned(30.0 * (pick(0) - 0.5), vec3(-0.24, 0.0, 0.2)));
    let pen = [vec3(-0.02, 0.011, 0.12), vec3(-0.04, 0.011, 0.25)];
    all.push(rod(&pen, 0.005, 10, paints.plastic));
    all.push(glass(paints).at(vec3(0.31 + 0.03 * pick(1), 0.0, 0.32)));
    if seat % 3 != 1 {
        all.push(laptop(paints).turned(20.0 * (pick(2) - 0.5), vec3(0.07, 0.0, 0.2)));
    } else {
        all.push(cup(paints).at(vec3(0.12, 0.0, 0.26)));
    }
    all
}

/// A tumbler of thick, milky glass: a solid with a hollow.
fn glass(paints: &Paints) -> Part {
    let profile = [
        [0.026, 0.0],
        [0.028, 0.003],
        [0.034, 0.1],
        [0.033, 0.102],
        [0.032, 0.1],
        [0.027, 0.012],
        [0.0, 0.01],
    ];
    lathe(&points(&profile), 28, paints.glass)
}

fn cup(paints: &Paints) -> Part {
    let saucer = [[0.03, 0.0], [0.03, 0.004], [0.07, 0.014], [0.068, 0.018], [0.03, 0.008], [0.0, 0.008]];
    let body = [
        [0.022, 0.006],
        [0.024, 0.012],
        [0.038, 0.04],
        [0.041, 0.07],
        [0.038, 0.07],
        [0.034, 0.04],
        [0.018, 0.016],
        [0.0, 0.014],
    ];
    let handle = [[0.036, 0.058], [0.056, 0.056], [0.062, 0.044], [0.054, 0.03], [0.034, 0.03]];
    lathe(&points(&saucer), 32, paints.china).and(lathe(&points(&body), 32, paints.china)).and(rod(
        &handle.map(|[x, y]| vec3(x, y, 0.0)),
        0.005,
        8,
        paints.china,
    ))
}

/// An open laptop for a person at z < 0.
fn laptop(paints: &Paints) -> Part {
    let mut all = bevelled(vec3(-0.16, 0.0, -0.11), vec3(0.16, 0.018, 0.11), 0.004, paints.steel);
    let key = bevelled(vec3(-0.0095, 0.0, -0.0085), vec3(0.0095, 0.006, 0.0085), 0.002, paints.plastic);
    for row in 0..5 {
        let shift = 0.004 * row as f32;
        let line = vec3(-0.125 - shift + 0.006, 0.0165, 0.08 - 0.022 * row as f32);
        all.push_at(&key, along(line, line + Vec3::X * 0.253, 12));
    }
    all.push(cuboid(vec3(-0.045, 0.016, -0.095), vec3(0.045, 0.0185, -0.04), paints.plastic));
    let hinge = Affine3A::from_translation(vec3(0.0, 0.016, 0.11)) * Affine3A::from_rotation_x(0.3);
    let lid = bevelled(vec3(-0.16, 0.0, -0.004), vec3(0.16, 0.22, 0.004), 0.002, paints.steel).and(cuboid(
        vec3(-0.148, 0.012, -0.0055),
        vec3(0.148, 0.21, -0.002),
        paints.screen,
    ));
    all.push(lid.placed(&hinge));
    all
}

/// A low cupboard along z = 0 with its front at +z, with a plant, a vase and cups.
pub(super) fn sideboard(paints: &Paints) -> Part {
    let half = 1.5;
    let mut all = bevelled(vec3(-half, 0.08, 0.0), vec3(half, 0.78, 0.46), 0.008, paints.veneer);
    all.push(cuboid(vec3(-half + 0.04, 0.0, 0.04), vec3(half - 0.04, 0.1, 0.4), paints.plastic));
    all.push(bevelled(vec3(-half - 0.02, 0.77, -0.01), vec3(half + 0.02, 0.81, 0.49), 0.008, paints.veneer));
    let door = bevelled(vec3(-0.365, 0.12, 0.45), vec3(0.365, 0.74, 0.485), 0.01, paints.veneer);
    let handle = rod(&[vec3(0.29, 0.36, 0.51), vec3(0.29, 0.5, 0.51)], 0.007, 10, paints.steel);
    let leg = rod(&[vec3(0.29, 0.38, 0.48), vec3(0.29, 0.38, 0.51)], 0.005, 8, paints.steel);
    let door = door.and(handle).and(leg.at(Vec3::Y * 0.1)).and(leg);
    all.push_at(&door, along(vec3(-1.125, 0.0, 0.0), vec3(1.125, 0.0, 0.0), 4));
    let top = 0.81;
    all.push(vase(0.42, [48, 28], paints.china).at(vec3(-1.1, top, 0.22)));
    let tuft = Tuft { leaves: 60, length: 0.6, width: 0.05, seed: 511, material: paints.leaf };
    all.push(tuft.part().at(vec3(-1.1, top + 0.36, 0.22)));
    all.push_at(&cup(paints), along(vec3(0.2, top, 0.15), vec3(0.9, top, 0.15), 5));
    all.push_at(&glass(paints), along(vec3(0.25, top, 0.32), vec3(0.85, top, 0.32), 6));
    let jug = [
        [0.05, 0.0],
        [0.07, 0.02],
        [0.08, 0.1],
        [0.05, 0.2],
        [0.055, 0.24],
        [0.05, 0.24],
        [0.045, 0.2],
        [0.07, 0.1],
        [0.06, 0.03],
        [0.0, 0.025],
    ];
    all.push(lathe(&points(&jug), 36, paints.steel).at(vec3(1.2, top, 0.22)));
    all
}

/// Shelves full of books, along z = 0, facing +z.
pub(super) fn bookcase(paints: &Paints) -> Part {
    let (half, height, depth) = (0.95, 2.1, 0.32);
    let mut all = cuboid(vec3(-half, 0.0, 0.0), vec3(half, height, 0.02), paints.veneer);
    for side in [-1.0f32, 1.0] {
        let x = side * (half - 0.015);
        all.push(cuboid(vec3(x - 0.016, 0.0, 0.01), vec3(x + 0.016, height + 0.004, depth), paints.veneer));
    }
    let shelf =
        cuboid(vec3(-half + 0.01, -0.025, 0.01), vec3(half - 0.01, 0.0, depth - 0.005), paints.veneer);
    all.push_at(&shelf, (0..7).map(|i| Vec3::Y * (0.085 + 0.335 * i as f32)));
    for level in 0..6u32 {
        let mut x = -half + 0.04;
        let mut book = 0;
        let gap = chance(level, 0, 521);
        while x < half - 0.1 {
            let pick = |i: u32| chance(level, 8 * book + i, 523);
            let (thick, tall, deep) = (0.02 + 0.035 * pick(0), 0.19 + 0.09 * pick(1), 0.16 + 0.07 * pick(2));
            if (x / half - (1.6 * gap - 0.8)).abs() > 0.12 {
                let cover = paints.books[(pick(3) * paints.books.len() as f32) as usize];
                let floor = 0.085 + 0.335 * level as f32;
                let body = bevelled(
                    vec3(x, floor - 0.001, 0.03),
                    vec3(x + thick, floor + tall, 0.03 + deep),
                    0.003,
                    cover,
                );
                all.push(body);
            }
            x += thick + 0.002;
            book += 1;
        }
    }
    all
}

/// A tub with a large plant.
pub(super) fn potted_plant(paints: &Paints) -> Part {
    let tub = [[0.2, 0.0], [0.22, 0.02], [0.26, 0.42], [0.24, 0.43], [0.23, 0.4], [0.0, 0.39]];
    let tuft = Tuft { leaves: 90, length: 1.25, width: 0.11, seed: 531, material: paints.leaf };
    lathe(&points(&tub), 40, paints.china).and(tuft.part().at(Vec3::Y * 0.4))
}
