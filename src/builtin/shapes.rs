//! Solids and open surfaces: boxes, extrusions, surfaces of revolution and sweeps.
//!
//! In: sizes in metres and a material. Out: a [`Part`] of one closed solid that faces outwards, or of one
//! open surface.

use std::f32::consts::TAU;

use glam::{Vec2, Vec3, vec2, vec3};

use super::part::{Part, face_uv, push_quad, push_triangle, push_vertex};
use crate::scene::Mesh;
use crate::scene::polygon::triangulate;

/// Frame of one cross section of a sweep. The path runs along `right` x `up`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    pub origin: Vec3,
    /// Direction of the profile's x axis; of any length.
    pub right: Vec3,
    /// Direction of the profile's y axis; of any length.
    pub up: Vec3,
}

/// Treatment of the first and last ring of a loft.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Ends {
    /// Closed by flat caps.
    Capped,
    /// Joined to each other.
    Joined,
}

/// An axis-aligned box.
pub(super) fn cuboid(min: Vec3, max: Vec3, material: u32) -> Part {
    let outline = [vec2(min.x, min.y), vec2(max.x, min.y), vec2(max.x, max.y), vec2(min.x, max.y)];
    prism(&outline, min.z, max.z, material)
}

/// A box of `size` on y = 0, centred on the y axis.
pub(super) fn block(size: Vec3, material: u32) -> Part {
    let half = vec3(0.5 * size.x, 0.0, 0.5 * size.z);
    cuboid(-half, half + Vec3::Y * size.y, material)
}

/// An axis-aligned box with edges bevelled by `bevel`.
pub(super) fn bevelled(min: Vec3, max: Vec3, bevel: f32, material: u32) -> Part {
    // At the caps the two vertices of each bevelled corner coincide.
    let ring = |y: f32, inset: f32| {
        let (low, high, b) = (min + inset, max - inset, bevel - inset);
        // Counter-clockwise seen from above.
        let plan = [
            [low.x + b, high.z],
            [high.x - b, high.z],
            [high.x, high.z - b],
            [high.x, low.z + b],
            [high.x - b, low.z],
            [low.x + b, low.z],
            [low.x, low.z + b],
            [low.x, high.z - b],
        ];
        plan.map(|[x, z]| vec3(x, y, z)).to_vec()
    };
    let rings = [ring(min.y, bevel), ring(min.y + bevel, 0.0), ring(max.y - bevel, 0.0), ring(max.y, bevel)];
    boxed(&loft(&rings, Ends::Capped, material))
}

/// The part with texture coordinates that follow the axes.
fn boxed(part: &Part) -> Part {
    let mut part = part.clone();
    for piece in &mut part.pieces {
        for (uv, (position, normal)) in piece.uvs.iter_mut().zip(piece.positions.iter().zip(&piece.normals)) {
            *uv = face_uv(*position, *normal);
        }
    }
    part
}

/// Extrudes an outline, counter-clockwise seen from +z, from z = `from` to z = `to`.
pub(super) fn prism(outline: &[Vec2], from: f32, to: f32, material: u32) -> Part {
    let ring = |z: f32| outline.iter().map(|point| point.extend(z)).collect::<Vec<_>>();
    let part = loft(&[ring(from), ring(to)], Ends::Capped, material);
    // Stone courses continue around corners; only soffits and roundings keep their own arc lengths.
    if outline.len() == 4 { boxed(&part) } else { part }
}

/// Maps x, y, z to x, -z, y: from a wall to the floor.
pub(super) fn lying() -> glam::Affine3A {
    glam::Affine3A::from_mat3(glam::Mat3::from_cols(Vec3::X, Vec3::NEG_Z, Vec3::Y))
}

/// A surface of revolution about the y axis of a profile of (radius, height), from bottom to top, closed to the axis
/// at both ends.
pub(super) fn lathe(profile: &[Vec2], segments: u32, material: u32) -> Part {
    lathe_shaped(profile, segments, material, |_, _| 1.0)
}

/// A surface of revolution whose radius is scaled by `shape(angle, height)`.
pub(super) fn lathe_shaped(
    profile: &[Vec2],
    segments: u32,
    material: u32,
    shape: impl Fn(f32, f32) -> f32,
) -> Part {
    let ring = |point: &Vec2| {
        let corner = |i: u32| {
            let angle = TAU * i as f32 / segments as f32;
            let radius = point.x * shape(angle, point.y);
            vec3(radius * angle.cos(), point.y, -radius * angle.sin())
        };
        (0..segments).map(corner).collect::<Vec<_>>()
    };
    let mut rings: Vec<_> = profile.iter().map(ring).collect();
    let pole = |point: Option<&Vec2>| {
        let point = point.filter(|point| point.x > 0.0)?;
        Some(vec![vec3(0.0, point.y, 0.0); segments as usize])
    };
    if let Some(bottom) = pole(profile.first()) {
        rings.insert(0, bottom);
    }
    rings.extend(pole(profile.last()));
    loft_open(&rings, material)
}

/// Sweeps a closed profile, counter-clockwise in (right, up), along a path.
pub(super) fn sweep(profile: &[Vec2], way: &[Frame], ends: Ends, material: u32) -> Part {
    let ring = |frame: &Frame| {
        let point = |p: &Vec2| frame.origin + frame.right * p.x + frame.up * p.y;
        profile.iter().map(point).collect::<Vec<_>>()
    };
    let rings: Vec<_> = way.iter().map(ring).collect();
    let mut part = loft(&rings, ends, material);
    for uv in part.pieces.iter_mut().flat_map(|piece| &mut piece.uvs) {
        *uv = vec2(-uv.y, uv.x);
    }
    part
}

/// Lofts a closed solid through rings with equal numbers of points, each counter-clockwise about the direction from
/// ring to ring.
pub(super) fn loft(rings: &[Vec<Vec3>], ends: Ends, material: u32) -> Part {
    let mut mesh = Mesh::default();
    push_sides(&mut mesh, rings, ends, material);
    if ends == Ends::Capped
        && let [first, .., last] = rings
    {
        let turned: Vec<Vec3> = first.iter().rev().copied().collect();
        push_lid(&mut mesh, &turned, material);
        push_lid(&mut mesh, last, material);
    }
    Part::of(mesh)
}

/// Lofts a solid whose first and last rings are single points.
pub(super) fn loft_open(rings: &[Vec<Vec3>], material: u32) -> Part {
    let mut mesh = Mesh::default();
    push_sides(&mut mesh, rings, Ends::Capped, material);
    Part::of(mesh)
}

/// Appends a flat face with its own vertices.
pub(super) fn push_lid(mesh: &mut Mesh, corners: &[Vec3], material: u32) {
    let area: Vec3 =
        (1..corners.len() - 1).map(|i| (corners[i] - corners[0]).cross(corners[i + 1] - corners[0])).sum();
    let first = mesh.positions.len() as u32;
    for corner in corners {
        push_vertex(mesh, *corner, face_uv(*corner, area));
    }
    for triangle in triangulate(corners) {
        push_triangle(mesh, triangle.map(|corner| first + corner as u32), material);
    }
}

fn push_sides(mesh: &mut Mesh, rings: &[Vec<Vec3>], ends: Ends, material: u32) {
    let points = rings[0].len();
    let around = lengths_around(rings);
    let mut along = 0.0;
    let mut rows: Vec<u32> = Vec::with_capacity(rings.len() + 1);
    let closing = if ends == Ends::Joined { rings.first() } else { None };
    let mut before: Option<&Vec<Vec3>> = None;
    for ring in rings.iter().chain(closing) {
        if let Some(before) = before {
            let distance: f32 = before.iter().zip(ring).map(|(a, b)| a.distance(*b)).sum();
            along += distance / points as f32;
        }
        rows.push(mesh.positions.len() as u32);
        for (i, length) in around.iter().enumerate() {
            push_vertex(mesh, ring[i % points], vec2(*length, -along));
        }
        before = Some(ring);
    }
    for pair in rows.windows(2) {
        for i in 0..points as u32 {
            push_quad(mesh, [pair[0] + i, pair[0] + i + 1, pair[1] + i + 1, pair[1] + i], material);
        }
    }
}

/// Arc lengths of the points along the longest ring, and its total length.
fn lengths_around(rings: &[Vec<Vec3>]) -> Vec<f32> {
    let lengths = |ring: &Vec<Vec3>| {
        let mut lengths = vec![0.0];
        for i in 0..ring.len() {
            lengths.push(lengths[i] + ring[i].distance(ring[(i + 1) % ring.len()]));
        }
        lengths
    };
    let total = |lengths: &Vec<f32>| lengths.last().copied().unwrap_or_default();
    let all = rings.iter().map(lengths);
    all.max_by(|a, b| total(a).total_cmp(&total(b))).unwrap_or_default()
}

/// An open surface of `columns` x `rows` quads with positions `point(u, v)`, u and v from 0 to 1, v down. Its front faces
/// right x up. Texture coordinates are (u, v) times `extent`.
pub(super) fn open_surface(
    [columns, rows]: [u32; 2],
    extent: Vec2,
    material: u32,
    point: impl Fn(Vec2) -> Vec3,
) -> Part {
    let mut mesh = Mesh::default();
    for row in 0..=rows {
        for column in 0..=columns {
            let share = vec2(column as f32 / columns as f32, row as f32 / rows as f32);
            push_vertex(&mut mesh, point(share), share * extent);
        }
    }
    let at = |column: u32, row: u32| row * (columns + 1) + column;
    for row in 0..rows {
        for column in 0..columns {
            let corners =
                [at(column, row + 1), at(column + 1, row + 1), at(column + 1, row), at(column, row)];
            push_quad(&mut mesh, corners, material);
        }
    }
    Part::of(mesh)
}

/// A solid of that shape and `thickness`.
pub(super) fn curved_slab(
    [columns, rows]: [u32; 2],
    thickness: f32,
    material: u32,
    point: impl Fn(Vec2) -> Vec3,
) -> Part {
    let at = |column: u32, row: u32| point(vec2(column as f32 / columns as f32, row as f32 / rows as f32));
    // The cross section of one row: along the front, then back along the other side.
    let ring = |row: u32| {
        let (above, below) = (row.saturating_sub(1), (row + 1).min(rows));
        let place = |column: u32, side: f32| {
            let (left, right) = (column.saturating_sub(1), (column + 1).min(columns));
            let normal = (at(right, row) - at(left, row)).cross(at(column, above) - at(column, below));
            at(column, row) + normal.normalize_or(Vec3::Y) * (side * 0.5 * thickness)
        };
        let back = (0..=columns).rev().map(|column| place(column, -1.0));
        (0..=columns).map(|column| place(column, 1.0)).chain(back).collect::<Vec<_>>()
    };
    loft(&(0..=rows).rev().map(ring).collect::<Vec<_>>(), Ends::Capped, material)
}

/// A superellipsoid about the origin: a ball at exponent 1, nearly a box of size 2 x `half` near 0.
pub(super) fn cushion(half: Vec3, exponent: f32, [segments, rings]: [u32; 2], material: u32) -> Part {
    let power = |value: f32| value.abs().powf(exponent).copysign(value);
    let ring = |j: u32| {
        let (sin, cos) = (std::f32::consts::PI * (j as f32 / rings as f32 - 0.5)).sin_cos();
        let corner = |i: u32| {
            let (s, c) = (TAU * i as f32 / segments as f32).sin_cos();
            let flat = if j == 0 || j == rings { 0.0 } else { power(cos) };
            vec3(flat * power(c), power(sin), -flat * power(s)) * half
        };
        (0..segments).map(corner).collect::<Vec<_>>()
    };
    loft_open(&(0..=rings).map(ring).collect::<Vec<_>>(), material)
}

/// A round bar of `radius` through `points`, with flat ends.
pub(super) fn rod(points: &[Vec3], radius: f32, segments: u32, material: u32) -> Part {
    let direction = |i: usize| {
        let (before, after) = (points[i.saturating_sub(1)], points[(i + 1).min(points.len() - 1)]);
        (after - before).normalize_or(Vec3::Y)
    };
    let mut right = direction(0).any_orthonormal_vector();
    let mut way = Vec::with_capacity(points.len());
    for (i, point) in points.iter().enumerate() {
        let along = direction(i);
        // Parallel transport: project the last frame to the plane of this cross section.
        right = right.reject_from(along).normalize_or(along.any_orthonormal_vector());
        way.push(Frame { origin: *point, right: right * radius, up: along.cross(right) * radius });
    }
    let corner = |i: u32| Vec2::from_angle(TAU * i as f32 / segments as f32);
    sweep(&(0..segments).map(corner).collect::<Vec<_>>(), &way, Ends::Capped, material)
}

/// A straight round bar.
pub(super) fn bar(from: Vec3, to: Vec3, radius: f32, segments: u32, material: u32) -> Part {
    rod(&[from, to], radius, segments, material)
}
