//! Materials at points of a scene: their textures, looked up or averaged.

use glam::{Vec3, Vec4};

use super::contents::Scene;
use super::material::{Alpha, Material, ThinSurface};
use super::mesh::{Mesh, Surface};
use super::texture_use::{Attributes, TextureUse};
use crate::bsdf::Bsdf;

impl TextureUse {
    /// Linear colour (level 0, bilinear).
    pub(crate) fn sample(&self, scene: &Scene, at: &Attributes) -> Vec3 {
        let image = &scene.textures[self.texture];
        image.filter(image.footprint(self.coordinates(at.uvs), self))
    }
}

impl Material {
    /// Its reflection at a point (textures bilinear, level 0).
    pub fn bsdf_at(&self, scene: &Scene, at: impl Into<Attributes>) -> Bsdf {
        let at = at.into();
        self.bsdf(scene, texel(scene, self.base_colour_texture, &at), &at)
    }

    /// The same, where the texture of the base colour has the colour `texel`.
    pub(crate) fn bsdf(&self, scene: &Scene, base: Vec3, at: &Attributes) -> Bsdf {
        let data = texel(scene, self.metallic_roughness_texture, at);
        self.bsdf_of(base * at.colour.truncate(), data)
    }

    /// Its reflection, averaged over its textures.
    pub fn mean_bsdf(&self, scene: &Scene) -> Bsdf {
        self.bsdf_of(mean(scene, self.base_colour_texture), mean(scene, self.metallic_roughness_texture))
    }

    /// Looks up the normal map at a point of an object.
    pub(crate) fn map_normal(&self, scene: &Scene, surface: &mut Surface) {
        let (Some(map), true) = (&self.normal_texture, surface.tangent.w != 0.0) else { return };
        let [x, y, z] = (map.sample(scene, &surface.attributes) * 2.0 - 1.0).to_array();
        let normal = surface.normal;
        let tangent = surface.tangent.truncate().normalize_or_zero();
        let bitangent = normal.cross(tangent) * surface.tangent.w.signum();
        let slope = (tangent * x + bitangent * y) * self.normal_scale;
        surface.mapped_normal = (slope + normal * z).normalize_or(normal);
    }

    /// Base colour, averaged over its texture.
    pub fn mean_base(&self, scene: &Scene) -> Vec3 {
        self.base_colour * mean(scene, self.base_colour_texture)
    }

    /// Radiance of the sides that emit at a point, W/m^2/sr.
    pub fn emission_at(&self, scene: &Scene, at: impl Into<Attributes>) -> Vec3 {
        if !self.is_emissive() {
            return Vec3::ZERO;
        }
        let at = at.into();
        let colour = if self.unlit { at.colour.truncate() } else { Vec3::ONE };
        self.emission * colour * texel(scene, self.emission_texture, &at)
    }

    /// Whether it varies over a triangle of `mesh`.
    pub(crate) fn emission_varies(&self, mesh: &Mesh) -> bool {
        self.emission_texture.is_some() || self.unlit && !mesh.colours.is_empty()
    }

    /// The same, averaged over its texture.
    pub fn mean_emission(&self, scene: &Scene) -> Vec3 {
        self.emission * mean(scene, self.emission_texture)
    }

    /// How much of a thin surface is there at a point: its share of an opaque surface's reflection; and what that lets pass.
    pub fn thin_surface_at(&self, scene: &Scene, at: impl Into<Attributes>) -> ThinSurface {
        let at = at.into();
        let texel = self.base_colour_texture.map_or(Vec4::ONE, |texture| {
            scene.textures[texture.texture].sample_rgba(texture.coordinates(at.uvs), &texture)
        });
        let colour = texel * at.colour;
        let coverage = if self.alpha == Alpha::Blend { self.opacity * colour.w } else { 1.0 };
        ThinSurface { coverage, passed: self.passed() * colour.truncate() }
    }
}

fn texel(scene: &Scene, texture: Option<TextureUse>, at: &Attributes) -> Vec3 {
    texture.map_or(Vec3::ONE, |texture| texture.sample(scene, at))
}

fn mean(scene: &Scene, texture: Option<TextureUse>) -> Vec3 {
    texture.map_or(Vec3::ONE, |texture| scene.textures[texture.texture].mean())
}
