//! Groin vaults: a block of masonry whose underside is the intersection of two barrel vaults.
//!
//! In: size of a bay. Out: a closed block, its ribs, and the height of its underside.

use glam::{Vec2, Vec3, vec2, vec3};

use super::part::{Part, face_uv, push_quad, push_triangle, push_vertex};
use super::paths::way;
use super::shapes::{Ends, Frame, sweep};
use crate::scene::Mesh;

/// A bay around the y axis.
#[derive(Clone, Copy, Debug)]
pub(super) struct Vault {
    /// Half of the bay's extent along x and z.
    pub half: Vec2,
    /// Height of the springing, in the corners.
    pub spring: f32,
    /// Rise from the springing to the centre.
    pub rise: f32,
    /// Pointedness of the barrels: height over half span of the arch before it is scaled to this bay; 1: round.
    pub point: f32,
    /// Quads from wall to wall, even.
    pub steps: u32,
}

impl Vault {
    /// Height of a barrel over its springing at the fraction `share` of the half span from its foot, 1 at the centre.
    fn barrel(&self, share: f32) -> f32 {
        let share = share.clamp(0.0, 1.0);
        if self.point <= 1.0 {
            return (1.0 - (1.0 - share) * (1.0 - share)).max(0.0).sqrt();
        }
        let radius = 0.5 * (1.0 + self.point * self.point);
        (2.0 * radius * share - share * share).max(0.0).sqrt() / self.point
    }

    /// Height of the underside at `place` (x, z), relative to the half extents.
    fn underside(&self, share: Vec2) -> f32 {
        let across = 1.0 - share.abs();
        self.spring + self.rise * self.barrel(across.x).max(self.barrel(across.y))
    }

    /// The block up to `top`.
    pub fn block(&self, top: f32, material: u32) -> Part {
        let mut mesh = Mesh::default();
        let n = self.steps;
        let share = |i: u32| (2 * i) as f32 / n as f32 - 1.0;
        let point = |i: u32, j: u32| {
            let s = vec2(share(i), share(j));
            vec3(s.x * self.half.x, self.underside(s), s.y * self.half.y)
        };
        for j in 0..=n {
            for i in 0..=n {
                let p = point(i, j);
                push_vertex(&mut mesh, p, vec2(p.x, p.z));
            }
        }
        let at = |i: u32, j: u32| j * (n + 1) + i;
        for j in 0..n {
            for i in 0..n {
                let quad = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                // The groins run along the diagonals, so each quad is split that way.
                let rotated =
                    if (i < n / 2) == (j < n / 2) { quad } else { [quad[1], quad[2], quad[3], quad[0]] };
                push_quad(&mut mesh, rotated, material);
            }
        }
        let mut rim: Vec<Vec3> = (0..n).map(|i| point(i, 0)).collect();
        rim.extend((0..n).map(|j| point(n, j)));
        rim.extend((0..n).map(|i| point(n - i, n)));
        rim.extend((0..n).map(|j| point(0, n - j)));
        close_above(&mut mesh, &rim, top, material);
        Part::of(mesh)
    }

    /// Ribs along both groins: `profile` in (sideways, upwards), about the line of the underside.
    pub fn groin_ribs(&self, profile: &[Vec2], steps: u32, material: u32) -> Part {
        let mut ribs = Part::default();
        for side in [-1.0, 1.0] {
            let end = vec2(self.half.x, side * self.half.y);
            ribs.push(self.rib(profile, end, steps, material));
        }
        ribs
    }

    /// A rib across the vault along z, at x = 0.
    pub fn cross_rib(&self, profile: &[Vec2], steps: u32, material: u32) -> Part {
        let end = vec2(0.0, self.half.y);
        self.rib(profile, end, steps, material)
    }

    /// Positions from -`end` through the centre to `end`.
    fn rib(&self, profile: &[Vec2], end: Vec2, steps: u32, material: u32) -> Part {
        let (along, half_length) = (end.normalize(), end.length());
        // Equidistant in angle, which gives the steep feet as many steps as the crown.
        let place = |i: u32| {
            let angle = std::f32::consts::PI * (i as f32 / steps as f32 - 0.5);
            let t = if i == 0 {
                -1.0
            } else if i == steps {
                1.0
            } else {
                angle.sin()
            };
            vec2(t * half_length, self.spring + self.rise * self.barrel(1.0 - t.abs()))
        };
        let points: Vec<Vec2> = (0..=steps).map(place).collect();
        let out = |v: Vec3| vec3(along.x * v.x, v.y, along.y * v.x);
        let sideways = vec3(along.y, 0.0, -along.x);
        let upright = |flat: Frame| Frame { origin: out(flat.origin), right: sideways, up: out(flat.right) };
        let way: Vec<Frame> = way(&points, false).into_iter().map(upright).collect();
        sweep(profile, &way, Ends::Capped, material)
    }
}

/// Closes a surface that faces down to a solid: walls from its `rim`, which goes from +x to +z,
/// to `top`.
fn close_above(mesh: &mut Mesh, rim: &[Vec3], top: f32, material: u32) {
    let n = rim.len();
    let above = |i: usize| rim[i % n].with_y(top);
    for i in 0..n {
        let (a, b) = (rim[i], rim[(i + 1) % n]);
        let normal = (b - a).cross(Vec3::Y);
        let corners = [b, a, above(i), above(i + 1)];
        let vertices = corners.map(|corner| push_vertex(mesh, corner, face_uv(corner, normal)));
        push_quad(mesh, vertices, material);
    }
    let middle = (rim[0] + rim[n / 2]).with_y(2.0 * top) * 0.5;
    let centre = push_vertex(mesh, middle, vec2(middle.x, middle.z));
    for i in 0..n {
        let corners = [above(i + 1), above(i)];
        let [b, a] = corners.map(|corner| push_vertex(mesh, corner, vec2(corner.x, corner.z)));
        push_triangle(mesh, [centre, b, a], material);
    }
}
