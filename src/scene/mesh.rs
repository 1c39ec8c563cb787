//! Triangle meshes in object space.

use glam::{Vec2, Vec3, Vec4, Vec4Swizzles};

use super::bounds::bounds_of;
use super::material::Material;
use super::texture_use::Attributes;

/// A triangle is degenerate if its height is below this fraction of its longest edge.
const DEGENERATE: f64 = 1e-7;

/// The colour of vertices without one.
const WHITE: Vec4 = Vec4::ONE;

/// An indexed triangle mesh: one bottom-level BVH.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Name for reports.
    pub name: String,
    /// Vertex positions, object space, about `anchor`.
    pub positions: Vec<Vec3>,
    /// Where the origin of the positions lies in the file's coordinates; zero unless these are far from the origin.
    pub anchor: Vec3,
    /// Unit shading normals, one a vertex.
    pub normals: Vec<Vec3>,
    /// Texture coordinates, one a vertex, origin at the image's top left; zero where the file has none.
    pub uvs: Vec<Vec2>,
    /// A second set of texture coordinates, one a vertex; empty if no material reads it.
    pub second_uvs: Vec<Vec2>,
    /// Tangents of normal maps, one a vertex, as in glTF: xyz points to the right on the image, unit length; w is the side of the
    /// bitangent w (n x t), which points up on it, 1 or -1, or 0 where there is none. Empty without normal maps.
    pub tangents: Vec<Vec4>,
    /// Linear colour and alpha, one a vertex; empty if all are white.
    pub colours: Vec<Vec4>,
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
    /// Greatest magnitudes of the coordinates of the triangle's corners: the rounding error of `position` grows with them.
    pub extent: Vec3,
    /// Unit shading normal, interpolated; the geometric normal if the vertex normals cancel out.
    pub normal: Vec3,
    /// Unit normal of the triangle, on its counter-clockwise side.
    pub geometric_normal: Vec3,
    /// Unit normal by the normal map; `normal` where there is none.
    pub mapped_normal: Vec3,
    /// As [`Mesh::tangents`], not of unit length; 0 where there is none.
    pub tangent: Vec4,
    /// Texture coordinates and colour.
    pub attributes: Attributes,
}

/// The vertex data of one triangle, contiguous in memory: saves the indirection from triangle to vertices for each
/// hit.
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C, align(64))]
pub struct TriangleSurface {
    positions: [Vec3; 3],
    normals: [Vec3; 3],
    uvs: [Vec2; 3],
    geometric_normal: Vec3,
    /// Index into `Scene::materials`.
    pub material: u32,
    /// Pads to two cache lines.
    padding: [u32; 4],
}

impl TriangleSurface {
    /// Interpolates with these weights of the second and third corner, all but what [`Mesh::add_details`] adds.
    #[inline]
    pub fn interpolate(&self, barycentrics: Vec2) -> Surface {
        let (u, v) = (barycentrics.x, barycentrics.y);
        let w = 1.0 - u - v;
        let [a, b, c] = self.positions;
        let shading = self.normals[0] * w + self.normals[1] * u + self.normals[2] * v;
        let normal = shading.normalize_or(self.geometric_normal);
        Surface {
            position: a * w + b * u + c * v,
            extent: a.abs().max(b.abs()).max(c.abs()),
            normal,
            geometric_normal: self.geometric_normal,
            mapped_normal: normal,
            tangent: Vec4::ZERO,
            attributes: (self.uvs[0] * w + self.uvs[1] * u + self.uvs[2] * v).into(),
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

    /// Everything at `point`, but for its normal map.
    pub fn interpolate(&self, point: SurfacePoint) -> Surface {
        let mut surface = self.triangle_surface(point.triangle).interpolate(point.barycentrics);
        self.add_details(point, &mut surface);
        surface
    }

    /// Whether its vertices have more than positions, normals and one set of texture coordinates.
    pub fn has_details(&self) -> bool {
        !(self.second_uvs.is_empty() && self.tangents.is_empty() && self.colours.is_empty())
    }

    /// Interpolates what few meshes have.
    pub fn add_details(&self, point: SurfacePoint, surface: &mut Surface) {
        let corners = self.triangles[point.triangle as usize].map(|vertex| vertex as usize);
        let (u, v) = (point.barycentrics.x, point.barycentrics.y);
        let weights = [1.0 - u - v, u, v];
        let mean = |value: &dyn Fn(usize) -> Vec4| -> Vec4 {
            corners.iter().zip(weights).map(|(&vertex, weight)| value(vertex) * weight).sum()
        };
        if !self.second_uvs.is_empty() {
            surface.attributes.uvs[1] = mean(&|vertex| self.second_uvs[vertex].extend(0.0).extend(0.0)).xy();
        }
        if !self.tangents.is_empty() {
            surface.tangent = mean(&|vertex| self.tangents[vertex]);
        }
        if !self.colours.is_empty() {
            surface.attributes.colour = mean(&|vertex| self.colours[vertex]);
        }
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

    /// Where the corners of a triangle of this material lie on its alpha mask.
    pub(crate) fn mask_coordinates(&self, triangle: u32, material: &Material) -> [Vec2; 3] {
        self.triangles[triangle as usize].map(|vertex| {
            let of = |uvs: &[Vec2]| uvs.get(vertex as usize).copied();
            let first = of(&self.uvs).unwrap_or_default();
            material.mask_coordinates([first, of(&self.second_uvs).unwrap_or(first)])
        })
    }

    /// The alpha of a triangle's corners.
    pub(crate) fn alphas(&self, triangle: u32) -> [f32; 3] {
        let alpha = |vertex: u32| self.colours.get(vertex as usize).map_or(1.0, |colour| colour.w);
        self.triangles[triangle as usize].map(alpha)
    }

    /// Sorts the triangles by material, keeping their order within one.
    pub(crate) fn sort_by_material(&mut self) {
        let mut order: Vec<usize> = (0..self.triangles.len()).collect();
        order.sort_by_key(|&i| self.triangle_materials[i]);
        self.triangles = order.iter().map(|&i| self.triangles[i]).collect();
        self.triangle_materials = order.iter().map(|&i| self.triangle_materials[i]).collect();
    }

    /// Appends the triangles of `other`.
    pub(crate) fn append(&mut self, other: Self) {
        let first = self.positions.len();
        let total = first + other.positions.len();
        self.positions.extend(other.positions);
        self.normals.extend(other.normals);
        append_details(&mut self.second_uvs, other.second_uvs, [first, total], Vec2::ZERO);
        append_details(&mut self.tangents, other.tangents, [first, total], Vec4::ZERO);
        append_details(&mut self.colours, other.colours, [first, total], WHITE);
        self.uvs.extend(other.uvs);
        self.triangles
            .extend(other.triangles.iter().map(|triangle| triangle.map(|vertex| first as u32 + vertex)));
        self.triangle_materials.extend(other.triangle_materials);
    }

    /// Appends a copy of a vertex; returns its index.
    pub(crate) fn repeat_vertex(&mut self, vertex: u32) -> u32 {
        let vertex = vertex as usize;
        self.positions.push(self.positions[vertex]);
        self.normals.push(self.normals[vertex]);
        self.uvs.push(self.uvs[vertex]);
        self.second_uvs.extend(self.second_uvs.get(vertex).copied());
        self.tangents.extend(self.tangents.get(vertex).copied());
        self.colours.extend(self.colours.get(vertex).copied());
        self.positions.len() as u32 - 1
    }

    /// Keeps the triangles for whose index `keep` is true.
    pub(crate) fn retain_triangles(&mut self, keep: impl Fn(&Self, usize) -> bool) {
        let kept: Vec<usize> = (0..self.triangles.len()).filter(|&i| keep(self, i)).collect();
        self.triangles = kept.iter().map(|&i| self.triangles[i]).collect();
        self.triangle_materials = kept.iter().map(|&i| self.triangle_materials[i]).collect();
    }

    /// Removes degenerate triangles.
    pub(crate) fn drop_degenerate_triangles(&mut self) {
        self.retain_triangles(|mesh, i| !mesh.is_degenerate(i));
    }

    /// Whether a triangle has hardly any area for its edges.
    pub(crate) fn is_degenerate(&self, triangle: usize) -> bool {
        let [a, b, c] = self.triangle_positions(triangle as u32).map(|corner| corner.as_dvec3());
        let (ab, ac, bc) = (b - a, c - a, c - b);
        let longest = ab.length_squared().max(ac.length_squared()).max(bc.length_squared());
        let has_area = ab.cross(ac).length() > DEGENERATE * longest;
        !has_area
    }

    /// Gives each triangle three vertices of its own, in order.
    pub(crate) fn unshare_vertices(&mut self) {
        let order: Vec<usize> = self.triangles.iter().flatten().map(|&vertex| vertex as usize).collect();
        self.select_vertices(&order);
        self.triangles = (0..order.len() as u32 / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    }

    fn select_vertices(&mut self, order: &[usize]) {
        select(&mut self.positions, order);
        select(&mut self.normals, order);
        select(&mut self.uvs, order);
        select(&mut self.second_uvs, order);
        select(&mut self.tangents, order);
        select(&mut self.colours, order);
    }

    /// Renumbers the vertices in order of first use by the triangles, and removes unused ones.
    pub(crate) fn drop_unused_vertices(&mut self) {
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
        self.select_vertices(&order);
    }
}

/// The elements of `order`; none stay none.
fn select<T: Copy>(elements: &mut Vec<T>, order: &[usize]) {
    if !elements.is_empty() {
        *elements = order.iter().map(|&i| elements[i]).collect();
    }
}

/// Appends what `more` has of an attribute to that of the `first` vertices, if either has any, up to `total`.
fn append_details<T: Copy>(all: &mut Vec<T>, more: Vec<T>, [first, total]: [usize; 2], default: T) {
    if !(all.is_empty() && more.is_empty()) {
        all.resize(first, default);
        all.extend(more);
        all.resize(total, default);
    }
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
            ..Mesh::default()
        };
        let at = |u, v| mesh.interpolate(SurfacePoint { triangle: 0, barycentrics: Vec2::new(u, v) });
        assert_eq!(at(1.0, 0.0).position, Vec3::X);
        assert_eq!(at(0.0, 1.0).attributes, Vec2::Y.into());
        assert_eq!(at(0.5, 0.0).geometric_normal, Vec3::Z);
        assert!(at(0.5, 0.0).normal.distance(Vec3::new(1.0, 0.0, 1.0).normalize()) < 1e-6);
        assert_eq!(mesh.bounds(), (Vec3::ZERO, Vec3::new(1.0, 1.0, 0.0)));
        assert_eq!(mesh.triangle_area(0), 0.5);
    }
}
