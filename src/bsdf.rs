//! The reflection of surfaces: glTF 2.0's metallic-roughness model. Twin: shaders/include/bsdf.glsl.
//!
//! In: base colour, metallic, roughness and reflectance at normal incidence; a shading normal and the direction to the
//! eye. Out: the BSDF (1/sr) of a Lambertian and a GGX lobe, directions in proportion to it, and their density (1/sr).
//!
//! ```text
//! f(o, i)  = (1 - metallic) ((1 - E(o)) base / pi + G(f0, f90)) + metallic G(base, 1)
//! G(F0, F90) = F(o h) D(h) V(o, i) (1 + F0 (1 / E_white(o) - 1)),              h = (o + i) / |o + i|
//! F(c)     = F0 + (F90 - F0) (1 - c)^5                                         Schlick 1994
//! D(h)     = a^2 / (pi (a^2 (n h)^2 + |n x h|^2)^2),  a = roughness^2          Trowbridge and Reitz 1975
//! V(o, i)  = 0.5 / (ni sqrt(a^2 + (1 - a^2) no^2) + no sqrt(a^2 + (1 - a^2) ni^2))     height-correlated Smith, Heitz 2014
//! ```
//!
//! E is the directional albedo of the dielectric's GGX lobe, E_white that for F = 1 without the last factor, which brings
//! back light that is reflected several times between microfacets (Turquin 2019). The Lambertian lobe gets what the GGX
//! lobe leaves (albedo scaling), so a surface of base colour 1 reflects all light, at every roughness and angle.

mod ggx;

use std::f32::consts::{PI, TAU};

use glam::{Vec2, Vec3};

use crate::sampling::{self, Frame};
pub use ggx::MIRROR_ROUGHNESS;
use ggx::{distribution, lengthened, mean_reflected, schlick, single_scattering, smith, visibility};

/// Least cosine between shading normal and eye; normals that face away are seen at a grazing angle.
const GRAZING: f32 = 1e-4;

/// The reflective properties of a point on a surface: a mixture of a dielectric and a metal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bsdf {
    /// Reflectance of the dielectric's Lambertian lobe under nothing, and of the metal at normal incidence.
    pub base: Vec3,
    /// The metal's share.
    pub metallic: f32,
    /// Perceptual roughness, 0 to 1; its square is GGX's alpha.
    pub roughness: f32,
    /// Reflectance of the dielectric's GGX lobe at normal incidence.
    pub f0: Vec3,
    /// Reflectance at grazing incidence; 0, with an `f0` of 0: no such lobe.
    pub f90: f32,
}

/// One value for each of the two lobes of a BSDF.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Lobes {
    /// Lambertian.
    pub diffuse: Vec3,
    /// GGX.
    pub reflected: Vec3,
}

/// A direction that light comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sampled {
    /// Unit vector.
    pub direction: Vec3,
    /// BSDF times cosine over density.
    pub weight: Vec3,
    /// 1/sr; none for the direction of a perfect mirror.
    pub density: Option<f32>,
}

/// A [`Bsdf`] seen from one side, with what does not depend on the direction of the light.
#[derive(Clone, Copy, Debug)]
pub struct Reflection {
    bsdf: Bsdf,
    frame: Frame,
    to_eye: Vec3,
    /// Between normal and eye.
    cosine: f32,
    shares: Shares,
}

/// Directional albedos of a surface, seen from one direction.
#[derive(Clone, Copy, Debug, Default)]
struct Shares {
    /// Directional albedo of the Lambertian lobe.
    diffuse: Vec3,
    /// Directional albedo of the GGX lobe.
    reflected: Vec3,
    /// Reflectances of the microfacets at normal and grazing incidence, times what multiple scattering adds.
    f0: Vec3,
    f90: Vec3,
}

impl Shares {
    fn fresnel(&self, cosine: f32) -> Vec3 {
        self.f0 + (self.f90 - self.f0) * schlick(cosine)
    }
}

impl Bsdf {
    /// A Lambertian surface.
    pub const fn lambertian(albedo: Vec3) -> Self {
        Self { base: albedo, metallic: 0.0, roughness: 1.0, f0: Vec3::ZERO, f90: 0.0 }
    }

    /// A GGX lobe alone that reflects all light.
    pub const fn white_ggx(roughness: f32) -> Self {
        Self { base: Vec3::ZERO, metallic: 0.0, roughness, f0: Vec3::ONE, f90: 1.0 }
    }

    /// Whether it has a GGX lobe.
    pub fn reflects(&self) -> bool {
        self.metallic > 0.0 || self.f90 > 0.0 || self.f0 != Vec3::ZERO
    }

    /// Whether its GGX lobe is that of a perfect mirror.
    pub fn is_mirror(&self) -> bool {
        self.roughness < MIRROR_ROUGHNESS
    }

    fn alpha(&self) -> f32 {
        self.roughness * self.roughness
    }

    /// The directional albedos at this cosine between normal and eye.
    fn shares(&self, cosine: f32) -> Shares {
        let diffuse = self.base * (1.0 - self.metallic);
        if !self.reflects() {
            return Shares { diffuse, ..Shares::default() };
        }
        let (white, grazing) = match self.is_mirror() {
            true => (1.0, schlick(cosine)),
            false => single_scattering(cosine, self.roughness),
        };
        // Dielectric and metal each get back what is scattered more than once.
        let again = 1.0 / white - 1.0;
        let albedo = |f0: Vec3, f90: Vec3| f0 * (white - grazing) + f90 * grazing;
        let dielectric = Vec3::ONE + self.f0 * again;
        let [dielectric_f0, dielectric_f90] = [self.f0 * dielectric, dielectric * self.f90];
        let metal = Vec3::ONE + self.base * again;
        let f0 = dielectric_f0.lerp(self.base * metal, self.metallic);
        let f90 = dielectric_f90.lerp(metal, self.metallic);
        let over = albedo(dielectric_f0, dielectric_f90).max_element().min(1.0);
        Shares { diffuse: diffuse * (1.0 - over), f0, f90, reflected: albedo(f0, f90).min(Vec3::ONE) }
    }

    /// Share of the light that it reflects, averaged over all directions by the cosine.
    pub fn mean_albedo(&self) -> Vec3 {
        if !self.reflects() {
            return self.base;
        }
        self.base * self.mean_diffuse_share() + self.mean_reflected_albedo()
    }

    /// The part of [`Self::mean_albedo`] that the GGX lobe reflects.
    pub fn mean_reflected_albedo(&self) -> Vec3 {
        let metal = mean_reflected(self.base, 1.0, self.roughness);
        mean_reflected(self.f0, self.f90, self.roughness).lerp(metal, self.metallic)
    }

    /// Mean albedo of the Lambertian lobe over the base colour.
    pub fn mean_diffuse_share(&self) -> f32 {
        let over = mean_reflected(self.f0, self.f90, self.roughness).max_element();
        (1.0 - self.metallic) * (1.0 - over)
    }

    /// Directional albedo for the cosine between normal and eye: the share of uniform light that it sends there.
    pub fn albedo(&self, cosine: f32) -> Vec3 {
        let shares = self.shares(cosine);
        shares.diffuse + shares.reflected
    }

    /// Directional-hemispherical reflectance of each lobe, for this cosine between normal and light. That of the Lambertian lobe does
    /// not depend on it: albedo scaling goes by the direction to the eye.
    pub fn hemispherical_reflectance(&self, cosine: f32) -> Lobes {
        if !self.reflects() {
            return Lobes { diffuse: self.base, reflected: Vec3::ZERO };
        }
        let diffuse = self.base * self.mean_diffuse_share();
        Lobes { diffuse, reflected: self.shares(cosine.max(GRAZING)).reflected }
    }

    /// This BSDF at a surface with shading normal `normal`, seen from `to_eye` (unit vectors).
    pub fn prepare(&self, normal: Vec3, to_eye: Vec3) -> Reflection {
        let cosine = normal.dot(to_eye);
        // A shading normal that faces away is bent until it does not.
        let normal = if cosine < GRAZING {
            (normal + to_eye * (GRAZING - cosine)).normalize_or(to_eye)
        } else {
            normal
        };
        let cosine = cosine.max(GRAZING);
        Reflection { bsdf: *self, frame: Frame::around(normal), to_eye, cosine, shares: self.shares(cosine) }
    }
}

impl Reflection {
    /// The normal, on the side of the eye.
    pub fn normal(&self) -> Vec3 {
        self.frame.normal
    }

    /// Whether there is a GGX lobe.
    pub fn reflects(&self) -> bool {
        self.bsdf.reflects()
    }

    /// Directional albedo of the Lambertian lobe: pi times its BSDF.
    pub fn diffuse_albedo(&self) -> Vec3 {
        self.shares.diffuse
    }

    /// Directional albedo of the GGX lobe.
    pub fn reflected_albedo(&self) -> Vec3 {
        self.shares.reflected
    }

    /// The BSDF for light from the unit vector `to_light`, 1/sr; the GGX lobe of a perfect mirror has no width and counts as 0.
    pub fn evaluate(&self, to_light: Vec3) -> Lobes {
        if self.normal().dot(to_light) <= 0.0 {
            return Lobes::default();
        }
        Lobes { diffuse: self.shares.diffuse / PI, reflected: self.reflected(to_light) }
    }

    fn reflected(&self, to_light: Vec3) -> Vec3 {
        if self.bsdf.is_mirror() || !self.reflects() {
            return Vec3::ZERO;
        }
        let half = (self.to_eye + to_light).normalize_or(self.normal());
        let cosine = self.normal().dot(to_light);
        let alpha = self.bsdf.alpha();
        self.shares.fresnel(self.to_eye.dot(half))
            * (distribution(self.normal(), half, alpha) * visibility(self.cosine, cosine, alpha))
    }

    /// Samples the GGX lobe by its visible normals (Heitz 2018; as a spherical cap, Dupuy and Benyoub 2023); none where
    /// that leads into the surface.
    pub fn sample_reflected(&self, u: Vec2) -> Option<Sampled> {
        let mirrored = |half: Vec3| half * (2.0 * self.to_eye.dot(half)) - self.to_eye;
        if !self.reflects() {
            return None;
        }
        if self.bsdf.is_mirror() {
            let weight = self.shares.fresnel(self.cosine);
            return Some(Sampled { direction: mirrored(self.normal()), weight, density: None });
        }
        let alpha = self.bsdf.alpha();
        let eye = self.frame.to_local(self.to_eye);
        let stretched = Vec3::new(alpha * eye.x, alpha * eye.y, self.cosine).normalize();
        let z = (1.0 - u.y) * (1.0 + stretched.z) - stretched.z;
        let (sin, cos) = (TAU * u.x).sin_cos();
        let radius = (1.0 - z * z).max(0.0).sqrt();
        let cap = Vec3::new(radius * cos, radius * sin, z) + stretched;
        let half = Vec3::new(alpha * cap.x, alpha * cap.y, cap.z.max(0.0)).normalize_or(Vec3::Z);
        let direction = mirrored(self.frame.to_world(half)).normalize_or(self.normal());
        let density = self.reflected_density(direction);
        let cosine = self.normal().dot(direction);
        (cosine > 0.0 && density > 0.0).then(|| {
            // The distribution cancels: it could overflow on smooth surfaces.
            let half = (self.to_eye + direction).normalize_or(self.normal());
            let masking = smith(cosine, self.cosine, alpha);
            let weight = self.shares.fresnel(self.to_eye.dot(half)) * masking;
            Sampled { direction, weight, density: Some(density) }
        })
    }

    /// Density of [`Self::sample_reflected`], 1/sr; 0 for a perfect mirror.
    pub fn reflected_density(&self, direction: Vec3) -> f32 {
        if self.bsdf.is_mirror() || !self.reflects() || self.normal().dot(direction) <= 0.0 {
            return 0.0;
        }
        let half = (self.to_eye + direction).normalize_or(self.normal());
        let alpha = self.bsdf.alpha();
        // Distribution of visible normals over 4 (o h), which cancels.
        let masking = 0.5 / (self.cosine + lengthened(self.cosine, alpha));
        distribution(self.normal(), half, alpha) * masking
    }

    /// Samples the Lambertian lobe.
    pub fn sample_diffuse(&self, u: Vec2) -> Sampled {
        let direction = self.frame.to_world(sampling::cosine_hemisphere(u));
        let density = self.diffuse_density(direction);
        Sampled { direction, weight: self.shares.diffuse, density: Some(density) }
    }

    /// Density of [`Self::sample_diffuse`], 1/sr.
    pub fn diffuse_density(&self, direction: Vec3) -> f32 {
        self.normal().dot(direction).max(0.0) / PI
    }

    /// Samples both lobes: `pick` chooses one in proportion to its albedo. None where nothing is reflected.
    pub fn sample(&self, pick: f32, u: Vec2) -> Option<Sampled> {
        let share = self.reflected_share();
        if !self.reflects() {
            return Some(self.sample_diffuse(u));
        }
        if pick < share {
            let sampled = self.sample_reflected(u)?;
            if self.bsdf.is_mirror() {
                return Some(Sampled { weight: sampled.weight / share, ..sampled });
            }
            return self.combined(sampled.direction);
        }
        let sampled = self.sample_diffuse(u);
        if self.bsdf.is_mirror() {
            let rest = 1.0 - share;
            let density = sampled.density.map(|density| density * rest);
            return Some(Sampled { weight: sampled.weight / rest, density, ..sampled });
        }
        self.combined(sampled.direction)
    }

    fn combined(&self, direction: Vec3) -> Option<Sampled> {
        let density = self.density(direction);
        let Lobes { diffuse, reflected } = self.evaluate(direction);
        let weight = (diffuse + reflected) * (self.normal().dot(direction) / density);
        (density > 0.0 && weight.is_finite()).then_some(Sampled { direction, weight, density: Some(density) })
    }

    /// Density of [`Self::sample`], 1/sr, without the directions of perfect mirrors.
    pub fn density(&self, direction: Vec3) -> f32 {
        let share = self.reflected_share();
        let diffuse = self.diffuse_density(direction);
        if share == 0.0 {
            return diffuse;
        }
        share * self.reflected_density(direction) + (1.0 - share) * diffuse
    }

    /// The probability of the GGX lobe.
    fn reflected_share(&self) -> f32 {
        let [reflected, diffuse] =
            [self.shares.reflected, self.shares.diffuse].map(|albedo| albedo.max_element());
        if reflected > 0.0 { reflected / (reflected + diffuse) } else { 0.0 }
    }
}

#[cfg(test)]
mod tests;
