//! Normal maps of known slopes, from files: in the G-buffer and in the path tracer.

use std::path::Path;
use std::sync::Arc;

use glam::{Vec2, Vec3};
use glowworm::formats::load_scene;
use glowworm::scene::{Camera, Scene};
use serde_json::{Value, json};

use super::support::golden::reference;
use super::support::{GpuFixture, exact, layer};

const SIZE: [u32; 2] = [64, 64];

/// The normals in the four quarters of the image: upper left, upper right, lower left, lower right.
const QUARTERS: [Vec3; 4] = [
    Vec3::new(-0.5, 0.0, 1.0),
    Vec3::new(0.3, 0.4, 1.0),
    Vec3::new(0.0, -0.7, 1.0),
    Vec3::new(0.2, 0.1, 1.0),
];

fn quarter(at: Vec2) -> Vec3 {
    QUARTERS[usize::from(at.x > 0.5) + 2 * usize::from(at.y > 0.5)].normalize()
}

/// An image of 32 x 32 normals.
fn write_map(folder: &Path) {
    let image = image::RgbImage::from_fn(32, 32, |x, y| {
        let normal = quarter(Vec2::new(x as f32 + 0.5, y as f32 + 0.5) / 32.0) * 127.5 + 127.5;
        image::Rgb(normal.round().to_array().map(|value| value as u8))
    });
    image.save(folder.join("map.png")).unwrap();
}

/// The quad from -1 to 1 in the plane z = 0, seen from z = 2.5.
fn load(folder: &Path, name: &str) -> Scene {
    let mut scene = load_scene(folder.join(name).to_str().unwrap(), None).unwrap();
    assert!(!scene.warnings.iter().any(|warning| warning.contains("not shown")), "{:?}", scene.warnings);
    scene.camera = Camera { vertical_fov: 0.85, ..Camera::looking(Vec3::new(0.0, 0.0, 2.5), Vec3::ZERO) };
    scene
}

fn obj(folder: &Path, mtl: &str, mirrored: bool) -> Scene {
    let [left, right] = if mirrored { [1, 0] } else { [0, 1] };
    std::fs::write(folder.join("q.mtl"), format!("newmtl q\nKd 1 1 1\n{mtl}\n")).unwrap();
    let text = format!(
        "mtllib q.mtl\nusemtl q\nv -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvt {left} 0\nvt {right} 0\nvt {right} 1\nvt {left} 1\n\
         f 1/1 2/2 3/3 4/4\n"
    );
    std::fs::write(folder.join("q.obj"), text).unwrap();
    load(folder, "q.obj")
}

/// A variation of a glTF file.
struct Variation {
    /// Its texture, but for the index.
    texture: Value,
    node: Value,
    tangent: Option<[f32; 4]>,
}

fn gltf(folder: &Path, Variation { mut texture, mut node, tangent }: Variation) -> Scene {
    let mut bytes: Vec<u8> = Vec::new();
    let mut views = Vec::new();
    let mut accessors = Vec::new();
    let mut add = |floats: &[f32], kind: &str, each: usize| {
        views.push(json!({ "buffer": 0, "byteOffset": bytes.len(), "byteLength": 4 * floats.len() }));
        bytes.extend(floats.iter().flat_map(|value| value.to_le_bytes()));
        let count = floats.len() / each;
        accessors.push(
            json!({ "bufferView": views.len() - 1, "componentType": 5126, "count": count, "type": kind,
            "min": [-1, -1, 0], "max": [1, 1, 0] }),
        );
        accessors.len() - 1
    };
    let positions = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    let all = |of: &dyn Fn([f32; 2]) -> Vec<f32>| positions.iter().flat_map(|p| of(*p)).collect::<Vec<f32>>();
    let mut attributes = json!({
        "POSITION": add(&all(&|[x, y]| vec![x, y, 0.0]), "VEC3", 3),
        "NORMAL": add(&all(&|_| vec![0.0, 0.0, 1.0]), "VEC3", 3),
        "TEXCOORD_0": add(&all(&|[x, y]| vec![0.5 + 0.5 * x, 0.5 - 0.5 * y]), "VEC2", 2),
        // The first set, mirrored.
        "TEXCOORD_1": add(&all(&|[x, y]| vec![0.5 - 0.5 * x, 0.5 - 0.5 * y]), "VEC2", 2),
    });
    if let Some(tangent) = tangent {
        attributes["TANGENT"] = json!(add(&all(&|_| tangent.to_vec()), "VEC4", 4));
    }
    texture["index"] = json!(0);
    node["mesh"] = json!(0);
    std::fs::write(folder.join("q.bin"), &bytes).unwrap();
    let document = json!({
        "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0] }], "nodes": [node],
        "extensionsUsed": ["KHR_texture_transform"],
        "meshes": [{ "primitives": [{ "attributes": attributes, "material": 0 }] }],
        "materials": [{ "normalTexture": texture, "pbrMetallicRoughness": { "metallicFactor": 0 }, "doubleSided": true }],
        "textures": [{ "source": 0 }], "images": [{ "uri": "map.png" }],
        "accessors": accessors, "bufferViews": views, "buffers": [{ "uri": "q.bin", "byteLength": bytes.len() }]
    });
    std::fs::write(folder.join("q.gltf"), document.to_string()).unwrap();
    load(folder, "q.gltf")
}

/// Compares the normals that pixels see with those that `expected` says for places on the quad, from its upper left corner.
fn check(gpu: &GpuFixture, what: &str, scene: Scene, expected: impl Fn(Vec2) -> Vec3) {
    let traced = reference("normal-map", &scene, SIZE, 0, 1);
    let rendered = gpu.rendered(&Arc::new(scene), &exact(SIZE), 1).read_picture(true).unwrap();
    for (by, picture) in [("G-buffer", rendered), ("reference", traced)] {
        let (normals, positions) = (layer(&picture, "normal"), layer(&picture, "position"));
        let mut seen = 0;
        for (normal, position) in
            normals.into_iter().zip(positions).map(|(n, p)| (Vec3::from(n), Vec3::from(p)))
        {
            let at = Vec2::new(0.5 + 0.5 * position.x, 0.5 - 0.5 * position.y);
            // Away from the borders between the quarters, where the filter mixes them.
            let inside = ((at * 2.0).fract() - 0.5).abs().max_element() < 0.4;
            if normal == Vec3::ZERO || !inside {
                continue;
            }
            let angle = normal.angle_between(expected(at)).to_degrees();
            assert!(angle < 0.5, "{what}, {by}, {at}: {normal} is {angle} degrees off {}", expected(at));
            seen += 1;
        }
        assert!(seen > 1000, "{what}, {by}: {seen}");
    }
}

const TURN: Vec3 = Vec3::new(-1.0, 1.0, 1.0);

fn mirrored(at: Vec2) -> Vec3 {
    quarter(Vec2::new(1.0 - at.x, at.y)) * TURN
}

#[test]
fn slopes_of_obj_files_read_back() {
    let Some(gpu) = GpuFixture::open() else { return };
    let folder = tempfile::tempdir().unwrap();
    write_map(folder.path());
    check(&gpu, "norm", obj(folder.path(), "norm map.png", false), quarter);
    check(&gpu, "a bluish map_Bump", obj(folder.path(), "map_Bump -bm 1 map.png", false), quarter);
    check(&gpu, "mirrored", obj(folder.path(), "norm map.png", true), mirrored);
    // Heights: to the right 3 of 255 a texel of 64, a hundredth of the image high: 0.64 x 3/255 x 50.
    let ramp = image::GrayImage::from_fn(64, 64, |x, _| image::Luma([(3 * x) as u8]));
    ramp.save(folder.path().join("ramp.png")).unwrap();
    let slope = 0.64 * 3.0 / 255.0 * 50.0;
    check(&gpu, "bump", obj(folder.path(), "bump -bm 50 ramp.png", false), |_| Vec3::new(-slope, 0.0, 1.0));
}

#[test]
fn slopes_of_gltf_files_read_back() {
    let Some(gpu) = GpuFixture::open() else { return };
    let folder = tempfile::tempdir().unwrap();
    write_map(folder.path());
    let plain = || Variation { texture: json!({}), node: json!({}), tangent: None };
    let show = |what: &str, variation: Variation, expected: &dyn Fn(Vec2) -> Vec3| {
        check(&gpu, what, gltf(folder.path(), variation), expected);
    };
    show("made tangents", plain(), &quarter);
    show("own tangents", Variation { tangent: Some([1.0, 0.0, 0.0, 1.0]), ..plain() }, &quarter);
    show("the other side", Variation { tangent: Some([1.0, 0.0, 0.0, -1.0]), ..plain() }, &|at| {
        quarter(at) * Vec3::new(1.0, -1.0, 1.0)
    });
    show("mirrored coordinates", Variation { texture: json!({ "texCoord": 1 }), ..plain() }, &mirrored);
    let mirror = json!({ "extensions": { "KHR_texture_transform": { "scale": [-1, 1], "offset": [1, 0] } } });
    show("a mirroring transform", Variation { texture: mirror, ..plain() }, &mirrored);
    show("negative scale", Variation { node: json!({ "scale": [-1, 1, 1] }), ..plain() }, &mirrored);
    show("seen from behind", Variation { node: json!({ "rotation": [0, 1, 0, 0] }), ..plain() }, &|at| {
        // The far side of what rises sinks.
        let [x, y, z] = quarter(Vec2::new(1.0 - at.x, at.y)).to_array();
        Vec3::new(x, -y, z)
    });
    let half = json!({ "scale": 0.5 });
    show("scale", Variation { texture: half, ..plain() }, &|at| {
        let normal = quarter(at);
        Vec3::new(0.5 * normal.x, 0.5 * normal.y, normal.z)
    });
}
