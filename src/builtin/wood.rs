//! Textures of wood.

use glam::{Vec2, Vec3, Vec4, vec2, vec3};

use super::noise::{chance, fractal, ramp};
use super::palette::Recipe;

/// Boards with their grain along x, 20 cm wide.
pub(super) const TIMBER: Recipe =
    Recipe { name: "timber", size: [512, 256], extent: [1.6, 0.8], paint: timber };
/// Polished veneer, its grain along x.
pub(super) const VENEER: Recipe =
    Recipe { name: "veneer", size: [512, 256], extent: [2.4, 1.2], paint: veneer };

/// Dark lines along x.
fn grain(place: Vec2, seed: u32) -> f32 {
    let bent = place + vec2(0.0, 0.03 * fractal(place, 4, 2, seed));
    let rings = fractal(bent * vec2(1.0, 8.0), 3, 4, seed + 3);
    let pores = fractal(place * vec2(2.0, 32.0), 8, 2, seed + 7);
    0.65 * rings + 0.35 * pores
}

fn opaque(colour: Vec3) -> Vec4 {
    colour.extend(1.0)
}

fn timber(place: Vec2) -> Vec4 {
    let board = (place.y * 4.0).floor();
    let inside = place.y * 4.0 - board;
    let tone = 0.75 + 0.4 * chance(board as u32, 3, 101);
    let own = place + vec2(chance(board as u32, 5, 103), 0.0);
    let wood = vec3(0.17, 0.085, 0.04).lerp(vec3(0.42, 0.25, 0.13), grain(own, 105)) * tone;
    opaque(wood * (0.35 + 0.65 * ramp(0.0, 0.05, 0.5 - (inside - 0.5).abs())))
}

fn veneer(place: Vec2) -> Vec4 {
    opaque(vec3(0.30, 0.15, 0.07).lerp(vec3(0.52, 0.31, 0.16), grain(place, 121)))
}
