//! A recording of a session in the demo: poses and settings by frame.
//!
//! A recording belongs to a scene file, and replays to the same pictures. Each frame stores only the difference to the
//! frame before. Numbers round-trip to the same bits.

use glam::Vec3;
use serde::{Deserialize, Serialize};

use super::camera::Camera;
use super::light::{LightType, SpotFalloff};
use crate::settings::Settings;

/// One frame.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RecordedFrame {
    /// Frame index, from 0.
    pub frame: u64,
    /// The text of the scene file from this frame on, shown by a new renderer.
    pub scene: Option<String>,
    /// The text of the scene file from this frame on, with which the renderer goes on.
    pub edited: Option<String>,
    /// The settings from this frame on.
    pub settings: Option<Settings>,
    /// The camera from this frame on.
    pub camera: Option<Camera>,
    /// All lights from this frame on.
    pub lights: Option<Vec<RecordedLight>>,
    /// Brightness and rotation of the environment from this frame on.
    pub environment: Option<RecordedEnvironment>,
    /// The instances that moved.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub instances: Vec<RecordedInstance>,
}

/// A light. Area lights are those of the scene, in order; they move with their instances.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RecordedLight {
    /// Name, which identifies the light when lights are added or removed.
    pub name: String,
    /// Type of the light.
    #[serde(rename = "type")]
    pub kind: LightType,
    /// World position.
    pub position: Vec3,
    /// Direction of propagation.
    pub direction: Vec3,
    /// Intensity or irradiance.
    pub power: Vec3,
    /// Half angles of a spot's cones, radians.
    pub angles: [f32; 2],
    /// How a spot's intensity falls between them.
    #[serde(default)]
    pub falloff: SpotFalloff,
    /// Radius of the sphere that shines.
    #[serde(default)]
    pub radius: f32,
    /// Half angle of the disc that shines, radians.
    #[serde(default)]
    pub half_angle: f32,
}

/// A change of the scene's environment.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RecordedEnvironment {
    /// Radiance, W/m^2/sr; with a map, its factor.
    pub radiance: Vec3,
    /// Radians about +y.
    pub rotation: f32,
}

/// An instance that moved.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RecordedInstance {
    /// Index into `Scene::instances`.
    pub index: usize,
    /// Object to world, column-major 3x4.
    pub transform: [f32; 12],
}

impl RecordedFrame {
    /// Whether there is no difference.
    pub fn is_empty(&self) -> bool {
        *self == Self { frame: self.frame, ..Self::default() }
    }
}
