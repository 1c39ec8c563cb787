//! glTF files of textured quads, made by code, and their pictures.

use std::io::Cursor;
use std::sync::Arc;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use glam::Vec3;
use glowworm::formats::load_scene;
use glowworm::output::Picture;
use glowworm::scene::{Camera, LightKind, Scene};
use glowworm::settings::Settings;
use image::{DynamicImage, ImageBuffer, ImageFormat, Rgba};
use serde_json::{Value, json};

use super::support::golden::reference;
use super::support::{GpuFixture, exact};

/// A glTF file of quads.
pub struct File {
    document: Value,
    bytes: Vec<u8>,
}

/// Two texels side by side, of 16 bits a channel.
pub type Pair = [[u16; 4]; 2];

impl File {
    pub fn new() -> Self {
        let document = json!({
            "asset": { "version": "2.0" }, "scenes": [{ "nodes": [] }], "nodes": [], "meshes": [], "materials": [],
            "accessors": [], "bufferViews": [], "images": [], "textures": [],
            "samplers": [{ "magFilter": 9729, "wrapS": 33071 }, { "magFilter": 9728, "wrapS": 33071 }],
            "extensionsUsed": ["KHR_lights_punctual", "KHR_materials_unlit", "KHR_materials_specular"],
            "extensions": { "KHR_lights_punctual": { "lights": [{ "type": "directional", "intensity": 683 }] } }
        });
        Self { document, bytes: Vec::new() }
    }

    fn push(&mut self, list: &str, value: Value) -> usize {
        let list = self.document[list].as_array_mut().unwrap();
        list.push(value);
        list.len() - 1
    }

    pub fn node(&mut self, node: Value) {
        let node = self.push("nodes", node);
        self.document["scenes"][0]["nodes"].as_array_mut().unwrap().push(json!(node));
    }

    fn accessor<const N: usize>(&mut self, rows: &[[f32; N]]) -> usize {
        let view = json!({ "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": 4 * N * rows.len() });
        self.bytes.extend(rows.iter().flatten().flat_map(|value| value.to_le_bytes()));
        let view = self.push("bufferViews", view);
        let kind = ["VEC2", "VEC3", "VEC4"][N - 2];
        let bounds = (json!([-9, -9, -9]), json!([9, 9, 9]));
        let plain = json!({ "bufferView": view, "componentType": 5126, "count": rows.len(), "type": kind });
        let index = self.push("accessors", plain);
        if N == 3 {
            let accessor = &mut self.document["accessors"][index];
            (accessor["min"], accessor["max"]) = bounds;
        }
        index
    }

    /// A material without a coat.
    pub fn material(&mut self, mut material: Value) -> usize {
        if material["extensions"].is_null() {
            material["extensions"] = json!({ "KHR_materials_specular": { "specularFactor": 0 } });
        }
        self.push("materials", material)
    }

    /// A texture of two texels, with a sampler.
    pub fn texture(&mut self, pair: Pair, nearest: bool) -> usize {
        let deep = pair.as_flattened().iter().any(|value| value % 257 != 0);
        let texels = ImageBuffer::<Rgba<u16>, _>::from_raw(2, 1, pair.concat()).unwrap();
        let image = DynamicImage::ImageRgba16(texels);
        let image = if deep { image } else { image.to_rgba8().into() };
        self.image(&image, nearest)
    }

    /// A texture of two texels, read at the nearest one, beyond its borders as `wrap` says.
    pub fn wrapped_texture(&mut self, pair: Pair, wrap: u32) -> usize {
        let texture = self.texture(pair, true);
        let sampler = self.push("samplers", json!({ "magFilter": 9728, "wrapS": wrap }));
        self.document["textures"][texture]["sampler"] = json!(sampler);
        texture
    }

    pub fn image(&mut self, image: &DynamicImage, nearest: bool) -> usize {
        let mut png = Cursor::new(Vec::new());
        image.write_to(&mut png, ImageFormat::Png).unwrap();
        let uri = format!("data:image/png;base64,{}", STANDARD.encode(png.get_ref()));
        let source = self.push("images", json!({ "uri": uri }));
        self.push("textures", json!({ "source": source, "sampler": usize::from(nearest) }))
    }

    /// A quad about `centre` that faces +z, 2 by 1 times `size`; `colours` are those of its left and right.
    pub fn quad(
        &mut self,
        centre: Vec3,
        size: f32,
        material: usize,
        colours: Option<[[f32; 4]; 2]>,
        node: Value,
    ) {
        let corners = [[-1.0, -0.5], [1.0, -0.5], [1.0, 0.5], [-1.0, 0.5]];
        let positions = corners.map(|[x, y]| (centre + size * Vec3::new(x, y, 0.0)).to_array());
        let mut attributes = json!({ "POSITION": self.accessor(&[0, 1, 2, 0, 2, 3].map(|i| positions[i])) });
        let uvs = [0, 1, 2, 0, 2, 3].map(|i| [0.5 * corners[i][0] + 0.5, 0.5 - corners[i][1]]);
        attributes["TEXCOORD_0"] = json!(self.accessor(&uvs));
        let tangents = self.accessor(&[[1.0, 0.0, 0.0, 1.0]; 6]);
        (attributes["NORMAL"], attributes["TANGENT"]) =
            (json!(self.accessor(&[[0.0, 0.0, 1.0]; 6])), json!(tangents));
        if let Some([left, right]) = colours {
            let colours = [left, right, right, left, right, left];
            attributes["COLOR_0"] = json!(self.accessor(&colours));
        }
        let mesh = self
            .push("meshes", json!({ "primitives": [{ "attributes": attributes, "material": material }] }));
        let mut node = node;
        node["mesh"] = json!(mesh);
        self.node(node);
    }

    /// The scene as `eye` sees it, looking along z, without made-up light.
    pub fn scene(&self, eye: Vec3, vertical_fov: f32) -> Scene {
        let mut document = self.document.clone();
        let uri = format!("data:application/octet-stream;base64,{}", STANDARD.encode(&self.bytes));
        document["buffers"] = json!([{ "byteLength": self.bytes.len(), "uri": uri }]);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("m.gltf");
        std::fs::write(&path, document.to_string()).unwrap();
        let mut scene = load_scene(path.to_str().unwrap(), None).unwrap();
        scene.environment = None;
        scene.lights.retain(|light| light.name == "sun" || matches!(light.kind, LightKind::Area { .. }));
        let target = Vec3::new(eye.x, eye.y, 0.0);
        scene.camera = Camera { vertical_fov, ..Camera::looking(eye, target) };
        scene
    }
}

/// Pictures by raster and by the path tracer, with layers and one bounce.
pub fn pictures(scene: Scene, size: [u32; 2], spp: u64) -> Vec<(&'static str, Picture)> {
    let mut pictures = vec![("reference", reference("gltf", &scene, size, 1, spp))];
    if let Some(gpu) = GpuFixture::open() {
        let settings = Settings { bounces: 1, ..exact(size) };
        let rendered = gpu.rendered(&Arc::new(scene), &settings, 1).read_picture(true).unwrap();
        pictures.push(("render", rendered));
    }
    pictures
}
