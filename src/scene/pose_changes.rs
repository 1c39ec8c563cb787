//! Recorded frames as changes of the pose.

use glam::{Affine3A, Vec2, Vec3};

use super::camera::Camera;
use super::contents::{Pose, Scene};
use super::light::{Light, LightKind, LightType, SpotFalloff};
use super::recording::{RecordedEnvironment, RecordedFrame, RecordedInstance, RecordedLight};

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
                .then_some(Camera { shift: Vec2::ZERO, ..now.camera }),
            lights: (lights_before.as_ref() != Some(&lights)).then_some(lights),
            environment: environment.filter(|_| before.and_then(recorded_environment) != environment),
            instances: moved
                .map(|(index, transform)| RecordedInstance { index, transform: transform.to_cols_array() })
                .collect(),
        }
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
    let mut spot_falloff = SpotFalloff::default();
    let (kind, power, angles) = match light.kind {
        LightKind::Point { intensity } => (LightType::Point, intensity, [0.0; 2]),
        LightKind::Spot { intensity, inner_angle, outer_angle, falloff } => {
            spot_falloff = falloff;
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
        falloff: spot_falloff,
        radius: light.radius,
        half_angle: light.half_angle,
    }
}

fn light_of(recorded: &RecordedLight, mut next_area: impl FnMut() -> Option<LightKind>) -> Option<Light> {
    let [inner_angle, outer_angle] = recorded.angles;
    let kind = match recorded.kind {
        LightType::Point => LightKind::Point { intensity: recorded.power },
        LightType::Spot => {
            let falloff = recorded.falloff;
            LightKind::Spot { intensity: recorded.power, inner_angle, outer_angle, falloff }
        }
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
