//! The scene that is shown: its document, its renderer, and what of the document is live.

use std::sync::Arc;

use glam::{Mat4, Vec2, Vec3};
use serde::Serialize;

use super::loader::Built;
use crate::bvh::Ray;
use crate::renderer::{Picked, RenderError, Renderer, camera_ray};
use crate::report::FrameReport;
use crate::scene::{
    Camera, InstanceEntry, LightEntry, LightKind, LightType, Pose, Scene, SceneDocument, SceneError,
};
use crate::settings::Settings;

/// Something that can be chosen: an entry of the document.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Selected {
    /// One of the instances.
    Instance(usize),
    /// One of the lights.
    Light(usize),
}

/// A scene on show.
pub(super) struct Stage {
    /// As it was asked for.
    pub name: String,
    pub settings: Settings,
    pub renderer: Renderer,
    /// What was loaded, with all edits.
    pub document: SceneDocument,
    /// The document that `scene` was made of.
    made: SceneDocument,
    /// What the renderer was made for.
    pub scene: Arc<Scene>,
    /// Where everything rests now; without meshes.
    pub rest: Scene,
    /// Radius of the scene's bounding sphere.
    pub radius: f32,
    pub selected: Option<Selected>,
    /// The light that goes with the camera.
    pub headlamp: Option<usize>,
    /// Whether anything was edited since the scene was loaded or saved.
    pub edited: bool,
    /// The pose of the last frame.
    pub pose: Pose,
    /// What was measured of the last frame that the device has finished.
    pub report: FrameReport,
}

/// What an edit needs to be seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Change {
    /// It is live.
    Live,
    /// The renderer must be made anew.
    Rebuild,
}

impl Stage {
    pub fn new(built: Built) -> Self {
        let Built { name, document, scene, settings, renderer, .. } = built;
        let rest = scene.without_meshes();
        let pose = rest.pose(0.0);
        let (low, high) = renderer.bvh().bounds();
        Self {
            name,
            settings,
            renderer,
            made: document.clone(),
            document,
            scene,
            rest,
            radius: 0.5 * low.distance(high),
            selected: None,
            headlamp: None,
            edited: false,
            pose,
            report: FrameReport::default(),
        }
    }

    /// Takes a renderer that was made for this scene after an edit, and keeps all that has been edited since.
    pub fn renew(&mut self, built: Built) -> Result<Change, SceneError> {
        let Built { document, scene, settings, renderer, .. } = built;
        self.settings = settings;
        self.renderer = renderer;
        self.made = document;
        self.scene = scene;
        // As a renderer that has not drawn anything has it.
        self.pose = self.scene.pose(0.0);
        self.apply()
    }

    /// The document that the renderer was made of, with its settings.
    pub fn made_document(&self) -> SceneDocument {
        let mut document = self.made.clone();
        document.set_settings(self.settings.differing());
        document
    }

    /// Draws the next frame with everything where it is at `time`, seen by `camera`.
    pub fn render(&mut self, time: f64, camera: Camera) -> Result<(), RenderError> {
        self.pose = self.pose_at(time, camera);
        self.renderer.render(&self.pose)?;
        if let Some(report) = self.renderer.take_reports().last() {
            self.report = *report;
        }
        Ok(())
    }

    fn pose_at(&self, time: f64, camera: Camera) -> Pose {
        let mut pose = Pose { camera, ..self.rest.pose(time) };
        let lamp = self.headlamp.and_then(|index| self.document.scene_light(index));
        if let Some(light) = lamp.and_then(|index| pose.lights.get_mut(index)) {
            light.position = camera.eye;
            light.direction = camera.forward();
        }
        pose
    }

    /// Changes a light of the document to `entry`.
    ///
    /// # Errors
    /// What is wrong with the entry; nothing has changed then.
    pub fn set_light(&mut self, index: usize, entry: LightEntry) -> Result<Change, SceneError> {
        self.document.light(&entry)?;
        self.edit(|document| {
            if let Some(light) = document.light_mut(index) {
                *light = entry;
            }
        })
    }

    /// Changes an instance of the document to `entry`.
    ///
    /// # Errors
    /// What is wrong with the entry; nothing has changed then.
    pub fn set_instance(&mut self, index: usize, entry: InstanceEntry) -> Result<Change, SceneError> {
        self.document.placement(&entry)?;
        self.edit(|document| {
            if let Some(instance) = document.instance_mut(index) {
                *instance = entry;
            }
        })
    }

    /// Adds a light and chooses it.
    pub fn add_light(&mut self, entry: LightEntry) -> Result<Change, SceneError> {
        self.document.light(&entry)?;
        let change = self.edit(|document| document.add_light(entry))?;
        self.selected = Some(Selected::Light(self.document.lights().len() - 1));
        Ok(change)
    }

    /// Removes a light.
    pub fn remove_light(&mut self, index: usize) -> Result<Change, SceneError> {
        self.selected = None;
        self.headlamp = match self.headlamp {
            Some(lamp) if lamp == index => None,
            Some(lamp) if lamp > index => Some(lamp - 1),
            lamp => lamp,
        };
        self.edit(|document| document.remove_light(index))
    }

    fn edit(&mut self, edit: impl FnOnce(&mut SceneDocument)) -> Result<Change, SceneError> {
        let before = self.document.clone();
        edit(&mut self.document);
        let change = self.apply();
        match change {
            Ok(_) => self.edited = true,
            Err(_) => self.document = before,
        }
        change
    }

    /// Brings the rest pose up to the document, where the renderer's scene can show it.
    fn apply(&mut self) -> Result<Change, SceneError> {
        if !is_shown_alike(&self.made, &self.document) {
            return Ok(Change::Rebuild);
        }
        let mut rest = self.scene.without_meshes();
        let areas = rest.lights.iter().filter(|light| matches!(light.kind, LightKind::Area { .. }));
        let mut areas: std::collections::VecDeque<_> = areas.cloned().collect();
        rest.lights.clear();
        for (index, entry) in self.document.lights().enumerate() {
            match self.document.light(entry)? {
                Some(light) => rest.lights.push(light),
                None if self.document.scene_light(index).is_some() => rest.lights.extend(areas.pop_front()),
                None => {}
            }
        }
        // Lights that no entry names: instances that shine by their materials.
        rest.lights.extend(areas);
        for (instance, entry) in rest.instances.iter_mut().zip(self.document.instances()) {
            let placement = self.document.placement(entry)?;
            (instance.transform, instance.animation) = (placement.transform, placement.animation);
        }
        let made = self.made.lights().filter_map(|light| light.polygon);
        let polygons = self.document.lights().enumerate().filter(|(_, light)| light.polygon.is_some());
        for ((index, light), made) in polygons.zip(made) {
            let placement = self.document.polygon_placement(light, made)?;
            let instance = self.document.light_instance(index).and_then(|i| rest.instances.get_mut(i));
            if let Some(instance) = instance {
                (instance.transform, instance.animation) = (placement.transform, placement.animation);
            }
        }
        self.rest = rest;
        Ok(Change::Live)
    }

    /// The document as it would be saved now: with `camera`, and the headlamp where it is.
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

    /// What the pointer would choose at a place in the picture, by surface.
    pub fn selected_at(&self, at: Vec2) -> Option<Selected> {
        let instance = self.pick(at)?.instance;
        if instance < self.document.instances().len() {
            return Some(Selected::Instance(instance));
        }
        let mut lights = 0..self.document.lights().len();
        lights.find(|&light| self.document.light_instance(light) == Some(instance)).map(Selected::Light)
    }

    /// Where a chosen thing is now, world space.
    pub fn place_of(&self, selected: Selected) -> Option<Vec3> {
        match selected {
            Selected::Instance(index) => {
                self.pose.instances.get(index).map(|transform| transform.translation.into())
            }
            Selected::Light(index) => {
                if let Some(instance) = self.document.light_instance(index) {
                    return self.pose.instances.get(instance).map(|transform| transform.translation.into());
                }
                let light = self.pose.lights.get(self.document.scene_light(index)?)?;
                match light.kind {
                    LightKind::Point { .. } | LightKind::Spot { .. } => Some(light.position),
                    // It has no place; its handles stand in the middle of the scene.
                    LightKind::Directional { .. } => {
                        let (low, high) = self.renderer.bvh().bounds();
                        Some(0.5 * (low + high))
                    }
                    LightKind::Area { instance, .. } => {
                        self.pose.instances.get(instance).map(|transform| transform.translation.into())
                    }
                }
            }
        }
    }

    /// World to clip space of the last frame.
    pub fn view_projection(&self) -> Mat4 {
        let camera = &self.pose.camera;
        let aspect = self.settings.size[0] as f32 / self.settings.size[1] as f32;
        camera.projection_matrix(aspect) * camera.view_matrix()
    }

    /// The nearest surface at a place in the picture, from (0, 0) at the top left to (1, 1).
    pub fn pick(&self, at: Vec2) -> Option<Picked> {
        self.renderer.pick(&self.pose, at * self.extent())
    }

    /// The ray through a place in the picture.
    pub fn ray(&self, at: Vec2) -> Ray {
        camera_ray(&self.pose.camera, self.settings.size, at * self.extent())
    }

    fn extent(&self) -> Vec2 {
        Vec2::from_array(self.settings.size.map(|side| side as f32))
    }
}

/// Puts a light where the camera is.
pub(super) fn carry(light: &mut LightEntry, camera: &Camera) {
    if matches!(light.kind, LightType::Point | LightType::Spot) {
        light.position = Some(camera.eye.to_array());
    }
    if matches!(light.kind, LightType::Spot | LightType::Directional) {
        light.direction = Some(camera.forward().to_array());
    }
}

/// Whether a renderer that was made for one document can show the other: only what it takes by the pose
/// differs.
fn is_shown_alike(made: &SceneDocument, now: &SceneDocument) -> bool {
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
