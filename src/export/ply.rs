//! Meshes as PLY files: binary, little-endian, 32-bit floats, with Mitsuba's property names.

use std::io::{self, Write};

use bytemuck::cast_slice;
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
    /// Tangent and side of the bitangent; one a vertex, or empty.
    pub(super) tangents: Vec<Vec4>,
    pub(super) triangles: Vec<[u32; 3]>,
}

impl PlyMesh {
    /// Writes the file.
    pub(super) fn write(&self, output: &mut dyn Write) -> io::Result<()> {
        let lanes: [(&[&str], &[f32]); 5] = [
            (&["x", "y", "z"], cast_slice(&self.positions)),
            (&["nx", "ny", "nz"], cast_slice(&self.normals)),
            (&["u", "v"], cast_slice(&self.uvs)),
            // Mitsuba names these vertex_color, vertex_tangent and vertex_side.
            (&["r", "g", "b"], cast_slice(&self.colours)),
            (&["tangent_x", "tangent_y", "tangent_z", "side_x"], cast_slice(&self.tangents)),
        ];
        let (vertices, triangles) = (self.positions.len(), self.triangles.len());
        writeln!(output, "ply\nformat binary_little_endian 1.0\nelement vertex {vertices}")?;
        let present = || lanes.iter().filter(|(_, floats)| !floats.is_empty());
        for name in present().flat_map(|(names, _)| *names) {
            writeln!(output, "property float {name}")?;
        }
        let indices = "property list uchar int vertex_indices";
        writeln!(output, "element face {triangles}\n{indices}\nend_header")?;
        for vertex in 0..vertices {
            for float in present().flat_map(|(names, floats)| &floats[names.len() * vertex..][..names.len()])
            {
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
