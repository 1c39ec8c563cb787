//! The built-in scenes, bare models and their materials.

use std::f32::consts::PI;

use glam::Vec2;
use glowworm::builtin::{BENCH_SCENES, NAMES};
use glowworm::scene::{Material, Texture};

use super::*;

#[test]
fn cornell_box_needs_no_assets() {
    let scene = load_scene("cornell-box", None).unwrap();
    check_consistency(&scene);
    assert_eq!((scene.triangle_count(), scene.lights.len()), (38, 1));
    let expected = PI * 0.130 * 0.105 * luminance(Vec3::new(17.0, 12.0, 4.0));
    assert!((total_flux(&scene) / expected - 1.0).abs() < 1e-5);
}

#[test]
fn real_scenes_load() {
    let Some(assets) = assets() else { return };
    // Triangles of the source plus two for each added area light, minus degenerate ones.
    for (name, triangles, lights, textures) in [
        ("sponza", 66_440..=66_449, 1, 17),
        ("sibenik", 75_270..=75_277, 3, 5),
        ("sibenik-spot", 75_270..=75_271, 1, 5),
        ("conference", 331_100..=331_183, 2, 0),
        ("conference-torus", 340_300..=340_395, 1, 0),
        ("classroom", 90_000..=103_862, 4, 2),
        ("living-room", 142_900..=142_983, 4, 4),
    ] {
        let scene = load_scene(name, Some(&assets)).unwrap();
        check_consistency(&scene);
        assert_eq!(scene.name, name);
        assert!(scene.warnings.is_empty(), "{name}: {:?}", scene.warnings);
        assert!(triangles.contains(&scene.triangle_count()), "{name}: {}", scene.triangle_count());
        assert_eq!(scene.lights.len(), lights, "{name}");
        assert_eq!(scene.textures.len(), textures, "{name}");
        assert!(total_flux(&scene) > 0.0);
        let (min, max) = scene.bounds(&scene.pose(0.0));
        assert!(scene.camera.eye.cmpge(min).all() && scene.camera.eye.cmple(max).all(), "{name}");
    }
}

#[test]
fn the_small_cornell_boxes_load_as_bare_objs() {
    let Some(assets) = assets() else { return };
    for (name, triangles) in [("cornell-box", 36), ("cornell-glossy", 1112)] {
        let path = assets.join(name).join(format!("{name}.obj"));
        let scene = load_scene(path.to_str().unwrap(), None).unwrap();
        check_consistency(&scene);
        assert_eq!(scene.triangle_count(), triangles);
        // Its Ke is its light: one area light of 0.1786 square units.
        assert_eq!(scene.lights.len(), 1);
        let expected = PI * 0.1786 * luminance(Vec3::new(17.0, 12.0, 4.0));
        assert!((total_flux(&scene) / expected - 1.0).abs() < 1e-3);
        assert_eq!(scene.warnings.len(), 1, "{:?}", scene.warnings);
    }
}

#[test]
fn living_room_leaves_are_cut_out_and_its_glass_lets_light_pass() {
    let Some(assets) = assets() else { return };
    let scene = load_scene("living-room", Some(&assets)).unwrap();
    let leaves = scene.materials.iter().position(|m| m.name == "Leaves").unwrap();
    let steps = (0..64).flat_map(|y| (0..64).map(move |x| Vec2::new(x as f32, y as f32) / 64.0));
    let opaque = steps.filter(|uv| scene.opaque_at(leaves as u32, *uv)).count();
    assert!((400..3700).contains(&opaque), "{opaque} of 4096");
    let glass = scene.materials.iter().find(|m| m.name == "Glass").unwrap();
    assert!(glass.is_thin_surface() && glass.alpha_mask.is_none() && glass.transmission == 1.0);
}

#[test]
fn every_builtin_scene_without_assets_says_what_to_do() {
    let made = |name: &str| ["playroom", "material-grid"].contains(&name) || BENCH_SCENES.contains(&name);
    for name in NAMES.iter().filter(|name| !made(name)) {
        for assets in [None, Some(Path::new("no/such/folder"))] {
            let error = load_scene(name, assets).unwrap_err().to_string();
            assert!(error.contains("GLOWWORM_ASSETS") && error.contains("--assets"), "{error}");
            assert!(error.contains("https://") && !error.contains('\n'), "{error}");
        }
    }
}

#[test]
fn a_bare_obj_gets_a_camera_and_a_light_and_says_so() {
    let scene = load_files(&[("thing.obj", "v -5 0 2\nv 7 0 2\nv 0 3 -4\nf 1 2 3\n")]);
    check_consistency(&scene);
    assert_eq!(scene.warnings.len(), 2);
    assert!(scene.warnings[0].contains("camera") && scene.warnings[1].contains("no light given"));
    assert!(scene.lights.is_empty() && scene.environment.is_some());
    let matrix = scene.camera.projection_matrix(1.0) * scene.camera.view_matrix();
    for position in &scene.meshes[0].positions {
        let seen = matrix.project_point3(*position);
        assert!(seen.x.abs() <= 1.0 && seen.y.abs() <= 1.0 && (0.0..=1.0).contains(&seen.z), "{seen}");
    }
}

#[test]
fn obj_peculiarities_are_understood() {
    let obj = "# caf\u{e9}\r\nmtllib my lib.mtl other.mtl\r\nv 0 0 0\r\nv 1 0 0 1 0.5 0.25\r\nv 2 2 0 2\r\n\
        vt 0 0\r\nvt 1 0\r\nvt 1 1\r\nvn 0 0 2\r\nusemtl red paint\r\nf 1/1/1 2/2/1 \\\r\n3/3/1\r\n\
        usemtl blue\r\nf -3//1 -2//1 -1//1 # a comment\r\nf 1 2 3\r\nl 1 2\r\np 1\r\nf 1 2 2\r\nf 4 5 6 7 8\r\n\
        v 0 0 5\nv 4 0 5\nv 4 4 5\nv 2 1 5\nv 0 4 5\n";
    let mtl = "newmtl red paint\nkd 1 0 0\nNs 30\nmap_Kd -clamp on -s 1 1 1 TEX\\Wood.PNG\n";
    let scene = load_files(&[("odd.obj", obj), ("my lib.mtl other.mtl", mtl), ("wood.png", "not an image")]);
    check_consistency(&scene);
    let mesh = &scene.meshes[0];
    // Three triangles, and a concave pentagon of three; the degenerate one is removed.
    assert_eq!(mesh.triangles.len(), 6);
    let area: f32 = (0..6).map(|i| mesh.triangle_area(i)).sum();
    assert!((area - (3.0 * 0.5 + 10.0)).abs() < 1e-5, "{area}");
    assert!(mesh.normals.iter().all(|normal| normal.distance(Vec3::Z) < 1e-6));
    let red = scene.materials.iter().position(|m| m.name == "red paint").unwrap();
    assert_eq!(mesh.triangle_materials.iter().filter(|&&m| m as usize == red).count(), 1);
    let first = mesh.triangle_materials.iter().position(|&m| m as usize == red).unwrap();
    let uvs = mesh.triangles[first].map(|vertex| mesh.uvs[vertex as usize]);
    assert_eq!(uvs, [Vec2::new(0.0, 1.0), Vec2::new(1.0, 1.0), Vec2::new(1.0, 0.0)]);
    assert!(scene.warnings.iter().any(|w| w.contains("blue") && w.contains("grey")));
    assert!(scene.warnings.iter().any(|w| w.contains("Wood.PNG") && w.contains("checkerboard")));
    let checkerboard = scene.materials[red].base_colour_texture.unwrap();
    assert_eq!(
        scene.textures[checkerboard.texture].sample(Vec2::splat(1.0 / 16.0)),
        Vec3::new(1.0, 0.0, 1.0)
    );
}

#[test]
fn dissolve_and_alpha_cut_surfaces_away() {
    let folder = tempfile::tempdir().unwrap();
    let leaf =
        image::RgbaImage::from_fn(4, 4, |x, _| image::Rgba([10, 200, 10, if x < 2 { 255 } else { 0 }]));
    leaf.save(folder.path().join("leaf.png")).unwrap();
    let hole = image::GrayImage::from_fn(4, 4, |_, y| image::Luma([if y < 2 { 255 } else { 0 }]));
    hole.save(folder.path().join("hole.png")).unwrap();
    let mtl = "newmtl a\nd 0.4\nnewmtl b\nmap_Kd leaf.png\nnewmtl c\nmap_Kd leaf.png\nmap_d hole.png\nnewmtl d\nd 0.6\n";
    std::fs::write(folder.path().join("m.mtl"), mtl).unwrap();
    let obj = format!("mtllib m.mtl\n{TRIANGLE}");
    let path = folder.path().join("m.obj");
    std::fs::write(&path, obj).unwrap();
    let scene = load_scene(path.to_str().unwrap(), None).unwrap();
    let opaque = |material: u32, u: f32, v: f32| scene.opaque_at(material, Vec2::new(u, v));
    let coverage =
        |material: usize| scene.materials[material].thin_surface_at(&scene, Vec2::splat(0.1)).coverage;
    assert_eq!([0, 3].map(coverage), [0.4, 0.6]);
    assert!(opaque(1, 0.1, 0.9) && !opaque(1, 0.9, 0.1));
    assert!(opaque(2, 0.9, 0.1) && !opaque(2, 0.1, 0.9));
    // Texels count by their opacity, so that with another map the same image is another texture.
    assert_eq!(scene.textures.len(), 2);
    let albedo = scene.materials[1].bsdf_at(&scene, Vec2::new(0.25, 0.5)).mean_albedo();
    assert!((albedo.y - 0.578).abs() < 2e-3, "{albedo}");
}

/// `d` does not hide an emissive surface; maps mask it like any other.
#[test]
fn what_emits_stays_visible_whatever_d_says() {
    let mtl = "newmtl a\nKe 2 2 2\nd 0.2\nnewmtl b\nd 0.2\nnewmtl c\nKe 2 2 2\nd 0\nmap_d hole.png\n";
    let folder = Folder::new().with("m.mtl", mtl).with("m.obj", TRIANGLE);
    let hole = image::GrayImage::from_fn(4, 4, |_, y| image::Luma([if y < 2 { 255 } else { 0 }]));
    hole.save(folder.path().join("hole.png")).unwrap();
    let scene = folder.load("m.obj").unwrap();
    let opaque = |material: u32, v: f32| scene.opaque_at(material, Vec2::new(0.1, v));
    assert!(opaque(0, 0.1) && scene.materials[1].is_thin_surface() && opaque(2, 0.1) && !opaque(2, 0.9));
    assert!(scene.lights.iter().any(|light| matches!(light.kind, LightKind::Area { .. })));
    // A light that names an instance whose `d` would hide it.
    let text = "[[models]]\nname = \"m\"\npath = \"m.obj\"\n[[instances]]\nname = \"i\"\nmodel = \"m\"\n[[lights]]\n\
                type = \"area\"\ninstance = \"i\"\nradiance = [1, 1, 1]\n";
    let glass = TRIANGLE.replace("usemtl a", "usemtl b");
    let scene = folder.with("m.obj", glass).with("s.toml", text).load("s.toml").unwrap();
    let material = scene.meshes.last().unwrap().triangle_materials[0];
    assert!(scene.materials[material as usize].is_emissive() && scene.opaque_at(material, Vec2::ZERO));
}

#[test]
fn albedo_is_the_product_of_colour_and_texture() {
    let mut scene = Scene::new("test");
    scene.textures.push(Texture::from_rgba8("grey", 1, 1, vec![188, 188, 188, 255]).into());
    let material = Material {
        base_colour_texture: Some(0.into()),
        ..Material::lambertian("m", Vec3::new(1.0, 0.5, 0.0))
    };
    let albedo = material.bsdf_at(&scene, Vec2::new(7.3, -2.0)).mean_albedo();
    assert!(albedo.distance(Vec3::new(0.503, 0.2515, 0.0)) < 1e-3, "{albedo}");
}
