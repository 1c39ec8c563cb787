//! A two-coloured torus, which rotates in a beam of light.

use std::f32::consts::TAU;

use glam::{Vec3, vec3};

use super::palette::Palette;
use super::part::{Part, push_quad, push_vertex};
use crate::scene::Mesh;

/// Radius of the ring and of its body.
const RADII: [f32; 2] = [0.42, 0.15];
/// Segments around the ring and around its body; the latter are even.
const SEGMENTS: [u32; 2] = [96, 48];

/// A torus around the y axis, 1.14 m wide; turquoise above, purple below.
pub(super) fn model(palette: &mut Palette) -> Part {
    let [ring, body] = SEGMENTS;
    let paints =
        [palette.plain("turquoise", [0.06, 0.62, 0.58]), palette.plain("purple", [0.45, 0.06, 0.62])];
    let mut mesh = Mesh::default();
    let point = |i: u32, j: u32| {
        let (sin, cos) = (TAU * (i % ring) as f32 / ring as f32).sin_cos();
        let (up, out) = (TAU * (j % body) as f32 / body as f32).sin_cos();
        let away = RADII[0] + RADII[1] * out;
        vec3(away * cos, RADII[1] * up, -away * sin)
    };
    for i in 0..=ring {
        for j in 0..=body {
            let share = vec3(i as f32 / ring as f32, j as f32 / body as f32, 0.0);
            push_vertex(&mut mesh, point(i, j), Vec3::truncate(share));
        }
    }
    let at = |i: u32, j: u32| i * (body + 1) + j;
    for i in 0..ring {
        for j in 0..body {
            let paint = paints[usize::from(j >= body / 2)];
            push_quad(&mut mesh, [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)], paint);
        }
    }
    Part::of(mesh)
}
