//! The upper storey of the atrium and its roof.
//!
//! In: materials and a column. Out: one side of the gallery, in the frame of `atrium_plan::sides`, and the roof.

use glam::{Vec2, Vec3, vec2, vec3};

use super::atrium_plan::{BAY, DEPTH, HALF, HALF_WALL, Paints, TOP, UPPER, bay_middles, column_places, ring};
use super::columns::{Column, along, baluster, pedestal};
use super::part::Part;
use super::paths::{points, strip};
use super::shapes::cuboid;
use super::walls::{Opening, Panel, cornice, pierced, straight};

/// Top of the columns.
pub(super) const SPRING: f32 = 7.75;
/// Height of the parapet above the floor.
const PARAPET: f32 = 0.95;

/// The slender columns; every other one is above the centre of a bay of the arcade.
pub(super) fn column(paints: &Paints, segments: u32) -> Column {
    Column {
        height: SPRING - UPPER - PARAPET,
        radius: 0.16,
        segments,
        materials: [paints.column, paints.trim],
    }
}

/// One side of the gallery: parapet, columns, pairs of arches, and the wall behind with its blind windows.
pub(super) fn side(paints: &Paints, column: &Part, bays: u32) -> Part {
    let mut all = Part::default();
    let half_bay = 0.5 * BAY;
    let feet: Vec<Vec3> = column_places(bays).chain(bay_middles(bays)).map(|x| vec3(x, UPPER, 0.0)).collect();
    all.push_at(column, feet.iter().map(|foot| *foot + Vec3::Y * PARAPET));
    all.push_at(&pedestal(0.24, PARAPET, paints.trim), feet);
    // Between two pedestals: balusters between a foot and a rail.
    let width = half_bay - 0.46;
    let rail = cuboid(vec3(-0.5 * width, 0.8, -0.13), vec3(0.5 * width, 0.93, 0.13), paints.trim);
    let foot = cuboid(vec3(-0.5 * width, -0.02, -0.12), vec3(0.5 * width, 0.1, 0.12), paints.trim);
    let mut parapet = rail.and(foot);
    let reach = 0.5 * width - 0.11;
    parapet.push_at(
        &baluster(0.72, 0.085, 6, paints.trim),
        along(vec3(-reach, 0.09, 0.0), vec3(reach, 0.09, 0.0), 4),
    );
    let opening = Opening { middle: 0.0, half: 0.6, sill: SPRING, spring: SPRING, rise: 0.6, steps: 10 };
    let wall = 0.7 * HALF_WALL;
    let panel = Panel {
        min: vec2(-0.5 * half_bay, SPRING),
        max: vec2(0.5 * half_bay, TOP - 0.02),
        depth: [-wall, wall],
    };
    let profile: Vec<Vec2> = points(&[[-0.015, -0.04], [0.15, -0.04], [0.15, 0.05], [-0.015, 0.03]]);
    let half_of_bay = pierced(&panel, &opening, paints.wall)
        .and(opening.moulding(&profile, wall, paints.trim))
        .and(parapet.at(Vec3::Y * UPPER));
    let middles = bay_middles(bays).flat_map(|x| [x - 0.5 * half_bay, x + 0.5 * half_bay]);
    all.push_at(&half_of_bay, middles.map(|x| vec3(x, 0.0, 0.0)));
    all.push(back_wall(paints, bays));
    all
}

/// Windows with closed shutters, and beams under the ceiling.
fn back_wall(paints: &Paints, bays: u32) -> Part {
    let mut all = Part::default();
    let opening = Opening { middle: 0.0, half: 0.55, sill: 1.2, spring: 2.3, rise: 0.55, steps: 8 };
    let profile: Vec<Vec2> = points(&[[0.0, -0.05], [0.2, -0.05], [0.2, 0.05], [0.14, 0.09], [0.0, 0.09]]);
    let mut window = opening
        .moulding(&profile, 0.0, paints.trim)
        .and(opening.filling(0.05, [-0.05, 0.02], paints.door))
        .and(straight(-0.85, 0.85, &strip(vec2(-0.05, 1.08), vec2(0.18, 1.2)), paints.trim));
    // Slats of the shutters.
    let slat = cuboid(vec3(-0.24, -0.05, 0.0), vec3(0.24, 0.05, 0.045), paints.door);
    for side in [-0.27, 0.27] {
        window.push_at(&slat, along(vec3(side, 1.3, 0.0), vec3(side, 2.22, 0.0), 7));
    }
    all.push_at(&window, bay_middles(bays).map(|x| vec3(x, UPPER, -DEPTH)));
    let beam = cuboid(vec3(-0.09, -0.26, -DEPTH - 0.05), vec3(0.09, 0.02, -0.1), paints.timber);
    let beams = bay_middles(bays).flat_map(|x| [-0.375, -0.125, 0.125, 0.375].map(|share| x + share * BAY));
    all.push_at(&beam, beams.map(|x| vec3(x, TOP - 0.1, 0.0)));
    all
}

/// Ceiling of the gallery and the tiled roof over it, which slopes towards the court.
pub(super) fn roof(paints: &Paints) -> Part {
    let outer = HALF + DEPTH + 0.6;
    let width = DEPTH + 0.6 + 0.75;
    let slope = points(&[[0.0, 1.7], [0.0, 0.2], [width - 0.1, 0.1], [width, 0.14], [width, 0.24]]);
    ring(HALF - 0.1, HALF + DEPTH + 0.05, [TOP - 0.1, TOP + 0.15], paints.plaster)
        .and(cornice(outer.x, outer.y, &slope, paints.roof).at(Vec3::Y * TOP))
}
