//! A recording of a session in the demo: poses and settings by frame.
//!
//! A recording belongs to a scene file, and replays to the same pictures. Each frame stores only the difference to the
//! frame before. Numbers round-trip to the same bits.

use glam::{Affine3A, Vec2, Vec3};
use serde::{Deserialize, Serialize};

use super::{Camera, Light, LightKind, LightType, Pose, Scene};
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
    /// Radius of the sphere that shines.
    #[serde(default)]
    pub radius: f32,
    /// Half angle of the disc that shines, radians.
    #[serde(default)]
    pub half_angle: f32,
}

/// Of the scene's environment.
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
    /// Index into [`Scene::instances`].
    pub index: usize,
    /// Object to world, column-major 3x4.
    pub transform: [f32; 12],
}

impl RecordedFrame {
    /// The difference between the frame before and `now`; everything for the first frame.
    pub fn between(frame: u64, before: Option<&Pose>, now: &Pose) -> Self {
        let was = |index: usize| before.and_then(|pose| pose.instances.get(index));
        let instances = now.instances.iter().enumerate();
        let moved = instances.filter(|(index, transform)| was(*index) != Some(transform));
        let lights: Vec<_> = now.lights.iter().map(recorded_light).collect();
        let lights_before = before.map(|pose| pose.lights.iter().map(recorded_light).collect::<Vec<_>>());
        let environment = recorded_environment(now);
        Self {
            frame,
            scene: None,
            edited: None,
            settings: None,
            camera: (before.map(|pose| pose.camera) != Some(now.camera))
                .then(|| Camera { shift: Vec2::ZERO, ..now.camera }),
            lights: (lights_before.as_ref() != Some(&lights)).then_some(lights),
            environment: environment.filter(|_| before.and_then(recorded_environment) != environment),
            instances: moved
                .map(|(index, transform)| RecordedInstance { index, transform: transform.to_cols_array() })
                .collect(),
        }
    }

    /// Whether there is no difference.
    pub fn is_empty(&self) -> bool {
        *self == Self { frame: self.frame, ..Self::default() }
    }

    /// Updates `pose` from the frame before to this one.
    ///
    /// # Errors
    /// One line, if the recording does not match the scene.
    pub fn apply(&self, pose: &mut Pose, scene: &Scene) -> Result<(), String> {
        if let Some(camera) = self.camera {
            pose.camera = Camera { shift: pose.camera.shift, ..camera };
        }
        if let Some(lights) = &self.lights {
            let mut areas = scene.lights.iter().filter(|light| matches!(light.kind, LightKind::Area { .. }));
            let light =
                |recorded: &RecordedLight| light_of(recorded, || areas.next().map(|area| area.kind.clone()));
            pose.lights = lights.iter().map(light).collect::<Option<_>>().ok_or_else(|| {
                format!("recording: frame {} has more area lights than the scene", self.frame)
            })?;
        }
        if let (Some(recorded), Some(environment)) = (self.environment, &mut pose.environment) {
            (environment.radiance, environment.rotation) = (recorded.radiance, recorded.rotation);
        }
        for moved in &self.instances {
            let count = pose.instances.len();
            let instance = pose.instances.get_mut(moved.index).ok_or_else(|| {
                let (frame, index) = (self.frame, moved.index);
                format!("recording: frame {frame} moves instance {index}, but the scene has {count}")
            })?;
            *instance = Affine3A::from_cols_array(&moved.transform);
        }
        let finite =
            pose.camera.eye.is_finite() && pose.instances.iter().all(|transform| transform.is_finite());
        if finite { Ok(()) } else { Err(format!("recording: frame {} has a non-finite number", self.frame)) }
    }
}

fn recorded_environment(pose: &Pose) -> Option<RecordedEnvironment> {
    let environment = pose.environment.as_ref()?;
    Some(RecordedEnvironment { radiance: environment.radiance, rotation: environment.rotation })
}

fn recorded_light(light: &Light) -> RecordedLight {
    let (kind, power, angles) = match light.kind {
        LightKind::Point { intensity } => (LightType::Point, intensity, [0.0; 2]),
        LightKind::Spot { intensity, inner_angle, outer_angle } => {
            (LightType::Spot, intensity, [inner_angle, outer_angle])
        }
        LightKind::Directional { irradiance } => (LightType::Directional, irradiance, [0.0; 2]),
        LightKind::Area { .. } => (LightType::Area, Vec3::ZERO, [0.0; 2]),
    };
    RecordedLight {
        name: light.name.clone(),
        kind,
        position: light.position,
        direction: light.direction,
        power,
        angles,
        radius: light.radius,
        half_angle: light.half_angle,
    }
}

fn light_of(recorded: &RecordedLight, mut next_area: impl FnMut() -> Option<LightKind>) -> Option<Light> {
    let [inner_angle, outer_angle] = recorded.angles;
    let kind = match recorded.kind {
        LightType::Point => LightKind::Point { intensity: recorded.power },
        LightType::Spot => LightKind::Spot { intensity: recorded.power, inner_angle, outer_angle },
        LightType::Directional => LightKind::Directional { irradiance: recorded.power },
        LightType::Area => next_area()?,
    };
    Some(Light {
        name: recorded.name.clone(),
        kind,
        position: recorded.position,
        direction: recorded.direction,
        radius: recorded.radius,
        half_angle: recorded.half_angle,
        animation: None,
    })
}
