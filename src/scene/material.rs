//! Surface materials, their textures and alpha masks.

use glam::{Vec2, Vec3};

use super::Scene;

/// A material: Lambertian diffuse and normalised Blinn-Phong specular reflection, optionally emission.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Name in the MTL.
    pub name: String,
    /// Kd, linear, multiplied with the texture; each channel in [0, 1].
    pub albedo: Vec3,
    /// Ks, linear.
    pub specular: Vec3,
    /// Ns, the Blinn-Phong exponent.
    pub shininess: f32,
    /// Ke, radiance of the front side, W/m^2/sr.
    pub emission: Vec3,
    /// map_Kd: index into `Scene::textures`.
    pub albedo_texture: Option<usize>,
    /// Index into `Scene::alpha_masks`; set if `map_d`, the alpha of `map_Kd` or, unless emissive, `d` masks parts of
    /// the surface. Masked parts do not emit.
    pub alpha_mask: Option<usize>,
}

/// An sRGB colour image with its mip chain.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// File name for reports.
    pub name: String,
    /// RGBA8, sRGB-encoded colour and linear alpha; level 0 first, each level half the one before
    /// (rounded down, at least 1), filtered in linear light. (width, height, texels by rows from the top).
    pub levels: Vec<(u32, u32, Vec<u8>)>,
}

/// The opaque texels of a surface: one bit a texel, the same for raster, CPU rays and shader rays.
#[derive(Clone, Debug, PartialEq)]
pub struct AlphaMask {
    /// Width in texels.
    pub width: u32,
    /// Height in texels.
    pub height: u32,
    /// Bit `y * width + x` (low bit of word 0 first) is 1 where the surface is opaque.
    pub bits: Vec<u32>,
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
            albedo,
            specular: Vec3::ZERO,
            shininess: 1.0,
            emission: Vec3::ZERO,
            albedo_texture: None,
            alpha_mask: None,
        }
    }

    /// A black surface that emits `radiance`, W/m^2/sr.
    pub fn emitter(name: &str, radiance: Vec3) -> Self {
        Self { emission: radiance, ..Self::lambertian(name, Vec3::ZERO) }
    }

    /// Linear albedo at `uv`: Kd times the texture (bilinear, repeating, level 0).
    pub fn albedo_at(&self, scene: &Scene, uv: Vec2) -> Vec3 {
        match self.albedo_texture {
            Some(texture) => self.albedo * scene.textures[texture].sample(uv),
            None => self.albedo,
        }
    }

    /// Whether it emits light.
    pub fn is_emissive(&self) -> bool {
        self.emission != Vec3::ZERO
    }
}

impl AlphaMask {
    /// Whether no texel is opaque.
    pub fn is_empty(&self) -> bool {
        self.bits.iter().all(|&word| word == 0)
    }

    /// Whether the surface is opaque at `uv` (repeating, nearest texel, origin top left).
    pub fn opaque_at(&self, uv: Vec2) -> bool {
        let wrapped = uv - uv.floor();
        let x = ((wrapped.x * self.width as f32) as u32).min(self.width - 1);
        let y = ((wrapped.y * self.height as f32) as u32).min(self.height - 1);
        let bit = y * self.width + x;
        self.bits[(bit / 32) as usize] >> (bit % 32) & 1 == 1
    }
}
