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
    scene.materials.push(Material { base_colour_texture: texel.map(|_| 0.into()), ..material });
    scene.textures.extend(texel.map(|grey| Texture::from_rgba8("grey", 1, 1, vec![grey, grey, grey, 255])));
    scene.meshes.push(Mesh::cuboid("box", Vec3::ONE, 0));
    scene.instances.push(Instance::fixed("box", 0, glam::Affine3A::IDENTITY));
    export_with(&scene, &ExportSettings { specular: Specular::Convert, ..settings() })
}

#[test]
fn ggx_lobes_become_rough_conductors_beside_the_diffuse_part() {
    let coat = Vec3::new(0.2, 0.3, 0.1);
    let material = Material::lambertian("shiny", Vec3::splat(0.5)).coated(coat, 30.0);
    let exported = shiny(material.clone(), None);
    let document = roxmltree::Document::parse(&exported.text).unwrap();
    let blend = only(by_id(document.root_element(), "material-0-shiny"), "bsdf");
    assert_eq!(kind(blend), "blendbsdf");
    let weight: f32 = value(blend, "weight").parse().unwrap();
    let parts = elements(blend, "bsdf");
    assert_eq!((kind(parts[0]), kind(parts[1])), ("diffuse", "roughconductor"));
    let diffuse = vector(value(parts[0], "reflectance")) * (1.0 - weight);
    let reflected = vector(value(parts[1], "specular_reflectance")) * weight;
    let mean = material.bsdf_at(&Scene::new("none"), Vec2::ZERO).mean_albedo();
    assert!((diffuse + reflected).distance(mean) < 1e-5, "{diffuse} {reflected} {mean}");
    assert!((reflected - coat).abs().max_element() < 0.1 && diffuse.max_element() < 0.45);
    assert_eq!(value(parts[1], "distribution"), "ggx");
    let alpha: f32 = value(parts[1], "alpha").parse().unwrap();
    assert!((alpha - 0.25).abs() < 1e-5);
    assert!(exported.report.inexact[0].contains("GGX lobes of 1 material are rough conductors"));
}

#[test]
fn metals_are_conductors_alone() {
    let metal = Material { metallic: 1.0, roughness: 0.5, ..Material::lambertian("shiny", Vec3::splat(0.9)) };
    let exported = shiny(metal, None);
    let document = roxmltree::Document::parse(&exported.text).unwrap();
    let conductor = only(by_id(document.root_element(), "material-0-shiny"), "bsdf");
    assert_eq!(kind(conductor), "roughconductor");
    let reflectance = vector(value(conductor, "specular_reflectance"));
    assert!((reflectance.x - 0.9).abs() < 0.03, "{reflectance}");
}

#[test]
fn ggx_lobes_that_are_left_out_are_named() {
    let mut scene = all_kinds();
    let named = |scene: &Scene| {
        let report = export(scene).report;
        let named = report.inexact.iter().any(|line| line.contains("omitted"));
        assert_eq!(named, report.highlights > 0);
        named
    };
    assert!(!named(&scene));
    (scene.materials[1].f0, scene.materials[1].f90) = (Vec3::splat(0.1), 1.0);
    assert!(named(&scene));
}
