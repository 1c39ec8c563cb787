//! BSDFs, textures and masks.

use glam::{Vec2, Vec3};
use glowworm::export::{ExportSettings, Specular};
use glowworm::scene::{Instance, Material, Mesh, Scene, Texture, srgb_to_linear};

use crate::support::*;

/// Decodes 16-bit sRGB (IEC 61966-2-1).
fn decode(encoded: u16) -> f64 {
    let s = f64::from(encoded) / 65_535.0;
    if s <= 0.04045 { s / 12.92 } else { ((s + 0.055) / 1.055).powf(2.4) }
}

#[test]
fn diffuse_surfaces_have_two_sides() {
    let exported = export(&all_kinds());
    let document = roxmltree::Document::parse(&exported.text).unwrap();
    let red = by_id(document.root_element(), "material-1-red");
    assert_eq!(kind(red), "twosided");
    let diffuse = only(red, "bsdf");
    assert_eq!(kind(diffuse), "diffuse");
    assert_eq!(vector(value(diffuse, "reflectance")), Vec3::new(0.6, 0.1, 0.08));
}

#[test]
fn textures_are_as_they_were_or_tinted() {
    let scene = all_kinds();
    let exported = export(&scene);
    let document = roxmltree::Document::parse(&exported.text).unwrap();
    let (_, _, texels) = &scene.textures[0].levels[0];
    for (material, tint) in
        [("material-3-picture", Vec3::ONE), ("material-2-floor", Vec3::new(0.8, 0.7, 0.55))]
    {
        let texture = only(only(by_id(document.root_element(), material), "bsdf"), "texture");
        assert_eq!((kind(texture), texture.attribute("name")), ("bitmap", Some("reflectance")));
        assert_eq!((value(texture, "filter_type"), value(texture, "wrap_mode")), ("bilinear", "repeat"));
        assert_eq!(value(texture, "format"), "variant");
        let image = image::open(exported.path(value(texture, "filename"))).unwrap();
        assert_eq!((image.width(), image.height()), (8, 8));
        if tint == Vec3::ONE {
            let expected: Vec<u8> = texels.chunks(4).flat_map(|texel| &texel[..3]).copied().collect();
            assert_eq!(image.as_rgb8().unwrap().as_raw(), &expected);
        } else {
            for (got, texel) in image.as_rgb16().unwrap().pixels().zip(texels.chunks(4)) {
                for channel in 0..3 {
                    let expected = tint[channel] * srgb_to_linear(texel[channel]);
                    assert!((decode(got[channel]) - f64::from(expected)).abs() < 2e-5);
                }
            }
        }
    }
    // An image's first row is its top, which is where v = 0 is.
    let picture = exported.mesh(by_id(document.root_element(), "mesh-0-room-material-3-picture"));
    let top_left = picture.positions.iter().position(|p| *p == Vec3::new(-2.0, 3.0, -2.0)).unwrap();
    assert_eq!(picture.uvs[top_left], Vec2::ZERO);
}

#[test]
fn masks_are_black_where_nothing_is() {
    let scene = all_kinds();
    let exported = export(&scene);
    let document = roxmltree::Document::parse(&exported.text).unwrap();
    let lattice = by_id(document.root_element(), "material-4-lattice");
    assert_eq!(kind(lattice), "mask");
    assert_eq!(kind(only(lattice, "bsdf")), "twosided");
    let opacity = only(lattice, "texture");
    assert_eq!(opacity.attribute("name"), Some("opacity"));
    assert_eq!((value(opacity, "filter_type"), value(opacity, "raw")), ("nearest", "true"));
    let image = image::open(exported.path(value(opacity, "filename"))).unwrap().to_luma8();
    let mask = &scene.alpha_masks[0];
    for (x, y, texel) in image.enumerate_pixels() {
        let uv = (Vec2::new(x as f32, y as f32) + 0.5) / 8.0;
        assert_eq!(texel.0[0], if mask.opaque_at(uv) { 255 } else { 0 });
    }
    assert!(image.pixels().any(|texel| texel.0[0] == 0));
    assert!(!exported.mesh(by_id(document.root_element(), "mesh-0-room-material-4")).uvs.is_empty());
}

/// One quad of a material, optionally with a uniform grey texture, under a point light.
fn shiny(material: Material, texel: Option<u8>) -> Exported {
    let mut scene = Scene::new("shiny");
    scene.materials.push(Material { albedo_texture: texel.map(|_| 0), ..material });
    scene.textures.extend(texel.map(|grey| Texture::from_rgba8("grey", 1, 1, vec![grey, grey, grey, 255])));
    scene.meshes.push(Mesh::cuboid("box", Vec3::ONE, 0));
    scene.instances.push(Instance::fixed("box", 0, glam::Affine3A::IDENTITY));
    export_with(&scene, &ExportSettings { specular: Specular::Convert, ..settings() })
}

fn with_highlight(albedo: f32, specular: Vec3) -> Material {
    Material { specular, shininess: 30.0, ..Material::lambertian("shiny", Vec3::splat(albedo)) }
}

#[test]
fn highlights_become_rough_conductors_that_take_nothing_from_the_diffuse_part() {
    let specular = Vec3::new(0.2, 0.3, 0.1);
    let exported = shiny(with_highlight(0.5, specular), None);
    let document = roxmltree::Document::parse(&exported.text).unwrap();
    let blend = only(by_id(document.root_element(), "material-0-shiny"), "bsdf");
    assert_eq!(kind(blend), "blendbsdf");
    let weight: f32 = value(blend, "weight").parse().unwrap();
    let parts = elements(blend, "bsdf");
    assert_eq!((kind(parts[0]), kind(parts[1])), ("diffuse", "roughconductor"));
    let diffuse = vector(value(parts[0], "reflectance")) * (1.0 - weight);
    assert!(diffuse.distance(Vec3::splat(0.5)) < 1e-6);
    let reflected = vector(value(parts[1], "specular_reflectance")) * weight;
    assert!(reflected.distance(specular) < 1e-6);
    let alpha: f32 = value(parts[1], "alpha").parse().unwrap();
    assert!((alpha - 0.25).abs() < 1e-6);
    assert!(exported.report.inexact[0].contains("highlights of 1 material are rough conductors"));
    assert!(!exported.report.inexact[0].contains("weaker"));
}

#[test]
fn highlights_have_what_the_diffuse_part_leaves() {
    // Kd 1 on a texture whose linear grey is a quarter.
    let exported = shiny(with_highlight(1.0, Vec3::splat(0.9)), Some(137));
    let document = roxmltree::Document::parse(&exported.text).unwrap();
    let blend = only(by_id(document.root_element(), "material-0-shiny"), "bsdf");
    let weight: f32 = value(blend, "weight").parse().unwrap();
    assert!((weight - (1.0 - srgb_to_linear(137))).abs() < 1e-6);
    let texture = only(elements(blend, "bsdf")[0], "texture");
    let image = image::open(exported.path(value(texture, "filename"))).unwrap().to_rgb16();
    // The texel over the weight of its part is white.
    assert_eq!(image.get_pixel(0, 0).0, [65_535; 3]);
    assert!(exported.report.inexact[0].contains("Those of 1 material are weaker"));

    let white = shiny(with_highlight(1.0, Vec3::splat(0.9)), None);
    assert!(!white.text.contains("roughconductor"));
    let metal = shiny(with_highlight(0.0, Vec3::splat(0.9)), None);
    let document = roxmltree::Document::parse(&metal.text).unwrap();
    let conductor = only(by_id(document.root_element(), "material-0-shiny"), "bsdf");
    assert_eq!(kind(conductor), "roughconductor");
    assert_eq!(vector(value(conductor, "specular_reflectance")), Vec3::splat(0.9));
}

#[test]
fn highlights_that_are_left_out_are_named_only_where_they_would_be_seen() {
    let mut scene = all_kinds();
    scene.materials[1].specular = Vec3::splat(0.1);
    let left_out = |scene: &Scene| {
        let report = export(scene).report;
        let named = report.inexact.iter().any(|line| line.contains("omitted"));
        assert_eq!(named, report.highlights > 0);
        named
    };
    assert!(left_out(&scene));
    scene.lights.retain(|light| matches!(light.kind, glowworm::scene::LightKind::Area { .. }));
    assert!(!left_out(&scene));
}
