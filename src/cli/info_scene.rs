//! `glowworm info SCENE`: what a scene consists of, and about how much device memory it takes.

use std::collections::{BTreeMap, BTreeSet};

use serde::Serialize;

use super::options::FileOptions;
use super::scene::{AnimationOption, load};
use super::{CliError, say};
use crate::report::COMMIT;
use crate::scene::{CameraOverride, LightKind, Scene};
use crate::settings::GivenSettings;

/// Bytes on the device of a vertex: position, normal, texture coordinates and tangent.
const VERTEX: usize = 32;
/// Bytes on the device of a triangle: indices for raster and rays, corners in the BVH, and its share of nodes.
const TRIANGLE: usize = 12 + 12 + 48 + 24;
/// Bytes on the device of a vertex's second texture coordinates or colour.
const EXTRA: usize = 8;
/// Bytes on the device of a texel of an environment map: with and without suns, and its share of the distribution.
const ENVIRONMENT_TEXEL: usize = 4 + 4 + 4;

/// The report of `--json`.
#[derive(Debug, Serialize)]
struct SceneReport {
    commit: &'static str,
    scene: String,
    /// Of all instances.
    triangles: usize,
    meshes: usize,
    /// Of all meshes.
    mesh_triangles: usize,
    instances: usize,
    materials: usize,
    /// How many of each kind.
    lights: BTreeMap<&'static str, usize>,
    /// Cameras of the files; 0: it is made up.
    cameras: usize,
    /// What moves.
    animated: Animated,
    /// Animations of a glTF file, one of which is shown.
    animations: Vec<String>,
    /// Frames of the recording.
    recorded_frames: u64,
    /// Extensions of glTF.
    extensions: BTreeSet<String>,
    textures: Textures,
    /// Estimates, bytes.
    device_memory: DeviceMemory,
}

/// How much moves.
#[derive(Debug, Serialize)]
struct Animated {
    instances: usize,
    lights: usize,
    camera: bool,
}

#[derive(Debug, Serialize)]
struct Textures {
    count: usize,
    /// With their mip levels.
    bytes: usize,
}

#[derive(Debug, Serialize)]
struct DeviceMemory {
    geometry: usize,
    textures: usize,
    environment: usize,
}

/// Describes the scene `name`.
pub(super) fn info_scene(
    name: &str,
    animation: &AnimationOption,
    files: &FileOptions,
) -> Result<(), CliError> {
    let json = files.report.check([])?;
    let options = animation.seen_by(CameraOverride::default());
    let loaded = load(name, &GivenSettings::default(), files, &options)?;
    let report = SceneReport::of(&loaded.scene);
    say::print(&report.describe())?;
    json.map_or(Ok(()), |json| Ok(json.save_json(&report)?))
}

impl SceneReport {
    fn of(scene: &Scene) -> Self {
        let mut lights = BTreeMap::new();
        for light in &scene.lights {
            let kind = match light.kind {
                LightKind::Point { .. } => "point",
                LightKind::Spot { .. } => "spot",
                LightKind::Directional { .. } => "directional",
                LightKind::Area { .. } => "area",
            };
            *lights.entry(kind).or_default() += 1;
        }
        if scene.environment.is_some() {
            lights.insert("environment", 1);
        }
        let mesh_triangles = scene.meshes.iter().map(|mesh| mesh.triangles.len()).sum();
        let levels = scene.textures.iter().flat_map(|texture| &texture.levels);
        let bytes = levels.map(|(_, _, texels)| texels.len()).sum();
        let vertices: usize = scene.meshes.iter().map(|mesh| mesh.positions.len()).sum();
        let map = scene.environment.as_ref().and_then(|environment| environment.map.as_ref());
        let texels = map.map_or(0, |map| map.texels().2.len());
        let has = |extra: bool| if extra { EXTRA } else { 0 };
        let vertex = VERTEX
            + has(scene.meshes.iter().any(|mesh| !mesh.second_uvs.is_empty()))
            + has(scene.meshes.iter().any(|mesh| !mesh.colours.is_empty()));
        Self {
            commit: COMMIT,
            scene: scene.name.clone(),
            triangles: scene.triangle_count(),
            meshes: scene.meshes.len(),
            mesh_triangles,
            instances: scene.instances.len(),
            materials: scene.materials.len(),
            lights,
            cameras: scene.files.cameras,
            animated: Animated {
                instances: scene.instances.iter().filter(|instance| instance.animation.is_some()).count(),
                lights: scene.lights.iter().filter(|light| light.animation.is_some()).count(),
                camera: scene.camera_animation.is_some(),
            },
            animations: scene.files.animations.clone(),
            recorded_frames: scene.recording.last().map_or(0, |last| last.frame + 1),
            extensions: scene.files.extensions.clone(),
            textures: Textures { count: scene.textures.len(), bytes },
            device_memory: DeviceMemory {
                geometry: vertices * vertex + mesh_triangles * TRIANGLE,
                textures: bytes,
                environment: texels * ENVIRONMENT_TEXEL,
            },
        }
    }

    fn describe(&self) -> String {
        let Self { textures, device_memory: memory, animated, .. } = self;
        let geometry = [
            counted(self.triangles, "triangle"),
            counted(self.instances, "instance"),
            format!("{} {}", self.meshes, if self.meshes == 1 { "mesh" } else { "meshes" }),
            counted(self.materials, "material"),
        ];
        let lights = self.lights.iter().map(|(kind, count)| format!("{count} {kind}"));
        let cameras =
            if self.cameras == 0 { "none; one is made up".to_owned() } else { self.cameras.to_string() };
        let moving = [
            (animated.instances > 0).then(|| counted(animated.instances, "instance")),
            (animated.lights > 0).then(|| counted(animated.lights, "light")),
            animated.camera.then(|| "the camera".to_owned()),
            (self.recorded_frames > 0).then(|| format!("a recording of {} frames", self.recorded_frames)),
        ];
        let lines = [
            ("scene", self.scene.clone()),
            ("geometry", geometry.join(", ")),
            ("lights", listed(lights)),
            ("cameras", cameras),
            ("animated", listed(moving.into_iter().flatten())),
            ("animations", listed(self.animations.iter().cloned())),
            ("extensions", listed(self.extensions.iter().cloned())),
            ("textures", format!("{}, {}", textures.count, mebibytes(textures.bytes))),
            (
                "device memory",
                format!(
                    "about {}: geometry {}, textures {}, environment {}; more while it is uploaded, and for frames, by --size",
                    mebibytes(memory.geometry + memory.textures + memory.environment),
                    mebibytes(memory.geometry),
                    mebibytes(memory.textures),
                    mebibytes(memory.environment)
                ),
            ),
        ];
        lines.iter().map(|(what, text)| format!("{what:<15}{text}\n")).collect()
    }
}

fn listed(items: impl Iterator<Item = String>) -> String {
    let items: Vec<_> = items.collect();
    if items.is_empty() { "none".to_owned() } else { items.join(", ") }
}

fn counted(count: usize, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}

fn mebibytes(bytes: usize) -> String {
    format!("{:.1} MiB", bytes as f64 / f64::from(1 << 20))
}
