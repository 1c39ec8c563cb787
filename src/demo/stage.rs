//! The current scene: document, renderer, and the edits applied without a rebuild.

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

/// A selectable entry of the document.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Selected {
    /// One of the instances.
    Instance(usize),
    /// One of the lights.
    Light(usize),
}

/// The current scene.
pub(super) struct Stage {
    /// Name or file it was loaded by.
    pub name: String,
    pub settings: Settings,
    pub renderer: Renderer,
    /// The document with all edits.
    pub document: SceneDocument,
    /// The document that `scene` was built from.
    made: SceneDocument,
    /// The scene of the renderer.
    pub scene: Arc<Scene>,
    /// The edited scene at rest, without meshes.
    pub rest: Scene,
    /// Radius of the scene's bounding sphere.
    pub radius: f32,
    pub selected: Option<Selected>,
    /// The light attached to the camera.
    pub headlamp: Option<usize>,
    /// Whether there are unsaved edits.
    pub edited: bool,
    /// The pose of the last frame.
    pub pose: Pose,
    /// Report of the last finished frame.
    pub report: FrameReport,
}

/// How an edit takes effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Change {
    /// Without a rebuild.
    Live,
    /// The renderer must be rebuilt.
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

    /// Takes a rebuilt renderer of this scene; keeps later edits.
    pub fn renew(&mut self, built: Built) -> Result<Change, SceneError> {
        let Built { document, scene, settings, renderer, .. } = built;
        self.settings = settings;
        self.renderer = renderer;
        self.made = document;
        self.scene = scene;
        // A new renderer has no report yet.
        self.pose = self.scene.pose(0.0);
        self.apply()
    }

    /// The document that the renderer was built from, with its settings.
    pub fn made_document(&self) -> SceneDocument {
        let mut document = self.made.clone();
        document.set_settings(self.settings.differing());
        document
    }

    /// Renders the next frame at animation time `time` with `camera`.
    pub fn render(&mut self, time: f64, camera: Camera) -> Result<(), RenderError> {
        self.pose = self.pose_at(time, camera);
        self.renderer.render(&self.pose)?;
        if let Some(report) = self.renderer.take_reports().pop() {
            self.report = report;
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
    /// If the entry is invalid; then nothing changes.
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
    /// If the entry is invalid; then nothing changes.
    pub fn set_instance(&mut self, index: usize, entry: InstanceEntry) -> Result<Change, SceneError> {
        self.document.placement(&entry)?;
        self.edit(|document| {
            if let Some(instance) = document.instance_mut(index) {
                *instance = entry;
            }
        })
    }

    /// Adds a light and selects it.
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

    /// Applies the document to the rest pose, if that needs no rebuild.
    fn apply(&mut self) -> Result<Change, SceneError> {
        if !differs_in_pose_only(&self.made, &self.document) {
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
        // Lights without an entry: instances with emissive materials.
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

    /// The entry whose surface is at a position of the picture.
    pub fn selected_at(&self, at: Vec2) -> Option<Selected> {
        let instance = self.pick(at)?.instance;
        if instance < self.document.instances().len() {
            return Some(Selected::Instance(instance));
        }
        let mut lights = 0..self.document.lights().len();
        lights.find(|&light| self.document.light_instance(light) == Some(instance)).map(Selected::Light)
    }

    /// Current position of an entry, world space.
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
                    // It has no position; place its handles at the scene's centre.
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

/// Moves a light to the camera.
pub(super) fn carry(light: &mut LightEntry, camera: &Camera) {
    if matches!(light.kind, LightType::Point | LightType::Spot) {
        light.position = Some(camera.eye.to_array());
    }
    if matches!(light.kind, LightType::Spot | LightType::Directional) {
        light.direction = Some(camera.forward().to_array());
    }
}

/// Whether two documents differ only in what the pose holds, so that no rebuild is needed.
fn differs_in_pose_only(made: &SceneDocument, now: &SceneDocument) -> bool {
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
