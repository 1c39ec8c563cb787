//! Materials at points of a scene: their textures, looked up or averaged; and which triangles emit.

use glam::{Vec3, Vec4};

use super::contents::Scene;
use super::light::{AreaTriangle, Light, LightKind};
use super::material::{Alpha, Material, ThinSurface};
use super::mesh::{Mesh, Surface, SurfacePoint};
use super::texture_use::{Attributes, TextureUse};
use crate::bsdf::Bsdf;
use crate::sampling;

/// Points of a triangle at which the texture of its emission is read.
const EMISSION_POINTS: u32 = 16;

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

    /// Share of the light that it reflects at a point, averaged over all directions by the cosine: what a light path keeps.
    pub fn albedo_at(&self, scene: &Scene, at: impl Into<Attributes>) -> Vec3 {
        self.bsdf_at(scene, at).mean_albedo()
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

impl Scene {
    /// Radiance of a triangle, averaged over it, W/m^2/sr.
    fn triangle_emission(&self, mesh: &Mesh, triangle: u32, material: &Material) -> Vec3 {
        if material.emission_texture.is_none() && (!material.unlit || mesh.colours.is_empty()) {
            return material.emission;
        }
        let at = |barycentrics| mesh.interpolate(SurfacePoint { triangle, barycentrics }).attributes;
        let points = sampling::triangle_points(EMISSION_POINTS);
        let sum: Vec3 = points.map(|point| material.emission_at(self, at(point))).sum();
        sum / EMISSION_POINTS as f32
    }

    /// Adds an area light for instance `instance`, with its name, if any of its triangles is emissive.
    pub fn add_area_light(&mut self, instance: usize) {
        let mesh = &self.meshes[self.instances[instance].mesh];
        let mut triangles = Vec::new();
        for (triangle, &material) in (0..).zip(&mesh.triangle_materials) {
            let material = &self.materials[material as usize];
            let radiance = self.triangle_emission(mesh, triangle, material);
            if radiance != Vec3::ZERO {
                let sides = [true, false].into_iter().filter(|&front| material.emits_on(front));
                triangles.extend(sides.map(|front| AreaTriangle { triangle, front, radiance }));
            }
        }
        if !triangles.is_empty() {
            self.lights.push(Light {
                name: self.instances[instance].name.clone(),
                kind: LightKind::Area { instance, triangles },
                position: Vec3::ZERO,
                direction: Vec3::NEG_Y,
                radius: 0.0,
                half_angle: 0.0,
                animation: None,
            });
        }
    }
}
