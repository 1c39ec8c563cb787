//! The GGX lobe by which a VPL on a glossy surface sends a share of its light; the rest leaves by the cosine.
//!
//! In: a BSDF, its normal and where the light came from. Out: the lobe, its density (1/sr) and samples of it. Twin:
//! shaders/estimators/vpls/vpls.glsl.

use bytemuck::{Pod, Zeroable};
use glam::{Vec2, Vec3};

use crate::bsdf::{Bsdf, Reflection};
use crate::sampling::{self, Frame};

/// Lobes of smoother surfaces are widened to this roughness: one VPL stands for light from many directions, and a narrow lobe would
/// be seen as the spots that it throws.
const LEAST_ROUGHNESS: f32 = 0.5;

/// `GlossyLobe` in shaders/estimators/vpls/vpls.glsl (std430, 16 bytes).
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct GlossyLobe {
    /// Unit direction in which the light arrived that the VPL reflects.
    pub incoming: Vec3,
    /// 8 bits each, the lowest first: in each channel the share of the flux, and the roughness. 0: no such lobe.
    pub packed: u32,
}

impl GlossyLobe {
    /// No lobe: all light leaves by the cosine.
    pub const NONE: Self = Self { incoming: Vec3::ZERO, packed: 0 };

    /// What a surface sends on of light that arrives in direction `incoming`, and the lobe that sends a share of it.
    pub(super) fn of(bsdf: &Bsdf, normal: Vec3, incoming: Vec3) -> (Vec3, Self) {
        let lobes = bsdf.sent_on(-normal.dot(incoming));
        let albedo = lobes.diffuse + lobes.reflected;
        let share = lobes.reflected / albedo.max(Vec3::splat(f32::MIN_POSITIVE));
        let fields = share.extend(bsdf.roughness.max(LEAST_ROUGHNESS)).to_array();
        let bytes = fields.map(|field| (field.clamp(0.0, 1.0) * 255.0).round() as u8);
        let is_none = lobes.reflected == Vec3::ZERO;
        (albedo, if is_none { Self::NONE } else { Self { incoming, packed: u32::from_le_bytes(bytes) } })
    }

    /// In each channel the share of the flux.
    fn share(&self) -> Vec3 {
        let [red, green, blue, _] = self.fields();
        Vec3::new(red, green, blue)
    }

    fn fields(&self) -> [f32; 4] {
        self.packed.to_le_bytes().map(|byte| f32::from(byte) / 255.0)
    }

    /// The lobe as that of a surface that reflects all light.
    fn reflection(&self, normal: Vec3) -> Reflection {
        let [.., roughness] = self.fields();
        Bsdf { roughness, ..Bsdf::MIRROR }.seen(normal, -self.incoming)
    }

    /// The share of the flux of a VPL with this lobe that leaves in a direction, of both lobes together, 1/sr.
    pub(super) fn density(&self, normal: Vec3, direction: Vec3) -> Vec3 {
        let cosine = normal.dot(direction).max(0.0);
        let diffuse = Vec3::splat(cosine / std::f32::consts::PI);
        if self.packed == 0 || cosine == 0.0 {
            return diffuse;
        }
        let glossy = self.reflection(normal).evaluate(direction).reflected * cosine;
        diffuse + self.share() * (glossy - diffuse)
    }

    /// Samples a direction of both lobes, with its weight; none where that leads into the surface.
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
    fn a_lobe_sends_what_the_bsdf_does() {
        for bsdf in [VARNISH, BRASS] {
            for slope in [0.0, 1.0, 3.0] {
                let incoming = Vec3::new(slope, 0.0, -1.0).normalize();
                let (albedo, lobe) = GlossyLobe::of(&bsdf, Vec3::Z, incoming);
                let (mut total, mut error, mut of_cosine) = (Vec3::ZERO, Vec3::ZERO, Vec3::ZERO);
                for (direction, angle) in directions(Vec3::Z) {
                    // The BSDF looks from where light leaves to where it came from.
                    let lobes = bsdf.seen(Vec3::Z, direction).evaluate(-incoming);
                    let truth = (lobes.diffuse + lobes.reflected) * (direction.z * angle);
                    total += truth;
                    let sent = |lobe: &GlossyLobe| albedo * lobe.density(Vec3::Z, direction) * angle;
                    error += (sent(&lobe) - truth).abs();
                    of_cosine += (sent(&GlossyLobe::NONE) - truth).abs();
                }
                assert!((albedo / total - 1.0).abs().max_element() < 0.1, "{albedo} {total}");
                assert!((error / total).max_element() < 0.3, "slope {slope}: {}", error / total);
                assert!((error / of_cosine).max_element() < 0.6, "slope {slope}: {}", error / of_cosine);
            }
        }
    }

    #[test]
    fn samples_have_the_density() {
        let incoming = Vec3::new(1.0, 0.3, -1.0).normalize();
        for bsdf in [VARNISH, BRASS, Bsdf::lambertian(Vec3::splat(0.5))] {
            let (_, lobe) = GlossyLobe::of(&bsdf, Vec3::Z, incoming);
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
    fn a_lambertian_surface_has_none() {
        let (albedo, lobe) = GlossyLobe::of(&Bsdf::lambertian(Vec3::splat(0.3)), Vec3::Z, -Vec3::Z);
        assert_eq!((albedo, lobe), (Vec3::splat(0.3), GlossyLobe::NONE));
    }
}
