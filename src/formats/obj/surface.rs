//! The surface that an MTL describes, as metallic-roughness. docs/FILES.md has the rule for people.
//!
//! In: a material of a library. Out: a [`Material`] without textures.
//!
//! - Ks 0: a Lambertian surface of Kd, whatever Ns.
//! - Ks above 0: Kd under a coat with F0 = Ks and the roughness of Ns; without any Kd a metal of base colour Ks, which
//!   reflects the same.
//! - Pr or Pm: glTF's model with base colour Kd; Ks is ignored.
//! - Glass (illum 4, 6, 7, 9 without Kd): a thin surface that lets Tf pass. Otherwise d, or 1 - Tr, is its alpha.

use glam::Vec3;

use super::mtl::MtlMaterial;
use crate::scene::{Alpha, GLTF_F0, Material, roughness_of_exponent};

/// Illumination models of glass.
const GLASS: [u8; 4] = [4, 6, 7, 9];

/// Illumination models of mirrors.
const MIRRORS: [u8; 3] = [3, 5, 8];

/// The surface of `material`; a colour map without Kd has a Kd of 1.
pub(super) fn surface(material: &MtlMaterial) -> Material {
    let kd = material.kd.unwrap_or(Vec3::splat(if material.map_kd.is_some() { 1.0 } else { 0.5 }));
    let emission = material.ke.unwrap_or_default();
    let plain = Material { emission, ..Material::lambertian(&material.name, kd) };
    let surface = reflecting(material, plain, kd);
    // An emissive surface is meant to be visible, so it ignores `d`.
    if emission != Vec3::ZERO || is_glass(material, kd) {
        return surface;
    }
    let opacity = material.d.or(material.tr.map(|tr| 1.0 - tr)).unwrap_or(1.0).clamp(0.0, 1.0);
    let alpha = if opacity < 1.0 { Alpha::Blend } else { Alpha::Opaque };
    Material { opacity, alpha, ..surface }
}

fn reflecting(material: &MtlMaterial, plain: Material, kd: Vec3) -> Material {
    let ks = material.ks.unwrap_or_default();
    let is_mirror = MIRRORS.contains(&material.illum.unwrap_or(2)) && material.ns.is_none();
    let shininess = material.ns.unwrap_or(if is_mirror { f32::INFINITY } else { 1.0 });
    // A map without a factor counts in full.
    let roughness = material.pr.or(material.map_pr.is_some().then_some(1.0));
    let metallic = material.pm.or(material.map_pm.is_some().then_some(1.0));
    if roughness.is_some() || metallic.is_some() {
        let roughness = roughness.unwrap_or(roughness_of_exponent(shininess)).min(1.0);
        let metallic = metallic.unwrap_or(0.0).min(1.0);
        return Material { metallic, roughness, f0: GLTF_F0, f90: 1.0, ..plain };
    }
    if is_glass(material, kd) {
        let tint = material.tf.unwrap_or(Vec3::ONE);
        let f0 = if ks == Vec3::ZERO { reflectance_of(material.ni) } else { ks };
        return Material { base_colour: tint, transmission: 1.0, ..plain.coated(f0, shininess) };
    }
    if kd == Vec3::ZERO && material.map_kd.is_none() && ks != Vec3::ZERO {
        return Material { base_colour: ks, metallic: 1.0, ..plain.coated(GLTF_F0, shininess) };
    }
    plain.coated(ks, shininess)
}

fn is_glass(material: &MtlMaterial, kd: Vec3) -> bool {
    GLASS.contains(&material.illum.unwrap_or(2)) && kd == Vec3::ZERO && material.map_kd.is_none()
}

/// Fresnel's reflectance at normal incidence of an index of refraction; 0 without one.
fn reflectance_of(index: Option<f32>) -> Vec3 {
    let index = index.unwrap_or(1.0);
    Vec3::splat(((index - 1.0) / (index + 1.0)).powi(2))
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::super::mtl;
    use super::*;

    fn of(text: &str) -> Material {
        let text = format!("newmtl a\n{text}\n");
        surface(&mtl::parse(Path::new("m.mtl"), text.as_bytes(), &mut Vec::new())[0])
    }

    #[test]
    fn highlights_become_reflectance_and_roughness() {
        let matte = of("Kd .1 .2 .3\nKs 0 0 0\nNs 50\nillum 2");
        assert_eq!((matte.base_colour, matte.f0, matte.f90), (Vec3::new(0.1, 0.2, 0.3), Vec3::ZERO, 0.0));
        assert_eq!(matte.alpha, Alpha::Opaque);
        let varnish = of("Kd 1 1 1\nKs .04 .04 .04\nNs 798");
        assert_eq!((varnish.metallic, varnish.f0, varnish.f90), (0.0, Vec3::splat(0.04), 1.0));
        // alpha^2 = 2 / 800
        assert!((varnish.roughness.powi(4) - 0.0025).abs() < 1e-6);
        let steel = of("Kd 0 0 0\nKs .7 .69 .68\nNs 198\nillum 3");
        assert_eq!((steel.metallic, steel.base_colour), (1.0, Vec3::new(0.7, 0.69, 0.68)));
        assert!((steel.roughness.powi(4) - 0.01).abs() < 1e-6);
    }

    #[test]
    fn mirrors_are_smooth() {
        for text in ["Kd 0 0 0\nKs 1 1 1\nNs 10000\nillum 3", "Kd 0 0 0\nKs 1 1 1\nillum 5"] {
            let mirror = of(text);
            assert_eq!((mirror.metallic, mirror.roughness, mirror.base_colour), (1.0, 0.0, Vec3::ONE));
        }
    }

    #[test]
    fn glass_is_a_tinted_thin_surface_and_d_is_alpha() {
        let glass = of("Kd 0 0 0\nKs .04 .04 .04\nNs 10000\nTf .1 .6 .2\nd .1\nillum 7");
        assert_eq!((glass.transmission, glass.base_colour), (1.0, Vec3::new(0.1, 0.6, 0.2)));
        assert_eq!((glass.alpha, glass.opacity, glass.roughness), (Alpha::Opaque, 1.0, 0.0));
        let by_index = of("Kd 0 0 0\nNi 1.5\nillum 4");
        assert!((by_index.f0.x - 0.04).abs() < 1e-6 && by_index.is_thin_surface());
        for text in ["Kd 1 0 0\nd .8", "Kd 1 0 0\nTr .2"] {
            let veil = of(text);
            assert_eq!((veil.alpha, veil.transmission), (Alpha::Blend, 0.0));
            assert!((veil.opacity - 0.8).abs() < 1e-6);
        }
        assert_eq!(of("Ke 1 1 1\nd 0").alpha, Alpha::Opaque);
    }

    #[test]
    fn physical_parameters_come_first() {
        let brass = of("Kd .9 .8 .4\nKs .5 .5 .5\nPr .3\nPm 1");
        assert_eq!((brass.metallic, brass.roughness, brass.f0), (1.0, 0.3, GLTF_F0));
        assert_eq!(brass.base_colour, Vec3::new(0.9, 0.8, 0.4));
        let mapped = of("Kd 1 1 1\nmap_Pr r.png");
        assert_eq!((mapped.metallic, mapped.roughness), (0.0, 1.0));
    }
}
