//! glTF files whose meshes are compressed, compared with the same mesh as it is.

use glam::{Quat, Vec2};
use serde_json::{Value, json};

use super::compressed::*;
use super::gltf_files::{glb, load_glb};
use super::*;

/// Position, normal, texture coordinates and colour of a corner.
type Corner = (Vec3, Vec3, Vec2, Vec3);

/// The corners of all triangles.
fn triangles(scene: &Scene) -> Vec<[Corner; 3]> {
    let mesh = &scene.meshes[0];
    let corner = |vertex: u32| {
        let vertex = vertex as usize;
        let colour = mesh.colours.get(vertex).map_or(Vec3::ONE, |colour| colour.truncate());
        (mesh.positions[vertex], mesh.normals[vertex], mesh.uvs[vertex], colour)
    };
    mesh.triangles.iter().map(|triangle| triangle.map(corner)).collect()
}

/// Both have the same triangles, in any order, from any corner; positions and what else there is differ by less than these.
fn assert_same_triangles(what: &str, found: &Scene, (position, other): (f32, f32), of_all: bool) {
    check_consistency(found);
    let (document, bytes) = plain();
    let expected = triangles(&load_glb(&document, &bytes));
    let mut found = triangles(found);
    assert_eq!((found.len(), expected.len()), (32, 32), "{what}");
    let near = |a: &Corner, b: &Corner| {
        let (uvs, colours) = (a.2.distance(b.2), a.3.distance(b.3));
        let attributes = !of_all || uvs < other && colours < other;
        a.0.distance(b.0) <= position && a.1.distance(b.1) < other && attributes
    };
    for triangle in expected {
        let turned = |found: &[Corner; 3]| {
            (0..3).any(|first| (0..3).all(|i| near(&found[(i + first) % 3], &triangle[i])))
        };
        let place = found.iter().position(turned).unwrap_or_else(|| panic!("{what}: no {triangle:?}"));
        found.swap_remove(place);
    }
}

fn assert_warns_of_nothing(scene: &Scene) {
    assert!(!scene.warnings.iter().any(|warning| warning.contains("not shown")), "{:?}", scene.warnings);
}

/// Whichever byte of a buffer is changed, the file gives a scene or one line.
fn damage(document: &Value, bytes: &[u8]) {
    let folder = Folder::new();
    let mut failed = 0;
    for at in (0..bytes.len()).step_by(7) {
        let mut changed = bytes.to_vec();
        changed[at] = [0, 0x7f, 0xff, bytes[at] ^ 1, bytes[at] ^ 0x80][at % 5];
        std::fs::write(folder.path().join("m.glb"), glb(document, &changed)).unwrap();
        if let Err(error) = folder.load("m.glb") {
            failed += 1;
            assert!(!error.to_string().contains('\n'), "{error}");
        }
    }
    assert!(failed > 2, "{failed}");
}

#[cfg(feature = "meshopt")]
#[test]
fn meshopt_streams_are_the_mesh_that_they_were() {
    let names = ["EXT_meshopt_compression", "KHR_meshopt_compression"];
    for (name, is_strip) in names.iter().flat_map(|name| [(name, false), (name, true)]) {
        for (positions, filter, error) in [
            (POSITIONS, "NONE", 0.0),
            (POSITIONS_1, "NONE", 0.0),
            (POSITIONS_EXPONENTIAL, "EXPONENTIAL", 2e-4),
        ] {
            let (document, bytes) = meshopt(name, positions, filter, is_strip);
            let scene = load_glb(&document, &bytes);
            assert_warns_of_nothing(&scene);
            assert_same_triangles(&format!("{name} {filter}"), &scene, (error, 0.02), false);
            for (time, degrees) in [(0.0, 0.0f32), (1.0, 45.0), (1.999, 90.0)] {
                let turned = scene.pose(time).instances[0].transform_vector3(Vec3::X);
                let expected = Quat::from_rotation_z(degrees.to_radians()) * Vec3::X;
                assert!(turned.distance(expected) < 3e-3, "{time}: {turned}");
            }
        }
    }
}

#[cfg(feature = "meshopt")]
#[test]
fn damaged_meshopt_streams_are_one_line() {
    let name = "EXT_meshopt_compression";
    let (document, bytes) = meshopt(name, POSITIONS, "NONE", false);
    damage(&document, &bytes);
    let (strip, bytes_of_strip) = meshopt(name, POSITIONS_EXPONENTIAL, "EXPONENTIAL", true);
    damage(&strip, &bytes_of_strip);
    for (key, value, says) in [
        ("mode", json!("OTHER"), "OTHER"),
        ("filter", json!("QUATERNION"), "layout"),
        ("count", json!(1000), "stream"),
        ("count", json!(4_294_967_295u32), "more elements"),
        ("byteStride", json!(13), "layout"),
        ("byteLength", json!(20), "stream"),
        ("byteOffset", json!(70_000), "out of the range"),
        ("buffer", json!(9), "out of the range"),
    ] {
        let mut document = document.clone();
        document["bufferViews"][0]["extensions"][name][key] = value;
        expect_error("bad.glb", glb(&document, &bytes), &["compressed buffer view 0", says, "again"]);
    }
}

#[cfg(feature = "draco")]
#[test]
fn draco_streams_are_the_mesh_that_they_were() {
    for (what, stream) in [("edgebreaker", EDGEBREAKER), ("valence", VALENCE), ("sequential", SEQUENTIAL)] {
        let (mut document, bytes) = draco(stream);
        let scene = load_glb(&document, &bytes);
        assert_warns_of_nothing(&scene);
        assert_same_triangles(what, &scene, (2e-4, 2e-3), true);
        // Meshes may share accessors and the view, and accessors may say less than they should.
        let primitive = document["meshes"][0]["primitives"][0].clone();
        document["meshes"] = json!([{ "primitives": [primitive] }, { "primitives": [primitive] }]);
        document["accessors"][0]["count"] = json!(1);
        document["nodes"][0]["mesh"] = json!(1);
        assert_same_triangles(what, &load_glb(&document, &bytes), (2e-4, 2e-3), true);
    }
}

#[cfg(feature = "draco")]
#[test]
fn damaged_draco_streams_are_one_line() {
    for stream in [EDGEBREAKER, VALENCE, SEQUENTIAL] {
        let (document, bytes) = draco(stream);
        damage(&document, &bytes);
        for length in (0..bytes.len() - 4).step_by(7) {
            let mut document = document.clone();
            document["bufferViews"][0]["byteLength"] = json!(length);
            let parts = &["compressed mesh 0 primitive 0", "again"];
            if length < 40 {
                expect_error("bad.glb", glb(&document, &bytes), parts);
            } else {
                let _ = Folder::new().with("m.glb", glb(&document, &bytes)).load("m.glb");
            }
        }
        let extension = |document: &mut Value, key: &str, value: Value| {
            document["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"][key] = value;
        };
        for (key, value, says) in [
            ("bufferView", json!(9), "past the end"),
            ("attributes", json!({ "POSITION": 7 }), "no attribute 7"),
            ("attributes", json!(3), "not valid"),
        ] {
            let mut document = document.clone();
            extension(&mut document, key, value);
            expect_error("bad.glb", glb(&document, &bytes), &["compressed mesh 0 primitive 0", says]);
        }
    }
}

#[test]
fn what_no_build_reads_is_refused_where_meshes_need_it() {
    let refused = |extension: &str| {
        let (mut document, bytes) = plain();
        document["extensionsRequired"] = json!([extension]);
        let scene = load_glb(&document, &bytes);
        assert_same_triangles(extension, &scene, (0.0, 1e-3), true);
        document["meshes"][0]["primitives"][0]["extensions"] = json!({ extension: {} });
        expect_error("bad.glb", glb(&document, &bytes), &["needs the extension", extension]);
    };
    refused("KHR_gaussian_splatting");
    refused("EXT_unheard_of");
    #[cfg(not(feature = "meshopt"))]
    refused("EXT_meshopt_compression");
    #[cfg(not(feature = "draco"))]
    refused("KHR_draco_mesh_compression");
}
