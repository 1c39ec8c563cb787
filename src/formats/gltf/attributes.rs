//! The attributes of a primitive's vertices.
//!
//! In: a primitive. Out: a vector for each vertex, or an error that names the primitive.

use ::gltf::{Accessor, Primitive, Semantic};
use glam::{Vec2, Vec3, Vec4};

use super::source::Source;
use crate::formats::error::SceneError;
use crate::scene::{Material, Mesh};

/// Reads a primitive's attributes.
pub(super) struct Attributes<'a> {
    pub source: &'a Source,
    pub primitive: &'a Primitive<'a>,
    /// Names it in errors.
    pub place: &'a str,
    /// The number of its vertices.
    pub count: usize,
}

impl Attributes<'_> {
    /// One attribute, if it is there.
    pub fn read<const N: usize>(
        &self,
        semantic: &Semantic,
        what: &str,
    ) -> Result<Option<Vec<[f32; N]>>, SceneError> {
        let Some(accessor) = self.primitive.get(semantic) else { return Ok(None) };
        let values = match semantic {
            // The specification lets these be integers, whatever else is.
            Semantic::Colors(_) | Semantic::Joints(_) | Semantic::Weights(_) => {
                self.of_each_vertex(self.source.vectors(&accessor, what)?, what)
            }
            _ => self.values(&accessor, what),
        };
        values.map(Some)
    }

    /// The numbers of an accessor, which must be one for each vertex.
    pub fn values<const N: usize>(
        &self,
        accessor: &Accessor<'_>,
        what: &str,
    ) -> Result<Vec<[f32; N]>, SceneError> {
        self.of_each_vertex(self.source.vertices(accessor, what)?, what)
    }

    fn of_each_vertex<T>(&self, values: Vec<T>, what: &str) -> Result<Vec<T>, SceneError> {
        if values.len() == self.count {
            return Ok(values);
        }
        let (count, given) = (self.count, values.len());
        let problem = format!("{} has {count} positions, but {given} {what}", self.place);
        Err(self.source.error(format!("{problem}; export the file again")))
    }

    /// Adds texture coordinates, and what else the material needs and is there.
    pub fn add_to(&self, piece: &mut Mesh, material: &Material) -> Result<(), SceneError> {
        let set = |set| self.read::<2>(&Semantic::TexCoords(set), "texture coordinates");
        let vectors = |uvs: Option<Vec<[f32; 2]>>| match uvs {
            Some(uvs) => uvs.into_iter().map(Vec2::from_array).collect(),
            None => vec![Vec2::ZERO; self.count],
        };
        piece.uvs = vectors(set(0)?);
        if material.textures().any(|texture| texture.set == 1) {
            piece.second_uvs = vectors(set(1)?);
        }
        if material.normal_texture.is_some()
            && let Some(tangents) = self.read::<4>(&Semantic::Tangents, "tangents")?
        {
            piece.tangents = tangents.into_iter().map(Vec4::from_array).collect();
        }
        let of_three = self
            .primitive
            .get(&Semantic::Colors(0))
            .is_some_and(|accessor| accessor.dimensions().multiplicity() == 3);
        let colours: Option<Vec<Vec4>> = if of_three {
            let colours = self.read::<3>(&Semantic::Colors(0), "colours")?;
            colours.map(|colours| colours.into_iter().map(|c| Vec3::from_array(c).extend(1.0)).collect())
        } else {
            let colours = self.read::<4>(&Semantic::Colors(0), "colours")?;
            colours.map(|colours| colours.into_iter().map(Vec4::from_array).collect())
        };
        let clamped = |colour: Vec4| colour.clamp(Vec4::ZERO, Vec4::ONE);
        piece.colours = colours.unwrap_or_default().into_iter().map(clamped).collect();
        Ok(())
    }
}
