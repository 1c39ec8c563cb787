//! Exports a scene to a temporary folder and parses the files.

use std::fs;
use std::path::PathBuf;

use glam::{Mat4, Vec2, Vec3};
use glowworm::export::{ExportFolder, ExportReport, ExportSettings, export_mitsuba};
use glowworm::formats::load_scene;
use glowworm::scene::Scene;
use tempfile::TempDir;

/// An export on disk.
pub struct Exported {
    pub folder: TempDir,
    pub report: ExportReport,
    pub text: String,
}

/// Small settings for frame 0.
pub fn settings() -> ExportSettings {
    ExportSettings { frame: 0, time: 0.0, size: [32, 16], bounces: Some(2), spp: 4 }
}

pub fn export(scene: &Scene) -> Exported {
    export_with(scene, &settings())
}

pub fn export_with(scene: &Scene, settings: &ExportSettings) -> Exported {
    let folder = tempfile::tempdir().unwrap();
    let report = export_mitsuba(scene, settings, &ExportFolder::new(folder.path()).unwrap()).unwrap();
    let text = fs::read_to_string(folder.path().join("scene.xml")).unwrap();
    Exported { folder, report, text }
}

/// A scene with every kind of light, material and instance.
pub fn all_kinds() -> Scene {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/scene-files/all-kinds.toml");
    load_scene(file, None).unwrap()
}

/// A scene from the text of a scene file.
pub fn scene(text: &str) -> Scene {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("scene.toml");
    fs::write(&file, text).unwrap();
    load_scene(file.to_str().unwrap(), None).unwrap()
}

impl Exported {
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// The mesh of a shape.
    pub fn mesh(&self, shape: Node<'_, '_>) -> Ply {
        Ply::parse(&fs::read(self.path(value(shape, "filename"))).unwrap())
    }
}

pub type Node<'a, 'input> = roxmltree::Node<'a, 'input>;

/// Elements of this tag, in order, directly below `parent`.
pub fn elements<'a, 'input>(parent: Node<'a, 'input>, tag: &str) -> Vec<Node<'a, 'input>> {
    parent.children().filter(|node| node.has_tag_name(tag)).collect()
}

/// The only element of this tag.
pub fn only<'a, 'input>(parent: Node<'a, 'input>, tag: &str) -> Node<'a, 'input> {
    let found = elements(parent, tag);
    assert_eq!(found.len(), 1, "<{tag}> in {parent:?}");
    found[0]
}

/// The element whose `name` this is.
pub fn named<'a, 'input>(parent: Node<'a, 'input>, name: &str) -> Node<'a, 'input> {
    let mut found = parent.children().filter(|node| node.attribute("name") == Some(name));
    found.next().unwrap_or_else(|| panic!("no {name} in {parent:?}"))
}

/// Its `value`.
pub fn value<'a>(parent: Node<'a, '_>, name: &str) -> &'a str {
    named(parent, name).attribute("value").unwrap()
}

pub fn kind<'a>(node: Node<'a, '_>) -> &'a str {
    node.attribute("type").unwrap()
}

/// The element whose id begins so.
pub fn by_id<'a, 'input>(root: Node<'a, 'input>, start: &str) -> Node<'a, 'input> {
    let starts = |node: &Node<'_, '_>| node.attribute("id").is_some_and(|id| id.starts_with(start));
    root.descendants().find(starts).unwrap_or_else(|| panic!("no element {start}"))
}

pub fn floats(text: &str) -> Vec<f32> {
    text.split(',').map(|number| number.trim().parse().unwrap()).collect()
}

pub fn vector(text: &str) -> Vec3 {
    Vec3::from_slice(&floats(text))
}

/// `x`, `y` and `z` of a point or vector.
pub fn coordinates(node: Node<'_, '_>) -> Vec3 {
    Vec3::from_array(["x", "y", "z"].map(|axis| node.attribute(axis).unwrap().parse().unwrap()))
}

/// `to_world` of a shape or emitter.
pub fn to_world(node: Node<'_, '_>) -> Mat4 {
    match node.children().find(|child| child.has_tag_name("transform")) {
        None => Mat4::IDENTITY,
        Some(transform) => {
            let rows = floats(only(transform, "matrix").attribute("value").unwrap());
            Mat4::from_cols_slice(&rows).transpose()
        }
    }
}

/// A PLY file as read by its header.
#[derive(Debug, Default)]
pub struct Ply {
    pub positions: Vec<Vec3>,
    pub normals: Vec<Vec3>,
    pub uvs: Vec<Vec2>,
    /// Colour, tangent and its side, in the order of the file.
    pub details: Vec<Vec<f32>>,
    pub triangles: Vec<[u32; 3]>,
}

impl Ply {
    pub fn parse(bytes: &[u8]) -> Self {
        let end = b"end_header\n";
        let body = bytes.windows(end.len()).position(|window| window == end).unwrap() + end.len();
        let header = std::str::from_utf8(&bytes[..body]).unwrap();
        assert!(header.starts_with("ply\nformat binary_little_endian 1.0\n"), "{header}");
        let count = |element: &str| -> usize {
            let line = header.lines().find_map(|line| line.strip_prefix(&format!("element {element} ")));
            line.unwrap().parse().unwrap()
        };
        let properties: Vec<_> =
            header.lines().filter_map(|line| line.strip_prefix("property float ")).collect();
        let mut ply = Self::default();
        let mut words = bytes[body..].chunks_exact(4);
        for _ in 0..count("vertex") {
            let mut vertex = std::collections::HashMap::new();
            for property in &properties {
                vertex.insert(*property, f32::from_le_bytes(words.next().unwrap().try_into().unwrap()));
            }
            let known = ["x", "y", "z", "nx", "ny", "nz", "u", "v"];
            let others = properties.iter().filter(|name| !known.contains(name));
            ply.details.push(others.map(|name| vertex[name]).collect());
            let get = |names: [&str; 3]| {
                Some(Vec3::new(*vertex.get(names[0])?, vertex[names[1]], vertex[names[2]]))
            };
            ply.positions.push(get(["x", "y", "z"]).unwrap());
            ply.normals.extend(get(["nx", "ny", "nz"]));
            ply.uvs.extend(vertex.get("u").map(|&u| Vec2::new(u, vertex["v"])));
        }
        assert!(header.contains("property list uchar int vertex_indices\n"));
        let faces = &bytes[body + 4 * properties.len() * count("vertex")..];
        assert_eq!(faces.len(), 13 * count("face"));
        for face in faces.chunks_exact(13) {
            assert_eq!(face[0], 3);
            let index = |at: usize| u32::from_le_bytes(face[at..at + 4].try_into().unwrap());
            let triangle = [index(1), index(5), index(9)];
            assert!(triangle.iter().all(|&vertex| (vertex as usize) < ply.positions.len()));
            ply.triangles.push(triangle);
        }
        ply
    }

    /// Corners of a triangle.
    pub fn corners(&self, triangle: usize) -> [Vec3; 3] {
        self.triangles[triangle].map(|vertex| self.positions[vertex as usize])
    }

    /// Unit normal of the counter-clockwise side.
    pub fn front(&self, triangle: usize) -> Vec3 {
        let [a, b, c] = self.corners(triangle);
        (b - a).cross(c - a).normalize()
    }
}
