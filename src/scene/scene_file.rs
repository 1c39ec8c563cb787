//! The TOML of a scene file, as it is written.
//!
//! In: text. Out: [`SceneFile`], checked for syntax, unknown keys and types, but not for sense; that is
//! for `scene_build`. Lengths are in scene units, angles in degrees, colours linear RGB.

use std::ops::Range;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use toml::Spanned;

use super::error::SceneError;
use crate::settings::Settings;

/// A whole scene file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SceneFile {
    /// Shown in reports; the file's stem if missing.
    pub name: Option<String>,
    /// Radiance seen where no surface is, W/m^2/sr; black if missing.
    pub background: Option<[f32; 3]>,
    pub camera: Option<Spanned<CameraEntry>>,
    #[serde(default)]
    pub models: Vec<Spanned<ModelEntry>>,
    #[serde(default)]
    pub instances: Vec<Spanned<InstanceEntry>>,
    #[serde(default)]
    pub lights: Vec<Spanned<LightEntry>>,
    /// Deserialised only to check keys and types.
    pub settings: Option<Settings>,
}

/// A mesh: exactly one of `path`, `asset`, `builtin` and `primitive`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ModelEntry {
    pub name: String,
    /// An `.obj`, relative to the scene file.
    pub path: Option<PathBuf>,
    /// An `.obj`, relative to the assets folder.
    pub asset: Option<PathBuf>,
    /// Where people can download the asset.
    pub download: Option<String>,
    /// A model made by code: "cornell-box".
    pub builtin: Option<String>,
    /// A shape about the origin: see [`Primitive`].
    pub primitive: Option<Primitive>,
    /// Of a primitive: edge lengths (box; of a quad x and z are used), radius in x (sphere). 1 if missing.
    pub size: Option<[f32; 3]>,
    /// Of a sphere: how often its icosahedron is split, 0 to 8; 4 if missing.
    pub subdivisions: Option<u32>,
    /// Of a primitive; grey 0.5 if missing.
    pub material: Option<MaterialEntry>,
    /// Materials of an `.obj` whose triangles are left out.
    #[serde(default)]
    pub without_materials: Vec<String>,
    /// The model is cut to this box, in its own space.
    pub clip: Option<ClipEntry>,
}

/// A box.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ClipEntry {
    pub min: [f32; 3],
    pub max: [f32; 3],
}

/// Shapes made by code.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Primitive {
    /// In the plane y = 0, facing up.
    Quad,
    Box,
    Sphere,
}

/// The material of a primitive.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct MaterialEntry {
    pub albedo: Option<[f32; 3]>,
    pub specular: Option<[f32; 3]>,
    pub shininess: Option<f32>,
    /// Radiance, W/m^2/sr.
    pub emission: Option<[f32; 3]>,
}

/// A placed model: scaled, rotated, then translated.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct InstanceEntry {
    pub name: Option<String>,
    pub model: String,
    pub translation: Option<[f32; 3]>,
    pub rotation: Option<RotationEntry>,
    pub scale: Option<ScaleEntry>,
    pub dynamic: Option<bool>,
    pub visible: Option<bool>,
    pub animation: Option<Spanned<AnimationEntry>>,
}

/// `[x, y, z]`, degrees about the fixed axes x, then y, then z; or axis and angle.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(
    untagged,
    expecting = "a rotation must be [x, y, z] in degrees or { axis = [x, y, z], degrees = angle }"
)]
pub(super) enum RotationEntry {
    Euler([f32; 3]),
    AxisAngle(AxisAngle),
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct AxisAngle {
    pub axis: [f32; 3],
    pub degrees: f32,
}

/// One factor, or one for each axis.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(untagged, expecting = "a scale must be a number or [x, y, z]")]
pub(super) enum ScaleEntry {
    Uniform(f32),
    PerAxis([f32; 3]),
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CameraEntry {
    pub eye: [f32; 3],
    pub target: [f32; 3],
    pub up: Option<[f32; 3]>,
    /// Vertical field of view; 45 if missing.
    pub vfov_deg: Option<f32>,
    pub near: Option<f32>,
    pub far: Option<f32>,
    pub animation: Option<Spanned<AnimationEntry>>,
}

/// Kinds of lights.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq)]
#[serde(rename_all = "kebab-case")]
pub(super) enum LightType {
    Point,
    Spot,
    Directional,
    Area,
}

/// A light; which keys it may have depends on its type.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct LightEntry {
    pub name: Option<String>,
    #[serde(rename = "type")]
    pub kind: LightType,
    /// Point and spot.
    pub position: Option<[f32; 3]>,
    /// Spot and directional: the way the light travels.
    pub direction: Option<[f32; 3]>,
    /// Point and spot, W/sr.
    pub intensity: Option<[f32; 3]>,
    /// Directional, W/m^2.
    pub irradiance: Option<[f32; 3]>,
    /// Spot: half angles of the cones, degrees.
    pub inner_deg: Option<f32>,
    pub outer_deg: Option<f32>,
    /// Area: corners of a flat convex quad, counter-clockwise seen from where its light goes.
    pub polygon: Option<[[f32; 3]; 4]>,
    /// Area, instead of a polygon: all triangles of this instance emit.
    pub instance: Option<String>,
    /// Area, W/m^2/sr.
    pub radiance: Option<[f32; 3]>,
    /// Area with a polygon: whether it is drawn and stops rays; true if missing. An invisible one is a
    /// portal: the light of whatever lies behind an opening.
    pub visible: Option<bool>,
    pub animation: Option<Spanned<AnimationEntry>>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct AnimationEntry {
    #[serde(default)]
    pub keyframes: Vec<KeyframeEntry>,
    pub rotation: Option<SpinEntry>,
}

/// Where a thing is at a time, relative to its rest pose.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct KeyframeEntry {
    /// Seconds.
    pub time: f64,
    pub translation: Option<[f32; 3]>,
    pub rotation: Option<RotationEntry>,
}

/// Constant rotation.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SpinEntry {
    pub axis: [f32; 3],
    pub degrees_per_second: f32,
    /// A point on the axis, world space; the thing's own origin if missing.
    pub pivot: Option<[f32; 3]>,
}

impl SceneFile {
    /// Parses the text of `file`.
    pub fn parse(file: &Path, text: &str) -> Result<Self, SceneError> {
        toml::from_str(text).map_err(|error| {
            let line = error.span().map(|span| line_of(text, &span));
            SceneError::invalid(file, line, error.message())
        })
    }
}

/// The line, from 1, on which `span` begins.
pub(super) fn line_of(text: &str, span: &Range<usize>) -> usize {
    let before = text.as_bytes().iter().take(span.start);
    1 + before.filter(|byte| **byte == b'\n').count()
}
