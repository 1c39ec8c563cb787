//! Broken glTF files and their messages.

use serde_json::{Value, json};

use super::gltf_files::*;
use super::*;

/// The change `change` to a good file makes loading fail with one line that has all of `parts`.
fn broken(change: impl Fn(&mut Value, &mut Vec<u8>), parts: &[&str]) {
    let (mut document, mut bytes) = (document(), buffer());
    change(&mut document, &mut bytes);
    expect_error("bad.glb", glb(&document, &bytes), parts);
}

#[test]
fn broken_files_say_what_is_wrong() {
    let good = glb(&document(), &buffer());
    for share in [5, 15, good.len() / 2, good.len() - 5] {
        expect_error("bad.glb", &good[..share], &["bad.glb", "again"]);
    }
    broken(|d, _| d["bufferViews"][0]["byteLength"] = json!(1000), &["buffer view 0", "out of the range"]);
    broken(|d, _| d["bufferViews"][0]["byteOffset"] = json!(u64::MAX), &["bad.glb"]);
    broken(|d, _| d["buffers"][0]["byteLength"] = json!(1000), &["buffer 0", "1000"]);
    broken(|d, _| d["accessors"][0]["count"] = json!(4), &["accessor 0", "buffer view 0"]);
    broken(|d, _| d["accessors"][0]["count"] = json!(1u64 << 60), &["accessor 0"]);
    broken(|d, _| d["accessors"][0]["type"] = json!("VEC2"), &["accessor 0", "POSITION", "2 components"]);
    broken(|d, _| d["accessors"][2]["componentType"] = json!(5126), &["accessor 2", "unsigned integers"]);
    broken(|d, _| d["accessors"][0]["componentType"] = json!(99), &["accessors[0]"]);
    broken(
        |d, _| d["meshes"][0]["primitives"][0]["indices"] = json!(7),
        &["primitives[0].indices", "past the end"],
    );
    broken(|d, _| d["nodes"][0]["mesh"] = json!(3), &["nodes[0].mesh", "past the end"]);
    broken(
        |d, _| d["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(9),
        &["meshes[0]", "POSITION", "past the end"],
    );
    broken(|_, b| b[60] = 9, &["vertex 9", "has 3"]);
    broken(|d, _| d["nodes"][0]["children"] = json!([0]), &["node 0", "below itself"]);
    broken(
        |d, _| d["nodes"] = json!([{ "children": [1] }, { "children": [2] }, { "children": [1], "mesh": 0 }]),
        &["node 1", "below itself"],
    );
    broken(|_, b| b[..4].copy_from_slice(&f32::NAN.to_le_bytes()), &["accessor 0", "POSITION", "not finite"]);
    broken(|d, _| d["nodes"][0]["translation"] = json!([1e39, 0, 0]), &["out of range"]);
    broken(|d, _| d["nodes"][0]["translation"] = json!([1e20, 0, 0]), &["node 0"]);
    broken(|d, _| d["asset"]["version"] = json!("1.0"), &["glTF 1.0"]);
    broken(|d, _| d["scenes"] = json!([]), &["bad.glb"]);
    broken(|d, _| d["scenes"][0]["nodes"] = json!([]), &["no triangles"]);
    expect_error("bad.glb", b"glTF", &["bad.glb"]);
    expect_error("bad.gltf", "{", &["not glTF"]);
    expect_error("bad.gltf", [0xff; 64], &["not glTF"]);
}

#[test]
fn files_that_are_named_must_be_there_and_inside() {
    for (uri, parts) in [
        ("gone.bin", &["buffer 0", "gone.bin", "cannot be read"][..]),
        ("../m.obj", &["buffer 0", "../m.obj", "out of the folder"]),
        ("a/../../m.obj", &["out of the folder"]),
        ("%2e%2e/m.obj", &["out of the folder"]),
        ("/etc/hostname", &["out of the folder"]),
        ("http://a/b.bin", &["out of the folder"]),
        ("data:application/octet-stream;base64,%%%", &["not base64"]),
        ("data:text/plain,hello", &["buffer 0", "5 bytes instead of 66"]),
    ] {
        broken(|d, _| d["buffers"][0]["uri"] = json!(uri), parts);
    }
}

#[test]
fn images_that_cannot_be_read_become_checkerboards() {
    // A picture of 2 texels that says that it is wider.
    let lying = |width: u32| {
        let mut liar = png(&[[255; 4], [0; 4]]);
        liar[16..20].copy_from_slice(&width.to_be_bytes());
        data_uri(&liar)
    };
    let ktx = data_uri(b"\xabKTX 20\xbb\r\n\x1a\n and so on");
    for (uri, says) in [
        ("gone.png", &["gone.png", "cannot be read"][..]),
        ("../x.png", &["../x.png", "out of the folder"]),
        (&data_uri(b"not an image"), &["decoded"]),
        (&lying(60_000), &["decoded"]),
        (&lying(40), &["decoded"]),
        (&lying(2_000_000_000), &["decoded"]),
        (&ktx, &["KTX", "PNG"]),
        ("data:image/png;base64,%%%", &["base64"]),
    ] {
        let mut d = document();
        d["images"] = json!([{ "uri": uri }]);
        d["textures"] = json!([{ "source": 0 }]);
        let map = json!({ "index": 0 });
        d["materials"] =
            json!([{ "pbrMetallicRoughness": { "baseColorTexture": map }, "normalTexture": map }]);
        let scene = load_glb(&d, &buffer());
        assert_eq!(scene.textures[0].levels[0].2[..4], [255, 0, 255, 255], "{uri}");
        let told: Vec<_> = scene.warnings.iter().filter(|warning| warning.contains("image 0")).collect();
        let all = |warning: &String| {
            says.iter().chain(&["m.glb", "checkerboard"]).all(|part| warning.contains(part))
        };
        assert!(told.len() == 1 && all(told[0]), "{told:?}");
        // Without a colour there is nothing to show.
        d["materials"] = json!([{ "normalTexture": map }]);
        let scene = load_glb(&d, &buffer());
        assert!(
            scene.textures.is_empty() && scene.warnings.iter().any(|warning| warning.contains("image 0"))
        );
    }
}

#[test]
fn no_bytes_of_a_glb_panic() {
    let (mut document, bytes) = (document(), buffer());
    document["nodes"][0]["scale"] = json!([1, 2, 1]);
    let good = glb(&document, &bytes);
    let folder = Folder::new();
    let file = folder.path().join("m.glb");
    for at in (0..good.len()).step_by(3) {
        for byte in [0, b'9', b'"', b'-', 0xff] {
            let mut changed = good.clone();
            changed[at] = byte;
            std::fs::write(&file, &changed).unwrap();
            if let Err(error) = folder.load("m.glb") {
                assert!(!error.to_string().contains('\n'), "{error}");
            }
        }
    }
}
