//! Textures of cloth, and of leaves with alpha masks.

use std::f32::consts::{PI, TAU};

use glam::{Vec2, Vec3, Vec4, vec2, vec3};

use super::noise::{chance, fractal, ramp};
use super::palette::Recipe;

/// Woven damask in greys, to be tinted.
pub(super) const DAMASK: Recipe =
    Recipe { name: "damask", size: [256, 256], extent: [0.5, 0.5], paint: damask };
/// One long leaf that grows upwards.
pub(super) const LEAF: Recipe = Recipe { name: "leaf", size: [64, 256], extent: [1.0, 1.0], paint: leaf };
/// A spray of ivy.
pub(super) const IVY: Recipe = Recipe { name: "ivy", size: [256, 256], extent: [1.0, 1.0], paint: ivy };
/// Red carpet with a golden border; one period across, periodic along.
pub(super) const CARPET: Recipe =
    Recipe { name: "carpet", size: [256, 256], extent: [2.6, 2.6], paint: carpet };
/// Short pile in blue-grey, in tiles.
pub(super) const PILE: Recipe = Recipe { name: "pile", size: [256, 256], extent: [1.0, 1.0], paint: pile };
/// Plain weave, nearly white, to be tinted.
pub(super) const WEAVE: Recipe = Recipe { name: "weave", size: [128, 128], extent: [0.2, 0.2], paint: weave };

/// A tile of the ornament: a pointed oval around a flower, from 0 (ground) to 1 (figure).
fn ornament(place: Vec2) -> f32 {
    let centred = place - place.floor() - 0.5;
    let oval = (centred.x.abs() - 0.42 * (PI * (centred.y + 0.5)).sin()).abs();
    let (radius, angle) = (centred.length(), centred.y.atan2(centred.x));
    let flower = radius - 0.16 - 0.05 * (6.0 * angle).cos();
    let heart = (radius - 0.05).abs() - 0.015;
    let inside = ramp(0.02, -0.02, flower) * ramp(-0.01, 0.01, heart);
    inside.max(ramp(0.05, 0.02, oval))
}

fn threads(place: Vec2, count: f32) -> f32 {
    let (warp, weft) = ((TAU * count * place.x).sin(), (TAU * count * place.y).sin());
    0.5 + 0.25 * (warp + weft)
}

fn damask(place: Vec2) -> Vec4 {
    let figure = ornament(place).max(ornament(place + 0.5));
    let tone = 0.62 + 0.38 * figure;
    Vec3::splat(tone * (0.85 + 0.15 * threads(place, 64.0))).extend(1.0)
}

fn weave(place: Vec2) -> Vec4 {
    Vec3::splat((0.8 + 0.2 * threads(place, 32.0)) * (0.9 + 0.1 * fractal(place, 8, 3, 151))).extend(1.0)
}

fn leaf(place: Vec2) -> Vec4 {
    let t = 1.0 - place.y;
    let across = (place.x - 0.5).abs() * 2.0;
    let width = 0.92 * (PI * (0.04 + 0.96 * t).powf(0.8)).sin().max(0.0);
    let rib = ramp(0.07, 0.02, across);
    let side_ribs = ramp(0.75, 0.95, (TAU * (9.0 * t - 2.0 * across)).cos());
    let green =
        vec3(0.06, 0.19, 0.035).lerp(vec3(0.17, 0.33, 0.07), 0.6 * t + 0.4 * fractal(place, 6, 3, 161));
    let colour = green.lerp(vec3(0.3, 0.42, 0.14), (0.8 * rib).max(0.25 * side_ribs));
    colour.extend(if across < width { 1.0 } else { 0.0 })
}

/// Whether `place` is on an ivy leaf at the origin that points down, and its distance from the rib.
fn ivy_leaf(place: Vec2) -> Option<f32> {
    let (radius, angle) = (place.length(), place.x.atan2(-place.y));
    // Five lobes, the one that points down the longest.
    let lobes = 0.62 + 0.28 * (2.5 * angle).cos().abs() + 0.25 * (0.5 * angle).cos().powi(8);
    let notch = 1.0 - 0.75 * ramp(2.7, 3.1, angle.abs());
    (radius < 0.5 * lobes * notch).then(|| (2.5 * angle).sin().abs() * radius)
}

fn ivy(place: Vec2) -> Vec4 {
    let mut colour = vec3(0.06, 0.14, 0.04);
    let mut opacity = 0.0;
    for i in 0..7 {
        let (x, y, z) = (chance(i, 1, 171), chance(i, 2, 171), chance(i, 3, 171));
        let middle = vec2(0.2 + 0.6 * x, (i as f32 + 0.8 + 0.3 * y) / 8.2);
        let size = 0.2 + 0.08 * z;
        let turned = Vec2::from_angle(1.6 * (z - 0.5)).rotate((place - middle) / size);
        if let Some(rib) = ivy_leaf(turned) {
            let young = chance(i, 4, 171);
            let green = vec3(0.045, 0.15, 0.03).lerp(vec3(0.13, 0.28, 0.06), young);
            colour = green.lerp(vec3(0.28, 0.4, 0.16), ramp(0.04, 0.01, rib));
            opacity = 1.0;
        }
    }
    colour.extend(opacity)
}

fn carpet(place: Vec2) -> Vec4 {
    let edge = 0.5 - (place.x - 0.5).abs();
    let red = vec3(0.42, 0.018, 0.022);
    let gold = vec3(0.5, 0.3, 0.06);
    let figure = ornament(place * 4.0).max(ornament(place * 4.0 + 0.5));
    let field = red.lerp(vec3(0.3, 0.01, 0.02), figure);
    let meander = ramp(0.1, -0.1, (TAU * 8.0 * place.y).sin() * (edge - 0.085) * 40.0);
    let border =
        if (0.055..0.115).contains(&edge) { gold.lerp(vec3(0.12, 0.02, 0.05), meander) } else { field };
    let line = |at: f32| ramp(0.012, 0.006, (edge - at).abs());
    let colour = border.lerp(gold, line(0.05).max(line(0.12)));
    (colour * (0.75 + 0.5 * fractal(place, 64, 2, 181))).extend(1.0)
}

fn pile(place: Vec2) -> Vec4 {
    let tile = (place * 2.0).floor();
    let inside = place * 2.0 - tile;
    // The pile of neighbouring tiles lies in different directions.
    let turned = ((tile.x + tile.y) as u32).is_multiple_of(2);
    let along = if turned { inside.x } else { inside.y };
    let stripes = 0.9 + 0.1 * (TAU * 24.0 * along).sin();
    let seam = 0.8 + 0.2 * ramp(0.0, 0.012, (0.5 - (inside - 0.5).abs()).min_element());
    let colour = vec3(0.20, 0.22, 0.26) * stripes * seam * (0.6 + 0.8 * fractal(place, 64, 2, 191));
    colour.extend(1.0)
}
