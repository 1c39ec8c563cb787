//! The current scene: document, renderer, and the edits applied without a rebuild.

use std::path::PathBuf;
use std::sync::Arc;

use glam::{Mat4, Vec2, Vec3};

use super::action::Selected;
use super::error::DemoError;
use super::live_metrics::Shot;
use super::loader::{Built, Edited};
use super::transform::carry;
use super::undo::{Press, State, Undo};
use crate::bvh::Ray;
use crate::formats::{ReadFiles, SceneDocument, SceneError};
use crate::renderer::{DebugView, Picked, RenderError, Renderer, camera_ray};
use crate::report::FrameReport;
use crate::scene::{Camera, LightKind, LightType, Pose, Scene};
use crate::settings::Settings;

/// The current scene.
pub(super) struct Session {
    /// Name or file it was loaded by.
    pub name: String,
    pub settings: Settings,
    pub renderer: Renderer,
    /// The document with all edits.
    pub document: SceneDocument,
    /// The document that `scene` was built from.
    built_document: SceneDocument,
    /// The files that were read for it.
    pub read: ReadFiles,
    /// The scene of the renderer.
    pub scene: Arc<Scene>,
    /// The scene with the edits that need no rebuild.
    pub live_scene: Scene,
    /// Radius of the scene's bounding sphere.
    pub radius: f32,
    pub selected: Option<Selected>,
    /// The light attached to the camera.
    pub headlamp: Option<usize>,
    /// Counts edits, and those that the last saved file has.
    pub edits: u64,
    pub saved_edits: u64,
    pub undo: Undo,
    /// The file that holds what is shown.
    pub saved: Option<Saved>,
    /// The pose of the last frame.
    pub pose: Pose,
    /// Report of the last finished frame.
    pub report: FrameReport,
}

/// A file that holds the scene.
pub(super) struct Saved {
    pub path: PathBuf,
    pub camera: Camera,
}

/// State of a session that outlives its device, besides the document and the settings.
pub(super) struct SessionState {
    pub view: DebugView,
    selected: Option<Selected>,
    headlamp: Option<usize>,
    edits: u64,
    saved_edits: u64,
    undo: Undo,
    saved: Option<Saved>,
}

/// The way in which an edit takes effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Change {
    /// The renderer goes on.
    Live,
    /// The renderer must be rebuilt.
    Rebuild,
}

impl Session {
    /// None if the built scene has no renderer of its own.
    pub fn new(built: Built) -> Option<Self> {
        let Built { name, document, scene, read, settings, renderer, .. } = built;
        let renderer = renderer?;
        let live_scene = Scene::clone(&scene);
        let pose = live_scene.pose(0.0);
        let (low, high) = renderer.bounds();
        Some(Self {
            name,
            settings,
            renderer,
            built_document: document.clone(),
            document,
            read,
            scene,
            live_scene,
            radius: 0.5 * low.distance(high),
            selected: None,
            headlamp: None,
            edits: 0,
            saved_edits: 0,
            undo: Undo::default(),
            saved: None,
            pose,
            report: FrameReport::default(),
        })
    }

    /// Takes the edited scene, perhaps with a renderer of its own; keeps later edits.
    pub fn renew(&mut self, built: Built) -> Result<Change, DemoError> {
        let Built { document, scene, read, settings, renderer, .. } = built;
        let pose = scene.pose(0.0);
        match renderer {
            Some(renderer) => (self.renderer, self.settings) = (renderer, settings),
            None => self.renderer.set_scene(&scene, &pose)?,
        }
        (self.built_document, self.scene, self.read, self.pose) = (document, scene, read, pose);
        self.live_scene = Scene::clone(&self.scene);
        Ok(self.apply()?)
    }

    /// The state that outlives the device.
    pub fn into_state(self) -> SessionState {
        let Self { renderer, selected, headlamp, edits, saved_edits, undo, saved, .. } = self;
        SessionState { view: renderer.view().clone(), selected, headlamp, edits, saved_edits, undo, saved }
    }

    /// Goes on as before the device was lost.
    pub fn restore(&mut self, state: SessionState) -> Result<(), RenderError> {
        self.renderer.set_view(&state.view)?;
        (self.selected, self.headlamp, self.undo) = (state.selected, state.headlamp, state.undo);
        (self.edits, self.saved_edits, self.saved) = (state.edits, state.saved_edits, state.saved);
        Ok(())
    }

    /// The current state, which can be taken back.
    pub fn state(&self) -> State {
        State {
            document: self.document.clone(),
            settings: self.settings.clone(),
            headlamp: self.headlamp,
            selected: self.selected,
        }
    }

    /// Makes a change that can be taken back. The state before it is stored once for all changes of a press, so that a drag clones and
    /// compares the document in its first frame alone; a change of the window's size is no step.
    pub fn step<T, E>(
        &mut self,
        press: Press,
        change: impl FnOnce(&mut Self) -> Result<T, E>,
    ) -> Result<T, E> {
        let begins = self.undo.begins_step(press);
        let before = begins.then(|| self.state());
        let changed = change(self)?;
        if before.as_ref().is_none_or(|before| !self.is_in(before)) {
            self.undo.remember(before, press);
        }
        Ok(changed)
    }

    fn is_in(&self, state: &State) -> bool {
        let settings = Settings { size: self.settings.size, ..state.settings.clone() };
        (self.headlamp, self.selected) == (state.headlamp, state.selected)
            && self.settings == settings
            && self.document == state.document
    }

    /// Changes the settings; where that cannot be, nothing changes.
    pub fn set_settings(&mut self, settings: &Settings) -> Result<(), DemoError> {
        settings.check().map_err(|error| DemoError::Settings { scene: self.name.clone(), error })?;
        self.renderer.set_settings(settings, &self.pose)?;
        self.settings.clone_from(settings);
        Ok(())
    }

    /// Whether there are unsaved edits.
    pub fn is_edited(&self) -> bool {
        self.edits != self.saved_edits
    }

    /// Goes to a state that was before or after the current one, but for its settings.
    pub fn go_to(&mut self, state: &State) -> Result<Change, SceneError> {
        self.document = state.document.clone();
        self.headlamp = state.headlamp;
        self.selected = state.selected.or(self.selected).filter(|selected| match *selected {
            Selected::Light(index) => index < self.document.lights().len(),
            Selected::Instance(index) => index < self.document.instances().len(),
        });
        self.edits += 1;
        self.apply()
    }

    /// Prepares the build of the document as it is. With `anew` it is the whole of it with a renderer of its own; else, where that is
    /// enough, only with other materials and environment, so that the renderer goes on with the rest in the pose.
    pub fn to_build(&self, anew: bool) -> Edited {
        let document = if !anew && is_arranged_alike(&self.built_document, &self.document) {
            self.built_document.with_appearance_of(&self.document)
        } else {
            self.document.clone()
        };
        Edited {
            document,
            read: self.read.clone(),
            settings: self.settings.clone(),
            #[cfg(feature = "shader-reload")]
            compiles_shaders: false,
            current: (!anew).then(|| Arc::clone(&self.scene)),
        }
    }

    /// Takes back the edits that could not be built.
    pub fn revert(&mut self) -> Result<(), SceneError> {
        if self.apply()? == Change::Rebuild {
            self.document = self.document.with_appearance_of(&self.built_document);
        }
        if self.apply()? == Change::Rebuild {
            self.document = self.built_document.clone();
            self.apply()?;
        }
        Ok(())
    }

    /// The document that the renderer was built from, with its settings.
    pub fn document_of_renderer(&self) -> SceneDocument {
        let mut document = self.built_document.clone();
        document.set_settings(self.settings.differing());
        document
    }

    /// Poses the world at animation time `time`, seen by `camera`.
    pub fn go_to_time(&mut self, time: f64, camera: Camera) {
        self.pose = Pose { camera, ..self.live_scene.pose(time) };
        let headlamp = self.headlamp.and_then(|index| self.document.scene_light(index));
        if let Some(light) = headlamp.and_then(|index| self.pose.lights.get_mut(index)) {
            light.position = camera.eye;
            light.direction = camera.forward();
        }
    }

    /// Renders the next frame; `pace` is that of automatic exposure.
    pub fn render(&mut self, pace: f32) -> Result<(), RenderError> {
        self.renderer.set_exposure_pace(pace);
        self.renderer.render(&self.pose)?;
        if let Some(report) = self.renderer.take_reports().pop() {
            self.report = report;
        }
        Ok(())
    }

    /// The picture of the last frame.
    pub fn shot(&self) -> Result<Shot, RenderError> {
        Ok(Shot { size: self.settings.size, pixels: self.renderer.read_display()? })
    }

    /// Replaces an entry of the document; where that cannot be, nothing changes.
    pub fn replace<T>(
        &mut self,
        entry: T,
        find: impl Fn(&mut SceneDocument) -> Option<&mut T>,
    ) -> Result<Change, SceneError> {
        let Some(place) = find(&mut self.document) else { return Ok(Change::Live) };
        let before = std::mem::replace(place, entry);
        let change = self.apply();
        match (&change, find(&mut self.document)) {
            (Err(_), Some(place)) => *place = before,
            _ => self.edits += 1,
        }
        change
    }

    /// Changes the document; where that cannot be, nothing changes.
    pub fn edit(
        &mut self,
        edit: impl FnOnce(&mut SceneDocument) -> Result<(), SceneError>,
    ) -> Result<Change, SceneError> {
        let before = self.document.clone();
        let change = edit(&mut self.document).and_then(|()| self.apply());
        match change {
            Ok(_) => self.edits += 1,
            Err(_) => self.document = before,
        }
        change
    }

    /// Applies the document to the rest pose, if that needs no rebuild.
    fn apply(&mut self) -> Result<Change, SceneError> {
        let (made, now) = (&self.built_document, &self.document);
        if !is_arranged_alike(made, now) || !made.has_appearance_of(now) {
            return Ok(Change::Rebuild);
        }
        let mut live = Scene::clone(&self.scene);
        let areas = live.lights.iter().filter(|light| matches!(light.kind, LightKind::Area { .. }));
        let mut areas: std::collections::VecDeque<_> = areas.cloned().collect();
        live.lights.clear();
        for (index, entry) in self.document.lights().enumerate() {
            match self.document.light(entry)? {
                Some(light) => live.lights.push(light),
                None if self.document.scene_light(index).is_some() => live.lights.extend(areas.pop_front()),
                None => {}
            }
        }
        // Lights without an entry: instances with emissive materials.
        live.lights.extend(areas);
        for (instance, entry) in live.instances.iter_mut().zip(self.document.instances()) {
            let placement = self.document.placement(entry)?;
            (instance.transform, instance.animation) = (placement.transform, placement.animation);
        }
        let made = self.built_document.lights().filter_map(|light| light.polygon);
        let polygons = self.document.lights().enumerate().filter(|(_, light)| light.polygon.is_some());
        for ((index, light), made) in polygons.zip(made) {
            let placement = self.document.polygon_placement(light, made)?;
            let instance = self.document.light_instance(index).and_then(|i| live.instances.get_mut(i));
            if let Some(instance) = instance {
                (instance.transform, instance.animation) = (placement.transform, placement.animation);
            }
        }
        if let (Some(environment), Some(entry)) = (&mut live.environment, self.document.environment()) {
            (environment.radiance, environment.rotation) = self.document.environment_numbers(entry)?;
        }
        self.live_scene = live;
        Ok(Change::Live)
    }

    /// The document to save: with `camera`, and the headlamp at its current position.
    pub fn document_to_save(&self, camera: Option<&Camera>) -> SceneDocument {
        let mut document = self.document.clone();
        if let Some(camera) = camera {
            document.set_camera(camera);
        }
        if let Some(light) = self.headlamp.and_then(|index| document.light_mut(index)) {
            carry(light, &self.pose.camera);
        }
        document.set_settings(self.settings.differing());
        document
    }

    /// Whether the camera is outside of everything, where that of the scene is inside.
    pub fn camera_is_outside(&self) -> bool {
        let (low, high) = self.renderer.bounds();
        let is_inside = |eye: Vec3| eye.cmpge(low).all() && eye.cmple(high).all();
        is_inside(self.scene.camera.eye) && !is_inside(self.pose.camera.eye)
    }

    /// World to clip space of the last frame.
    pub fn view_projection(&self) -> Mat4 {
        let camera = &self.pose.camera;
        let aspect = self.settings.size[0] as f32 / self.settings.size[1] as f32;
        camera.projection_matrix(aspect) * camera.view_matrix()
    }

    /// The visible surface at a position of the picture, from (0, 0) at the top left to (1, 1).
    pub fn pick(&self, at: Vec2) -> Option<Picked> {
        self.renderer.pick(&self.pose, at * self.extent())
    }

    /// The camera ray through a position of the picture.
    pub fn ray(&self, at: Vec2) -> Ray {
        camera_ray(&self.pose.camera, self.settings.size, at * self.extent())
    }

    fn extent(&self) -> Vec2 {
        Vec2::from_array(self.settings.size.map(|side| side as f32))
    }
}

/// Whether lights and instances of two documents differ only in what the pose holds, so that no rebuild is needed.
fn is_arranged_alike(made: &SceneDocument, now: &SceneDocument) -> bool {
    let areas = |document: &SceneDocument| -> Vec<_> {
        let areas = document.lights().filter(|light| light.kind == LightType::Area);
        areas
            .map(|light| (light.polygon.is_some(), light.instance.clone(), light.radiance, light.visible))
            .collect()
    };
    let instances = |document: &SceneDocument| -> Vec<_> {
        document.instances().map(|instance| (instance.model.clone(), instance.visible)).collect()
    };
    areas(made) == areas(now) && instances(made) == instances(now)
}
