//! Triangle meshes in object space.

use glam::{Vec2, Vec3};

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
    /// Vertex indices, counter-clockwise seen from the front; sorted by material.
    pub triangles: Vec<[u32; 3]>,
    /// Material of each triangle, an index into `Scene::materials`.
    pub triangle_materials: Vec<u32>,
}

/// A place on a mesh: triangle and barycentric weights of its second and third vertex.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// Index into [`Mesh::triangles`].
    pub triangle: u32,
    /// Weights (u, v) of vertices 1 and 2; vertex 0 has 1 - u - v.
    pub barycentrics: Vec2,
}
