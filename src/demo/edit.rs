//! Edits of the current scene; default lights and simple animations.

use std::path::PathBuf;

use glam::Vec3;
use serde::Serialize;

use super::session::{Change, Selected, Session, label};
use crate::formats::{
    AnimationEntry, AxisAngle, EnvironmentEntry, InstanceEntry, KeyframeEntry, LightEntry, MaterialEdit,
    ModelSource, Primitive, RotationEntry, ScaleEntry, SceneError, SpinEntry,
};
use crate::scene::LightType;

/// Warm white.
const WHITE: Vec3 = Vec3::new(1.0, 0.93, 0.82);
/// Corners of a path.
const CORNERS: u32 = 8;
/// Edge length or radius of a new shape, radii of the scene.
const SHAPE: f32 = 0.08;

/// How far apart new things stand, radii of the scene.
const APART: f32 = 0.1;

/// An object to add.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum NewObject {
    /// Another instance of this model.
    Model(String),
    /// A shape with a material of its own.
    Shape(Primitive),
    /// A model's file.
    File(PathBuf),
}

/// Edits of the document. One that is invalid is an error and changes nothing.
impl Session {
    /// Changes a light of the document to `entry`.
    pub fn set_light(&mut self, index: usize, entry: LightEntry) -> Result<Change, SceneError> {
        self.document.light(&entry)?;
        self.edit(|document| {
            if let Some(light) = document.light_mut(index) {
                *light = entry;
            }
            Ok(())
        })
    }

    /// Changes an instance of the document to `entry`.
    pub fn set_instance(&mut self, index: usize, entry: InstanceEntry) -> Result<Change, SceneError> {
        self.document.placement(&entry)?;
        self.edit(|document| {
            if let Some(instance) = document.instance_mut(index) {
                *instance = entry;
            }
            Ok(())
        })
    }

    /// Changes the materials of a name.
    pub fn set_material(&mut self, edit: MaterialEdit) -> Result<Change, SceneError> {
        self.edit(|document| document.set_material(edit))
    }

    /// Changes the environment, or takes it away.
    pub fn set_environment(&mut self, environment: Option<EnvironmentEntry>) -> Result<Change, SceneError> {
        self.edit(|document| document.set_environment(environment))
    }

    /// Uses a file as the map of the environment; brightness and rotation stay.
    pub fn set_map(&mut self, map: PathBuf) -> Result<Change, SceneError> {
        let now = self.document.environment().filter(|now| now.has_map()).cloned().unwrap_or_default();
        let map = EnvironmentEntry { asset: None, download: None, builtin: None, map: Some(map), ..now };
        self.set_environment(Some(map))
    }

    /// Adds a light and selects it.
    pub fn add_light(&mut self, entry: LightEntry) -> Result<Change, SceneError> {
        self.document.light(&entry)?;
        let change = self.edit(|document| {
            document.add_light(entry);
            Ok(())
        })?;
        self.selected = Some(Selected::Light(self.document.lights().len() - 1));
        Ok(change)
    }

    /// Removes a light.
    pub fn remove_light(&mut self, index: usize) -> Result<Change, SceneError> {
        self.selected = None;
        self.headlamp = match self.headlamp {
            Some(light) if light == index => None,
            Some(light) if light > index => Some(light - 1),
            light => light,
        };
        self.edit(|document| {
            document.remove_light(index);
            Ok(())
        })
    }

    /// Adds an object in view of the camera and selects it; the file of a model is read when the scene is built.
    pub fn add_object(&mut self, object: NewObject) -> Result<Change, SceneError> {
        let place = Some(place_in_view(self).to_array());
        let size = SHAPE * self.radius;
        let before = self.document.clone();
        let (model, scale) = match object {
            NewObject::Model(name) => {
                let known = self.document.instances().find(|instance| instance.model == name);
                let scale = known.and_then(|instance| instance.scale);
                (name, scale)
            }
            NewObject::Shape(shape) => {
                let model = self.document.add_model(ModelSource::Shape(shape));
                (model, Some(ScaleEntry::Uniform(size)))
            }
            NewObject::File(path) => (self.document.add_model(ModelSource::File(path)), None),
        };
        let name = Some(free_name(self, &model));
        let entry = InstanceEntry { name, translation: place, scale, ..InstanceEntry::of(model) };
        let change = self.add_instance(entry);
        if change.is_err() {
            self.document = before;
        }
        change
    }

    /// Adds an instance and selects it.
    pub fn add_instance(&mut self, entry: InstanceEntry) -> Result<Change, SceneError> {
        self.document.placement(&entry)?;
        let change = self.edit(|document| {
            document.add_instance(entry);
            Ok(())
        })?;
        self.selected = Some(Selected::Instance(self.document.instances().len() - 1));
        Ok(change)
    }

    /// Removes an instance.
    pub fn remove_instance(&mut self, index: usize) -> Result<Change, SceneError> {
        self.selected = None;
        self.edit(|document| {
            document.remove_instance(index);
            Ok(())
        })
    }
}

/// A place before what is in the middle of the picture.
fn place_in_view(session: &Session) -> Vec3 {
    let camera = &session.pose.camera;
    let distance =
        session.pick(glam::Vec2::splat(0.5)).map_or(0.5 * session.radius, |picked| picked.distance);
    free_place(session, camera.eye + camera.forward() * (0.7 * distance))
}

/// `place`, or one to the right of it where nothing stands yet.
pub(super) fn free_place(session: &Session, mut place: Vec3) -> Vec3 {
    let lights = (0..session.document.lights().len()).map(Selected::Light);
    let all = lights.chain((0..session.document.instances().len()).map(Selected::Instance));
    let taken: Vec<Vec3> = all.filter_map(|known| session.place_of(known)).collect();
    let camera = &session.pose.camera;
    let step = camera.forward().cross(camera.up).normalize_or(Vec3::X) * (APART * session.radius);
    while taken.iter().any(|known| known.distance(place) < 0.5 * APART * session.radius) {
        place += step;
    }
    place
}

/// `name`, with as many times " copy" as make it a name that no instance has.
pub(super) fn free_name(session: &Session, name: &str) -> String {
    let instances = || session.document.instances();
    let mut name = name.to_owned();
    while instances().any(|known| *known.name.as_ref().unwrap_or(&known.model) == name) {
        name += " copy";
    }
    name
}

/// A light of this kind in view of the camera, with a power that suits the scene's size.
pub(super) fn new_light(session: &Session, kind: LightType) -> LightEntry {
    let camera = &session.pose.camera;
    let place = place_in_view(session);
    // An irradiance of pi at a third of the scene's radius.
    let away = 0.33 * session.radius;
    let intensity = WHITE * (std::f32::consts::PI * away * away);
    let name = (1..)
        .map(|number| format!("{} {number}", label(kind)))
        .find(|name| session.document.lights().all(|light| light.name.as_ref() != Some(name)));
    let entry = LightEntry { name, ..LightEntry::of(kind) };
    match kind {
        LightType::Point => {
            LightEntry { position: Some(place.to_array()), intensity: Some(intensity.to_array()), ..entry }
        }
        LightType::Spot => LightEntry {
            position: Some(place.to_array()),
            direction: Some(camera.forward().to_array()),
            intensity: Some((intensity * 4.0).to_array()),
            outer_deg: Some(30.0),
            ..entry
        },
        LightType::Directional => LightEntry {
            direction: Some(Vec3::new(0.3, -1.0, 0.2).normalize().to_array()),
            irradiance: Some((WHITE * std::f32::consts::PI).to_array()),
            ..entry
        },
        LightType::Area => {
            let half = 0.06 * session.radius;
            let corner = |x: f32, z: f32| (place + Vec3::new(x * half, 0.0, z * half)).to_array();
            let radiance = intensity / (4.0 * half * half);
            LightEntry {
                polygon: Some([corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)]),
                radiance: Some(radiance.to_array()),
                ..entry
            }
        }
    }
}

/// An animation that the panel offers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Motion {
    /// None.
    Still,
    /// Rotation about the vertical axis, degrees per second.
    Spin(f32),
    /// Oscillation about the z axis: amplitude in degrees, period in seconds.
    Sway(f32, f32),
    /// Horizontal circle: radius in scene units, period in seconds.
    Path(f32, f32),
    /// Keyframes of the scene file.
    Keys,
}

impl Motion {
    /// The motion of an animation.
    pub fn of(animation: Option<&AnimationEntry>) -> Self {
        let Some(animation) = animation else { return Self::Still };
        let candidates = [
            animation.rotation.as_ref().map(|spin| Self::Spin(spin.degrees_per_second)),
            animation.keyframes.last().and_then(|last| {
                let quarter = animation.keyframes.get(1)?;
                let degrees = match quarter.rotation? {
                    RotationEntry::AxisAngle(turn) => turn.degrees,
                    RotationEntry::Euler(_) => return None,
                };
                Some(Self::Sway(degrees, last.time as f32))
            }),
            animation.keyframes.last().and_then(|last| {
                let across = animation.keyframes.get(CORNERS as usize / 2)?.translation?;
                Some(Self::Path(0.5 * Vec3::from_array(across).length(), last.time as f32))
            }),
        ];
        let is_it = |motion: &Self| motion.animation().as_ref() == Some(animation);
        candidates.into_iter().flatten().find(is_it).unwrap_or(Self::Keys)
    }

    /// The animation entry; none for [`Self::Still`].
    pub fn animation(self) -> Option<AnimationEntry> {
        match self {
            Self::Still | Self::Keys => None,
            Self::Spin(degrees_per_second) => Some(AnimationEntry {
                rotation: Some(SpinEntry { axis: [0.0, 1.0, 0.0], degrees_per_second, pivot: None }),
                ..AnimationEntry::default()
            }),
            Self::Sway(degrees, period) => {
                let key = |quarter: u32| {
                    let share = [0.0, 1.0, 0.0, -1.0, 0.0][quarter as usize];
                    let turn = AxisAngle { axis: [0.0, 0.0, 1.0], degrees: share * degrees };
                    KeyframeEntry {
                        time: f64::from(period) * f64::from(quarter) / 4.0,
                        translation: None,
                        rotation: Some(RotationEntry::AxisAngle(turn)),
                    }
                };
                Some(AnimationEntry { keyframes: (0..5).map(key).collect(), repeat: true, rotation: None })
            }
            Self::Path(radius, period) => {
                let key = |corner: u32| {
                    // The first and last keyframes are bitwise equal.
                    let angle = (corner % CORNERS) as f32 / CORNERS as f32 * std::f32::consts::TAU;
                    KeyframeEntry {
                        time: f64::from(period) * f64::from(corner) / f64::from(CORNERS),
                        translation: Some([radius * (1.0 - angle.cos()), 0.0, radius * angle.sin()]),
                        rotation: None,
                    }
                };
                let keyframes = (0..=CORNERS).map(key).collect();
                Some(AnimationEntry { keyframes, repeat: true, rotation: None })
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn motions_are_known_again() {
        for motion in [Motion::Still, Motion::Spin(45.0), Motion::Sway(20.0, 3.0), Motion::Path(0.5, 6.0)] {
            let animation = motion.animation();
            let known = Motion::of(animation.as_ref());
            match (motion, known) {
                (Motion::Path(a, b), Motion::Path(c, d)) => {
                    assert!((a - c).abs() < 1e-5 && (b - d).abs() < 1e-5);
                }
                _ => assert_eq!(known, motion),
            }
        }
    }
}
