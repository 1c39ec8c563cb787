//! Generates missing tangents with MikkTSpace (Mikkelsen 2008), which normal maps are baked for.
//!
//! In: a mesh with normals and texture coordinates. Out: a tangent at each corner of a triangle whose material has a normal
//! map; vertices whose triangles differ in it are split.

use std::collections::HashMap;
use std::ops::Range;

use bevy_mikktspace::{Geometry, TangentSpace, generate_tangents};
use glam::{Vec2, Vec3, Vec4};

use super::material::Material;
use super::mesh::Mesh;
use super::texture_use::TextureUse;

/// Tangents closer to the normal than this span no plane.
const LEAST_ANGLE: f32 = 1e-3;

/// The triangles of one normal map, by whose coordinates they get their tangents.
struct Part<'a> {
    mesh: &'a Mesh,
    triangles: Range<usize>,
    map: TextureUse,
    /// Tangent of each corner of each triangle; 0 where there is none.
    tangents: Vec<Vec4>,
}

impl Part<'_> {
    fn vertex(&self, face: usize, corner: usize) -> usize {
        self.mesh.triangles[self.triangles.start + face][corner] as usize
    }
}

impl Geometry for Part<'_> {
    fn num_faces(&self) -> usize {
        self.triangles.len()
    }

    fn num_vertices_of_face(&self, _face: usize) -> usize {
        3
    }

    fn position(&self, face: usize, corner: usize) -> [f32; 3] {
        self.mesh.positions[self.vertex(face, corner)].to_array()
    }

    fn normal(&self, face: usize, corner: usize) -> [f32; 3] {
        self.mesh.normals[self.vertex(face, corner)].to_array()
    }

    fn tex_coord(&self, face: usize, corner: usize) -> [f32; 2] {
        let vertex = self.vertex(face, corner);
        let first = self.mesh.uvs[vertex];
        let uv = self.map.coordinates([first, self.mesh.second_uvs.get(vertex).copied().unwrap_or(first)]);
        // The green of normal maps points up on the image, while v counts from its top.
        Vec2::new(uv.x, 1.0 - uv.y).to_array()
    }

    fn set_tangent(&mut self, tangent: Option<TangentSpace>, face: usize, corner: usize) {
        let tangent = tangent.map_or(Vec4::ZERO, |tangent| Vec4::from_array(tangent.tangent_encoded()));
        self.tangents[3 * face + corner] = usable(tangent, self.mesh.normals[self.vertex(face, corner)]);
    }
}

/// The tangent with unit length and a side of 1 or -1; 0 if it has no side or spans no plane with the normal.
pub(crate) fn usable(tangent: Vec4, normal: Vec3) -> Vec4 {
    let direction = tangent.truncate().normalize_or_zero();
    let spans = tangent.w.is_finite() && tangent.w != 0.0 && direction.cross(normal).length() > LEAST_ANGLE;
    if spans { direction.extend(tangent.w.signum()) } else { Vec4::ZERO }
}

/// Generates the tangents of those triangles that need them and lack one. The mesh is sorted by material.
pub(crate) fn fill_missing(mesh: &mut Mesh, materials: &[Material]) {
    let mut parts = Vec::new();
    let mut first = 0;
    for run in mesh.triangle_materials.chunk_by(|a, b| a == b) {
        let triangles = first..first + run.len();
        first = triangles.end;
        let Some(map) = materials[run[0] as usize].normal_texture else { continue };
        let has_tangent = |&vertex: &u32| mesh.tangents.get(vertex as usize).is_some_and(|t| t.w != 0.0);
        if mesh.triangles[triangles.clone()].iter().flatten().all(has_tangent) {
            continue;
        }
        let tangents = vec![Vec4::ZERO; 3 * triangles.len()];
        let mut part = Part { mesh, triangles, map, tangents };
        // It has no errors.
        if generate_tangents(&mut part).is_ok() {
            parts.push((part.triangles, part.tangents));
        }
    }
    for (triangles, tangents) in parts {
        assign(mesh, triangles, &tangents);
    }
}

/// Gives the corners of `triangles` their tangents.
fn assign(mesh: &mut Mesh, triangles: Range<usize>, tangents: &[Vec4]) {
    mesh.tangents.resize(mesh.positions.len(), Vec4::ZERO);
    // The vertices that stand for an original one, by its index and tangent.
    let mut made: HashMap<(u32, [u32; 4]), u32> = HashMap::new();
    let mut given = vec![false; mesh.positions.len()];
    for (index, &tangent) in tangents.iter().enumerate() {
        let (triangle, corner) = (triangles.start + index / 3, index % 3);
        let vertex = mesh.triangles[triangle][corner];
        let key = (vertex, tangent.to_array().map(f32::to_bits));
        let place = *made.entry(key).or_insert_with(|| {
            let is_free = !std::mem::replace(&mut given[vertex as usize], true)
                && mesh.tangents[vertex as usize] == Vec4::ZERO;
            let place = if is_free { vertex } else { mesh.repeat_vertex(vertex) };
            mesh.tangents[place as usize] = tangent;
            place
        });
        mesh.triangles[triangle][corner] = place;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mapped() -> Vec<Material> {
        vec![Material { normal_texture: Some(0.into()), ..Material::grey("mapped") }]
    }

    /// Quads' coordinates have u to the right and v downwards.
    #[test]
    fn tangents_point_to_the_right_of_the_image() {
        let mut mesh = Mesh::polygon("quad", &[Vec3::ZERO, Vec3::X, Vec3::X + Vec3::Y, Vec3::Y], 0);
        fill_missing(&mut mesh, &mapped());
        assert_eq!(mesh.positions.len(), 4);
        assert!(mesh.tangents.iter().all(|tangent| tangent.distance(Vec4::new(1.0, 0.0, 0.0, 1.0)) < 1e-6));
        // Mirrored, what is right of the image is left on the quad; up stays up.
        mesh.tangents.clear();
        mesh.uvs.iter_mut().for_each(|uv| uv.x = 1.0 - uv.x);
        fill_missing(&mut mesh, &mapped());
        assert!(mesh.tangents.iter().all(|tangent| tangent.distance(Vec4::new(-1.0, 0.0, 0.0, -1.0)) < 1e-6));
    }

    #[test]
    fn vertices_are_split_where_the_image_is_mirrored() {
        // Two quads that share an edge, with u rising towards it from both sides.
        let mut mesh = Mesh {
            positions: [[0, 0], [1, 0], [2, 0], [0, 1], [1, 1], [2, 1]]
                .map(|[x, y]| Vec3::new(x as f32, y as f32, 0.0))
                .to_vec(),
            normals: vec![Vec3::Z; 6],
            uvs: [[0, 1], [1, 1], [0, 1], [0, 0], [1, 0], [0, 0]]
                .map(|[u, v]| Vec2::new(u as f32, v as f32))
                .to_vec(),
            triangles: vec![[0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4]],
            triangle_materials: vec![0; 4],
            ..Mesh::default()
        };
        fill_missing(&mut mesh, &mapped());
        assert_eq!((mesh.positions.len(), mesh.uvs.len(), mesh.tangents.len()), (8, 8, 8));
        for (triangle, expected) in mesh.triangles.iter().zip([1.0, 1.0, -1.0, -1.0]) {
            for &vertex in triangle {
                let tangent = mesh.tangents[vertex as usize];
                assert!(tangent.distance(Vec4::new(expected, 0.0, 0.0, expected)) < 1e-6, "{tangent}");
            }
        }
    }

    #[test]
    fn without_coordinates_there_is_no_tangent_that_is_not_finite() {
        let mut mesh = Mesh::polygon("quad", &[Vec3::ZERO, Vec3::X, Vec3::X + Vec3::Y, Vec3::Y], 0);
        mesh.uvs.fill(Vec2::ZERO);
        fill_missing(&mut mesh, &mapped());
        assert!(mesh.tangents.iter().all(|tangent| tangent.is_finite()));
        let mut plain = Mesh::cuboid("box", Vec3::ONE, 0);
        fill_missing(&mut plain, &[Material::grey("plain")]);
        assert!(plain.tangents.is_empty());
    }
}
