//! Scenes from their public side: the real ones, scene files, bare models, animation and radiometry.
//! What is wrong with a file is the matter of `tests/broken_scenes.rs`.

use std::f32::consts::PI;
use std::path::{Path, PathBuf};

use glam::{Vec2, Vec3};
use glowworm::scene::{
    BUILTIN_SCENES, LightKind, Material, Mesh, Scene, load_scene, luminance, spot_falloff,
};

/// The folder of the downloadable models; says aloud that the test is skipped when there is none.
fn assets() -> Option<PathBuf> {
    let assets = std::env::var_os("GLOWWORM_ASSETS").map(PathBuf::from);
    if assets.is_none() {
        println!("SKIPPED: GLOWWORM_ASSETS is not set, so the large models cannot be loaded");
        let required = std::env::var("GLOWWORM_REQUIRE_ALL").is_ok_and(|value| value == "1");
        assert!(
            !required,
            "GLOWWORM_REQUIRE_ALL=1 and GLOWWORM_ASSETS is not set"
        );
    }
    assets
}

/// Writes `files` into a folder and loads the first of them.
fn load_files(files: &[(&str, &str)]) -> Scene {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in files {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    load_scene(
        folder.path().join(files[0].0).to_str().unwrap(),
        Some(folder.path()),
    )
    .unwrap()
}

fn load_toml(text: &str) -> Scene {
    load_files(&[("test.toml", text)])
}

/// Everything that the rest of the program relies on.
fn check_consistency(scene: &Scene) {
    for mesh in &scene.meshes {
        let vertices = mesh.positions.len();
        assert!(mesh.normals.len() == vertices && mesh.uvs.len() == vertices);
        assert_eq!(mesh.triangles.len(), mesh.triangle_materials.len());
        assert!(!mesh.triangles.is_empty());
        assert!(
            mesh.triangles
                .iter()
                .flatten()
                .all(|&vertex| (vertex as usize) < vertices)
        );
        assert!(mesh.triangle_materials.is_sorted());
        assert!(
            mesh.triangle_materials
                .iter()
                .all(|&m| (m as usize) < scene.materials.len())
        );
        assert!(mesh.positions.iter().all(|position| position.is_finite()));
        assert!(mesh.uvs.iter().all(|uv| uv.is_finite()));
        assert!(
            mesh.normals
                .iter()
                .all(|normal| (normal.length() - 1.0).abs() < 1e-3)
        );
    }
    for material in &scene.materials {
        assert!(material.albedo.min_element() >= 0.0 && material.albedo.max_element() <= 1.0);
        assert!(
            material
                .albedo_texture
                .is_none_or(|texture| texture < scene.textures.len())
        );
        assert!(
            material
                .alpha_mask
                .is_none_or(|mask| mask < scene.alpha_masks.len())
        );
    }
    for light in &scene.lights {
        if let LightKind::Area {
            instance,
            triangles,
        } = &light.kind
        {
            let mesh = &scene.meshes[scene.instances[*instance].mesh];
            assert!(
                triangles
                    .iter()
                    .all(|t| (t.triangle as usize) < mesh.triangles.len())
            );
        }
    }
    assert!(0.0 < scene.camera.near && scene.camera.near < scene.camera.far);
}

fn total_flux(scene: &Scene) -> f32 {
    let pose = scene.pose(0.0);
    let bounds = scene.bounding_sphere(&pose);
    scene
        .lights
        .iter()
        .map(|light| luminance(light.flux(scene, &pose, &bounds)))
        .sum()
}

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
    // Triangles of the source plus two for each area light made here, less those without area.
    for (name, triangles, lights, textures) in [
        ("sponza", 66_440..=66_449, 1, 12),
        ("sibenik", 75_270..=75_277, 3, 3),
        ("conference", 331_100..=331_183, 2, 0),
        ("classroom", 90_000..=103_862, 4, 2),
        ("living-room", 142_900..=142_983, 4, 4),
    ] {
        let scene = load_scene(name, Some(&assets)).unwrap();
        check_consistency(&scene);
        assert_eq!(scene.name, name);
        assert!(scene.warnings.is_empty(), "{name}: {:?}", scene.warnings);
        assert!(
            triangles.contains(&scene.triangle_count()),
            "{name}: {}",
            scene.triangle_count()
        );
        assert_eq!(scene.lights.len(), lights, "{name}");
        assert_eq!(scene.textures.len(), textures, "{name}");
        assert!(total_flux(&scene) > 0.0);
        let (min, max) = scene.bounds(&scene.pose(0.0));
        assert!(
            scene.camera.eye.cmpge(min).all() && scene.camera.eye.cmple(max).all(),
            "{name}"
        );
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
fn living_room_leaves_are_cut_out() {
    let Some(assets) = assets() else { return };
    let scene = load_scene("living-room", Some(&assets)).unwrap();
    let leaves = scene
        .materials
        .iter()
        .position(|m| m.name == "Leaves")
        .unwrap();
    let steps = (0..64).flat_map(|y| (0..64).map(move |x| Vec2::new(x as f32, y as f32) / 64.0));
    let opaque = steps
        .filter(|uv| scene.opaque_at(leaves as u32, *uv))
        .count();
    assert!((400..3700).contains(&opaque), "{opaque} of 4096");
    let glass = scene
        .materials
        .iter()
        .position(|m| m.name == "Glass")
        .unwrap();
    assert!(!scene.opaque_at(glass as u32, Vec2::splat(0.5)));
}

#[test]
fn every_builtin_scene_without_assets_says_what_to_do() {
    for name in BUILTIN_SCENES.iter().filter(|name| **name != "cornell-box") {
        for assets in [None, Some(Path::new("no/such/folder"))] {
            let error = load_scene(name, assets).unwrap_err().to_string();
            assert!(
                error.contains("GLOWWORM_ASSETS") && error.contains("--assets"),
                "{error}"
            );
            assert!(
                error.contains("https://") && !error.contains('\n'),
                "{error}"
            );
        }
    }
}

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

#[test]
fn a_bare_obj_gets_a_camera_and_a_light_and_says_so() {
    let scene = load_files(&[("thing.obj", "v -5 0 2\nv 7 0 2\nv 0 3 -4\nf 1 2 3\n")]);
    check_consistency(&scene);
    assert_eq!(scene.warnings.len(), 2);
    assert!(scene.warnings[0].contains("camera") && scene.warnings[1].contains("light"));
    assert!(matches!(scene.lights[0].kind, LightKind::Point { .. }));
    let matrix = scene.camera.projection_matrix(1.0) * scene.camera.view_matrix();
    for position in &scene.meshes[0].positions {
        let seen = matrix.project_point3(*position);
        assert!(
            seen.x.abs() <= 1.0 && seen.y.abs() <= 1.0 && (0.0..=1.0).contains(&seen.z),
            "{seen}"
        );
    }
}

#[test]
fn obj_peculiarities_are_understood() {
    let obj = "# caf\u{e9}\r\nmtllib my lib.mtl other.mtl\r\nv 0 0 0\r\nv 1 0 0 1 0.5 0.25\r\nv 2 2 0 2\r\n\
        vt 0 0\r\nvt 1 0\r\nvt 1 1\r\nvn 0 0 2\r\nusemtl red paint\r\nf 1/1/1 2/2/1 \\\r\n3/3/1\r\n\
        usemtl blue\r\nf -3//1 -2//1 -1//1 # a comment\r\nf 1 2 3\r\nl 1 2\r\np 1\r\nf 1 2 2\r\nf 4 5 6 7 8\r\n\
        v 0 0 5\nv 4 0 5\nv 4 4 5\nv 2 1 5\nv 0 4 5\n";
    let mtl = "newmtl red paint\nkd 1 0 0\nNs 30\nmap_Kd -clamp on -s 1 1 1 TEX\\Wood.PNG\n";
    let scene = load_files(&[
        ("odd.obj", obj),
        ("my lib.mtl other.mtl", mtl),
        ("wood.png", "not an image"),
    ]);
    check_consistency(&scene);
    let mesh = &scene.meshes[0];
    // Three triangles, and a concave pentagon of three; the one without area is gone.
    assert_eq!(mesh.triangles.len(), 6);
    let area: f32 = (0..6).map(|i| mesh.triangle_area(i)).sum();
    assert!((area - (3.0 * 0.5 + 10.0)).abs() < 1e-5, "{area}");
    assert!(
        mesh.normals
            .iter()
            .all(|normal| normal.distance(Vec3::Z) < 1e-6)
    );
    let red = scene
        .materials
        .iter()
        .position(|m| m.name == "red paint")
        .unwrap();
    assert_eq!(
        mesh.triangle_materials
            .iter()
            .filter(|&&m| m as usize == red)
            .count(),
        1
    );
    let first = mesh
        .triangle_materials
        .iter()
        .position(|&m| m as usize == red)
        .unwrap();
    let uvs = mesh.triangles[first].map(|vertex| mesh.uvs[vertex as usize]);
    assert_eq!(
        uvs,
        [
            Vec2::new(0.0, 1.0),
            Vec2::new(1.0, 1.0),
            Vec2::new(1.0, 0.0)
        ]
    );
    assert!(
        scene
            .warnings
            .iter()
            .any(|w| w.contains("blue") && w.contains("grey"))
    );
    assert!(
        scene
            .warnings
            .iter()
            .any(|w| w.contains("Wood.PNG") && w.contains("checkerboard"))
    );
    let checkerboard = scene.materials[red].albedo_texture.unwrap();
    assert_eq!(
        scene.textures[checkerboard].sample(Vec2::splat(1.0 / 16.0)),
        Vec3::new(1.0, 0.0, 1.0)
    );
}

#[test]
fn dissolve_and_alpha_cut_surfaces_away() {
    let folder = tempfile::tempdir().unwrap();
    let leaf = image::RgbaImage::from_fn(4, 4, |x, _| {
        image::Rgba([10, 200, 10, if x < 2 { 255 } else { 0 }])
    });
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
    assert!(!opaque(0, 0.1, 0.1) && opaque(3, 0.1, 0.1));
    assert!(opaque(1, 0.1, 0.9) && !opaque(1, 0.9, 0.1));
    assert!(opaque(2, 0.9, 0.1) && !opaque(2, 0.1, 0.9));
    assert_eq!(scene.textures.len(), 1);
    let albedo = scene.materials[1].albedo_at(&scene, Vec2::new(0.25, 0.5));
    assert!((albedo.y - 0.578).abs() < 2e-3, "{albedo}");
}

const WORLD: &str = r#"
name = "world"
background = [0.1, 0.2, 0.3]

[[models]]
name = "ball"
primitive = "sphere"
size = [2, 1, 1]
subdivisions = 3
material = { albedo = [0.2, 0.4, 0.6] }

[[models]]
name = "lamp"
primitive = "quad"
size = [2, 1, 3]

[[models]]
name = "glow"
primitive = "box"
material = { emission = [1, 2, 3] }

[[models]]
name = "room"
builtin = "cornell-box"

[[instances]]
model = "ball"
translation = [1, 2, 3]
rotation = [0, 90, 0]
scale = [1, 2, 1]
animation = { rotation = { axis = [0, 2, 0], degrees_per_second = 90, pivot = [0, 0, 0] } }

[[instances]]
name = "lamp 1"
model = "lamp"
rotation = { axis = [1, 0, 0], degrees = 180 }

[[instances]]
model = "glow"
scale = 2
visible = false

[[instances]]
model = "room"
dynamic = true

[camera]
eye = [0, 0, 10]
target = [0, 0, 0]
vfov_deg = 60
animation = { keyframes = [{ time = 0 }, { time = 2, translation = [4, 0, 0], rotation = [0, 90, 0] }] }

[[lights]]
name = "bulb"
type = "point"
position = [0, 5, 0]
intensity = [1, 1, 1]
animation = { rotation = { axis = [0, 0, 1], degrees_per_second = 180, pivot = [0, 0, 0] } }

[[lights]]
type = "spot"
position = [0, 5, 0]
direction = [0, -3, 0]
intensity = [2, 2, 2]
inner_deg = 20
outer_deg = 40
animation = { rotation = { axis = [1, 0, 0], degrees_per_second = 90 } }

[[lights]]
name = "sun"
type = "directional"
direction = [0, -1, 0]
irradiance = [3, 3, 3]

[[lights]]
name = "panel"
type = "area"
radiance = [4, 4, 4]
polygon = [[-1, 3, -2], [1, 3, -2], [1, 3, 2], [-1, 3, 2]]
visible = false
animation = { keyframes = [{ time = 0 }, { time = 1, translation = [0, 1, 0] }] }

[[lights]]
name = "lamp light"
type = "area"
instance = "lamp 1"
radiance = [5, 5, 5]

[settings]
vpls = 64
exposure = 1
"#;

#[test]
fn a_scene_file_says_what_it_means() {
    let scene = load_toml(WORLD);
    check_consistency(&scene);
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    assert_eq!(
        (scene.name.as_str(), scene.background),
        ("world", Vec3::new(0.1, 0.2, 0.3))
    );
    let names: Vec<&str> = scene
        .lights
        .iter()
        .map(|light| light.name.as_str())
        .collect();
    assert_eq!(
        names,
        [
            "bulb",
            "light 2",
            "sun",
            "panel",
            "lamp light",
            "glow",
            "room"
        ]
    );
    let dynamic: Vec<bool> = scene
        .instances
        .iter()
        .map(|instance| instance.dynamic)
        .collect();
    assert_eq!(dynamic, [true, false, false, true, true]);
    let visible: Vec<bool> = scene
        .instances
        .iter()
        .map(|instance| instance.visible)
        .collect();
    assert_eq!(visible, [true, true, false, true, false]);
    assert_eq!(
        scene.settings.get("vpls").and_then(toml::Value::as_integer),
        Some(64)
    );
    assert_eq!(scene.settings.len(), 2);
    // A quad that is turned over and lit shines from what was its upper side.
    let LightKind::Area {
        instance,
        triangles,
    } = &scene.lights[4].kind
    else {
        panic!("an area light")
    };
    assert_eq!(
        (*instance, triangles.len(), triangles[0].radiance),
        (1, 2, Vec3::splat(5.0))
    );
    let down = scene.instances[1]
        .transform
        .transform_vector3(scene.meshes[scene.instances[1].mesh].normals[0]);
    assert!(down.distance(Vec3::NEG_Y) < 1e-5);
}

#[test]
fn poses_follow_the_animations() {
    let scene = load_toml(WORLD);
    assert_eq!(scene.pose(0.5), scene.pose(0.5));
    let rest = scene.pose(0.0);
    assert_eq!(rest.camera, scene.camera);
    assert_eq!(rest.instances[0], scene.instances[0].transform);
    // The ball orbits the y axis at 90 degrees a second, as one rigid body.
    let quarter = scene.pose(1.0);
    let centre = Vec3::from(quarter.instances[0].translation);
    assert!(
        centre.distance(Vec3::new(3.0, 2.0, -1.0)) < 1e-4,
        "{centre}"
    );
    assert_eq!(quarter.instances[1], rest.instances[1]);
    // The bulb turns about z, the spot about itself, the panel rises.
    assert!(
        quarter.lights[0]
            .position
            .distance(Vec3::new(0.0, -5.0, 0.0))
            < 1e-4
    );
    assert_eq!(quarter.lights[1].position, rest.lights[1].position);
    assert!(quarter.lights[1].direction.distance(Vec3::NEG_Z) < 1e-5);
    assert!(Vec3::from(quarter.instances[4].translation).distance(Vec3::new(0.0, 4.0, 0.0)) < 1e-5);
    // The camera travels and looks to the left in the end, and stays.
    let end = scene.pose(2.0).camera;
    assert!(end.eye.distance(Vec3::new(4.0, 0.0, 10.0)) < 1e-5);
    assert!(end.forward().distance(Vec3::NEG_X) < 1e-5);
    assert_eq!(scene.pose(99.0).camera, end);
    assert!(end.eye.length() < scene.camera.far);
}

#[test]
fn flux_agrees_with_numerical_integration() {
    let scene = load_toml(WORLD);
    let pose = scene.pose(0.0);
    let bounds = scene.bounding_sphere(&pose);
    let flux: Vec<f32> = scene
        .lights
        .iter()
        .map(|light| light.flux(&scene, &pose, &bounds).x)
        .collect();
    let close = |got: f32, expected: f32| {
        assert!(
            (got / expected - 1.0).abs() < 1e-3,
            "{got}, expected {expected}"
        );
    };
    // Integrate the intensity over the sphere, in rings of equal cosine.
    const RINGS: usize = 100_000;
    let sphere = |intensity: &dyn Fn(f32) -> f32| {
        let rings =
            (0..RINGS).map(|i| f64::from(intensity(2.0 * (i as f32 + 0.5) / RINGS as f32 - 1.0)));
        (rings.sum::<f64>() * f64::from(4.0 * PI) / RINGS as f64) as f32
    };
    close(flux[0], sphere(&|_| 1.0));
    let (inner, outer) = (20f32.to_radians(), 40f32.to_radians());
    close(
        flux[1],
        sphere(&|cos| 2.0 * spot_falloff(cos, inner, outer)),
    );
    close(flux[2], 3.0 * PI * bounds.radius * bounds.radius);
    close(flux[3], 4.0 * PI * 8.0);
    close(flux[4], 5.0 * PI * 6.0);
    // All six faces of a box scaled by two, each 4 large.
    close(flux[5], PI * 24.0);
}

#[test]
fn spot_falloff_is_smooth_and_bounded() {
    let (inner, outer) = (0.3f32, 0.9f32);
    assert_eq!(
        spot_falloff(0.31f32.cos().max(inner.cos()), inner, outer),
        1.0
    );
    assert_eq!(spot_falloff(outer.cos() - 0.01, inner, outer), 0.0);
    let middle = 0.5 * (inner.cos() + outer.cos());
    assert!((spot_falloff(middle, inner, outer) - 0.5).abs() < 1e-6);
}

#[test]
fn empty_and_dark_scenes_are_allowed() {
    let scene = load_toml("");
    assert!(scene.instances.is_empty() && scene.lights.is_empty());
    assert!(
        scene
            .warnings
            .iter()
            .any(|w| w.contains("black") && w.contains("light"))
    );
    let pose = scene.pose(0.0);
    assert_eq!(scene.bounds(&pose), (Vec3::splat(-0.5), Vec3::splat(0.5)));
    check_consistency(&scene);
}

#[test]
fn models_come_from_files_and_can_be_cut() {
    let text = "[[models]]\nname = \"m\"\npath = \"m.obj\"\nclip = { min = [-1, -1, -1], max = [0.5, 9, 9] }\n\
        [[models]]\nname = \"n\"\nasset = \"m.obj\"\n[[instances]]\nmodel = \"m\"\n[[instances]]\nmodel = \"n\"\n";
    let scene = load_files(&[("s.toml", text), ("m.obj", TRIANGLE)]);
    let area = |mesh: &Mesh| {
        (0..mesh.triangles.len() as u32)
            .map(|i| mesh.triangle_area(i))
            .sum::<f32>()
    };
    assert!((area(&scene.meshes[0]) - 0.375).abs() < 1e-6);
    assert_eq!(area(&scene.meshes[1]), 0.5);
}

#[test]
fn albedo_is_the_product_of_colour_and_texture() {
    let mut scene = Scene::new("test");
    scene.textures.push(glowworm::scene::Texture::from_rgba8(
        "grey",
        1,
        1,
        vec![188, 188, 188, 255],
    ));
    let material = Material {
        albedo_texture: Some(0),
        ..Material::lambertian("m", Vec3::new(1.0, 0.5, 0.0))
    };
    let albedo = material.albedo_at(&scene, Vec2::new(7.3, -2.0));
    assert!(
        albedo.distance(Vec3::new(0.503, 0.2515, 0.0)) < 1e-3,
        "{albedo}"
    );
}
