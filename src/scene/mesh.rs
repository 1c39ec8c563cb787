//! Triangle meshes in object space.

use glam::{Vec2, Vec3};

/// A triangle is degenerate if its height is below this fraction of its longest edge.
const DEGENERATE: f64 = 1e-7;

/// An indexed triangle mesh: one bottom-level BVH.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Name for reports.
    pub name: String,
    /// Vertex positions, object space.
    pub positions: Vec<Vec3>,
    /// Unit shading normals, one a vertex.
    pub normals: Vec<Vec3>,
    /// Texture coordinates, one a vertex, origin at the image's top left; zero where the file has none.
    pub uvs: Vec<Vec2>,
    /// Vertex indices, front faces counter-clockwise; sorted by material.
    pub triangles: Vec<[u32; 3]>,
    /// Material of each triangle, an index into `Scene::materials`.
    pub triangle_materials: Vec<u32>,
}

/// A point on a mesh: triangle and barycentric weights of its second and third vertex.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// Index into [`Mesh::triangles`].
    pub triangle: u32,
    /// Weights (u, v) of vertices 1 and 2; vertex 0 has 1 - u - v.
    pub barycentrics: Vec2,
}

/// Interpolated vertex data at a [`SurfacePoint`], object space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface {
    /// Position, on the flat triangle.
    pub position: Vec3,
    /// Unit shading normal, interpolated; the geometric normal if the vertex normals cancel out.
    pub normal: Vec3,
    /// Unit normal of the triangle, on its counter-clockwise side.
    pub geometric_normal: Vec3,
    /// Texture coordinates.
    pub uv: Vec2,
}

/// The vertex data of one triangle, contiguous in memory: saves the indirection from triangle to vertices for each
/// hit.
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C, align(64))]
pub struct TriangleSurface {
    positions: [Vec3; 3],
    normals: [Vec3; 3],
    pub(crate) uvs: [Vec2; 3],
    geometric_normal: Vec3,
    /// Index into `Scene::materials`.
    pub material: u32,
    /// Pads to two cache lines.
    padding: [u32; 4],
}

impl TriangleSurface {
    /// Interpolates with these weights of the second and third corner.
    #[inline]
    pub fn interpolate(&self, barycentrics: Vec2) -> Surface {
        let (u, v) = (barycentrics.x, barycentrics.y);
        let w = 1.0 - u - v;
        let [a, b, c] = self.positions;
        let shading = self.normals[0] * w + self.normals[1] * u + self.normals[2] * v;
        Surface {
            position: a * w + b * u + c * v,
            normal: shading.normalize_or(self.geometric_normal),
            geometric_normal: self.geometric_normal,
            uv: self.uvs[0] * w + self.uvs[1] * u + self.uvs[2] * v,
        }
    }
}

impl Mesh {
    /// Object-space bounds (min, max) of all vertices; both zero for a mesh without any.
    pub fn bounds(&self) -> (Vec3, Vec3) {
        bounds_of(self.positions.iter().copied()).unwrap_or_default()
    }

    /// Object-space corners of a triangle.
    pub fn triangle_positions(&self, triangle: u32) -> [Vec3; 3] {
        self.triangles[triangle as usize].map(|vertex| self.positions[vertex as usize])
    }

    /// Object-space area of a triangle, in square scene units.
    pub fn triangle_area(&self, triangle: u32) -> f32 {
        let [a, b, c] = self.triangle_positions(triangle);
        0.5 * (b - a).cross(c - a).length()
    }

    /// Position, normals and texture coordinates at `point`.
    pub fn interpolate(&self, point: SurfacePoint) -> Surface {
        self.triangle_surface(point.triangle).interpolate(point.barycentrics)
    }

    /// The vertex data of a triangle.
    pub fn triangle_surface(&self, triangle: u32) -> TriangleSurface {
        let corners = self.triangles[triangle as usize].map(|vertex| vertex as usize);
        let positions = corners.map(|vertex| self.positions[vertex]);
        let [a, b, c] = positions;
        TriangleSurface {
            positions,
            normals: corners.map(|vertex| self.normals[vertex]),
            uvs: corners.map(|vertex| self.uvs[vertex]),
            geometric_normal: (b - a).cross(c - a).normalize_or(Vec3::Y),
            material: self.triangle_materials[triangle as usize],
            padding: [0; 4],
        }
    }

    /// Sorts the triangles by material, keeping their order within one.
    pub(super) fn sort_by_material(&mut self) {
        let mut order: Vec<usize> = (0..self.triangles.len()).collect();
        order.sort_by_key(|&i| self.triangle_materials[i]);
        self.triangles = order.iter().map(|&i| self.triangles[i]).collect();
        self.triangle_materials = order.iter().map(|&i| self.triangle_materials[i]).collect();
    }

    /// Appends the triangles of `other`.
    pub(super) fn append(&mut self, other: Self) {
        let first = self.positions.len() as u32;
        self.positions.extend(other.positions);
        self.normals.extend(other.normals);
        self.uvs.extend(other.uvs);
        self.triangles.extend(other.triangles.iter().map(|triangle| triangle.map(|vertex| first + vertex)));
        self.triangle_materials.extend(other.triangle_materials);
    }

    /// Keeps the triangles for whose index `keep` is true.
    pub(super) fn retain_triangles(&mut self, keep: impl Fn(&Self, usize) -> bool) {
        let kept: Vec<usize> = (0..self.triangles.len()).filter(|&i| keep(self, i)).collect();
        self.triangles = kept.iter().map(|&i| self.triangles[i]).collect();
        self.triangle_materials = kept.iter().map(|&i| self.triangle_materials[i]).collect();
    }

    /// Removes degenerate triangles.
    pub(super) fn drop_degenerate_triangles(&mut self) {
        self.retain_triangles(|mesh, i| {
            let [a, b, c] = mesh.triangle_positions(i as u32).map(|corner| corner.as_dvec3());
            let (ab, ac, bc) = (b - a, c - a, c - b);
            let longest = ab.length_squared().max(ac.length_squared()).max(bc.length_squared());
            ab.cross(ac).length() > DEGENERATE * longest
        });
    }

    /// Renumbers the vertices in order of first use by the triangles, and removes unused ones.
    pub(super) fn drop_unused_vertices(&mut self) {
        const UNUSED: u32 = u32::MAX;
        let mut place = vec![UNUSED; self.positions.len()];
        let mut order = Vec::with_capacity(self.positions.len());
        for vertex in self.triangles.iter_mut().flatten() {
            let slot = &mut place[*vertex as usize];
            if *slot == UNUSED {
                *slot = order.len() as u32;
                order.push(*vertex as usize);
            }
            *vertex = *slot;
        }
        self.positions = order.iter().map(|&i| self.positions[i]).collect();
        self.normals = order.iter().map(|&i| self.normals[i]).collect();
        self.uvs = order.iter().map(|&i| self.uvs[i]).collect();
    }
}

/// Bounds (min, max) of `points`; none for no points.
pub(super) fn bounds_of(points: impl Iterator<Item = Vec3>) -> Option<(Vec3, Vec3)> {
    points.fold(None, |bounds, point| match bounds {
        None => Some((point, point)),
        Some((min, max)) => Some((min.min(point), max.max(point))),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn interpolates_corners_and_edges() {
        let mesh = Mesh {
            name: "triangle".into(),
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
            normals: vec![Vec3::Z, Vec3::X, Vec3::Z],
            uvs: vec![Vec2::ZERO, Vec2::X, Vec2::Y],
            triangles: vec![[0, 1, 2]],
            triangle_materials: vec![0],
        };
        let at = |u, v| mesh.interpolate(SurfacePoint { triangle: 0, barycentrics: Vec2::new(u, v) });
        assert_eq!(at(1.0, 0.0).position, Vec3::X);
        assert_eq!(at(0.0, 1.0).uv, Vec2::Y);
        assert_eq!(at(0.5, 0.0).geometric_normal, Vec3::Z);
        assert!(at(0.5, 0.0).normal.distance(Vec3::new(1.0, 0.0, 1.0).normalize()) < 1e-6);
        assert_eq!(mesh.bounds(), (Vec3::ZERO, Vec3::new(1.0, 1.0, 0.0)));
        assert_eq!(mesh.triangle_area(0), 0.5);
    }
}
