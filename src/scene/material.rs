//! Surface materials and their textures.

use glam::{Vec2, Vec3};

use super::texture_use::TextureUse;
use crate::bsdf::Bsdf;

/// Reflectance of dielectrics at normal incidence in glTF.
pub(crate) const GLTF_F0: Vec3 = Vec3::splat(0.04);

/// How the alpha of the base colour is used.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Alpha {
    /// Not at all.
    #[default]
    Opaque,
    /// The surface is there where alpha is at least this: see [`Material::alpha_mask`].
    Mask(f32),
    /// It is a thin surface: alpha is the share of it that is there, and light passes the rest without refraction.
    Blend,
}

/// A surface, as in glTF 2.0: metallic-roughness, see [`Bsdf`].
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Name in the file.
    pub name: String,
    /// Base colour, linear, multiplied with its texture and the vertices' colours; each channel in [0, 1].
    pub base_colour: Vec3,
    /// sRGB colour and alpha.
    pub base_colour_texture: Option<TextureUse>,
    /// Share of metal, 0 to 1, multiplied with the blue channel of its texture.
    pub metallic: f32,
    /// Perceptual roughness, 0 to 1, multiplied with the green channel of its texture. 0: a perfect mirror.
    pub roughness: f32,
    /// Linear, green and blue.
    pub metallic_roughness_texture: Option<TextureUse>,
    /// Reflectance of its dielectric part at normal incidence; 0.04 in glTF.
    pub f0: Vec3,
    /// Reflectance at grazing incidence; 1 in glTF. 0, with an `f0` of 0: a Lambertian surface.
    pub f90: f32,
    /// Radiance of the sides that emit, multiplied with its texture, W/m^2/sr.
    pub emission: Vec3,
    /// sRGB.
    pub emission_texture: Option<TextureUse>,
    /// Linear: the normal in the frame of tangent, bitangent and normal, from -1 to 1, as in glTF.
    pub normal_texture: Option<TextureUse>,
    /// Factor on the slopes of the normal map.
    pub normal_scale: f32,
    /// How alpha is used.
    pub alpha: Alpha,
    /// Alpha, 0 to 1, multiplied with that of the base colour's texture and of the vertices' colours.
    pub opacity: f32,
    /// Share of what the base colour reflects diffusely that it lets pass instead, tinted: a thin surface without refraction.
    pub transmission: f32,
    /// Whether its back shows to the eye; all other rays meet both sides.
    pub double_sided: bool,
    /// Whether its back emits as its front does.
    pub emits_on_both_sides: bool,
    /// Whether its emission is that of its base colour, and so multiplied with the vertices' colours (KHR_materials_unlit).
    pub unlit: bool,
    /// Index into `Scene::alpha_masks`; set where parts of the surface are cut out, never where it blends. What is cut out does not
    /// emit.
    pub alpha_mask: Option<usize>,
}

/// An image with its mip chain.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// File name for reports.
    pub name: String,
    /// Whether its colour is linear; otherwise sRGB-encoded.
    pub linear: bool,
    /// Whether texels are half floats, of linear colour, for images of more than 8 bits a channel; otherwise bytes.
    pub half: bool,
    /// RGBA of 8 bits or little-endian half floats, alpha always linear; level 0 first, each level half the one before
    /// (rounded down, at least 1), filtered in linear light. (width, height, texels by rows from the top).
    pub levels: Vec<(u32, u32, Vec<u8>)>,
}

impl Material {
    /// A grey Lambertian surface of albedo 0.5 without emission: the fallback for a missing material.
    pub fn grey(name: &str) -> Self {
        Self::lambertian(name, Vec3::splat(0.5))
    }

    /// A Lambertian surface of the given albedo, linear.
    pub fn lambertian(name: &str, albedo: Vec3) -> Self {
        Self {
            name: name.to_owned(),
            base_colour: albedo,
            base_colour_texture: None,
            metallic: 0.0,
            roughness: 1.0,
            metallic_roughness_texture: None,
            f0: Vec3::ZERO,
            f90: 0.0,
            emission: Vec3::ZERO,
            emission_texture: None,
            normal_texture: None,
            normal_scale: 1.0,
            alpha: Alpha::Opaque,
            opacity: 1.0,
            transmission: 0.0,
            double_sided: true,
            emits_on_both_sides: false,
            unlit: false,
            alpha_mask: None,
        }
    }

    /// A black surface that emits `radiance`, W/m^2/sr.
    pub fn emitter(name: &str, radiance: Vec3) -> Self {
        Self { emission: radiance, ..Self::lambertian(name, Vec3::ZERO) }
    }

    /// This surface under a coat that reflects `f0` at normal incidence, as smooth as a Phong highlight of the exponent
    /// `shininess`: see [`roughness_of_exponent`].
    pub fn coated(self, f0: Vec3, shininess: f32) -> Self {
        let f90 = if f0 == Vec3::ZERO { 0.0 } else { 1.0 };
        Self { f0, f90, roughness: roughness_of_exponent(shininess), ..self }
    }

    /// Textures: base colour, metallic and roughness, emission, normal.
    pub fn texture_uses(&self) -> [Option<TextureUse>; 4] {
        [
            self.base_colour_texture,
            self.metallic_roughness_texture,
            self.emission_texture,
            self.normal_texture,
        ]
    }

    /// The textures that it has.
    pub fn textures(&self) -> impl Iterator<Item = TextureUse> {
        self.texture_uses().into_iter().flatten()
    }

    /// BSDF where its textures have these values.
    pub(super) fn bsdf_of(&self, texel: Vec3, data: Vec3) -> Bsdf {
        Bsdf {
            base: self.reflected_base() * texel,
            metallic: self.metallic * data.z,
            roughness: self.roughness * data.y,
            f0: self.f0,
            f90: self.f90,
        }
    }

    /// Base colour without what passes, to be multiplied with its texture. Metals let nothing pass.
    pub(crate) fn reflected_base(&self) -> Vec3 {
        self.base_colour * (1.0 - self.transmission * (1.0 - self.metallic))
    }

    /// Where its alpha mask is read.
    #[inline]
    pub(crate) fn mask_coordinates(&self, uvs: [Vec2; 2]) -> Vec2 {
        self.base_colour_texture.map_or(uvs[0], |texture| texture.coordinates(uvs))
    }

    /// Whether light passes it in part.
    pub fn is_thin_surface(&self) -> bool {
        self.alpha == Alpha::Blend || self.transmission > 0.0
    }

    /// Transmittance of a thin surface where its coat reflects nothing, to be multiplied with its texture.
    pub(crate) fn passed(&self) -> Vec3 {
        self.base_colour * (self.transmission * (1.0 - self.metallic))
    }

    /// Whether it emits light on this side.
    pub fn emits_on(&self, front: bool) -> bool {
        front || self.emits_on_both_sides
    }

    /// Whether it emits light.
    pub fn is_emissive(&self) -> bool {
        self.emission != Vec3::ZERO
    }
}

/// A point of a thin surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThinSurface {
    /// The share of the surface that is there.
    pub coverage: f32,
    /// Transmittance of that part for the light that its coat does not reflect.
    pub passed: Vec3,
}

impl ThinSurface {
    /// Transmittance of the thin surface where its coat reflects `reflected`.
    pub fn transmittance(&self, reflected: f32) -> Vec3 {
        Vec3::splat(1.0 - self.coverage) + self.passed * (self.coverage * (1.0 - reflected))
    }
}

/// The exponent from which a highlight counts as that of a perfect mirror.
const MIRROR_EXPONENT: f32 = 10_000.0;

/// The roughness whose GGX lobe is as wide as a Phong highlight `(n h)^Ns`: alpha^2 = 2 / (Ns + 2) (Walter et al. 2007),
/// and roughness^2 = alpha. Exponents of 10,000 and more are perfect mirrors, roughness 0.
pub fn roughness_of_exponent(shininess: f32) -> f32 {
    if shininess >= MIRROR_EXPONENT { 0.0 } else { (2.0 / (shininess.max(0.0) + 2.0)).powf(0.25) }
}
