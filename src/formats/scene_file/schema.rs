//! The TOML schema of a scene file.
//!
//! In: text. Out: [`SceneFile`], with syntax, keys and types checked; `scene_build` validates the values. Lengths
//! are in scene units, angles in degrees, colours linear RGB.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use toml::Spanned;

use super::entry::line_of;
use super::material_edit::MaterialEdit;
use crate::formats::error::SceneError;
use crate::scene::{LightType, RecordedFrame};
use crate::settings::Settings;

/// Name of the map made by code.
pub(crate) const SKY: &str = "sky";

/// A whole scene file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct SceneFile {
    /// Shown in reports; the file's stem if missing.
    pub name: Option<String>,
    /// Metres per scene unit: how fast the camera flies; unknown if missing.
    pub metres_per_unit: Option<f32>,
    /// Radiance of camera rays that miss, W/m^2/sr; black if missing.
    pub background: Option<[f32; 3]>,
    pub environment: Option<EnvironmentEntry>,
    pub camera: Option<CameraEntry>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub models: Vec<ModelEntry>,
    /// What is other than in the models' files.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub materials: Vec<MaterialEdit>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub instances: Vec<InstanceEntry>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub lights: Vec<LightEntry>,
    /// Recorded edits, by frame.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub recording: Vec<RecordedFrame>,
    /// Deserialised only to check keys and types.
    #[serde(skip_serializing)]
    pub settings: Option<Settings>,
}

/// Light from everywhere around the scene; it is seen, too.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EnvironmentEntry {
    /// Radiance, W/m^2/sr; with a map its factor, 1 if missing.
    pub colour: Option<[f32; 3]>,
    /// Factor of the colour; 1 if missing.
    pub strength: Option<f32>,
    /// An equirectangular `.hdr` or `.exr`, relative to the scene file.
    pub map: Option<PathBuf>,
    /// The same, relative to the assets folder.
    pub asset: Option<PathBuf>,
    /// Download address of the asset.
    pub download: Option<String>,
    /// A map made by code: "sky".
    pub builtin: Option<String>,
    /// Degrees by which the map is turned about +y.
    pub rotation_deg: Option<f32>,
}

impl EnvironmentEntry {
    /// The map made by code.
    pub fn sky() -> Self {
        Self { builtin: Some(SKY.to_owned()), ..Self::default() }
    }

    /// The same radiance from everywhere, W/m^2/sr.
    pub fn constant(colour: [f32; 3]) -> Self {
        Self { colour: Some(colour), ..Self::default() }
    }

    /// Whether it has a map.
    pub fn has_map(&self) -> bool {
        self.map.is_some() || self.asset.is_some() || self.builtin.is_some()
    }

    /// What its map is, without its brightness and rotation.
    pub fn without_numbers(&self) -> Self {
        Self { colour: None, strength: None, rotation_deg: None, ..self.clone() }
    }
}

/// A mesh: exactly one of `path`, `asset`, `builtin` and `primitive`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ModelEntry {
    pub name: String,
    /// An `.obj`, `.gltf` or `.glb`, relative to the scene file.
    pub path: Option<PathBuf>,
    /// The same, relative to the assets folder.
    pub asset: Option<PathBuf>,
    /// Download address of the asset.
    pub download: Option<String>,
    /// A procedural model, such as "cornell-box".
    pub builtin: Option<String>,
    /// A shape about the origin: see [`Primitive`].
    pub primitive: Option<Primitive>,
    /// Of a primitive: edge lengths (box; of a quad x and z are used), radius in x (sphere). 1 if missing.
    pub size: Option<[f32; 3]>,
    /// Of a sphere: subdivisions of its icosahedron, 0 to 8; 4 if missing.
    pub subdivisions: Option<u32>,
    /// Of a primitive; grey 0.5 if missing.
    pub material: Option<MaterialEntry>,
    /// Materials of a file whose triangles are left out.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub without_materials: Vec<String>,
    /// The model is clipped to this box, in object space.
    pub clip: Option<ClipEntry>,
}

/// A box.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ClipEntry {
    pub min: [f32; 3],
    pub max: [f32; 3],
}

/// Procedural shapes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Primitive {
    /// In the plane y = 0, facing up.
    Quad,
    /// A cuboid.
    Box,
    /// A subdivided icosahedron.
    Sphere,
}

impl Primitive {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Box, Self::Sphere, Self::Quad];

    /// Its name, as in scene files.
    pub fn label(self) -> &'static str {
        match self {
            Self::Quad => "quad",
            Self::Box => "box",
            Self::Sphere => "sphere",
        }
    }
}

/// The material of a primitive.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct MaterialEntry {
    /// Base colour, linear.
    pub albedo: Option<[f32; 3]>,
    /// Share of metal.
    pub metallic: Option<f32>,
    /// Given: it reflects as glTF's materials do. Missing: a Lambertian surface.
    pub roughness: Option<f32>,
    /// Radiance, W/m^2/sr.
    pub emission: Option<[f32; 3]>,
}

/// A placed model: scaled, rotated, then translated.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct InstanceEntry {
    /// The model's if missing.
    pub name: Option<String>,
    /// Name of the model.
    pub model: String,
    /// Scene units.
    pub translation: Option<[f32; 3]>,
    /// None if missing.
    pub rotation: Option<RotationEntry>,
    /// 1 if missing.
    pub scale: Option<ScaleEntry>,
    /// Whether it may move; true with an animation.
    pub dynamic: Option<bool>,
    /// Whether it is rasterised and rays can hit it; true if missing.
    pub visible: Option<bool>,
    /// Its animation.
    pub animation: Option<AnimationEntry>,
}

/// `[x, y, z]`, degrees about the fixed axes x, then y, then z; or axis and angle.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(
    untagged,
    expecting = "a rotation must be [x, y, z] in degrees or { axis = [x, y, z], degrees = angle }"
)]
pub enum RotationEntry {
    /// About the fixed axes.
    Euler([f32; 3]),
    /// About any axis.
    AxisAngle(AxisAngle),
}

/// A rotation about an axis.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AxisAngle {
    /// Of any length but zero.
    pub axis: [f32; 3],
    /// Counter-clockwise about the axis.
    pub degrees: f32,
}

/// One factor, or one for each axis.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged, expecting = "a scale must be a number or [x, y, z]")]
pub enum ScaleEntry {
    /// The same along all axes.
    Uniform(f32),
    /// Along x, y and z.
    PerAxis([f32; 3]),
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct CameraEntry {
    pub eye: [f32; 3],
    pub target: [f32; 3],
    pub up: Option<[f32; 3]>,
    /// Vertical field of view; 45 if missing.
    pub vfov_deg: Option<f32>,
    pub near: Option<f32>,
    pub far: Option<f32>,
    pub animation: Option<AnimationEntry>,
}

/// A light; its type determines the allowed keys.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LightEntry {
    /// Generated if missing.
    pub name: Option<String>,
    /// Type of the light.
    #[serde(rename = "type")]
    pub kind: LightType,
    /// Point and spot.
    pub position: Option<[f32; 3]>,
    /// Spot and directional: direction of propagation.
    pub direction: Option<[f32; 3]>,
    /// Point and spot, W/sr.
    pub intensity: Option<[f32; 3]>,
    /// Directional, W/m^2.
    pub irradiance: Option<[f32; 3]>,
    /// Spot: half angle of the inner cone, degrees.
    pub inner_deg: Option<f32>,
    /// Spot: half angle of the outer cone, degrees; no light beyond.
    pub outer_deg: Option<f32>,
    /// Point and spot: radius of the sphere that shines, scene units; 0 if missing.
    pub radius: Option<f32>,
    /// Directional: half angle of the disc that shines, degrees; 0 if missing.
    pub angle_deg: Option<f32>,
    /// Area: corners of a flat convex quad, counter-clockwise seen from the emitting side.
    pub polygon: Option<[[f32; 3]; 4]>,
    /// Area, instead of a polygon: all triangles of this instance emit.
    pub instance: Option<String>,
    /// Area, W/m^2/sr.
    pub radiance: Option<[f32; 3]>,
    /// Area with a polygon: whether it is rasterised and rays can hit it; true if missing. An invisible one is a
    /// portal: light that enters through an opening.
    pub visible: Option<bool>,
    /// Its animation.
    pub animation: Option<AnimationEntry>,
}

/// An animation, relative to the rest pose.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AnimationEntry {
    /// In ascending order of time.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub keyframes: Vec<KeyframeEntry>,
    /// Whether the keyframes repeat after the last one.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub repeat: bool,
    /// An additional constant rotation.
    pub rotation: Option<SpinEntry>,
}

/// A keyframe, relative to the rest pose.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct KeyframeEntry {
    /// Seconds.
    pub time: f64,
    /// Added to the rest position.
    pub translation: Option<[f32; 3]>,
    /// About the object's own origin.
    pub rotation: Option<RotationEntry>,
}

/// Constant rotation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SpinEntry {
    /// Of any length but zero.
    pub axis: [f32; 3],
    /// Angular speed, degrees a second.
    pub degrees_per_second: f32,
    /// A point on the axis, world space; the object's own origin if missing.
    pub pivot: Option<[f32; 3]>,
}

impl InstanceEntry {
    /// A model at rest at the origin.
    pub fn of(model: String) -> Self {
        Self { model, ..Self::default() }
    }

    /// Its name, or the model's.
    pub fn shown_name(&self) -> &str {
        self.name.as_ref().unwrap_or(&self.model)
    }
}

impl LightEntry {
    /// An entry of this type without any other key.
    pub fn of(kind: LightType) -> Self {
        Self { kind, ..Self::default() }
    }
}

impl SceneFile {
    /// Parses the text of `file`.
    pub fn parse(file: &Path, text: &str) -> Result<Self, SceneError> {
        toml::from_str(text).map_err(|error| {
            // The type determines the allowed keys, so report an unknown type before unknown keys.
            unknown_light_type(file, text).unwrap_or_else(|| {
                let line = error.span().map(|span| line_of(text, &span));
                SceneError::invalid(file, line, error.message())
            })
        })
    }
}

/// The error for the first light of unknown type; none if all types are known or the text is not TOML.
fn unknown_light_type(file: &Path, text: &str) -> Option<SceneError> {
    #[derive(Deserialize)]
    struct Types {
        lights: Vec<TypeOnly>,
    }
    #[derive(Deserialize)]
    struct TypeOnly {
        name: Option<String>,
        #[serde(rename = "type")]
        kind: Option<Spanned<String>>,
    }
    let lights = toml::from_str::<Types>(text).ok()?.lights;
    lights.into_iter().enumerate().find_map(|(index, light)| {
        let kind = light.kind?;
        let error = LightType::deserialize(toml::Value::String(kind.get_ref().clone())).err()?;
        let name = light.name.unwrap_or_else(|| format!("light {}", index + 1));
        let problem =
            format!("light \"{name}\": {}", error.message().replace("unknown variant", "unknown type"));
        Some(SceneError::invalid(file, Some(line_of(text, &kind.span())), problem))
    })
}
