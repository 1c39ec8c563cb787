//! Generates missing vertex normals.
//!
//! In: a mesh, some of whose vertices have a zero normal. Out: the mesh with unit normals: the angle-weighted mean of
//! the adjacent face normals (Thuermer and Wuethrich 1998) in the smoothing group or, where there are none, within the crease
//! angle; other edges stay sharp.

use std::collections::HashMap;

use glam::Vec3;

use super::mesh::Mesh;

/// Crease angle, degrees: adjacent faces with a smaller angle between their normals are smoothed.
const CREASE_DEGREES: f32 = 40.0;

/// Vertices of a higher valence are shaded flat: comparing all pairs of faces takes quadratic time.
const MAX_VALENCE: usize = 512;

/// One corner of a triangle.
#[derive(Clone, Copy)]
struct Corner {
    triangle: usize,
    corner: usize,
    face_normal: Vec3,
    angle: f32,
}

/// Replaces every zero normal; vertices on a crease are split.
pub(crate) fn fill_missing(mesh: &mut Mesh) {
    fill_missing_in_groups(mesh, &[]);
}

/// [`fill_missing`] by the smoothing group of each triangle, of which 0 is flat; a triangle that has none goes by the crease angle.
pub(crate) fn fill_missing_in_groups(mesh: &mut Mesh, smoothing: &[Option<u32>]) {
    let group_of = |corner: &Corner| smoothing.get(corner.triangle).copied().flatten();
    let crease_cos = CREASE_DEGREES.to_radians().cos();
    let mut made: HashMap<(u32, [u32; 3]), u32> = HashMap::new();
    let mut given = vec![false; mesh.positions.len()];
    for group in corner_groups(mesh) {
        let mut smooth: HashMap<u32, Vec3> = HashMap::new();
        for corner in &group {
            if let Some(number @ 1..) = group_of(corner) {
                *smooth.entry(number).or_default() += corner.face_normal * corner.angle;
            }
        }
        for corner in &group {
            let sum = match group_of(corner) {
                Some(number) => smooth.get(&number).copied().unwrap_or_default(),
                None if group.len() > MAX_VALENCE => Vec3::ZERO,
                None => {
                    let is_near = |other: &&Corner| {
                        group_of(other).is_none() && other.face_normal.dot(corner.face_normal) >= crease_cos
                    };
                    group.iter().filter(is_near).map(|other| other.face_normal * other.angle).sum()
                }
            };
            let normal = sum.normalize_or(corner.face_normal);
            let vertex = mesh.triangles[corner.triangle][corner.corner];
            let key = (vertex, normal.to_array().map(f32::to_bits));
            let place = *made.entry(key).or_insert_with(|| {
                if !std::mem::replace(&mut given[vertex as usize], true) {
                    mesh.normals[vertex as usize] = normal;
                    return vertex;
                }
                let copy = mesh.repeat_vertex(vertex);
                mesh.normals[copy as usize] = normal;
                copy
            });
            mesh.triangles[corner.triangle][corner.corner] = place;
        }
    }
}

/// The corners without a normal, grouped by position, in the order of the triangles.
fn corner_groups(mesh: &Mesh) -> Vec<Vec<Corner>> {
    let mut groups: Vec<Vec<Corner>> = Vec::new();
    let mut by_position: HashMap<[u32; 3], usize> = HashMap::new();
    for (triangle, vertices) in mesh.triangles.iter().enumerate() {
        let points = vertices.map(|vertex| mesh.positions[vertex as usize]);
        let face_normal = (points[1] - points[0]).cross(points[2] - points[0]).normalize_or(Vec3::Y);
        for corner in 0..3 {
            if mesh.normals[vertices[corner] as usize] != Vec3::ZERO {
                continue;
            }
            let [here, next, last] = [points[corner], points[(corner + 1) % 3], points[(corner + 2) % 3]];
            let angle = (next - here).angle_between(last - here);
            // Adding zero turns -0 into +0, which must compare equal.
            let key = (here + 0.0).to_array().map(f32::to_bits);
            let group = *by_position.entry(key).or_insert_with(|| {
                groups.push(Vec::new());
                groups.len() - 1
            });
            let angle = if angle.is_finite() { angle } else { 0.0 };
            groups[group].push(Corner { triangle, corner, face_normal, angle });
        }
    }
    groups
}

#[cfg(test)]
mod tests {
    use super::*;

    fn without_normals(mut mesh: Mesh) -> Mesh {
        mesh.normals.fill(Vec3::ZERO);
        mesh
    }

    #[test]
    fn box_edges_stay_sharp() {
        let expected = Mesh::cuboid("box", Vec3::ONE, 0);
        let mut mesh = without_normals(expected.clone());
        fill_missing(&mut mesh);
        assert_eq!(mesh.positions.len(), 24);
        for (got, expected) in mesh.normals.iter().zip(&expected.normals) {
            assert!(got.distance(*expected) < 1e-6);
        }
    }

    #[test]
    fn spheres_become_smooth() {
        let expected = Mesh::sphere("sphere", 3.0, 4, 0);
        let mut mesh = without_normals(expected.clone());
        fill_missing(&mut mesh);
        assert_eq!(mesh.positions.len(), expected.positions.len());
        for (got, expected) in mesh.normals.iter().zip(&expected.normals) {
            assert!(got.dot(*expected) > 0.9999);
        }
    }

    #[test]
    fn creases_split_shared_vertices() {
        let mut mesh = Mesh {
            name: "roof".into(),
            positions: vec![Vec3::ZERO, Vec3::Z, Vec3::new(1.0, -1.0, 0.0), Vec3::new(-1.0, -1.0, 0.0)],
            normals: vec![Vec3::ZERO; 4],
            uvs: vec![glam::Vec2::ZERO; 4],
            triangles: vec![[0, 1, 2], [1, 0, 3]],
            triangle_materials: vec![0, 0],
            ..Mesh::default()
        };
        fill_missing(&mut mesh);
        assert_eq!(mesh.positions.len(), 6);
        for (i, triangle) in mesh.triangles.iter().enumerate() {
            let [a, b, c] = mesh.triangle_positions(i as u32);
            let flat = (b - a).cross(c - a).normalize();
            assert!(triangle.iter().all(|&v| mesh.normals[v as usize].distance(flat) < 1e-6));
        }
    }
}
