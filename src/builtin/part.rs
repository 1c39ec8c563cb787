//! Parts of the built-in models: meshes of solids and open surfaces.
//!
//! In: vertices and triangles without normals. Out: placed meshes with normals, and finally one mesh of all. The
//! models are single meshes like the scenes that they replace, not instances of columns and chairs; rays traverse
//! a single bottom level fastest.

use glam::{Affine3A, Vec2, Vec3};

use crate::scene::Mesh;
use crate::scene::normals;

/// A group of solids and open surfaces. Texture coordinates are in metres until [`Part::into_mesh`].
#[derive(Clone, Debug, Default)]
pub(super) struct Part {
    /// Each one closed solid, or one open surface.
    pub pieces: Vec<Mesh>,
}

impl Part {
    /// A part of one piece, with generated normals: smooth except at creases of 40 degrees or more.
    pub fn of(mut piece: Mesh) -> Self {
        piece.drop_degenerate_triangles();
        normals::fill_missing(&mut piece);
        Self { pieces: vec![piece] }
    }

    /// Appends the pieces of `other`.
    pub fn push(&mut self, other: Part) {
        self.pieces.extend(other.pieces);
    }

    /// This part with the pieces of `other`.
    pub fn and(mut self, other: Part) -> Self {
        self.push(other);
        self
    }

    /// A transformed copy; faces keep their orientation under a mirroring `transform`.
    pub fn placed(&self, transform: &Affine3A) -> Self {
        Self { pieces: self.pieces.iter().map(|piece| transformed(piece, transform)).collect() }
    }

    /// A translated copy.
    pub fn at(&self, offset: Vec3) -> Self {
        self.placed(&Affine3A::from_translation(offset))
    }

    /// A copy, rotated about the y axis, then translated.
    pub fn turned(&self, degrees: f32, offset: Vec3) -> Self {
        self.placed(&(Affine3A::from_translation(offset) * Affine3A::from_rotation_y(degrees.to_radians())))
    }

    /// Adds copies of `other` at `places`.
    pub fn push_at(&mut self, other: &Part, places: impl IntoIterator<Item = Vec3>) {
        for place in places {
            self.push(other.at(place));
        }
    }

    /// Triangle count of all pieces.
    pub fn triangle_count(&self) -> usize {
        self.pieces.iter().map(|piece| piece.triangles.len()).sum()
    }

    /// All pieces as one mesh, sorted by material. `tiles` are the texture sizes of the materials, metres.
    pub fn into_mesh(self, name: &str, tiles: &[Vec2]) -> Mesh {
        let mut mesh = Mesh { name: name.to_owned(), ..Mesh::default() };
        let vertices = self.pieces.iter().map(|piece| piece.positions.len()).sum();
        mesh.positions.reserve(vertices);
        mesh.normals.reserve(vertices);
        mesh.uvs.reserve(vertices);
        mesh.triangles.reserve(self.triangle_count());
        mesh.triangle_materials.reserve(self.triangle_count());
        for mut piece in self.pieces {
            let first = mesh.positions.len() as u32;
            let mut tile = vec![Vec2::ONE; piece.positions.len()];
            for (triangle, &material) in piece.triangles.iter().zip(&piece.triangle_materials) {
                for &vertex in triangle {
                    tile[vertex as usize] = tiles[material as usize];
                }
                mesh.triangles.push(triangle.map(|vertex| first + vertex));
            }
            mesh.uvs.extend(piece.uvs.iter().zip(tile).map(|(uv, tile)| *uv / tile));
            mesh.positions.append(&mut piece.positions);
            mesh.normals.append(&mut piece.normals);
            mesh.triangle_materials.append(&mut piece.triangle_materials);
        }
        mesh.sort_by_material();
        mesh.drop_unused_vertices();
        mesh
    }
}

fn transformed(piece: &Mesh, transform: &Affine3A) -> Mesh {
    let mut piece = piece.clone();
    let normal_matrix = transform.matrix3.inverse().transpose();
    for position in &mut piece.positions {
        *position = transform.transform_point3(*position);
    }
    for normal in &mut piece.normals {
        *normal = Vec3::from(normal_matrix * glam::Vec3A::from(*normal)).normalize_or(*normal);
    }
    if transform.matrix3.determinant() < 0.0 {
        for triangle in &mut piece.triangles {
            triangle.swap(1, 2);
        }
    }
    piece
}

/// Appends a vertex without a normal.
pub(super) fn push_vertex(mesh: &mut Mesh, position: Vec3, uv: Vec2) -> u32 {
    mesh.positions.push(position);
    mesh.normals.push(Vec3::ZERO);
    mesh.uvs.push(uv);
    mesh.positions.len() as u32 - 1
}

/// Appends a triangle of existing vertices.
pub(super) fn push_triangle(mesh: &mut Mesh, corners: [u32; 3], material: u32) {
    mesh.triangles.push(corners);
    mesh.triangle_materials.push(material);
}

/// Appends a quad of existing vertices, counter-clockwise.
pub(super) fn push_quad(mesh: &mut Mesh, [a, b, c, d]: [u32; 4], material: u32) {
    push_triangle(mesh, [a, b, c], material);
    push_triangle(mesh, [a, c, d], material);
}

/// Planar texture coordinates (metres) along the two dominant axes of a face with this normal: right and down on
/// walls.
pub(super) fn face_uv(position: Vec3, normal: Vec3) -> Vec2 {
    let n = normal.abs();
    if n.y >= n.x && n.y >= n.z {
        Vec2::new(position.x, position.z)
    } else if n.x >= n.z {
        Vec2::new(position.z, -position.y)
    } else {
        Vec2::new(position.x, -position.y)
    }
}
