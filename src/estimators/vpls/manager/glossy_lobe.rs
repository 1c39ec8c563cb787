//! The GGX lobe of a VPL on a glossy surface, by which it emits a share of its flux; the Lambertian lobe emits the rest.
//!
//! In: a BSDF, its surface and the direction of incidence. Out: the lobes, their density (1/sr) and samples of it. Twin:
//! shaders/estimators/vpls/vpls.glsl.
//!
//! Light paths go against the paths of `reference`, so the shading normal counts where light arrives, and the geometric normal where
//! it leaves (the adjoint BSDF: Veach 1997, section 5.3). No VPL shines below its triangle.

use bytemuck::{Pod, Zeroable};
use glam::{Vec2, Vec3};

use crate::bsdf::{Bsdf, Reflection};
use crate::sampling::{self, Frame};
use crate::scene::WorldSurface;

/// Lobes of smoother surfaces get this roughness: each VPL stands for a continuum of light paths, and a narrow lobe would show as a
/// spot of its own.
const LEAST_ROUGHNESS: f32 = 0.5;

/// By how much light that grazes the triangle, and not the bump, counts more, at most.
const MOST_GAIN: f32 = 100.0;

/// `GlossyLobe` in shaders/estimators/vpls/vpls.glsl (std430, 16 bytes).
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct GlossyLobe {
    /// Unit direction in which light arrived at the VPL, turned so that the geometric normal mirrors it as the shading normal mirrors
    /// light.
    pub incident: Vec3,
    /// Unorm, 8 bits each, the lowest first: the lobe's share of the flux in each channel, and its roughness. 0: no such lobe.
    pub packed: u32,
}

impl GlossyLobe {
    /// No such lobe: the VPL is Lambertian.
    pub const NONE: Self = Self { incident: Vec3::ZERO, packed: 0 };

    /// The albedo of a surface for light in the unit direction `incident`, what it receives over the cosine to its triangle, and the lobe. `from_light`: as a sample
    /// of a punctual light, of which the shading normal mirrors nothing up.
    pub(super) fn of(
        bsdf: &Bsdf,
        surface: &WorldSurface,
        incident: Vec3,
        from_light: bool,
    ) -> (Vec3, f32, Self) {
        let WorldSurface { geometric_normal, normal, .. } = *surface;
        let arrives = -normal.dot(incident);
        if arrives <= 0.0 {
            return (Vec3::ZERO, 1.0, Self::NONE);
        }
        let received = if from_light { arrives } else { surface.received(-incident) };
        let lobes = bsdf.hemispherical_reflectance(arrives);
        let albedo = lobes.diffuse + lobes.reflected;
        // Bumps spread their lobes as a Lambertian surface would: by the square of the cosine of twice their slope, less is left of one.
        let level = (2.0 * normal.dot(geometric_normal).powi(2) - 1.0).max(0.0).powi(2);
        let share = lobes.reflected * level / albedo.max(Vec3::splat(f32::MIN_POSITIVE));
        let fields = share.extend(bsdf.roughness.max(LEAST_ROUGHNESS)).to_array();
        let bytes = fields.map(|field| (field.clamp(0.0, 1.0) * 255.0).round() as u8);
        let gain = (received / -geometric_normal.dot(incident)).clamp(0.0, MOST_GAIN);
        if share == Vec3::ZERO {
            return (albedo, gain, Self::NONE);
        }
        // Mirrored once more by the triangle, unless it has been below.
        let mirrored = incident.reflect(normal);
        let is_above = mirrored.dot(geometric_normal) > 0.0;
        let incident = if is_above { mirrored.reflect(geometric_normal) } else { mirrored };
        (albedo, gain, Self { incident, packed: u32::from_le_bytes(bytes) })
    }

    /// The lobe's share of the flux in each channel.
    fn share(&self) -> Vec3 {
        let [red, green, blue, _] = self.fields();
        Vec3::new(red, green, blue)
    }

    fn fields(&self) -> [f32; 4] {
        self.packed.to_le_bytes().map(|byte| f32::from(byte) / 255.0)
    }

    /// The lobe, normalized.
    fn reflection(&self, normal: Vec3) -> Reflection {
        let [.., roughness] = self.fields();
        Bsdf::white_ggx(roughness).prepare(normal, -self.incident)
    }

    /// Intensity of the VPL in a unit direction over its flux, 1/sr, of both lobes.
    pub(super) fn density(&self, normal: Vec3, direction: Vec3) -> Vec3 {
        let cosine = normal.dot(direction).max(0.0);
        let diffuse = Vec3::splat(cosine / std::f32::consts::PI);
        if self.packed == 0 || cosine == 0.0 {
            return diffuse;
        }
        let glossy = self.reflection(normal).evaluate(direction).reflected * cosine;
        diffuse + self.share() * (glossy - diffuse)
    }

    /// Samples a direction by both lobes, with its weight: [`Self::density`] over that of the samples. None below the surface.
    pub(super) fn sample(&self, normal: Vec3, u: Vec2) -> Option<(Vec3, Vec3)> {
        let share = self.share();
        let probability = share.max_element();
        if u.x < probability {
            let u = Vec2::new(u.x / probability, u.y);
            let sampled = self.reflection(normal).sample_reflected(u)?;
            return Some((sampled.direction, sampled.weight * share / probability));
        }
        let rest = 1.0 - probability;
        let u = Vec2::new((u.x - probability) / rest, u.y);
        Some((Frame::around(normal).to_world(sampling::cosine_hemisphere(u)), (Vec3::ONE - share) / rest))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const VARNISH: Bsdf = Bsdf {
        base: Vec3::new(0.6, 0.3, 0.1),
        metallic: 0.0,
        roughness: 0.5,
        f0: Vec3::splat(0.04),
        f90: 1.0,
    };
    const BRASS: Bsdf = Bsdf { base: Vec3::new(0.9, 0.7, 0.3), metallic: 1.0, ..VARNISH };

    /// On a level surface.
    fn of(bsdf: &Bsdf, incident: Vec3) -> (Vec3, GlossyLobe) {
        let surface = WorldSurface {
            position: Vec3::ZERO,
            geometric_normal: Vec3::Z,
            normal: Vec3::Z,
            ray_offset: 0.0,
        };
        let (albedo, _, lobe) = GlossyLobe::of(bsdf, &surface, incident, false);
        (albedo, lobe)
    }

    /// The middle of each cell of a grid over the hemisphere of equal solid angles, with that angle.
    fn directions(normal: Vec3) -> impl Iterator<Item = (Vec3, f32)> {
        let (rings, around) = (256, 256);
        (0..rings * around).map(move |cell| {
            let z = ((cell / around) as f32 + 0.5) / rings as f32;
            let angle = std::f32::consts::TAU * ((cell % around) as f32 + 0.5) / around as f32;
            let radius = (1.0 - z * z).sqrt();
            let direction =
                Frame::around(normal).to_world(Vec3::new(radius * angle.cos(), radius * angle.sin(), z));
            (direction, std::f32::consts::TAU / (rings * around) as f32)
        })
    }

    #[test]
    fn the_density_is_that_of_the_bsdf() {
        for bsdf in [VARNISH, BRASS] {
            for slope in [0.0, 1.0, 3.0] {
                let incident = Vec3::new(slope, 0.0, -1.0).normalize();
                let (albedo, lobe) = of(&bsdf, incident);
                let (mut total, mut error, mut of_lambertian) = (Vec3::ZERO, Vec3::ZERO, Vec3::ZERO);
                for (direction, angle) in directions(Vec3::Z) {
                    // Seen from the direction in which light leaves.
                    let lobes = bsdf.prepare(Vec3::Z, direction).evaluate(-incident);
                    let reference = (lobes.diffuse + lobes.reflected) * (direction.z * angle);
                    total += reference;
                    let emitted = |lobe: &GlossyLobe| albedo * lobe.density(Vec3::Z, direction) * angle;
                    error += (emitted(&lobe) - reference).abs();
                    of_lambertian += (emitted(&GlossyLobe::NONE) - reference).abs();
                }
                assert!((albedo / total - 1.0).abs().max_element() < 0.1, "{albedo} {total}");
                assert!((error / total).max_element() < 0.3, "slope {slope}: {}", error / total);
                assert!(
                    (error / of_lambertian).max_element() < 0.6,
                    "slope {slope}: {}",
                    error / of_lambertian
                );
            }
        }
    }

    #[test]
    fn samples_have_the_density() {
        let incident = Vec3::new(1.0, 0.3, -1.0).normalize();
        for bsdf in [VARNISH, BRASS, Bsdf::lambertian(Vec3::splat(0.5))] {
            let (_, lobe) = of(&bsdf, incident);
            let expected: Vec3 =
                directions(Vec3::Z).map(|(d, angle)| lobe.density(Vec3::Z, d) * (angle * d.x)).sum();
            let count = 1 << 14;
            let got: Vec3 = (0..count)
                .filter_map(|index| lobe.sample(Vec3::Z, sampling::sequence_point(index, 0, 0)))
                .map(|(direction, weight)| weight * (direction.x / count as f32))
                .sum();
            assert!((got - expected).abs().max_element() < 5e-3, "{got} {expected}");
        }
    }

    #[test]
    fn leaning_normals_keep_the_flux_of_uniform_light() {
        for slope in [0.0, 0.2, 0.6, 1.7] {
            let normal = Vec3::new(slope, 0.0, 1.0).normalize();
            let surface =
                WorldSurface { position: Vec3::ZERO, geometric_normal: Vec3::Z, normal, ray_offset: 0.0 };
            let white = Bsdf::lambertian(Vec3::ONE);
            let flux = |d: Vec3| {
                let (albedo, gain, _) = GlossyLobe::of(&white, &surface, -d, false);
                albedo.x * gain * d.z
            };
            let total: f32 = directions(Vec3::Z).map(|(d, angle)| flux(d) * angle).sum();
            assert!((total / std::f32::consts::PI - 1.0).abs() < 0.01, "slope {slope}: {total}");
        }
    }

    #[test]
    fn a_lambertian_surface_has_none() {
        let (albedo, lobe) = of(&Bsdf::lambertian(Vec3::splat(0.3)), -Vec3::Z);
        assert_eq!((albedo, lobe), (Vec3::splat(0.3), GlossyLobe::NONE));
    }
}
