//! Small whole inputs of every kind, made here.

use std::io::Cursor;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use image::{DynamicImage, ImageFormat};
use serde_json::{Value, json};

use super::compressed::*;

/// Files by name; the first is the scene.
pub type Files = Vec<(String, Vec<u8>)>;

fn encoded(image: &DynamicImage, format: ImageFormat) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    image.write_to(&mut bytes, format).unwrap();
    bytes.into_inner()
}

/// A PNG of 4 x 4 texels of `depth` bits: 0 grey, 2 RGB, 3 of a palette of two with transparency, 4 grey and alpha.
fn png(kind: u8, depth: u8) -> Vec<u8> {
    let samples = [1, 0, 3, 1, 2][kind as usize] * usize::from(depth);
    let row: Vec<u8> =
        (0..(4 * samples).div_ceil(8)).map(|i| if kind == 3 { 0x11 } else { 40 * i as u8 }).collect();
    let rows: Vec<u8> = (0..4).flat_map(|_| [&[0], &row[..]].concat()).collect();
    let length = rows.len() as u16;
    let stored =
        [&[0x78, 1, 1], &length.to_le_bytes()[..], &(!length).to_le_bytes(), &rows, &[0; 4]].concat();
    let mut bytes = b"\x89PNG\r\n\x1a\n".to_vec();
    let mut chunk = |name: &[u8; 4], data: &[u8]| {
        bytes.extend([&(data.len() as u32).to_be_bytes()[..], name, data, &[0; 4]].concat());
    };
    chunk(b"IHDR", &[0, 0, 0, 4, 0, 0, 0, 4, depth, kind, 0, 0, 0]);
    if kind == 3 {
        chunk(b"PLTE", &[200, 40, 90, 10, 20, 30]);
        chunk(b"tRNS", &[255, 0]);
    }
    chunk(b"IDAT", &stored);
    chunk(b"IEND", &[]);
    mend_png(&mut bytes);
    bytes
}

/// Gives the chunks of a PNG their checksums, so that a change of it is not refused for that alone.
pub fn mend_png(bytes: &mut [u8]) {
    let mut at = 8;
    while let Some(head) = bytes.get(at..at + 8) {
        let length = u32::from_be_bytes([head[0], head[1], head[2], head[3]]) as usize;
        let end = at.saturating_add(8).saturating_add(length);
        let Some(content) = bytes.get(at + 4..end) else { return };
        let sum = !content.iter().fold(!0u32, |sum, &byte| {
            (0..8).fold(sum ^ u32::from(byte), |sum, _| sum >> 1 ^ (0xedb8_8320 & (sum & 1).wrapping_neg()))
        });
        let Some(place) = bytes.get_mut(end..end + 4) else { return };
        place.copy_from_slice(&sum.to_be_bytes());
        at = end + 4;
    }
}

/// Images of all formats, by file name.
fn images() -> Files {
    let texel = |x: u32, y: u32| image::Rgb([(60 * x) as u8, (60 * y) as u8, 30]);
    let rgb = DynamicImage::ImageRgb8(image::RgbImage::from_fn(8, 4, texel));
    let float = DynamicImage::ImageRgb32F(rgb.to_rgb32f());
    let made = [
        ("jpg", ImageFormat::Jpeg),
        ("webp", ImageFormat::WebP),
        ("tif", ImageFormat::Tiff),
        ("bmp", ImageFormat::Bmp),
    ];
    let mut files: Files =
        made.into_iter().map(|(name, format)| (format!("t.{name}"), encoded(&rgb, format))).collect();
    files.push(("t.tga".into(), encoded(&rgb, ImageFormat::Tga)));
    for (name, format) in [("exr", ImageFormat::OpenExr), ("hdr", ImageFormat::Hdr)] {
        files.push((format!("t.{name}"), encoded(&float, format)));
    }
    for (kind, depth) in [(0, 1), (0, 16), (2, 8), (2, 16), (3, 1), (3, 8), (4, 8)] {
        files.push((format!("t{kind}-{depth}.png"), png(kind, depth)));
    }
    let mut dds = vec![0u8; 136];
    dds[..4].copy_from_slice(b"DDS ");
    for (at, word) in [(4, 124u32), (8, 0x1007), (12, 4), (16, 4), (76, 32), (80, 4), (108, 0x1000)] {
        dds[at..at + 4].copy_from_slice(&word.to_le_bytes());
    }
    dds[84..88].copy_from_slice(b"DXT1");
    files.push(("t.dds".into(), dds));
    files
}

/// Two triangles with all attributes, a skin and a morph target; and the bytes of their buffer.
fn document() -> (Value, Vec<u8>) {
    let (mut views, mut accessors, mut bytes) = (Vec::new(), Vec::new(), Vec::<u8>::new());
    let mut add = |kind: &str, component: u32, count: usize, data: &[u8]| {
        views.push(json!({ "buffer": 0, "byteOffset": bytes.len(), "byteLength": data.len() }));
        accessors.push(json!({ "bufferView": views.len() - 1, "componentType": component, "count": count, "type": kind }));
        bytes.extend(data);
        bytes.resize(bytes.len().next_multiple_of(4), 0);
        accessors.len() - 1
    };
    let floats = |values: &[f32]| values.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<_>>();
    let positions = add("VEC3", 5126, 4, &floats(&[0., 0., 0., 1., 0., 0., 1., 1., 0., 0., 1., 0.]));
    let normals = add("VEC3", 5126, 4, &floats(&[0., 0., 1.].repeat(4)));
    let uvs = add("VEC2", 5126, 4, &floats(&[0., 0., 1., 0., 1., 1., 0., 1.]));
    let colours = add("VEC4", 5121, 4, &[255, 128, 0, 200].repeat(4));
    let joints = add("VEC4", 5121, 4, &[0, 1, 0, 0].repeat(4));
    let weights = add("VEC4", 5126, 4, &floats(&[0.5, 0.5, 0., 0.].repeat(4)));
    let indices = add("SCALAR", 5123, 6, &[0, 0, 1, 0, 2, 0, 0, 0, 2, 0, 3, 0]);
    let bones = add("MAT4", 5126, 2, &floats(&glam::Mat4::IDENTITY.to_cols_array().repeat(2)));
    let times = add("SCALAR", 5126, 2, &floats(&[0., 1.]));
    let turns = add("VEC4", 5126, 2, &floats(&[0., 0., 0., 1., 0., 1., 0., 0.]));
    let moves = add("VEC3", 5126, 2, &floats(&[0., 0., 0., 1., 0., 0.]));
    accessors[positions]["min"] = json!([0, 0, 0]);
    accessors[positions]["max"] = json!([1, 1, 0]);
    accessors[colours]["normalized"] = json!(true);
    accessors[normals]["sparse"] = json!({ "count": 1, "indices": { "bufferView": indices, "componentType": 5123 },
        "values": { "bufferView": normals } });
    let image = format!("data:image/png;base64,{}", STANDARD.encode(png(2, 8)));
    let transform =
        json!({ "KHR_texture_transform": { "offset": [0.5, 0], "rotation": 1, "scale": [2, 1] } });
    let sampler = |output: usize| json!({ "input": times, "output": output, "interpolation": "LINEAR" });
    let channel =
        |sampler: u32, path: &str| json!({ "sampler": sampler, "target": { "node": 1, "path": path } });
    let document = json!({
        "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0] }],
        "extensionsUsed": ["KHR_texture_transform", "KHR_lights_punctual", "KHR_materials_emissive_strength"],
        "extensions": { "KHR_lights_punctual": { "lights": [{ "type": "spot", "spot": { "outerConeAngle": 0.5 } }] } },
        "nodes": [
            { "children": [1, 2, 3], "translation": [0, 0, 1] },
            { "mesh": 0, "skin": 0, "rotation": [0, 0, 0, 1], "name": "\u{1b}[31mquad" },
            { "camera": 0, "translation": [0, 0, 5], "extensions": { "KHR_lights_punctual": { "light": 0 } } },
            { "matrix": glam::Mat4::IDENTITY.to_cols_array() }
        ],
        "cameras": [{ "type": "perspective", "perspective": { "yfov": 0.6, "znear": 0.1, "zfar": 100 } }],
        "skins": [{ "joints": [1, 3], "inverseBindMatrices": bones }],
        "meshes": [{ "weights": [0.5], "primitives": [{ "indices": indices, "material": 0, "mode": 4,
            "attributes": { "POSITION": positions, "NORMAL": normals, "TEXCOORD_0": uvs, "COLOR_0": colours,
                "JOINTS_0": joints, "WEIGHTS_0": weights }, "targets": [{ "POSITION": normals }] }] }],
        "materials": [{ "alphaMode": "MASK", "alphaCutoff": 0.4, "doubleSided": true, "emissiveFactor": [1, 0, 0],
            "extensions": { "KHR_materials_emissive_strength": { "emissiveStrength": 2 } },
            "normalTexture": { "index": 0, "scale": 0.5 },
            "pbrMetallicRoughness": { "baseColorFactor": [1, 1, 1, 0.5], "metallicFactor": 0.5,
                "baseColorTexture": { "index": 0, "extensions": transform },
                "metallicRoughnessTexture": { "index": 0 } } }],
        "textures": [{ "source": 0, "sampler": 0 }], "images": [{ "uri": image }],
        "samplers": [{ "magFilter": 9728, "wrapS": 33071, "wrapT": 33648 }],
        "animations": [{ "samplers": [sampler(turns), sampler(moves), sampler(moves)],
            "channels": [channel(0, "rotation"), channel(1, "translation"), channel(2, "scale")] }],
        "bufferViews": views, "accessors": accessors, "buffers": [{ "byteLength": bytes.len() }],
    });
    (document, bytes)
}

fn gltf((mut document, bytes): (Value, Vec<u8>)) -> Files {
    document["buffers"][0]["uri"] = json!("m.bin");
    vec![("s.gltf".into(), document.to_string().into_bytes()), ("m.bin".into(), bytes)]
}

fn glb() -> Files {
    let (document, bytes) = document();
    let mut text = document.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let total = 28 + text.len() + bytes.len();
    let mut file = [&b"glTF\x02\0\0\0"[..], &(total as u32).to_le_bytes()].concat();
    for (kind, chunk) in [(b"JSON", &text), (b"BIN\0", &bytes)] {
        file.extend([&(chunk.len() as u32).to_le_bytes()[..], kind, &chunk[..]].concat());
    }
    vec![("s.glb".into(), file)]
}

const OBJ: &str = "mtllib m.mtl # materials\nv 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 1 1 0 0 0 1\nv 0 1 0 1 1 1\nv 2 2 1 2\n\
    vt 0 0\nvt 1 0\nvt 1 1\nvn 0 0 1\no thing\ns 1\nusemtl a b\nf 1/1/1 2/2/1 3/3/1 4/1/1\ns off\nusemtl c\n\
    f -1//1 -2 \\\n-3//1\nf 1 2 5 3 4\nl 1 2\np 1\n";
const MTL: &str = "newmtl a b\nKd .8 .7 .6\nKs .1 .1 .1\nNs 50\nmap_Kd -s 2 1 -o .5 0 0 -clamp on t.png\nmap_Bump -bm 2 t.png\n\
    map_d t.png\nnewmtl c # comment\nKe 2 1 1\nmap_Ke t.png\nPr .3\nmap_Pr t.png\nPm 1\nd .5\nTf 1\nillum 4\nNi 1.5\n";
const TOML: &str = "name = \"\\u001b[31ms\"\nbackground = [0.1, 0.1, 0.1]\n[[models]]\nname = \"m\"\npath = \"m.obj\"\n[[models]]\n\
    name = \"q\"\nprimitive = \"quad\"\nsize = [1, 1, 2]\nmaterial = { albedo = [0.5, 0.5, 0.5] }\n[[instances]]\nname = \"i\"\n\
    model = \"m\"\ntranslation = [0, 1, 0]\nscale = 2\n[[instances]]\nname = \"j\"\nmodel = \"q\"\n[[instances.animation.keyframes]]\n\
    time = 0\ntranslation = [0, 0, 0]\n[[instances.animation.keyframes]]\ntime = 1\ntranslation = [1, 0, 0]\n[[lights]]\ntype = \"point\"\n\
    name = \"l\"\nposition = [0, 3, 0]\nintensity = [5, 5, 5]\n[[lights]]\ntype = \"spot\"\nposition = [1, 3, 0]\ndirection = [0, -1, 0]\n\
    intensity = [5, 5, 5]\ninner_deg = 10\nouter_deg = 30\n[camera]\neye = [0, 1, 5]\ntarget = [0, 1, 0]\nvfov_deg = 40\n\
    [settings]\nbounces = 2\nexposure = 1\n";

/// A scene of one model with camera and light, which therefore need not be made up.
const PLACED: &str = "[[models]]\nname = \"m\"\npath = \"m.obj\"\n[[instances]]\nmodel = \"m\"\n[camera]\neye = [0, 1, 5]\n\
    target = [0, 1, 0]\n[[lights]]\ntype = \"point\"\nposition = [0, 3, 3]\nintensity = [5, 5, 5]\n";

/// Every input.
pub fn all() -> Vec<Files> {
    let model = |image: Vec<u8>| -> Files {
        vec![("m.obj".into(), OBJ.into()), ("m.mtl".into(), MTL.into()), ("t.png".into(), image)]
    };
    let mut inputs =
        vec![gltf(document()), glb(), gltf(document()), glb(), model(png(2, 8)), model(png(3, 1))];
    let mut scene = model(png(0, 16));
    scene.insert(0, ("s.toml".into(), TOML.into()));
    inputs.push(scene);
    let sky = TOML.replace("background = [0.1, 0.1, 0.1]", "environment = { map = \"t.exr\", strength = 2 }");
    inputs.push(gltf(plain()));
    if cfg!(feature = "draco") {
        inputs.extend([draco(EDGEBREAKER), draco(VALENCE), draco(SEQUENTIAL)].map(gltf));
    }
    if cfg!(feature = "meshopt") {
        let (old, new) = ("EXT_meshopt_compression", "KHR_meshopt_compression");
        inputs.push(gltf(meshopt(old, POSITIONS, "NONE", false)));
        inputs.push(gltf(meshopt(old, POSITIONS_EXPONENTIAL, "EXPONENTIAL", true)));
        inputs.push(gltf(meshopt(new, POSITIONS_1, "NONE", false)));
    }
    for (name, content) in images() {
        if name.ends_with("exr") || name.ends_with("hdr") {
            let scene = sky.replace("t.exr", &name).into_bytes();
            inputs.push(vec![
                ("s.toml".into(), scene),
                ("m.obj".into(), OBJ.into()),
                (name.clone(), content.clone()),
            ]);
        }
        inputs.push(vec![
            ("s.toml".into(), PLACED.into()),
            ("m.obj".into(), OBJ.into()),
            ("m.mtl".into(), MTL.replace("t.png", &name).into()),
            (name, content),
        ]);
    }
    inputs
}
