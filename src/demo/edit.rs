//! Edits of the document and the settings, with what they select; default lights.

use std::path::PathBuf;

use glam::Vec3;

use super::action::{EditAction, Entry, NewObject, Selected};
use super::error::DemoError;
use super::selection::label;
use super::session::{Change, Session};
use super::transform::{carry, moved_instance, moved_light};
use super::undo::Press;
use super::view::View;
use crate::formats::{EnvironmentEntry, InstanceEntry, LightEntry, ModelSource, ScaleEntry, SceneError};
use crate::scene::LightType;
use crate::settings::Settings;

/// Warm white.
const WHITE: Vec3 = Vec3::new(1.0, 0.93, 0.82);
/// Edge length or radius of a new shape, radii of the scene.
const SHAPE: f32 = 0.08;

/// Distance between new objects, radii of the scene.
const APART: f32 = 0.1;

impl View {
    /// Executes an edit; all edits of one press are one step that can be taken back.
    ///
    /// # Errors
    /// Nothing has changed, or the device is lost.
    pub fn edit(&mut self, action: EditAction, press: Press) -> Result<Change, DemoError> {
        match action {
            EditAction::Set(settings) => self.set(&settings, Some(press)).map(|()| Change::Live),
            EditAction::Undo => self.take_step(true),
            EditAction::Redo => self.take_step(false),
            EditAction::Handles(mode) => {
                self.handles = mode.unwrap_or(self.handles.next());
                Ok(Change::Live)
            }
            EditAction::Select(selected) => {
                if let Some(session) = &mut self.session {
                    session.selected = selected;
                }
                self.inspector.choose(None);
                Ok(Change::Live)
            }
            EditAction::EditLight(index, entry) => {
                self.step(press, |session| session.set_light(index, *entry))
            }
            EditAction::EditInstance(index, entry) => {
                self.step(press, |session| session.set_instance(index, *entry))
            }
            EditAction::EditMaterial(edit) => {
                self.step(press, |session| session.edit(|document| document.set_material(*edit)))
            }
            EditAction::EditEnvironment(entry) => {
                self.step(press, |session| session.set_environment(entry.map(|entry| *entry)))
            }
            EditAction::OpenMap(path) => {
                self.interface.error = None;
                self.step(press, |session| session.set_map(path))
            }
            EditAction::AddLight(kind) => {
                self.step(press, |session| session.add_light(new_light(session, kind)))
            }
            EditAction::AddObject(object) => self.step(press, |session| session.add_object(object)),
            EditAction::Duplicate => self.step(press, Session::duplicate),
            EditAction::Delete => self.step(press, Session::delete),
            EditAction::ToggleHeadlamp => self.step(press, Session::toggle_headlamp),
        }
    }

    fn step(
        &mut self,
        press: Press,
        edit: impl FnOnce(&mut Session) -> Result<Change, SceneError>,
    ) -> Result<Change, DemoError> {
        let Some(session) = &mut self.session else { return Ok(Change::Live) };
        Ok(session.step(press, edit)?)
    }

    /// Goes to the state before or after the current one; the window keeps its size.
    fn take_step(&mut self, is_back: bool) -> Result<Change, DemoError> {
        let Some(session) = &mut self.session else { return Ok(Change::Live) };
        let now = session.state();
        let Some(state) = session.undo.step(is_back, now) else { return Ok(Change::Live) };
        let settings = Settings { size: session.settings.size, ..state.settings.clone() };
        let change = session.go_to(&state);
        if settings != session.settings {
            self.set(&settings, None)?;
        }
        Ok(change?)
    }
}

/// Edits of the document. One that is invalid is an error and changes nothing.
impl Session {
    /// Changes a light of the document to `entry`.
    fn set_light(&mut self, index: usize, entry: LightEntry) -> Result<Change, SceneError> {
        self.document.light(&entry)?;
        self.replace(entry, |document| document.light_mut(index))
    }

    /// Changes an instance of the document to `entry`.
    fn set_instance(&mut self, index: usize, entry: InstanceEntry) -> Result<Change, SceneError> {
        self.document.placement(&entry)?;
        self.replace(entry, |document| document.instance_mut(index))
    }

    /// Changes the environment, or takes it away.
    fn set_environment(&mut self, environment: Option<EnvironmentEntry>) -> Result<Change, SceneError> {
        self.edit(|document| document.set_environment(environment))
    }

    /// Uses a file as the map of the environment; brightness and rotation stay.
    fn set_map(&mut self, map: PathBuf) -> Result<Change, SceneError> {
        let now = self.document.environment().filter(|now| now.has_map()).cloned().unwrap_or_default();
        let map = EnvironmentEntry { asset: None, download: None, builtin: None, map: Some(map), ..now };
        self.set_environment(Some(map))
    }

    /// Adds a light and selects it.
    fn add_light(&mut self, entry: LightEntry) -> Result<Change, SceneError> {
        self.document.light(&entry)?;
        let change = self.edit(|document| {
            document.add_light(entry);
            Ok(())
        })?;
        self.selected = Some(Selected::Light(self.document.lights().len() - 1));
        Ok(change)
    }

    /// Adds an object in view of the camera and selects it; the file of a model is read when the scene is built.
    fn add_object(&mut self, object: NewObject) -> Result<Change, SceneError> {
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
    fn add_instance(&mut self, entry: InstanceEntry) -> Result<Change, SceneError> {
        self.document.placement(&entry)?;
        let change = self.edit(|document| {
            document.add_instance(entry);
            Ok(())
        })?;
        self.selected = Some(Selected::Instance(self.document.instances().len() - 1));
        Ok(change)
    }

    /// Deletes the selected entry.
    fn delete(&mut self) -> Result<Change, SceneError> {
        match self.selected.take() {
            Some(Selected::Light(index)) => {
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
            Some(Selected::Instance(index)) => self.edit(|document| {
                document.remove_instance(index);
                Ok(())
            }),
            None => Ok(Change::Live),
        }
    }

    /// Duplicates the selected entry.
    fn duplicate(&mut self) -> Result<Change, SceneError> {
        let place = self.selected.and_then(|selected| self.place_of(selected)).unwrap_or_default();
        let way = free_place(self, place) - place;
        match self.selected.and_then(|selected| self.entry(selected)) {
            Some(Entry::Light(_, light)) => {
                let name = light.name.as_ref().map(|name| format!("{name} copy"));
                self.add_light(moved_light(&LightEntry { name, ..light }, way))
            }
            Some(Entry::Instance(_, instance)) => {
                let name = Some(free_name(self, instance.shown_name()));
                self.add_instance(moved_instance(&InstanceEntry { name, ..instance }, way))
            }
            None => Ok(Change::Live),
        }
    }

    /// Attaches the selected light to the camera, or detaches the one that is attached.
    fn toggle_headlamp(&mut self) -> Result<Change, SceneError> {
        if let Some(index) = self.headlamp.take() {
            let Some(light) = self.document.lights().nth(index) else { return Ok(Change::Live) };
            let mut light = light.clone();
            carry(&mut light, &self.pose.camera);
            return self.set_light(index, light);
        }
        if let Some(Selected::Light(index)) = self.selected {
            self.headlamp = Some(index);
        }
        Ok(Change::Live)
    }
}

/// A place before the surface in the middle of the picture.
fn place_in_view(session: &Session) -> Vec3 {
    let camera = &session.pose.camera;
    let distance =
        session.pick(glam::Vec2::splat(0.5)).map_or(0.5 * session.radius, |picked| picked.distance);
    free_place(session, camera.eye + camera.forward() * (0.7 * distance))
}

/// `place`, or one to the right of it where nothing stands yet.
fn free_place(session: &Session, mut place: Vec3) -> Vec3 {
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
fn free_name(session: &Session, name: &str) -> String {
    let instances = || session.document.instances();
    let mut name = name.to_owned();
    while instances().any(|known| *known.name.as_ref().unwrap_or(&known.model) == name) {
        name += " copy";
    }
    name
}

/// A light of this kind in view of the camera, with a power that suits the scene's size.
fn new_light(session: &Session, kind: LightType) -> LightEntry {
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
