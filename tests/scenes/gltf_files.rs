//! Small glTF files, made by code.

use serde_json::{Value, json};

use super::*;

/// Triangle in the plane z = 0: positions, texture coordinates, indices, as one buffer of 66 bytes.
pub(super) fn buffer() -> Vec<u8> {
    let floats = [0.0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0];
    let indices = [0u16, 1, 2];
    let mut bytes: Vec<u8> = floats.iter().flat_map(|v| v.to_le_bytes()).collect();
    bytes.extend(indices.iter().flat_map(|v| v.to_le_bytes()));
    bytes
}

/// The document of that buffer: one node with one triangle.
pub(super) fn document() -> Value {
    json!({
        "asset": { "version": "2.0" },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0, "name": "n" }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0, "TEXCOORD_0": 1 }, "indices": 2 }] }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0] },
            { "bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC2" },
            { "bufferView": 2, "componentType": 5123, "count": 3, "type": "SCALAR" }
        ],
        "bufferViews": [
            { "buffer": 0, "byteOffset": 0, "byteLength": 36 },
            { "buffer": 0, "byteOffset": 36, "byteLength": 24 },
            { "buffer": 0, "byteOffset": 60, "byteLength": 6 }
        ],
        "buffers": [{ "byteLength": 66 }]
    })
}

/// Appends bytes to a buffer and an accessor for them to its document; returns the accessor's index.
pub(super) fn add_accessor(
    document: &mut Value,
    bytes: &mut Vec<u8>,
    floats: &[f32],
    kind: &str,
    count: usize,
) -> usize {
    bytes.resize(bytes.len().next_multiple_of(4), 0);
    let view = json!({ "buffer": 0, "byteOffset": bytes.len(), "byteLength": 4 * floats.len() });
    bytes.extend(floats.iter().flat_map(|v| v.to_le_bytes()));
    document["buffers"][0]["byteLength"] = json!(bytes.len());
    let views = document["bufferViews"].as_array_mut().unwrap();
    views.push(view);
    let place = views.len() - 1;
    let accessors = document["accessors"].as_array_mut().unwrap();
    accessors.push(json!({ "bufferView": place, "componentType": 5126, "count": count, "type": kind, "min": [0], "max": [9] }));
    accessors.len() - 1
}

/// A GLB of a document and its buffer.
pub(super) fn glb(document: &Value, bytes: &[u8]) -> Vec<u8> {
    let mut json = document.to_string().into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut bytes = bytes.to_vec();
    bytes.resize(bytes.len().next_multiple_of(4), 0);
    let total = 12 + 8 + json.len() + 8 + bytes.len();
    let mut glb = Vec::new();
    glb.extend(b"glTF");
    for word in [2, total as u32, json.len() as u32] {
        glb.extend(word.to_le_bytes());
    }
    glb.extend(b"JSON");
    glb.extend(json);
    glb.extend((bytes.len() as u32).to_le_bytes());
    glb.extend(b"BIN\0");
    glb.extend(bytes);
    glb
}

pub(super) fn load_glb(document: &Value, bytes: &[u8]) -> Scene {
    let folder = Folder::new().with("m.glb", glb(document, bytes));
    folder.load("m.glb").unwrap()
}

pub(super) fn png(texels: &[[u8; 4]]) -> Vec<u8> {
    let image = image::RgbaImage::from_fn(texels.len() as u32, 1, |x, _| image::Rgba(texels[x as usize]));
    let mut bytes = std::io::Cursor::new(Vec::new());
    image.write_to(&mut bytes, image::ImageFormat::Png).unwrap();
    bytes.into_inner()
}

pub(super) fn data_uri(bytes: &[u8]) -> String {
    use base64::Engine;
    format!(
        "data:application/octet-stream;base64,{}",
        base64::engine::general_purpose::STANDARD.encode(bytes)
    )
}
