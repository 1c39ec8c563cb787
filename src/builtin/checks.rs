//! Checks of a model against light leaks and z-fighting.
//!
//! In: the pieces of a model. Out: defects, one line each.

use std::collections::{BTreeMap, HashMap, HashSet};

use glam::{DVec2, DVec3, Vec3};

use crate::scene::Mesh;

/// Parallel faces nearer than this are coincident, metres.
const TOUCHING: f64 = 2e-4;

/// Smaller overlaps are ignored, square metres.
const SMALLEST_OVERLAP: f64 = 2e-5;

fn key(point: Vec3) -> [u32; 3] {
    // Adding zero turns -0 into +0, which must compare equal.
    (point + 0.0).to_array().map(f32::to_bits)
}

/// A piece with welded vertices: one for each position.
struct Welded {
    triangles: Vec<[usize; 3]>,
    /// Union-find parents: vertices of one connected body share a root.
    body: Vec<usize>,
}

impl Welded {
    fn of(mesh: &Mesh) -> Self {
        let mut places = HashMap::new();
        let mut place = |point: Vec3| {
            let next = places.len();
            *places.entry(key(point)).or_insert(next)
        };
        let triangles: Vec<[usize; 3]> = mesh
            .triangles
            .iter()
            .map(|triangle| triangle.map(|vertex| place(mesh.positions[vertex as usize])))
            .collect();
        let mut welded = Self { triangles, body: (0..places.len()).collect() };
        for i in 0..welded.triangles.len() {
            let [a, b, c] = welded.triangles[i].map(|vertex| welded.root(vertex));
            welded.body[b] = a;
            let c = welded.root(c);
            welded.body[c] = a;
        }
        welded
    }

    fn root(&self, mut vertex: usize) -> usize {
        while self.body[vertex] != vertex {
            vertex = self.body[vertex];
        }
        vertex
    }
}

/// Checks that a solid is a closed manifold (each edge has two triangles, in opposite directions) facing outwards.
pub(super) fn solid(mesh: &Mesh) -> Result<(), String> {
    let welded = Welded::of(mesh);
    let mut edges: HashMap<(usize, usize), i32> = HashMap::new();
    for [a, b, c] in &welded.triangles {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            *edges.entry((*from, *to)).or_default() += 1;
        }
    }
    let open = edges.iter().filter(|((a, b), n)| **n != 1 || edges.get(&(*b, *a)) != Some(&1)).count();
    if open > 0 {
        return Err(format!("{open} of {} edges are open or shared by more than two", edges.len()));
    }
    let mut volumes: BTreeMap<usize, f64> = BTreeMap::new();
    let origin = mesh.positions[0].as_dvec3();
    for (i, triangle) in welded.triangles.iter().enumerate() {
        let [a, b, c] = mesh.triangle_positions(i as u32).map(|corner| corner.as_dvec3() - origin);
        *volumes.entry(welded.root(triangle[0])).or_default() += a.dot(b.cross(c)) / 6.0;
    }
    match volumes.values().find(|volume| **volume <= 1e-12) {
        Some(volume) => Err(format!("a body has the volume {volume:e} m^3: it is flat or inside out")),
        None => Ok(()),
    }
}

/// Checks that each edge of an open surface has at most two triangles, with consistent winding.
pub(super) fn open_surface(mesh: &Mesh) -> Result<(), String> {
    let welded = Welded::of(mesh);
    let mut edges: HashMap<(usize, usize), i32> = HashMap::new();
    for [a, b, c] in &welded.triangles {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            *edges.entry((*from, *to)).or_default() += 1;
        }
    }
    let bad = edges.values().filter(|n| **n != 1).count();
    if bad > 0 {
        Err(format!("{bad} edges have more than two triangles, or two that disagree"))
    } else {
        Ok(())
    }
}

/// Checks that all triangles have an area, and all vertices unit normals on the front side.
pub(super) fn surface(mesh: &Mesh) -> Result<(), String> {
    for (i, triangle) in mesh.triangles.iter().enumerate() {
        let [a, b, c] = mesh.triangle_positions(i as u32).map(|corner| corner.as_dvec3());
        let across = (b - a).cross(c - a);
        if across.length() < 1e-9 {
            return Err(format!("triangle {i} at {a} has the area {:e} m^2", 0.5 * across.length()));
        }
        for &vertex in triangle {
            let normal = mesh.normals[vertex as usize].as_dvec3();
            let cos = normal.dot(across.normalize());
            if (normal.length() - 1.0).abs() > 1e-3 || cos < 0.3 {
                return Err(format!("triangle {i} at {a}: normal {normal}, {cos} to the triangle's"));
            }
            if !mesh.uvs[vertex as usize].is_finite() {
                return Err(format!(
                    "triangle {i} at {a}: texture coordinates {}",
                    mesh.uvs[vertex as usize]
                ));
            }
        }
    }
    Ok(())
}

/// A triangle, projected to its plane.
struct Face {
    corners: [DVec3; 3],
    normal: DVec3,
    piece: usize,
}

/// Coincident faces with the same normal, which would z-fight; not those inside another solid. One point for each pair
/// of pieces.
pub(super) fn overlaps(pieces: &[Mesh]) -> Vec<String> {
    let mut faces = Vec::new();
    let mut planes: HashMap<[i64; 4], Vec<usize>> = HashMap::new();
    for (piece, mesh) in pieces.iter().enumerate() {
        for i in 0..mesh.triangles.len() {
            let corners = mesh.triangle_positions(i as u32).map(|corner| corner.as_dvec3());
            let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize();
            let face = Face { corners, normal, piece };
            planes.entry(plane(&face).map(|value| value.round() as i64)).or_default().push(faces.len());
            faces.push(face);
        }
    }
    let solids: Vec<Solid> = pieces.iter().filter(|piece| solid(piece).is_ok()).map(Solid::of).collect();
    let (mut found, mut named) = (Vec::new(), HashSet::new());
    for (first, face) in faces.iter().enumerate() {
        for there in nearby(face) {
            for &second in planes.get(&there).into_iter().flatten().filter(|second| **second > first) {
                let Some((area, middle)) = overlap(face, &faces[second]) else { continue };
                if named.contains(&(face.piece, faces[second].piece)) {
                    continue;
                }
                let before = middle + face.normal * 2.0 * TOUCHING;
                if !solids.iter().any(|solid| solid.contains(before)) {
                    named.insert((face.piece, faces[second].piece));
                    found.push(format!(
                        "pieces {} and {} share {area:.5} m^2 near {middle:.3}, normal {:.2}",
                        face.piece, faces[second].piece, face.normal
                    ));
                }
            }
        }
    }
    found
}

/// Hash cell of a face's plane: normal and distance from the origin.
fn plane(face: &Face) -> [f64; 4] {
    let Face { normal, corners, .. } = face;
    [normal.x * 256.0, normal.y * 256.0, normal.z * 256.0, normal.dot(corners[0]) / 4e-3]
}

/// The cells that may contain faces coplanar with this one, given rounding.
fn nearby(face: &Face) -> Vec<[i64; 4]> {
    let mut cells = vec![[0; 4]];
    for (axis, value) in plane(face).into_iter().enumerate() {
        let inexact = if axis == 3 { 0.8 } else { 0.25 };
        let (from, to) = ((value - inexact).round() as i64, (value + inexact).round() as i64);
        let at = |cell: i64| {
            cells.iter().map(move |before| std::array::from_fn(|i| if i == axis { cell } else { before[i] }))
        };
        cells = (from..=to).flat_map(at).collect();
    }
    cells
}

/// Overlap area of two faces and a point in it, if they are coplanar with the same normal.
fn overlap(first: &Face, second: &Face) -> Option<(f64, DVec3)> {
    let off_plane = |point: &DVec3| first.normal.dot(*point - first.corners[0]).abs();
    if first.normal.dot(second.normal) < 0.999 || second.corners.iter().any(|p| off_plane(p) > TOUCHING) {
        return None;
    }
    let (x, y) = first.normal.any_orthonormal_pair();
    let flat = |face: &Face| {
        let mut corners = face.corners.map(|p| {
            let p = p - first.corners[0];
            DVec2::new(p.dot(x), p.dot(y))
        });
        if (corners[1] - corners[0]).perp_dot(corners[2] - corners[0]) < 0.0 {
            corners.swap(1, 2);
        }
        corners
    };
    let (clip, mut polygon) = (flat(first), flat(second).to_vec());
    for i in 0..3 {
        let (from, to) = (clip[i], clip[(i + 1) % 3]);
        let side = |p: DVec2| (to - from).perp_dot(p - from);
        let mut kept = Vec::with_capacity(polygon.len() + 1);
        for j in 0..polygon.len() {
            let (a, b) = (polygon[j], polygon[(j + 1) % polygon.len()]);
            let (s, t) = (side(a), side(b));
            if s >= 0.0 {
                kept.push(a);
            }
            if (s < 0.0) != (t < 0.0) {
                kept.push(a.lerp(b, s / (s - t)));
            }
        }
        polygon = kept;
    }
    let area = |i: usize| polygon[i].perp_dot(polygon[(i + 1) % polygon.len()]);
    let area = 0.5 * (0..polygon.len()).map(area).sum::<f64>();
    let middle = polygon.iter().sum::<DVec2>() / polygon.len().max(1) as f64;
    (area > SMALLEST_OVERLAP).then(|| (area, first.corners[0] + x * middle.x + y * middle.y))
}

/// A piece, for inside tests.
struct Solid<'a> {
    mesh: &'a Mesh,
    bounds: (DVec3, DVec3),
}

impl<'a> Solid<'a> {
    fn of(mesh: &'a Mesh) -> Self {
        let (min, max) = mesh.bounds();
        Self { mesh, bounds: (min.as_dvec3(), max.as_dvec3()) }
    }

    /// Winding number: how often a ray from `point` leaves the piece, minus how often it enters.
    fn contains(&self, point: DVec3) -> bool {
        if point.cmplt(self.bounds.0).any() || point.cmpgt(self.bounds.1).any() {
            return false;
        }
        // A generic direction, which no edge of a model is parallel to.
        let direction = DVec3::new(0.2718, 0.8315, 0.4846);
        let mut leaving = 0;
        for i in 0..self.mesh.triangles.len() {
            let [a, b, c] = self.mesh.triangle_positions(i as u32).map(|corner| corner.as_dvec3() - point);
            let sides = [a, b, c].map(|corner| corner.cross(direction));
            let turns = [a.dot(sides[1]), b.dot(sides[2]), c.dot(sides[0])];
            let along = a.dot(b.cross(c));
            if turns.iter().all(|turn| *turn < 0.0) && along > 0.0 {
                leaving += 1;
            } else if turns.iter().all(|turn| *turn > 0.0) && along < 0.0 {
                leaving -= 1;
            }
        }
        leaving > 0
    }
}
