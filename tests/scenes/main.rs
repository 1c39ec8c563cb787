//! The public interface of scenes: models, scene files, animation, radiometry, and errors in files.

// A failed unwrap fails the test, and helpers are not marked as tests.
#![allow(clippy::unwrap_used)]

mod bare_models;
mod broken_gltf;
mod broken_models;
mod broken_runs;
mod broken_scene_files;
#[path = "../support/compressed.rs"]
mod compressed;
mod documents;
mod environments;
mod gltf;
mod gltf_compressed;
mod gltf_files;
mod gltf_pictures;
mod gltf_poses;
mod gltf_structure;
mod lights;
mod made;
mod models;
mod obj;
#[path = "../program/mod.rs"]
mod program;
mod scene_files;
mod untrusted_files;

use std::io::Write;
use std::path::{Path, PathBuf};

use glam::Vec3;
use glowworm::formats::{SceneError, load_scene};
use glowworm::scene::{LightKind, Scene, luminance};

/// A mesh of one triangle whose material library may be missing.
const TRIANGLE: &str =
    "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl a\nf 1/1 2/2 3/3\n";

/// A temporary folder of scene files, removed on drop.
struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn with(self, name: &str, content: impl AsRef<[u8]>) -> Self {
        std::fs::write(self.0.path().join(name), content).unwrap();
        self
    }

    fn path(&self) -> &Path {
        self.0.path()
    }

    fn load(&self, name: &str) -> Result<Scene, SceneError> {
        load_scene(self.path().join(name).to_str().unwrap(), Some(self.path()))
    }
}

/// Loads `name` from a folder that holds `content`; the error must be one line with all of `parts`.
fn expect_error(name: &str, content: impl AsRef<[u8]>, parts: &[&str]) {
    let folder = Folder::new().with(name, content).with("m.obj", TRIANGLE);
    let error = folder.load(name).map(|_| ()).expect_err(&format!("an error about {parts:?}")).to_string();
    assert!(!error.contains('\n') && error.contains(name), "{error}");
    for part in parts {
        assert!(error.contains(part), "\"{error}\" should say \"{part}\"");
    }
}

/// Truncates the file at every byte and changes every byte; a panic fails the test.
fn fuzz(folder: &Folder, name: &str, text: &str) {
    let file = folder.path().join(name);
    let mut loaded = 0;
    let mut attempt = |bytes: &[u8]| {
        std::fs::write(&file, bytes).unwrap();
        match folder.load(name) {
            Ok(scene) => {
                loaded += 1;
                let pose = scene.pose(0.25);
                scene.bounds(&pose);
            }
            Err(error) => assert!(!error.to_string().contains('\n'), "{error}"),
        }
    };
    attempt(text.as_bytes());
    for i in 0..text.len() {
        attempt(&text.as_bytes()[..i]);
        for byte in [0, b'\n', b' ', b'-', b'9', b'/', b'"', b'\\', b'#', b'e', 0xff] {
            let mut changed = text.as_bytes().to_vec();
            changed[i] = byte;
            attempt(&changed);
        }
    }
    assert!(loaded > 0);
}

/// The folder of the downloadable models; reports the test as skipped if there is none.
fn assets() -> Option<PathBuf> {
    let assets = std::env::var_os("GLOWWORM_ASSETS").map(PathBuf::from);
    if assets.is_none() {
        // The test harness captures what the print macros write, but not this.
        let _ = writeln!(
            std::io::stderr(),
            "SKIPPED: GLOWWORM_ASSETS is not set, so the large models cannot be loaded"
        );
        let required = std::env::var("GLOWWORM_REQUIRE_ALL").is_ok_and(|value| value == "1");
        assert!(!required, "GLOWWORM_REQUIRE_ALL=1 and GLOWWORM_ASSETS is not set");
    }
    assets
}

/// Writes `files` into a folder and loads the first of them.
fn load_files(files: &[(&str, &str)]) -> Scene {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in files {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    load_scene(folder.path().join(files[0].0).to_str().unwrap(), Some(folder.path())).unwrap()
}

fn load_toml(text: &str) -> Scene {
    load_files(&[("test.toml", text)])
}

/// The invariants of a scene that the program relies on.
fn check_consistency(scene: &Scene) {
    for mesh in &scene.meshes {
        let vertices = mesh.positions.len();
        assert!(mesh.normals.len() == vertices && mesh.uvs.len() == vertices);
        for count in [mesh.second_uvs.len(), mesh.tangents.len(), mesh.colours.len()] {
            assert!(count == 0 || count == vertices, "{count} of {vertices}");
        }
        assert!(
            mesh.tangents
                .iter()
                .all(|tangent| tangent.w == 0.0 || (tangent.truncate().length() - 1.0).abs() < 1e-3)
        );
        assert_eq!(mesh.triangles.len(), mesh.triangle_materials.len());
        assert!(!mesh.triangles.is_empty());
        assert!(mesh.triangles.iter().flatten().all(|&vertex| (vertex as usize) < vertices));
        assert!(mesh.triangle_materials.is_sorted());
        assert!(mesh.triangle_materials.iter().all(|&m| (m as usize) < scene.materials.len()));
        assert!(mesh.positions.iter().all(|position| position.is_finite()));
        assert!(mesh.uvs.iter().all(|uv| uv.is_finite()));
        assert!(mesh.normals.iter().all(|normal| (normal.length() - 1.0).abs() < 1e-3));
    }
    for material in &scene.materials {
        assert!(material.base_colour.min_element() >= 0.0 && material.base_colour.max_element() <= 1.0);
        assert!(material.textures().all(|texture| texture.texture < scene.textures.len()));
        assert!(material.alpha_mask.is_none_or(|mask| mask < scene.alpha_masks.len()));
    }
    for light in &scene.lights {
        if let LightKind::Area { instance, triangles } = &light.kind {
            let mesh = &scene.meshes[scene.instances[*instance].mesh];
            assert!(triangles.iter().all(|t| (t.triangle as usize) < mesh.triangles.len()));
        }
    }
    assert!(0.0 < scene.camera.near && scene.camera.near < scene.camera.far);
}

fn total_flux(scene: &Scene) -> f32 {
    let pose = scene.pose(0.0);
    let bounds = scene.bounding_sphere(&pose);
    scene.lights.iter().map(|light| luminance(light.flux(scene, &pose, &bounds))).sum()
}
