//! Textures of stone, brick, plaster and tiles.
//!
//! In: a point in the unit square. Out: linear colour, periodic over the square.

use glam::{UVec2, Vec2, Vec3, Vec4, vec2, vec3};

use super::noise::{chance, fractal, ramp, warped};
use super::palette::Recipe;

/// Blocks of pale limestone, 40 x 80 cm.
pub(super) const ASHLAR: Recipe =
    Recipe { name: "ashlar", size: [512, 512], extent: [2.4, 2.4], paint: ashlar };
/// Bricks, 6.7 x 20 cm.
pub(super) const BRICK: Recipe = Recipe { name: "brick", size: [512, 512], extent: [1.6, 1.6], paint: brick };
/// Smooth stone without joints.
pub(super) const LIMESTONE: Recipe =
    Recipe { name: "limestone", size: [256, 256], extent: [1.5, 1.5], paint: limestone };
/// Old plaster.
pub(super) const PLASTER: Recipe =
    Recipe { name: "plaster", size: [256, 256], extent: [3.0, 3.0], paint: plaster };
/// Large worn flags, 60 cm.
pub(super) const PAVING: Recipe =
    Recipe { name: "paving", size: [512, 512], extent: [2.4, 2.4], paint: paving };
/// Terracotta tiles, 30 cm.
pub(super) const TERRACOTTA: Recipe =
    Recipe { name: "terracotta", size: [512, 512], extent: [1.8, 1.8], paint: terracotta };
/// White marble with grey veins.
pub(super) const WHITE_MARBLE: Recipe =
    Recipe { name: "white marble", size: [512, 512], extent: [2.0, 2.0], paint: white_marble };
/// White and dark green marble in squares of 75 cm.
pub(super) const MARBLE_FLOOR: Recipe =
    Recipe { name: "marble floor", size: [512, 512], extent: [3.0, 3.0], paint: marble_floor };
/// Barrel tiles of a roof, 20 cm wide.
pub(super) const ROOF_TILES: Recipe =
    Recipe { name: "roof tiles", size: [256, 256], extent: [1.2, 1.2], paint: roof_tiles };

/// A point's position in a bond of courses.
struct Bond {
    /// Index of the block.
    block: UVec2,
    /// Distance to the nearest joint, metres.
    joint: f32,
}

/// `blocks` in each of `courses`, every other course offset by half a block, on a square of `size` metres.
fn bond(place: Vec2, [blocks, courses]: [u32; 2], size: f32) -> Bond {
    let course = (place.y * courses as f32).floor();
    let shift = if course as u32 % 2 == 1 { 0.5 } else { 0.0 };
    let x = place.x * blocks as f32 + shift;
    let cell = vec2(x.floor(), course);
    let inside = vec2(x - cell.x, place.y * courses as f32 - cell.y);
    let from_edge = (0.5 - (inside - 0.5).abs()) * vec2(size / blocks as f32, size / courses as f32);
    Bond {
        block: UVec2::new(cell.x as u32 % blocks, cell.y as u32 % courses),
        joint: from_edge.min_element(),
    }
}

fn opaque(colour: Vec3) -> Vec4 {
    colour.max(Vec3::ZERO).extend(1.0)
}

fn ashlar(place: Vec2) -> Vec4 {
    let Bond { block, joint } = bond(place, [3, 6], 2.4);
    let tone = 0.8 + 0.3 * chance(block.x, block.y, 1);
    let warm = chance(block.x, block.y, 2);
    let grain = 0.72 + 0.56 * fractal(place, 8, 5, 3);
    let stone = vec3(0.60, 0.52, 0.41).lerp(vec3(0.57, 0.45, 0.34), warm) * tone * grain;
    let pits = 1.0 - 0.25 * ramp(0.68, 0.8, fractal(place, 40, 3, 11));
    let worn = 0.003 + 0.006 * fractal(place, 24, 2, 17);
    opaque(vec3(0.34, 0.30, 0.25).lerp(stone * pits, ramp(worn, worn + 0.006, joint)))
}

fn brick(place: Vec2) -> Vec4 {
    let Bond { block, joint } = bond(place, [8, 24], 1.6);
    let pick = chance(block.x, block.y, 5);
    let tone = (0.7 + 0.5 * chance(block.x, block.y, 6)) * (0.75 + 0.5 * fractal(place, 16, 4, 7));
    let clay = vec3(0.40, 0.155, 0.09).lerp(vec3(0.48, 0.25, 0.14), pick) * tone;
    let mortar = vec3(0.42, 0.38, 0.33) * (0.8 + 0.4 * fractal(place, 32, 3, 9));
    opaque(mortar.lerp(clay, ramp(0.003, 0.008, joint)))
}

fn limestone(place: Vec2) -> Vec4 {
    let clouds = fractal(place, 4, 5, 21);
    let streaks = fractal(warped(place, 3, 0.2, 25), 6, 3, 29);
    opaque(vec3(0.66, 0.60, 0.51) * (0.78 + 0.3 * clouds + 0.12 * streaks))
}

fn plaster(place: Vec2) -> Vec4 {
    let clouds = fractal(place, 3, 5, 31);
    let stain = ramp(0.55, 0.75, fractal(warped(place, 4, 0.15, 35), 3, 4, 37));
    opaque(vec3(0.72, 0.66, 0.56).lerp(vec3(0.62, 0.52, 0.40), stain) * (0.85 + 0.25 * clouds))
}

fn paving(place: Vec2) -> Vec4 {
    let Bond { block, joint } = bond(place, [4, 4], 2.4);
    let tone = 0.78 + 0.34 * chance(block.x, block.y, 41);
    let tint = chance(block.x, block.y, 42);
    let grain = 0.75 + 0.5 * fractal(place, 8, 5, 43);
    let stone = vec3(0.52, 0.47, 0.40).lerp(vec3(0.50, 0.41, 0.36), tint) * tone * grain;
    let scratches = 1.0 - 0.15 * ramp(0.62, 0.7, fractal(place * vec2(1.0, 4.0), 12, 3, 47));
    opaque(vec3(0.2, 0.18, 0.15).lerp(stone * scratches, ramp(0.004, 0.012, joint)))
}

fn terracotta(place: Vec2) -> Vec4 {
    let Bond { block, joint } = bond(place, [6, 6], 1.8);
    let tone = (0.72 + 0.5 * chance(block.x, block.y, 51)) * (0.8 + 0.4 * fractal(place, 12, 4, 53));
    let clay = vec3(0.46, 0.21, 0.12).lerp(vec3(0.5, 0.29, 0.17), chance(block.x, block.y, 52)) * tone;
    opaque(vec3(0.33, 0.28, 0.23).lerp(clay, ramp(0.003, 0.008, joint)))
}

/// Strength of the marble's veins, 0 to 1.
fn vein(place: Vec2, cells: u32, width: f32, seed: u32) -> f32 {
    let wave = fractal(warped(place, cells, 0.35, seed), cells, 5, seed + 3);
    1.0 - ramp(0.0, width, (wave - 0.5).abs())
}

fn white_marble(place: Vec2) -> Vec4 {
    let clouds = fractal(place, 4, 5, 61);
    let veins = 0.7 * vein(place, 3, 0.035, 63) + 0.35 * vein(place, 6, 0.03, 71);
    opaque(vec3(0.80, 0.78, 0.74).lerp(vec3(0.38, 0.38, 0.40), veins.min(1.0)) * (0.86 + 0.2 * clouds))
}

fn marble_floor(place: Vec2) -> Vec4 {
    let Bond { joint, .. } = bond(place, [1, 4], 3.0);
    let cell = (place * 4.0).floor();
    let inside = place * 4.0 - cell;
    let side = 0.75 * (0.5 - (inside.x - 0.5).abs());
    let white = ((cell.x + cell.y) as u32).is_multiple_of(2);
    // Each slab is cut from another part of the quarry.
    let slab =
        place + vec2(chance(cell.x as u32, cell.y as u32, 81), chance(cell.y as u32, cell.x as u32, 83));
    let colour = if white {
        white_marble(slab).truncate()
    } else {
        let veins = vein(slab, 5, 0.05, 85);
        vec3(0.055, 0.095, 0.075).lerp(vec3(0.3, 0.38, 0.33), 0.6 * veins)
    };
    opaque(vec3(0.25, 0.24, 0.22).lerp(colour, ramp(0.001, 0.006, side.min(joint))))
}

fn roof_tiles(place: Vec2) -> Vec4 {
    let cell = (place * vec2(6.0, 4.0)).floor();
    let inside = place * vec2(6.0, 4.0) - cell;
    let round = 1.0 - 1.6 * (inside.x - 0.5) * (inside.x - 0.5) * 2.0;
    let lap = 0.55 + 0.45 * ramp(0.0, 0.15, inside.y);
    let tone = 0.7 + 0.5 * chance(cell.x as u32, cell.y as u32, 91);
    opaque(vec3(0.44, 0.2, 0.11) * (round * lap * tone * (0.8 + 0.4 * fractal(place, 12, 4, 93))))
}

/// Pieces of coloured glass between bars of lead.
pub(super) const STAINED_GLASS: Recipe =
    Recipe { name: "stained glass", size: [256, 256], extent: [1.2, 1.2], paint: stained_glass };

fn stained_glass(place: Vec2) -> Vec4 {
    const CELLS: u32 = 12;
    let cell = (place * CELLS as f32).floor();
    let (mut nearest, mut second, mut owner) = (f32::MAX, f32::MAX, 0.0);
    for step in 0..9 {
        let there = cell + vec2((step % 3) as f32 - 1.0, (step / 3) as f32 - 1.0);
        let wrapped = there.rem_euclid(Vec2::splat(CELLS as f32)).as_uvec2();
        let pick = |seed: u32| chance(wrapped.x, wrapped.y, seed);
        let distance = (there + 0.15 + 0.7 * vec2(pick(141), pick(142)) - place * CELLS as f32).length();
        if distance < nearest {
            (second, nearest, owner) = (nearest, distance, pick(143));
        } else {
            second = second.min(distance);
        }
    }
    let colours =
        [[0.62, 0.05, 0.05], [0.05, 0.12, 0.6], [0.75, 0.5, 0.08], [0.06, 0.4, 0.12], [0.6, 0.62, 0.6]];
    let colour = Vec3::from_array(colours[(owner * 5.0) as usize % 5]);
    let lead = Vec3::splat(0.03);
    opaque(lead.lerp(colour * (0.7 + 0.6 * fractal(place, 16, 2, 145)), ramp(0.03, 0.09, second - nearest)))
}
