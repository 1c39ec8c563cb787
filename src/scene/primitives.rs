//! Procedural meshes: polygon, box and sphere, for scene files, built-in scenes and tests.
//!
//! In: sizes. Out: a [`Mesh`] whose triangles face outwards (counter-clockwise) and whose material
//! indices are all `material`.

use std::collections::HashMap;

use glam::{Vec2, Vec3};

use super::mesh::Mesh;

impl Mesh {
    /// A flat convex polygon, its front where `corners` go counter-clockwise. Texture coordinates of a
    /// quad run from (0, 1) at the first corner to (1, 0) at the third.
    pub fn polygon(name: &str, corners: &[Vec3], material: u32) -> Self {
        let mut mesh = Self { name: name.to_owned(), ..Self::default() };
        mesh.push_polygon(corners, material);
        mesh
    }

    /// Appends a flat convex polygon of at least three corners, with its own vertices.
    pub fn push_polygon(&mut self, corners: &[Vec3], material: u32) {
        const QUAD_UVS: [Vec2; 4] =
            [Vec2::new(0.0, 1.0), Vec2::new(1.0, 1.0), Vec2::new(1.0, 0.0), Vec2::ZERO];
        let first = self.positions.len() as u32;
        // Newell's method gives the area vector of any planar polygon, even with collinear corners.
        let area = (0..corners.len()).fold(Vec3::ZERO, |sum, i| {
            let (a, b) = (corners[i] - corners[0], corners[(i + 1) % corners.len()] - corners[0]);
            sum + a.cross(b)
        });
        let normal = area.normalize_or(Vec3::Y);
        for (i, corner) in corners.iter().enumerate() {
            self.positions.push(*corner);
            self.normals.push(normal);
            self.uvs.push(QUAD_UVS[i % 4]);
        }
        for i in 1..corners.len() as u32 - 1 {
            self.triangles.push([first, first + i, first + i + 1]);
            self.triangle_materials.push(material);
        }
    }

    /// An axis-aligned box about the origin with edges of length `size`, flat shaded.
    pub fn cuboid(name: &str, size: Vec3, material: u32) -> Self {
        let mut mesh = Self { name: name.to_owned(), ..Self::default() };
        for axis in 0..3 {
            for sign in [-1.0, 1.0] {
                let normal = Vec3::AXES[axis] * sign;
                let tangent = Vec3::AXES[(axis + 1) % 3];
                let bitangent = normal.cross(tangent);
                let corner = |s: f32, t: f32| (normal + tangent * s + bitangent * t) * size * 0.5;
                let corners = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
                mesh.push_polygon(&corners, material);
            }
        }
        mesh
    }

    /// A sphere about the origin: an icosahedron split `subdivisions` times (20 * 4^n triangles, at most
    /// n = 8), all vertices on the sphere, smooth normals, latitude-longitude texture coordinates.
    pub fn sphere(name: &str, radius: f32, subdivisions: u32, material: u32) -> Self {
        let (mut points, mut triangles) = icosahedron();
        for _ in 0..subdivisions.min(8) {
            triangles = subdivide(&mut points, &triangles);
        }
        Self {
            name: name.to_owned(),
            positions: points.iter().map(|point| *point * radius).collect(),
            uvs: points.iter().map(|point| latitude_longitude(*point)).collect(),
            normals: points,
            triangle_materials: vec![material; triangles.len()],
            triangles,
            ..Self::default()
        }
    }

    /// The mesh with flipped winding and normals, to be seen from inside.
    pub fn turned_inside_out(mut self) -> Self {
        for triangle in &mut self.triangles {
            triangle.swap(1, 2);
        }
        for normal in &mut self.normals {
            *normal = -*normal;
        }
        self
    }
}

fn latitude_longitude(point: Vec3) -> Vec2 {
    let longitude = point.z.atan2(point.x) / std::f32::consts::TAU + 0.5;
    Vec2::new(longitude, point.y.clamp(-1.0, 1.0).acos() / std::f32::consts::PI)
}

fn icosahedron() -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let golden = 0.5 * (1.0 + 5f32.sqrt());
    // Twelve corners: the cyclic permutations of (0, +-1, +-golden).
    let mut points = Vec::with_capacity(12);
    for axis in 0..3 {
        for (s, t) in [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)] {
            let mut point = [0.0; 3];
            point[(axis + 1) % 3] = s;
            point[(axis + 2) % 3] = t * golden;
            points.push(Vec3::from_array(point).normalize());
        }
    }
    // Faces are the triples of corners one edge apart; the edge is 2 long before normalising.
    let edge = 2.0 / (1.0 + golden * golden).sqrt();
    let near = |a: usize, b: usize| (points[a].distance(points[b]) - edge).abs() < 1e-3;
    let mut triangles = Vec::with_capacity(20);
    for a in 0..12 {
        for b in a + 1..12 {
            for c in b + 1..12 {
                if near(a, b) && near(b, c) && near(a, c) {
                    let outward = (points[b] - points[a]).cross(points[c] - points[a]).dot(points[a]) > 0.0;
                    let face = if outward { [a, b, c] } else { [a, c, b] };
                    triangles.push(face.map(|corner| corner as u32));
                }
            }
        }
    }
    (points, triangles)
}

fn subdivide(points: &mut Vec<Vec3>, triangles: &[[u32; 3]]) -> Vec<[u32; 3]> {
    let mut middles = HashMap::new();
    let mut middle = |a: u32, b: u32| {
        *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
            points.push((points[a as usize] + points[b as usize]).normalize());
            points.len() as u32 - 1
        })
    };
    let split = |&[a, b, c]: &[u32; 3]| {
        let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
        [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]
    };
    triangles.iter().flat_map(split).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area_and_volume(mesh: &Mesh) -> (f32, f32) {
        (0..mesh.triangles.len() as u32).fold((0.0, 0.0), |(area, volume), i| {
            let [a, b, c] = mesh.triangle_positions(i);
            (area + mesh.triangle_area(i), volume + a.dot(b.cross(c)) / 6.0)
        })
    }

    #[test]
    fn sphere_is_round_and_faces_outwards() {
        let mesh = Mesh::sphere("sphere", 2.0, 6, 0);
        assert_eq!(mesh.triangles.len(), 81_920);
        assert!(mesh.positions.iter().all(|p| (p.length() - 2.0).abs() < 1e-5));
        let (area, volume) = area_and_volume(&mesh);
        assert!((area / (16.0 * std::f32::consts::PI) - 1.0).abs() < 1e-3);
        assert!((volume / (32.0 / 3.0 * std::f32::consts::PI) - 1.0).abs() < 1e-3);
        assert!(area_and_volume(&mesh.turned_inside_out()).1 < 0.0);
    }

    #[test]
    fn cuboid_has_its_size_and_faces_outwards() {
        let mesh = Mesh::cuboid("box", Vec3::new(1.0, 2.0, 3.0), 0);
        let (area, volume) = area_and_volume(&mesh);
        assert_eq!((area, volume), (22.0, 6.0));
        let (min, max) = mesh.bounds();
        assert_eq!((min, max), (Vec3::new(-0.5, -1.0, -1.5), Vec3::new(0.5, 1.0, 1.5)));
        for (i, triangle) in mesh.triangles.iter().enumerate() {
            let [a, b, c] = mesh.triangle_positions(i as u32);
            assert!((b - a).cross(c - a).dot(mesh.normals[triangle[0] as usize]) > 0.0);
        }
    }
}
