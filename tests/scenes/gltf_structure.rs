//! What nodes of glTF files place: incomplete files, buffers, animation.

use glam::{Affine3A, Quat};
use glowworm::formats::{LoadOptions, load_scene_with};
use glowworm::scene::{LightKind, SpotFalloff};
use serde_json::{Value, json};

use super::gltf_files::{add_accessor, buffer, data_uri, document, glb, load_glb, png};
use super::*;

pub(super) type Change = fn(&mut Value, &mut Vec<u8>);

/// The corners of all triangles in world space at `time`.
pub(super) fn corners(scene: &Scene, time: f64) -> Vec<Vec3> {
    let pose = scene.pose(time);
    let of = |(index, transform): (usize, &Affine3A)| {
        let mesh = &scene.meshes[scene.instances[index].mesh];
        mesh.triangles
            .iter()
            .flatten()
            .map(|vertex| transform.transform_point3(mesh.positions[*vertex as usize]))
            .collect::<Vec<_>>()
    };
    pose.instances.iter().enumerate().flat_map(of).collect()
}

pub(super) fn assert_corners(what: &str, scene: &Scene, time: f64, expected: &[Vec3]) {
    let found = corners(scene, time);
    let same =
        found.len() == expected.len() && found.iter().zip(expected).all(|(a, b)| a.distance(*b) < 2e-5);
    assert!(same, "{what} at {time}: {found:?} instead of {expected:?}");
}

pub(super) const TRIANGLE: [Vec3; 3] = [Vec3::ZERO, Vec3::X, Vec3::Y];

pub(super) fn at(place: Vec3) -> [Vec3; 3] {
    TRIANGLE.map(|corner| corner + place)
}

fn channel(target: Value) -> Value {
    json!([{ "samplers": [{ "input": 3, "output": 4 }], "channels": [{ "sampler": 0, "target": target }] }])
}

fn with_keys(document: &mut Value, bytes: &mut Vec<u8>) {
    add_accessor(document, bytes, &[0.0, 1.0], "SCALAR", 2);
    add_accessor(document, bytes, &[0.0, 0.0, 0.0, 3.0, 0.0, 0.0], "VEC3", 2);
}

fn textured(document: &mut Value, texture: Value) {
    document["images"] = json!([{ "uri": data_uri(&png(&[[9, 9, 9, 255]])) }, {}]);
    document["textures"] = json!([texture]);
    let of_base = json!({ "baseColorTexture": { "index": 0 } });
    document["materials"] = json!([{ "pbrMetallicRoughness": of_base, "normalTexture": { "index": 0 } }]);
    document["meshes"][0]["primitives"][0]["material"] = json!(0);
}

/// Incomplete documents, and the warning about each.
const INCOMPLETE: &[(&str, Change, &str)] = &[
    ("no node", |d, b| (with_keys(d, b), d["animations"] = channel(json!({ "path": "scale" }))).1, "no node"),
    (
        "a pointer",
        |d, b| (with_keys(d, b), d["animations"] = channel(json!({ "node": 0, "path": "pointer" }))).1,
        "no node",
    ),
    (
        "a node past the end",
        |d, b| (with_keys(d, b), d["animations"] = channel(json!({ "node": 9, "path": "scale" }))).1,
        "nodes that are not in the file",
    ),
    ("an empty animation", |d, _| d["animations"] = json!([{}]), ""),
    ("no image", |d, _| textured(d, json!({})), "textures without an image"),
    ("an empty image", |d, _| textured(d, json!({ "source": 1 })), "textures without an image"),
    (
        "another format",
        |d, _| {
            textured(d, json!({ "extensions": { "KHR_texture_basisu": { "source": 0 } } }));
            d["extensionsRequired"] = json!(["KHR_texture_basisu"]);
        },
        "KHR_texture_basisu (export them as PNG or JPEG)",
    ),
    (
        "no positions",
        |d, _| {
            let primitives = d["meshes"][0]["primitives"].as_array_mut().unwrap();
            primitives.push(json!({ "attributes": { "TEXCOORD_0": 1 } }));
        },
        "primitives without positions",
    ),
    ("a mesh of nothing", |d, _| d["meshes"].as_array_mut().unwrap().push(json!({})), ""),
    (
        "no bounds",
        |d, _| {
            d["accessors"][0]["max"] = json!([1]);
            d["accessors"][0].as_object_mut().unwrap().remove("min");
        },
        "",
    ),
    (
        "an attribute of the author",
        |d, _| d["meshes"][0]["primitives"][0]["attributes"]["_ID"] = json!(1),
        "",
    ),
    ("no scene named", |d, _| drop(d.as_object_mut().unwrap().remove("scene")), ""),
    (
        "no scenes",
        |d, _| {
            d.as_object_mut().unwrap().retain(|key, _| !key.starts_with("scene"));
            d["nodes"] = json!([{ "mesh": 0 }, { "children": [0] }]);
        },
        "",
    ),
    (
        "a scene without nodes before",
        |d, _| {
            d["scenes"] = json!([{}, { "nodes": [0] }]);
            d.as_object_mut().unwrap().remove("scene");
        },
        "scenes but the first or default one",
    ),
    (
        "a later scene",
        |d, _| (d["scenes"] = json!([{}, { "nodes": [0] }]), d["scene"] = json!(1)).1,
        "scenes",
    ),
    (
        "an extension that nobody knows and no shape needs",
        |d, _| {
            d["extensionsRequired"] = json!(["EXT_unheard_of"]);
            d["materials"] = json!([{ "extensions": { "EXT_unheard_of": {} } }]);
        },
        "extension EXT_unheard_of",
    ),
    (
        "keys whose times fall",
        |d, b| {
            add_accessor(d, b, &[1.0, 0.0], "SCALAR", 2);
            add_accessor(d, b, &[0.0, 0.0, 0.0, 3.0, 0.0, 0.0], "VEC3", 2);
            d["animations"] = channel(json!({ "node": 0, "path": "translation" }));
        },
        "rising times",
    ),
    (
        "an extension that is ignored",
        |d, _| {
            d["extensionsUsed"] = json!(["KHR_xmp"]);
            d["extensionsRequired"] = json!(["KHR_materials_volume"]);
        },
        "extension KHR_materials_volume, extension KHR_xmp",
    ),
    (
        "zeros for a morph target",
        |d, _| {
            d["accessors"]
                .as_array_mut()
                .unwrap()
                .push(json!({ "componentType": 5126, "count": 3, "type": "VEC3" }));
            d["meshes"][0]["primitives"][0]["targets"] = json!([{ "POSITION": 3 }]);
            d["meshes"][0]["weights"] = json!([1]);
        },
        "",
    ),
];

#[test]
fn incomplete_files_show_what_is_there() {
    for (what, change, warning) in INCOMPLETE {
        let (mut document, mut bytes) = (document(), buffer());
        change(&mut document, &mut bytes);
        let scene = load_glb(&document, &bytes);
        check_consistency(&scene);
        assert_corners(what, &scene, 0.5, &TRIANGLE);
        let said = scene.warnings.iter().find(|said| said.contains("not shown")).cloned().unwrap_or_default();
        assert!(said.contains(warning) && said.is_empty() == warning.is_empty(), "{what}: \"{said}\"");
    }
}

#[test]
fn what_cannot_be_read_is_named_with_what_to_do() {
    let table: &[(Change, &[&str])] = &[
        (|d, _| d["asset"]["minVersion"] = json!("2.1"), &["glTF 2.1"]),
        (|d, _| *d = json!({ "asset": { "version": "1.0" }, "nodes": {}, "scene": "a" }), &["is glTF 1.0"]),
    ];
    for (change, parts) in table {
        let (mut document, mut bytes) = (document(), buffer());
        change(&mut document, &mut bytes);
        expect_error("bad.glb", glb(&document, &bytes), parts);
    }
    expect_error("bad.glb", b"glTF\x01\0\0\0\x14\0\0\0\0\0\0\0\0\0\0\0", &["glTF 1.0"]);
}

#[test]
fn buffers_and_names_are_found_as_viewers_find_them() {
    let bytes = buffer();
    let plain = data_uri(&bytes);
    let encoded: String = bytes.iter().map(|byte| format!("%{byte:02x}")).collect();
    let (head, tail) = plain.split_at(60);
    for uri in [
        plain.replace("data:", "DATA:").replace(";base64", ";BASE64"),
        plain.trim_end_matches('=').to_owned(),
        plain.replace('+', "-").replace("/A", "_A").replace("/B", "_B"),
        format!("{head}\n {tail}"),
        plain.replace('=', "%3D"),
        format!("data:,{encoded}"),
        "m.bin".to_owned(),
        "m.bin?v=2".to_owned(),
        "M.BIN".to_owned(),
    ] {
        let mut document = document();
        document["buffers"][0]["uri"] = json!(uri);
        let text = format!("\u{feff}{document}");
        let scene = Folder::new().with("m.bin", &bytes).with("m.gltf", text).load("m.gltf").unwrap();
        assert_corners(&uri, &scene, 0.0, &TRIANGLE);
    }
    let mut document = document();
    document["buffers"][0]["uri"] = json!("U\u{308}.bin");
    let scene = Folder::new().with("\u{dc}.bin", &bytes).with("m.gltf", document.to_string()).load("m.gltf");
    assert_corners("composed", &scene.unwrap(), 0.0, &TRIANGLE);
}

#[test]
fn nodes_move_as_their_channels_say() {
    // Path, interpolation, times, values, and where (1, 0, 0) of the mesh is at some times.
    type Row<'a> = (&'a str, &'a str, &'a [f32], &'a [f32], &'a [(f64, Vec3)]);
    let y = |v: f32| Vec3::new(v, 0.0, 0.0);
    let table: &[Row] = &[
        (
            "scale",
            "LINEAR",
            &[0.0, 2.0],
            &[1.0, 1.0, 1.0, 3.0, 1.0, 1.0],
            &[(0.0, y(1.0)), (1.0, y(2.0)), (1.9, y(2.9))],
        ),
        (
            "scale",
            "STEP",
            &[0.0, 1.0, 2.0],
            &[1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0],
            &[(0.0, y(1.0)), (0.99, y(1.0)), (1.0, y(0.0)), (1.5, y(0.0)), (1.99, y(0.0)), (2.5, y(1.0))],
        ),
        (
            "translation",
            "LINEAR",
            &[5.0, 7.0],
            &[-1.0, 0.0, 0.0, 1.0, 0.0, 0.0],
            &[(0.0, y(0.0)), (6.0, y(1.0)), (8.0, y(0.0))],
        ),
        (
            // h(1/2) of 0 with slope 4 to 2 with slope 0: 1 + 4/8.
            "translation",
            "CUBICSPLINE",
            &[0.0, 1.0],
            &[[0.0; 6], [4.0, 0.0, 0.0, 0.0, 0.0, 0.0], [2.0, 0.0, 0.0, 0.0, 0.0, 0.0]].concat(),
            &[(0.0, y(1.0)), (0.5, y(2.5))],
        ),
        (
            "rotation",
            "STEP",
            &[0.0, 1.0, 2.0],
            &[0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0],
            &[(0.9, y(1.0)), (1.1, y(-1.0))],
        ),
    ];
    for (path, interpolation, times, values, expected) in table {
        let (mut document, mut bytes) = (document(), buffer());
        let input = add_accessor(&mut document, &mut bytes, times, "SCALAR", times.len());
        let width = if *path == "rotation" { 4 } else { 3 };
        let kind = format!("VEC{width}");
        let output = add_accessor(&mut document, &mut bytes, values, &kind, values.len() / width);
        document["animations"] = json!([{
            "samplers": [{ "input": input, "output": output, "interpolation": interpolation }],
            "channels": [{ "sampler": 0, "target": { "node": 0, "path": path } }]
        }]);
        let scene = load_glb(&document, &bytes);
        for (time, place) in *expected {
            let transform = scene.pose(*time).instances[0];
            let found = transform.transform_point3(Vec3::X);
            assert!(
                found.distance(*place) < 1e-4,
                "{path} {interpolation} at {time}: {found} instead of {place}"
            );
            assert!(transform.inverse().is_finite(), "{path} {interpolation} at {time}");
        }
    }
}

/// A light and a camera turn by 40 degrees about y below a node that mirrors and stretches, which changes where they look.
#[test]
fn lights_and_cameras_move_with_all_that_nodes_above_them_do() {
    let half = 20f32.to_radians();
    for scale in [Vec3::ONE, Vec3::new(-1.0, 1.0, 1.0), Vec3::new(3.0, 1.0, 1.0), Vec3::new(1.0, -2.0, -0.5)]
    {
        let (mut d, mut b) = (document(), buffer());
        let input = add_accessor(&mut d, &mut b, &[0.0, 1.0], "SCALAR", 2);
        let turns = [0.0, 0.0, 0.0, 1.0, 0.0, half.sin(), 0.0, half.cos()];
        let output = add_accessor(&mut d, &mut b, &turns, "VEC4", 2);
        d["extensionsUsed"] = json!(["KHR_lights_punctual"]);
        d["extensions"] = json!({ "KHR_lights_punctual": { "lights": [{ "type": "directional" }] } });
        d["cameras"] = json!([{ "type": "perspective", "perspective": { "yfov": 1, "znear": 0.1 } }]);
        d["nodes"] = json!([
            { "mesh": 0 },
            { "children": [2], "scale": scale.to_array() },
            { "camera": 0, "extensions": { "KHR_lights_punctual": { "light": 0 } } }
        ]);
        d["scenes"][0]["nodes"] = json!([0, 1]);
        d["animations"] = json!([{
            "samplers": [{ "input": input, "output": output }],
            "channels": [{ "sampler": 0, "target": { "node": 2, "path": "rotation" } }]
        }]);
        let scene = load_glb(&d, &b);
        // Without a far plane the near one stays.
        assert!(scene.camera.near == 0.1 && scene.camera.far >= 0.2);
        for time in [0.0, 0.4, 0.99f32] {
            let turn = Quat::from_rotation_y(time * 2.0 * half);
            let expected = (scale * (turn * Vec3::NEG_Z)).normalize();
            let pose = scene.pose(f64::from(time));
            let up = pose.camera.up.normalize();
            assert!(
                pose.lights[0].direction.distance(expected) < 1e-3,
                "{scale}: {}",
                pose.lights[0].direction
            );
            assert!(pose.camera.forward().distance(expected) < 1e-3, "{scale}: {}", pose.camera.forward());
            assert!(up.distance(Vec3::Y * scale.y.signum()) < 1e-3, "{scale}: {up}");
        }
    }
}

#[test]
fn an_animation_is_chosen_by_name_or_index() {
    let (mut document, mut bytes) = (document(), buffer());
    with_keys(&mut document, &mut bytes);
    add_accessor(&mut document, &mut bytes, &[0.0, 0.0, 0.0, 0.0, 7.0, 0.0], "VEC3", 2);
    let [mut walk, mut jump] = [channel(json!({ "node": 0, "path": "translation" })), Value::Null];
    jump.clone_from(&walk[0]);
    (jump["samplers"][0]["output"], jump["name"]) = (json!(5), json!("jump"));
    walk.as_array_mut().unwrap().push(jump);
    document["animations"] = walk;
    let folder = Folder::new().with("m.glb", glb(&document, &bytes)).with("m.obj", super::TRIANGLE);
    let load = |name: &str, choice: Option<&str>| {
        let options = LoadOptions { animation: choice.map(str::to_owned), ..LoadOptions::default() };
        load_scene_with(folder.path().join(name).to_str().unwrap(), None, &options)
    };
    for (choice, place) in [
        (None, Vec3::X * 1.5),
        (Some("0"), Vec3::X * 1.5),
        (Some("1"), Vec3::Y * 3.5),
        (Some("jump"), Vec3::Y * 3.5),
    ] {
        let scene = load("m.glb", choice).unwrap();
        assert_corners(&format!("{choice:?}"), &scene, 0.5, &at(place));
        let told = scene.warnings.iter().any(|warning| warning.contains("--animation"));
        assert_eq!(told, choice.is_none(), "{:?}", scene.warnings);
    }
    let error = load("m.glb", Some("run")).unwrap_err().to_string();
    assert!(error.contains("\"run\"") && error.contains("0, 1 (\"jump\")"), "{error}");
    assert!(load("m.obj", Some("0")).unwrap_err().to_string().contains("--animation"));
}

#[test]
fn a_tree_may_be_deep() {
    let (mut document, mut bytes) = (document(), buffer());
    with_keys(&mut document, &mut bytes);
    let count = 30_000;
    let mut nodes: Vec<Value> = (1..count).map(|child| json!({ "children": [child] })).collect();
    nodes.push(json!({ "mesh": 0 }));
    document["nodes"] = json!(nodes);
    document["animations"] = channel(json!({ "node": 0, "path": "translation" }));
    let scene = load_glb(&document, &bytes);
    assert_corners("deep", &scene, 0.5, &at(Vec3::X * 1.5));
}

#[test]
fn spots_fall_by_the_square() {
    let (mut document, bytes) = (document(), buffer());
    document["extensionsUsed"] = json!(["KHR_lights_punctual"]);
    let spot = json!({ "innerConeAngle": 0, "outerConeAngle": std::f32::consts::FRAC_PI_3 });
    document["extensions"] =
        json!({ "KHR_lights_punctual": { "lights": [{ "type": "spot", "intensity": 683, "spot": spot }] } });
    document["nodes"][0]["extensions"] = json!({ "KHR_lights_punctual": { "light": 0 } });
    let scene = load_glb(&document, &bytes);
    let LightKind::Spot { inner_angle, outer_angle, falloff, .. } = scene.lights[0].kind else {
        panic!("a spot")
    };
    assert_eq!(falloff, SpotFalloff::Square);
    let at = |cos: f32| glowworm::scene::spot_falloff(cos, inner_angle, outer_angle, falloff);
    assert!((at(0.74) - 0.48 * 0.48).abs() < 1e-4, "{}", at(0.74));
    // The flux is the integral of the intensity over the sphere.
    let steps = 100_000;
    let sum: f64 = (0..steps).map(|i| f64::from(at((i as f32 + 0.5) / steps as f32))).sum();
    let expected = (sum / f64::from(steps)) as f32 * 2.0 * std::f32::consts::PI;
    assert!((total_flux(&scene) / expected - 1.0).abs() < 1e-3, "{} {expected}", total_flux(&scene));
}
