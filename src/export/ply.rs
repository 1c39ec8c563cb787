//! Meshes as PLY files: binary, little-endian, 32-bit floats, with Mitsuba's property names.

use std::io::{self, Write};

use glam::{Vec2, Vec3, Vec4};

/// An indexed triangle mesh to write.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct PlyMesh {
    pub(super) positions: Vec<Vec3>,
    /// One a vertex, or empty.
    pub(super) normals: Vec<Vec3>,
    /// One a vertex, or empty; origin at the top left of an image.
    pub(super) uvs: Vec<Vec2>,
    /// Linear; one a vertex, or empty.
    pub(super) colours: Vec<Vec3>,
    /// With the side of the bitangent; one a vertex, or empty.
    pub(super) tangents: Vec<Vec4>,
    pub(super) triangles: Vec<[u32; 3]>,
}

impl PlyMesh {
    /// Writes the file.
    pub(super) fn write(&self, output: &mut dyn Write) -> io::Result<()> {
        let properties = |names: &[&str], present: bool| {
            let line = |name: &&str| format!("property float {name}\n");
            if present { names.iter().map(line).collect() } else { String::new() }
        };
        write!(
            output,
            "ply\nformat binary_little_endian 1.0\nelement vertex {}\n{}{}{}{}{}element face {}\n\
             property list uchar int vertex_indices\nend_header\n",
            self.positions.len(),
            properties(&["x", "y", "z"], true),
            properties(&["nx", "ny", "nz"], !self.normals.is_empty()),
            properties(&["u", "v"], !self.uvs.is_empty()),
            // Mitsuba names these vertex_color, vertex_tangent and vertex_side.
            properties(&["r", "g", "b"], !self.colours.is_empty()),
            properties(&["tangent_x", "tangent_y", "tangent_z", "side_x"], !self.tangents.is_empty()),
            self.triangles.len(),
        )?;
        for (vertex, position) in self.positions.iter().enumerate() {
            let normal = self.normals.get(vertex).map(Vec3::to_array);
            let uv = self.uvs.get(vertex).map(Vec2::to_array);
            let colour = self.colours.get(vertex).map(Vec3::to_array);
            let tangent = self.tangents.get(vertex).map(Vec4::to_array);
            let floats = position
                .to_array()
                .into_iter()
                .chain(normal.into_iter().flatten())
                .chain(uv.into_iter().flatten())
                .chain(colour.into_iter().flatten())
                .chain(tangent.into_iter().flatten());
            for float in floats {
                output.write_all(&float.to_le_bytes())?;
            }
        }
        for triangle in &self.triangles {
            output.write_all(&[3])?;
            for vertex in triangle {
                output.write_all(&vertex.to_le_bytes())?;
            }
        }
        Ok(())
    }
}
