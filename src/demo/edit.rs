//! Edits of the current scene; default lights.

use std::path::PathBuf;

use glam::Vec3;
use serde::Serialize;

use super::action::Action;
use super::session::{Change, Selected, Session, label};
use crate::formats::{
    AnimationEntry, EnvironmentEntry, InstanceEntry, LightEntry, MaterialEdit, ModelSource, Primitive,
    ScaleEntry, SceneError,
};
use crate::scene::LightType;

/// Warm white.
const WHITE: Vec3 = Vec3::new(1.0, 0.93, 0.82);
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

/// An instance or a light of the document.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Entry {
    Instance(usize, InstanceEntry),
    Light(usize, LightEntry),
}

impl Entry {
    pub fn animation(&mut self) -> &mut Option<AnimationEntry> {
        match self {
            Self::Instance(_, entry) => &mut entry.animation,
            Self::Light(_, entry) => &mut entry.animation,
        }
    }

    /// The edit that changes the document to it.
    pub fn edit(self) -> Action {
        match self {
            Self::Instance(index, entry) => Action::EditInstance(index, Box::new(entry)),
            Self::Light(index, entry) => Action::EditLight(index, Box::new(entry)),
        }
    }
}

/// Edits of the document. One that is invalid is an error and changes nothing.
impl Session {
    /// An entry as it is.
    pub fn entry(&self, of: Selected) -> Option<Entry> {
        Some(match of {
            Selected::Instance(index) => {
                Entry::Instance(index, self.document.instances().nth(index)?.clone())
            }
            Selected::Light(index) => Entry::Light(index, self.document.lights().nth(index)?.clone()),
        })
    }

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
