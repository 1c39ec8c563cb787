//! The atrium: two storeys of colonnades around an open court.
//!
//! In: materials and the columns to use. Out: the building. x runs along the court, y up; metres.

use glam::{Vec2, Vec3, vec2, vec3};

use super::atrium_plan::{
    BAY, DEPTH, HALF, HALF_WALL, Paints, SPRING, STEP, TOP, UPPER, bay_middles, column_places, ring, sides,
};
use super::atrium_upper;
use super::columns::{Column, along};
use super::part::Part;
use super::paths::{arc, points, strip};
use super::shapes::{block, cuboid};
use super::vault::Vault;
use super::walls::{Opening, Panel, cornice, pierced, straight};

/// The column of the lower arcade.
pub(super) fn lower_column(paints: &Paints, segments: u32) -> Column {
    Column { height: SPRING - STEP, radius: 0.27, segments, materials: [paints.column, paints.trim] }
}

/// The whole building with these columns, below and above.
pub(super) fn building(paints: &Paints, columns: [&Part; 2]) -> Part {
    let mut all = floors(paints);
    for (place, bays) in sides() {
        all.push(lower_side(paints, columns[0], bays).placed(&place));
        all.push(atrium_upper::side(paints, columns[1], bays).placed(&place));
    }
    all.push(corner_piers(paints));
    all.push(vaults(paints));
    all.push(string_courses(paints));
    all.push(outer_walls(paints));
    all.push(atrium_upper::roof(paints));
    all.push(well(paints));
    all
}

fn floors(paints: &Paints) -> Part {
    let edge = HALF + HALF_WALL + 0.12;
    let wall = HALF + DEPTH + 0.05;
    let ground = wall + 0.6;
    let curb = [[0.0, -0.1], [0.36, -0.1], [0.36, 0.1], [0.33, STEP + 0.005], [0.0, STEP + 0.005]];
    cuboid(vec3(-ground.x, -0.5, -ground.y), vec3(ground.x, 0.0, ground.y), paints.court)
        .and(ring(edge - 0.8, wall, [-0.05, STEP], paints.tiles))
        .and(cornice(edge.x - 0.72, edge.y - 0.72, &points(&curb), paints.trim))
        .and(ring(HALF - 0.25, wall, [UPPER - 0.45, UPPER], paints.tiles))
}

/// One side of the lower arcade, with pilasters and doors in the wall behind it.
fn lower_side(paints: &Paints, column: &Part, bays: u32) -> Part {
    let mut all = Part::default();
    let half = 0.5 * BAY * bays as f32;
    all.push_at(column, column_places(bays).map(|x| vec3(x, STEP, 0.0)));
    let opening = Opening { middle: 0.0, half: 1.27, sill: SPRING, spring: SPRING, rise: 1.27, steps: 16 };
    let panel = Panel {
        min: vec2(-0.5 * BAY, SPRING),
        max: vec2(0.5 * BAY, UPPER - 0.1),
        depth: [-HALF_WALL, HALF_WALL],
    };
    let bay = pierced(&panel, &opening, paints.wall);
    let archivolt: Vec<Vec2> =
        points(&[[-0.02, -0.05], [0.26, -0.05], [0.26, 0.05], [0.18, 0.075], [-0.02, 0.02]]);
    let arches = opening.moulding(&archivolt, HALF_WALL, paints.trim);
    let keystone = block(vec3(0.22, 0.5, 2.0 * HALF_WALL + 0.22), paints.trim).at(vec3(
        0.0,
        SPRING + opening.rise - 0.06,
        0.0,
    ));
    let all_of_bay = bay.and(arches).and(keystone);
    all.push_at(&all_of_bay, bay_middles(bays).map(|x| vec3(x, 0.0, 0.0)));
    all.push(lower_wall(paints, bays, half));
    all
}

/// Pilasters, plinth and doors of the outer wall behind a side.
fn lower_wall(paints: &Paints, bays: u32, half: f32) -> Part {
    let mut all = Part::default();
    let wall = -DEPTH;
    let pilaster = cuboid(vec3(-0.26, 0.0, wall - 0.05), vec3(0.26, SPRING - 0.3, wall + 0.14), paints.trim)
        .and(cuboid(vec3(-0.32, 0.0, wall - 0.05), vec3(0.32, 0.55, wall + 0.2), paints.trim))
        .and(cuboid(
            vec3(-0.32, SPRING - 0.34, wall - 0.05),
            vec3(0.32, SPRING - 0.1, wall + 0.2),
            paints.trim,
        ));
    let places = column_places(bays).chain([-half, half]);
    all.push_at(&pilaster, places.map(|x| vec3(x, 0.0, 0.0)));
    let door = door(paints);
    let doors = bay_middles(bays).enumerate().filter(|(i, _)| i % 2 == 1).map(|(_, x)| vec3(x, STEP, wall));
    all.push_at(&door, doors);
    all
}

/// A door of two panelled leaves under a fanlight, in a frame of stone, before the wall z = 0.
fn door(paints: &Paints) -> Part {
    let opening = Opening { middle: 0.0, half: 0.72, sill: -0.02, spring: 2.15, rise: 0.0, steps: 2 };
    let profile: Vec<Vec2> =
        points(&[[0.0, -0.05], [0.22, -0.05], [0.22, 0.18], [0.14, 0.18], [0.1, 0.14], [0.0, 0.14]]);
    let mut all = opening.moulding(&profile, 0.0, paints.trim);
    all.push(straight(-1.05, 1.05, &strip(vec2(-0.05, 2.4), vec2(0.26, 2.5)), paints.trim));
    for side in [-1.0, 1.0] {
        all.push(cuboid(
            vec3(0.36 * side - 0.355, -0.02, -0.05),
            vec3(0.36 * side + 0.355, 2.17, 0.1),
            paints.door,
        ));
        for [low, high] in [[0.15, 0.85], [1.05, 2.03]] {
            let half = vec3(0.26, 0.0, 0.0);
            let middle = vec3(0.36 * side, 0.0, 0.0);
            let [low, high] = [middle - half + Vec3::Y * low, middle + half + vec3(0.0, high, 0.125)];
            all.push(super::shapes::bevelled(low, high, 0.02, paints.door));
        }
        let knob = super::shapes::cushion(Vec3::splat(0.035), 1.0, [6, 4], paints.bronze);
        all.push(knob.at(vec3(0.07 * side, 1.05, 0.13)));
    }
    all
}

/// Square piers in the corners of the court, through both storeys.
fn corner_piers(paints: &Paints) -> Part {
    let half = HALF_WALL + 0.06;
    let pier = cuboid(vec3(-half, 0.0, -half), vec3(half, TOP - 0.01, half), paints.wall);
    let band = |low: f32, high: f32, wider: f32| {
        let side = half + wider;
        super::shapes::bevelled(vec3(-side, low, -side), vec3(side, high, side), 0.03, paints.trim)
    };
    let pier = pier
        .and(band(0.0, 0.5, 0.07))
        .and(band(SPRING - 0.2, SPRING + 0.02, 0.08))
        .and(band(UPPER, UPPER + 0.3, 0.06))
        .and(band(atrium_upper::SPRING - 0.14, atrium_upper::SPRING + 0.02, 0.07));
    let mut all = Part::default();
    let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    all.push_at(&pier, corners.map(|[x, z]| vec3(x * HALF.x, 0.0, z * HALF.y)));
    all
}

/// Groin vaults over the lower gallery, with arches between the bays.
fn vaults(paints: &Paints) -> Part {
    let vault =
        Vault { half: vec2(0.5 * BAY, 0.5 * DEPTH), spring: SPRING - 0.1, rise: 1.45, point: 1.0, steps: 8 };
    let corner = Vault { half: Vec2::splat(0.5 * DEPTH), ..vault };
    let top = UPPER - 0.44;
    let block = vault.block(top, paints.plaster);
    let rib = vault.cross_rib(&strip(vec2(-0.2, -0.14), vec2(0.2, 0.1)), 12, paints.trim);
    let mut all = Part::default();
    for (place, bays) in sides() {
        let mut side = Part::default();
        let back = vec3(0.0, 0.0, -0.5 * DEPTH);
        side.push_at(&block, bay_middles(bays).map(|x| back + Vec3::X * x));
        let half = 0.5 * BAY * bays as f32;
        side.push_at(&rib, column_places(bays).chain([-half, half]).map(|x| back + Vec3::X * x));
        all.push(side.placed(&place));
    }
    let middle = HALF + 0.5 * DEPTH;
    let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    all.push_at(
        &corner.block(top, paints.plaster),
        corners.map(|[x, z]| vec3(x * middle.x, 0.0, z * middle.y)),
    );
    all
}

/// The moulding under the upper floor and the cornice on top of the walls.
fn string_courses(paints: &Paints) -> Part {
    let out = HALF - HALF_WALL;
    let mut low = vec![vec2(-0.1, UPPER - 0.5), vec2(0.05, UPPER - 0.5)];
    low.extend(arc(vec2(0.05, UPPER - 0.34), 0.1, [-90.0, 0.0], 3));
    low.extend([[0.2, -0.22], [0.26, -0.1], [0.26, 0.02], [-0.1, 0.02]].map(|p| vec2(p[0], UPPER + p[1])));
    let mut high = vec![vec2(-0.1, TOP - 0.5), vec2(0.06, TOP - 0.5), vec2(0.06, TOP - 0.36)];
    high.extend(arc(vec2(0.3, TOP - 0.36), 0.22, [180.0, 90.0], 4));
    high.extend([[0.44, -0.1], [0.5, 0.0], [0.5, 0.08], [-0.1, 0.08]].map(|p| vec2(p[0], TOP + p[1])));
    cornice(out.x, out.y, &low, paints.trim).and(cornice(out.x, out.y, &high, paints.trim))
}

/// The outer walls: brick on a stone floor.
fn outer_walls(paints: &Paints) -> Part {
    let inner = HALF + DEPTH;
    let plinth = [[-0.05, 0.0], [0.08, 0.0], [0.08, 0.42], [0.03, 0.48], [-0.05, 0.48]];
    let dado = [[-0.05, -0.02], [0.05, -0.02], [0.05, 0.9], [0.09, 0.94], [0.09, 1.0], [-0.05, 1.0]];
    let feet = cornice(inner.x, inner.y, &points(&plinth), paints.trim)
        .and(cornice(inner.x, inner.y, &points(&dado), paints.plaster).at(Vec3::Y * UPPER));
    feet.and(ring(inner, inner + 0.5, [-0.1, UPPER - 0.2], paints.wall)).and(ring(
        inner,
        inner + 0.5,
        [UPPER - 0.2, TOP + 0.2],
        paints.brick,
    ))
}

/// A well with a stone basin in the centre of the court.
fn well(paints: &Paints) -> Part {
    let basin = [
        [1.15, -0.05],
        [1.15, 0.14],
        [1.0, 0.2],
        [0.95, 0.28],
        [0.95, 0.6],
        [1.05, 0.66],
        [1.1, 0.78],
        [0.86, 0.8],
        [0.84, 0.74],
        [0.84, 0.3],
        [0.0, 0.3],
    ];
    let bowl = [
        [0.3, 0.28],
        [0.3, 0.4],
        [0.16, 0.5],
        [0.13, 0.9],
        [0.2, 1.1],
        [0.45, 1.25],
        [0.62, 1.4],
        [0.6, 1.44],
        [0.4, 1.34],
        [0.0, 1.3],
    ];
    let surface = [[0.86, 0.31], [0.86, 0.62]];
    let step = block(vec3(2.9, 0.12, 2.9), paints.trim);
    let mut all = super::shapes::lathe(&points(&basin), 32, paints.trim)
        .and(super::shapes::lathe(&points(&bowl), 24, paints.trim))
        .and(super::shapes::lathe(&points(&surface), 32, paints.water))
        .at(Vec3::Y * 0.1)
        .and(step.at(Vec3::NEG_Y * 0.02));
    let knob = super::shapes::cushion(vec3(0.1, 0.14, 0.1), 1.0, [16, 10], paints.bronze);
    all.push_at(&knob, along(vec3(0.0, 1.5, 0.0), vec3(0.0, 1.5, 0.0), 1));
    all
}
