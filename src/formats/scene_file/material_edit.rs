//! The `[[materials]]` of a scene file: what is other than in the files of the models.
//!
//! In: the materials of all models, and an edit of those of one name. Out: the materials changed.

use std::path::Path;

use glam::Vec3;
use serde::{Deserialize, Serialize};

use super::entry::Entry;
use crate::formats::error::SceneError;
use crate::scene::{GLTF_F0, Material};

/// An edit of all materials of one name; a missing key leaves what the file says.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MaterialEdit {
    /// Name of the materials.
    pub name: String,
    /// Linear, each channel from 0 to 1.
    pub base_colour: Option<[f32; 3]>,
    /// Share of metal, 0 to 1. Makes a Lambertian surface reflect as glTF's materials do, like `roughness`.
    pub metallic: Option<f32>,
    /// Perceptual roughness, 0 to 1.
    pub roughness: Option<f32>,
    /// Radiance, W/m^2/sr.
    pub emission: Option<[f32; 3]>,
    /// Alpha of a surface that blends, 0 to 1.
    pub opacity: Option<f32>,
    /// Share of the diffuse reflection that passes instead, 0 to 1.
    pub transmission: Option<f32>,
    /// What the slopes of the normal map are multiplied by.
    pub normal_scale: Option<f32>,
}

impl MaterialEdit {
    /// The edit that turns `file` into `now`, as far as an edit can.
    pub fn between(file: &Material, now: &Material) -> Self {
        let number = |file: f32, now: f32| (file != now).then_some(now);
        let colour = |file: Vec3, now: Vec3| (file != now).then(|| now.to_array());
        Self {
            name: file.name.clone(),
            base_colour: colour(file.base_colour, now.base_colour),
            metallic: number(file.metallic, now.metallic),
            roughness: number(file.roughness, now.roughness),
            emission: colour(file.emission, now.emission),
            opacity: number(file.opacity, now.opacity),
            transmission: number(file.transmission, now.transmission),
            normal_scale: number(file.normal_scale, now.normal_scale),
        }
    }

    /// Whether it changes nothing.
    pub fn is_empty(&self) -> bool {
        *self == Self { name: self.name.clone(), ..Self::default() }
    }

    /// Edits a material; the values were checked.
    pub fn apply(&self, material: &mut Material) {
        let numbers = [
            (self.metallic, &mut material.metallic),
            (self.roughness, &mut material.roughness),
            (self.opacity, &mut material.opacity),
            (self.transmission, &mut material.transmission),
            (self.normal_scale, &mut material.normal_scale),
        ];
        for (given, number) in numbers {
            *number = given.unwrap_or(*number);
        }
        let colours =
            [(self.base_colour, &mut material.base_colour), (self.emission, &mut material.emission)];
        for (given, colour) in colours {
            *colour = given.map_or(*colour, Vec3::from_array);
        }
        let is_lambertian = material.f0 == Vec3::ZERO && material.f90 == 0.0;
        if is_lambertian && (self.metallic.is_some() || self.roughness.is_some()) {
            (material.f0, material.f90) = (GLTF_F0, 1.0);
        }
    }

    /// Checks the values of an entry.
    pub(super) fn check(&self, entry: &Entry) -> Result<(), SceneError> {
        self.base_colour.map(|colour| entry.reflectance("base_colour", colour)).transpose()?;
        self.emission.map(|radiance| entry.power("emission", radiance)).transpose()?;
        self.normal_scale.map(|scale| entry.number("normal_scale", scale)).transpose()?;
        for (key, share) in [
            ("metallic", self.metallic),
            ("roughness", self.roughness),
            ("opacity", self.opacity),
            ("transmission", self.transmission),
        ] {
            share.map(|share| entry.share(key, share)).transpose()?;
        }
        Ok(())
    }

    /// Checks the values, as for a scene file at `path`.
    pub(crate) fn check_alone(&self, path: &Path) -> Result<(), SceneError> {
        self.check(&Entry::edited(path, format!("material \"{}\"", self.name)))
    }
}
