//! BSDFs, textures and masks.

use std::sync::Arc;

use glam::{Vec2, Vec3};
use glowworm::scene::{Alpha, Instance, Material, Mesh, Scene, Texture, TextureUse, Wrap, srgb_to_linear};

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
        assert_eq!(texel.0[0], if mask.opaque_at(uv, 1.0) { 255 } else { 0 });
    }
    assert!(image.pixels().any(|texel| texel.0[0] == 0));
    assert!(!exported.mesh(by_id(document.root_element(), "mesh-0-room-material-4")).uvs.is_empty());
}

/// A box of a material with textures, under a point light.
fn shiny(material: Material, textures: Vec<Texture>) -> Exported {
    let mut scene = Scene::new("shiny");
    scene.materials.push(material);
    scene.textures.extend(textures.into_iter().map(Arc::new));
    scene.meshes.push(Mesh::cuboid("box", Vec3::ONE, 0).into());
    scene.instances.push(Instance::fixed("box", 0, glam::Affine3A::IDENTITY));
    export(&scene)
}

fn read(exported: &Exported, file: &str) -> String {
    std::fs::read_to_string(exported.path(file)).unwrap()
}

/// The root of a BSDF named "shiny" in a file of materials.
fn with_shiny(exported: &Exported, file: &str, check: impl Fn(Node<'_, '_>)) {
    let text = read(exported, file);
    let document = roxmltree::Document::parse(&text).unwrap();
    check(by_id(document.root_element(), "material-0-shiny"));
}

#[test]
fn materials_that_mitsuba_lacks_are_written_for_the_plugin_and_nearly_for_mitsuba_alone() {
    let material = Material {
        metallic: 0.25,
        roughness: 0.5,
        ..Material::lambertian("shiny", Vec3::new(0.5, 0.6, 0.7)).coated(Vec3::splat(0.25), 0.0)
    };
    let exported = shiny(material, vec![]);
    let document = roxmltree::Document::parse(&exported.text).unwrap();
    let root = document.root_element();
    assert_eq!(only(root, "include").attribute("filename"), Some("$materials"));
    let default = elements(root, "default").into_iter().find(|d| d.attribute("name") == Some("materials"));
    assert_eq!(default.unwrap().attribute("value"), Some("materials.xml"));
    assert!(elements(root, "bsdf").is_empty());
    with_shiny(&exported, "materials-glowworm.xml", |bsdf| {
        assert_eq!(kind(bsdf), "glowworm");
        let number = |name: &str| value(bsdf, name).parse::<f32>().unwrap();
        assert_eq!([number("metallic"), number("roughness"), number("f90")], [0.25, 0.5, 1.0]);
        assert_eq!(number("transmission"), 0.0);
        assert_eq!(vector(value(bsdf, "f0")), Vec3::splat(0.25));
        assert_eq!(vector(value(bsdf, "base_color")), Vec3::new(0.5, 0.6, 0.7));
    });
    with_shiny(&exported, "materials.xml", |bsdf| {
        assert_eq!(kind(bsdf), "twosided");
        let plain = only(bsdf, "bsdf");
        assert_eq!(
            (kind(plain), value(plain, "roughness"), value(plain, "metallic")),
            ("principled", "0.5", "0.25")
        );
        // ((eta - 1) / (eta + 1))^2 = 0.25
        assert!((value(plain, "eta").parse::<f32>().unwrap() - 3.0).abs() < 1e-5);
    });
    assert!(read(&exported, "glowworm_bsdf.py").contains("register_bsdf"));
    for file in ["materials.xml", "materials-glowworm.xml", "glowworm_bsdf.py"] {
        assert!(exported.report.files.iter().any(|name| name == file), "{file}");
    }
    assert_eq!(exported.report.special, 1);
    assert!(
        exported.report.inexact[0].contains("only come near 1 material"),
        "{:?}",
        exported.report.inexact
    );
    assert!(exported.report.inexact[0].contains("glowworm_bsdf.py"));
}

#[test]
fn lambertian_surfaces_need_no_plugin() {
    let exported = export(&all_kinds());
    assert_eq!(exported.report.special, 0);
    assert!(!exported.path("glowworm_bsdf.py").exists() && !exported.path("materials.xml").exists());
    assert!(!exported.text.contains("include"));
}

#[test]
fn metallic_and_roughness_are_grey_images_times_their_factors() {
    let data = Texture::linear_from_rgba8("data", 2, 1, vec![9, 51, 255, 255, 9, 204, 0, 255]);
    let material = Material {
        metallic: 1.0,
        roughness: 0.5,
        metallic_roughness_texture: Some(0.into()),
        f90: 1.0,
        ..Material::lambertian("shiny", Vec3::ONE)
    };
    let exported = shiny(material, vec![data]);
    with_shiny(&exported, "materials-glowworm.xml", |bsdf| {
        for (name, expected) in [("metallic", [1.0, 0.0]), ("roughness", [0.1, 0.4])] {
            let texture = named(bsdf, name);
            assert_eq!((value(texture, "raw"), value(texture, "filter_type")), ("true", "bilinear"));
            let image = image::open(exported.path(value(texture, "filename"))).unwrap();
            for (texel, expected) in image.as_luma16().unwrap().pixels().zip(expected) {
                assert!((f64::from(texel.0[0]) / 65_535.0 - expected).abs() < 2e-5, "{name}");
            }
        }
    });
}

#[test]
fn thin_surfaces_have_coverage_and_pass_their_colour() {
    let leaf = Texture::from_rgba8("leaf", 2, 1, vec![255, 255, 255, 255, 255, 255, 255, 51]);
    let material = Material {
        alpha: Alpha::Blend,
        opacity: 0.5,
        transmission: 0.75,
        base_colour_texture: Some(0.into()),
        f0: Vec3::splat(0.04),
        f90: 1.0,
        roughness: 0.3,
        ..Material::lambertian("shiny", Vec3::new(0.2, 0.8, 0.4))
    };
    let exported = shiny(material, vec![leaf]);
    assert_eq!(exported.report.integrator, "volpath");
    for file in ["materials-glowworm.xml", "materials.xml"] {
        with_shiny(&exported, file, |bsdf| {
            assert_eq!(kind(bsdf), "mask");
            let image = image::open(exported.path(value(named(bsdf, "opacity"), "filename"))).unwrap();
            let opacities: Vec<f64> =
                image.as_luma16().unwrap().pixels().map(|texel| f64::from(texel.0[0]) / 65_535.0).collect();
            assert!((opacities[0] - 0.5).abs() < 2e-5 && (opacities[1] - 0.1).abs() < 2e-5, "{opacities:?}");
        });
    }
    with_shiny(&exported, "materials-glowworm.xml", |bsdf| {
        assert_eq!(value(only(bsdf, "bsdf"), "transmission"), "0.75");
    });
    with_shiny(&exported, "materials.xml", |bsdf| {
        let surface = only(bsdf, "bsdf");
        assert_eq!(kind(surface), "mask");
        let opacity: f32 = value(surface, "opacity").parse().unwrap();
        assert!((0.4..0.7).contains(&opacity), "{opacity}");
    });
}

#[test]
fn textured_emission_is_a_linear_image() {
    let glow = Texture::from_rgba8("glow", 1, 1, vec![188, 0, 255, 255]);
    let material = Material {
        emission: Vec3::new(2.0, 3.0, 4.0),
        emission_texture: Some(0.into()),
        ..Material::lambertian("shiny", Vec3::ZERO)
    };
    let exported = shiny(material, vec![glow]);
    let document = roxmltree::Document::parse(&exported.text).unwrap();
    let emitter = document.descendants().find(|node| node.has_tag_name("emitter")).unwrap();
    let file = exported.path(value(named(emitter, "radiance"), "filename"));
    let texel = image::open(file).unwrap().to_rgb32f().get_pixel(0, 0).0;
    let expected = Vec3::new(2.0 * srgb_to_linear(188), 0.0, 4.0);
    assert!(Vec3::from_array(texel).distance(expected) < 1e-5, "{texel:?}");
}

#[test]
fn normal_maps_and_vertex_colours_come_with_what_they_need() {
    let mut scene = Scene::new("mapped");
    scene.textures.push(Texture::linear_from_rgba8("bumps", 1, 1, vec![128, 128, 255, 255]).into());
    scene.materials.push(Material {
        normal_texture: Some(TextureUse { offset: Vec2::new(0.5, 0.25), wrap: [Wrap::Clamp; 2], ..0.into() }),
        normal_scale: 0.5,
        ..Material::lambertian("shiny", Vec3::ONE)
    });
    let corners = [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y];
    let mut mesh = Mesh::polygon("quad", &corners, 0);
    mesh.tangents = vec![glam::Vec4::new(1.0, 0.0, 0.0, -1.0); 4];
    mesh.colours = vec![glam::Vec4::new(1.0, 0.2, 0.0, 1.0); 4];
    let first_uv = mesh.uvs[0];
    scene.meshes.push(mesh.into());
    // Twice as large, and mirrored.
    let transform = glam::Affine3A::from_scale(Vec3::new(-2.0, 2.0, 2.0));
    scene.instances.push(Instance::fixed("quad", 0, transform));
    let exported = export(&scene);
    with_shiny(&exported, "materials-glowworm.xml", |bsdf| {
        assert_eq!(value(bsdf, "normal_scale"), "0.5");
        let map = named(bsdf, "normal_map");
        assert_eq!((value(map, "raw"), value(map, "wrap_mode")), ("true", "clamp"));
        for attribute in ["vertex_color", "vertex_tangent", "vertex_side"] {
            assert_eq!(value(named(bsdf, attribute), "name"), attribute);
        }
    });
    with_shiny(&exported, "materials.xml", |bsdf| assert_eq!(kind(only(bsdf, "bsdf")), "normalmap"));
    let document = roxmltree::Document::parse(&exported.text).unwrap();
    let shape = only(document.root_element(), "shape");
    let file = exported.path(value(shape, "filename"));
    let text = String::from_utf8_lossy(&std::fs::read(file).unwrap()).into_owned();
    let names = ["r", "g", "b", "tangent_x", "tangent_y", "tangent_z", "side_x"];
    let properties: String = names.iter().map(|name| format!("property float {name}\n")).collect();
    assert!(text.contains(&properties));
    let ply = exported.mesh(shape);
    assert!(ply.positions.contains(&Vec3::new(-2.0, 2.0, 0.0)));
    assert!(ply.uvs.contains(&(first_uv + Vec2::new(0.5, 0.25))));
    assert_eq!(ply.details[0], [1.0, 0.2, 0.0, -2.0, 0.0, 0.0, 1.0]);
}
