//! The surface that an MTL describes, as metallic-roughness. docs/FILES.md has the rule for people.
//!
//! In: one of tobj's materials. Out: a [`Material`] without textures.
//!
//! - Ks 0: a Lambertian surface of Kd, whatever Ns.
//! - Ks above 0: Kd under a coat with F0 = Ks and the roughness of Ns; without any Kd a metal of base colour Ks, which
//!   reflects the same.
//! - Pr or Pm: glTF's model with base colour Kd; Ks is ignored.
//! - Glass (illum 4, 6, 7, 9 without Kd): a thin sheet that lets Tf pass. Otherwise d, or 1 - Tr, is its alpha.

use glam::Vec3;

use crate::scene::{Alpha, GLTF_F0, Material, roughness_of_exponent};

/// Illumination models of glass.
const GLASS: [u8; 4] = [4, 6, 7, 9];

/// Illumination models of mirrors.
const MIRRORS: [u8; 3] = [3, 5, 8];

/// The surface of `material`; a colour map without Kd has a Kd of 1.
pub(crate) fn surface(material: &tobj::Material) -> Material {
    let mapped = material.diffuse_texture.is_some();
    let kd = Vec3::from_array(material.diffuse.unwrap_or([if mapped { 1.0 } else { 0.5 }; 3]));
    let ks = Vec3::from_array(material.specular.unwrap_or_default());
    let emission = Vec3::from_array(material.emissive.unwrap_or_default());
    let plain = Material { emission, ..Material::lambertian(&material.name, kd) };
    let surface = reflecting(material, plain, kd, ks);
    // An emissive surface is meant to be visible, so it ignores `d`.
    if emission != Vec3::ZERO || is_glass(material, kd) {
        return surface;
    }
    let opacity =
        material.dissolve.or_else(|| Some(1.0 - number(material, "Tr")?)).unwrap_or(1.0).clamp(0.0, 1.0);
    let alpha = if opacity < 1.0 { Alpha::Blend } else { Alpha::Opaque };
    Material { opacity, alpha, ..surface }
}

fn reflecting(material: &tobj::Material, plain: Material, kd: Vec3, ks: Vec3) -> Material {
    let model = material.illumination_model.unwrap_or(2);
    let is_mirror = MIRRORS.contains(&model) && material.shininess.is_none();
    let shininess = material.shininess.unwrap_or(if is_mirror { f32::INFINITY } else { 1.0 });
    let (rough, metal) = (number(material, "Pr"), number(material, "Pm"));
    let maps = ["map_Pr", "map_Pm"].map(|key| material.unknown_param.contains_key(key));
    if rough.is_some() || metal.is_some() || maps[0] || maps[1] {
        // A map without a factor counts in full.
        let roughness = rough.unwrap_or(if maps[0] { 1.0 } else { roughness_of_exponent(shininess) });
        let metallic = metal.unwrap_or(if maps[1] { 1.0 } else { 0.0 });
        let (metallic, roughness) = (metallic.min(1.0), roughness.min(1.0));
        return Material { metallic, roughness, f0: GLTF_F0, f90: 1.0, ..plain };
    }
    if is_glass(material, kd) {
        let tint = Vec3::from_array(colour(material, "Tf").unwrap_or([1.0; 3]));
        let f0 = if ks == Vec3::ZERO { reflectance_of(material.optical_density) } else { ks };
        return Material { base_colour: tint, transmission: 1.0, ..plain.coated(f0, shininess) };
    }
    if kd == Vec3::ZERO && material.diffuse_texture.is_none() && ks != Vec3::ZERO {
        return Material { base_colour: ks, metallic: 1.0, ..plain.coated(GLTF_F0, shininess) };
    }
    plain.coated(ks, shininess)
}

fn is_glass(material: &tobj::Material, kd: Vec3) -> bool {
    let model = material.illumination_model.unwrap_or(2);
    GLASS.contains(&model) && kd == Vec3::ZERO && material.diffuse_texture.is_none()
}

/// Fresnel's reflectance at normal incidence of an index of refraction; 0 without one.
fn reflectance_of(index: Option<f32>) -> Vec3 {
    let index = index.unwrap_or(1.0);
    Vec3::splat(((index - 1.0) / (index + 1.0)).powi(2))
}

/// A number that tobj leaves as text; the statements were checked.
fn number(material: &tobj::Material, key: &str) -> Option<f32> {
    material.unknown_param.get(key)?.parse().ok()
}

fn colour(material: &tobj::Material, key: &str) -> Option<[f32; 3]> {
    let mut words = material.unknown_param.get(key)?.split_whitespace().map(str::parse);
    let mut next = || words.next()?.ok();
    Some([next()?, next()?, next()?])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(text: &str) -> Material {
        let (materials, _) = tobj::load_mtl_buf(&mut format!("newmtl a\n{text}\n").as_bytes()).unwrap();
        surface(&materials[0])
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
    fn glass_is_a_tinted_sheet_and_d_is_alpha() {
        let glass = of("Kd 0 0 0\nKs .04 .04 .04\nNs 10000\nTf .1 .6 .2\nd .1\nillum 7");
        assert_eq!((glass.transmission, glass.base_colour), (1.0, Vec3::new(0.1, 0.6, 0.2)));
        assert_eq!((glass.alpha, glass.opacity, glass.roughness), (Alpha::Opaque, 1.0, 0.0));
        let by_index = of("Kd 0 0 0\nNi 1.5\nillum 4");
        assert!((by_index.f0.x - 0.04).abs() < 1e-6 && by_index.is_sheet());
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
