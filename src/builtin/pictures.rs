//! Pictures for the walls.

use glam::{Vec2, Vec3, Vec4, vec2, vec3};

use super::noise::{chance, fractal, ramp};
use super::palette::Recipe;

/// Hills in the evening.
pub(super) const HILLS: Recipe = Recipe { name: "hills", size: [256, 256], extent: [1.0, 1.0], paint: hills };
/// Squares of paint.
pub(super) const SQUARES: Recipe =
    Recipe { name: "squares", size: [256, 256], extent: [1.0, 1.0], paint: squares };

fn hills(place: Vec2) -> Vec4 {
    let sun = ramp(0.11, 0.1, place.distance(vec2(0.68, 0.36)));
    let sky = vec3(0.12, 0.22, 0.45).lerp(vec3(0.75, 0.4, 0.18), place.y * 1.6);
    let mut colour = sky.lerp(vec3(0.85, 0.62, 0.2), sun);
    for ridge in 0..4u32 {
        let depth = ridge as f32 / 3.0;
        let line = 0.42 + 0.16 * ridge as f32
            - 0.2 * (fractal(vec2(place.x, 0.37 * ridge as f32), 2, 4, 601 + ridge) - 0.35);
        let earth = vec3(0.3, 0.24, 0.4).lerp(vec3(0.05, 0.13, 0.06), depth);
        colour = colour.lerp(earth, ramp(line, line + 0.006, place.y));
    }
    (colour * (0.85 + 0.3 * fractal(place * vec2(1.0, 3.0), 16, 3, 611))).extend(1.0)
}

fn squares(place: Vec2) -> Vec4 {
    let colours =
        [[0.6, 0.12, 0.08], [0.75, 0.6, 0.2], [0.1, 0.2, 0.42], [0.72, 0.7, 0.62], [0.12, 0.32, 0.26]];
    let mut colour = Vec3::new(0.7, 0.67, 0.58);
    for i in 0..14 {
        let pick = |k: u32| chance(i, k, 621);
        let middle = vec2(pick(0), pick(1));
        let half = vec2(0.05 + 0.16 * pick(2), 0.05 + 0.12 * pick(3));
        let outside = ((place - middle).abs() - half).max_element();
        let paint = Vec3::from_array(colours[(pick(4) * 5.0) as usize % 5]);
        colour = colour.lerp(paint, 0.9 * ramp(0.004, -0.004, outside));
    }
    (colour * (0.85 + 0.3 * fractal(place, 24, 3, 631))).extend(1.0)
}
