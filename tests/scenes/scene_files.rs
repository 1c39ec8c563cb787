//! Scene files: animation, and the flux of lights.

use std::f32::consts::PI;

use glowworm::scene::{Mesh, SpotFalloff, spot_falloff};

use super::*;

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
    assert_eq!((scene.name.as_str(), scene.background), ("world", Vec3::new(0.1, 0.2, 0.3)));
    let names: Vec<&str> = scene.lights.iter().map(|light| light.name.as_str()).collect();
    assert_eq!(names, ["bulb", "light 2", "sun", "panel", "lamp light", "glow", "room"]);
    let dynamic: Vec<bool> = scene.instances.iter().map(|instance| instance.dynamic).collect();
    assert_eq!(dynamic, [true, false, false, true, true]);
    let visible: Vec<bool> = scene.instances.iter().map(|instance| instance.visible).collect();
    assert_eq!(visible, [true, true, false, true, false]);
    assert_eq!(scene.settings.get("vpls").and_then(toml::Value::as_integer), Some(64));
    assert_eq!(scene.settings.len(), 2);
    // An emissive quad that is rotated by 180 degrees emits from its former upper side.
    let LightKind::Area { instance, triangles } = &scene.lights[4].kind else { panic!("an area light") };
    assert_eq!((*instance, triangles.len(), triangles[0].radiance), (1, 2, Vec3::splat(5.0)));
    let down =
        scene.instances[1].transform.transform_vector3(scene.meshes[scene.instances[1].mesh].normals[0]);
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
    assert!(centre.distance(Vec3::new(3.0, 2.0, -1.0)) < 1e-4, "{centre}");
    assert_eq!(quarter.instances[1], rest.instances[1]);
    // The bulb rotates about z, the spot about itself, the panel rises.
    assert!(quarter.lights[0].position.distance(Vec3::new(0.0, -5.0, 0.0)) < 1e-4);
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
    let flux: Vec<f32> = scene.lights.iter().map(|light| light.flux(&scene, &pose, &bounds).x).collect();
    let close = |got: f32, expected: f32| {
        assert!((got / expected - 1.0).abs() < 1e-3, "{got}, expected {expected}");
    };
    // Integrate the intensity over the sphere, in rings of equal cosine.
    const RINGS: usize = 100_000;
    let sphere = |intensity: &dyn Fn(f32) -> f32| {
        let rings = (0..RINGS).map(|i| f64::from(intensity(2.0 * (i as f32 + 0.5) / RINGS as f32 - 1.0)));
        (rings.sum::<f64>() * f64::from(4.0 * PI) / RINGS as f64) as f32
    };
    close(flux[0], sphere(&|_| 1.0));
    let (inner, outer) = (20f32.to_radians(), 40f32.to_radians());
    close(flux[1], sphere(&|cos| 2.0 * spot_falloff(cos, inner, outer, SpotFalloff::Smooth)));
    close(flux[2], 3.0 * PI * bounds.radius * bounds.radius);
    close(flux[3], 4.0 * PI * 8.0);
    close(flux[4], 5.0 * PI * 6.0);
    // All six faces of a box scaled by two, each 4 large.
    close(flux[5], PI * 24.0);
}

#[test]
fn spot_falloff_is_smooth_and_bounded() {
    let (inner, outer) = (0.3f32, 0.9f32);
    assert_eq!(spot_falloff(0.31f32.cos().max(inner.cos()), inner, outer, SpotFalloff::Smooth), 1.0);
    assert_eq!(spot_falloff(outer.cos() - 0.01, inner, outer, SpotFalloff::Smooth), 0.0);
    let middle = 0.5 * (inner.cos() + outer.cos());
    assert!((spot_falloff(middle, inner, outer, SpotFalloff::Smooth) - 0.5).abs() < 1e-6);
}

#[test]
fn empty_and_dark_scenes_are_allowed() {
    let scene = load_toml("");
    assert!(scene.instances.is_empty() && scene.lights.is_empty());
    assert!(scene.warnings.iter().any(|w| w.contains("black") && w.contains("light")));
    let pose = scene.pose(0.0);
    assert_eq!(scene.bounds(&pose), (Vec3::splat(-0.5), Vec3::splat(0.5)));
    check_consistency(&scene);
}

#[test]
fn models_come_from_files_and_can_be_cut() {
    let text = "[[models]]\nname = \"m\"\npath = \"m.obj\"\nclip = { min = [-1, -1, -1], max = [0.5, 9, 9] }\n\
        [[models]]\nname = \"n\"\nasset = \"m.obj\"\n[[instances]]\nmodel = \"m\"\n[[instances]]\nmodel = \"n\"\n";
    let scene = load_files(&[("s.toml", text), ("m.obj", TRIANGLE)]);
    let area = |mesh: &Mesh| (0..mesh.triangles.len() as u32).map(|i| mesh.triangle_area(i)).sum::<f32>();
    assert!((area(&scene.meshes[0]) - 0.375).abs() < 1e-6);
    assert_eq!(area(&scene.meshes[1]), 0.5);
}

#[test]
fn a_scene_with_nothing_to_see_says_so() {
    let light = "[[lights]]\ntype = \"point\"\nposition = [0, 1, 0]\nintensity = [1, 1, 1]\n";
    let hidden =
        "[[models]]\nname = \"m\"\nprimitive = \"box\"\n[[instances]]\nmodel = \"m\"\nvisible = false\n";
    for (text, expected) in [
        (light.to_owned(), true),
        (format!("{hidden}{light}"), true),
        (format!("{hidden}{light}").replace("false", "true"), false),
    ] {
        let warnings = load_toml(&text).warnings;
        let said = warnings.iter().any(|warning| warning.contains("no visible [[instances]]"));
        assert_eq!(said, expected, "{warnings:?}");
    }
}

#[test]
fn many_instances_load() {
    let count = 60_000;
    let mut text = "[[models]]\nname = \"m\"\nprimitive = \"box\"\n".to_owned();
    for i in 0..count {
        text += &format!("[[instances]]\nmodel = \"m\"\ntranslation = [{}, 0, {}]\n", i % 250, i / 250);
    }
    assert_eq!(load_toml(&text).instances.len(), count);
}
