//! Plants: leaves are open surfaces with alpha masks.

use std::f32::consts::{FRAC_PI_2, TAU};

use glam::{Quat, Vec2, Vec3, vec2, vec3};

use super::noise::chance;
use super::part::{Part, push_quad, push_vertex};
use crate::scene::Mesh;

/// A tuft of long leaves that bend outwards.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tuft {
    pub leaves: u32,
    /// Length of the longest leaf, metres.
    pub length: f32,
    pub width: f32,
    /// Seed of the leaves' directions.
    pub seed: u32,
    pub material: u32,
}

/// Quads along a leaf.
const JOINTS: u32 = 6;

impl Tuft {
    /// The leaves, from the origin upwards and outwards.
    pub fn part(&self) -> Part {
        let mut mesh = Mesh::default();
        for leaf in 0..self.leaves {
            let pick = |i: u32| chance(leaf, i, self.seed);
            let heading = TAU * (leaf as f32 * 0.618_034 + 0.05 * pick(0));
            // Inner leaves are upright, outer ones droop.
            let age = (leaf as f32 + pick(1)) / self.leaves as f32;
            let lean = 0.12 + 1.0 * age;
            let bend = 0.5 + 1.3 * age * (0.6 + 0.4 * pick(2));
            let length = self.length * (0.7 + 0.3 * pick(3));
            let out = vec3(heading.cos(), 0.0, heading.sin());
            let side = vec3(-heading.sin(), 0.0, heading.cos()) * (0.5 * self.width);
            let mut place = out * 0.02;
            let mut rows = Vec::with_capacity(JOINTS as usize + 1);
            for joint in 0..=JOINTS {
                let t = joint as f32 / JOINTS as f32;
                let left = push_vertex(&mut mesh, place - side, vec2(0.0, 1.0 - t));
                let right = push_vertex(&mut mesh, place + side, vec2(1.0, 1.0 - t));
                rows.push([left, right]);
                let elevation = FRAC_PI_2 - lean - bend * t * t;
                place += (out * elevation.cos() + Vec3::Y * elevation.sin()) * (length / JOINTS as f32);
            }
            for pair in rows.windows(2) {
                push_quad(&mut mesh, [pair[0][0], pair[0][1], pair[1][1], pair[1][0]], self.material);
            }
        }
        Part::of(mesh)
    }
}

/// Ivy on a wall z = 0, at those of `tries` random points (x, y) in `area` for which `covers` is true.
pub(super) fn ivy(
    [min, max]: [Vec2; 2],
    tries: u32,
    seed: u32,
    material: u32,
    covers: impl Fn(Vec2) -> bool,
) -> Part {
    let mut mesh = Mesh::default();
    for i in 0..tries {
        let pick = |k: u32| chance(i, k, seed);
        let place = min + (max - min) * vec2(pick(0), pick(1));
        if !covers(place) {
            continue;
        }
        let size = 0.26 + 0.16 * pick(2);
        let tilt = Quat::from_rotation_y(0.9 * (pick(3) - 0.5))
            * Quat::from_rotation_x(-0.15 - 0.5 * pick(4))
            * Quat::from_rotation_z(1.4 * (pick(5) - 0.5));
        let middle = place.extend(0.07 + 0.08 * pick(6));
        let corner = |x: f32, y: f32| middle + tilt * vec3(x * size, y * size, 0.06 * (x * x + y));
        let corners = [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]]
            .map(|[x, y]: [f32; 2]| push_vertex(&mut mesh, corner(x, y), vec2(0.5 + x, 0.5 - y)));
        push_quad(&mut mesh, corners, material);
    }
    Part::of(mesh)
}
