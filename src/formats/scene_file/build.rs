//! Builds a [`Scene`] from a parsed scene file: resolves names and files and validates values.
//!
//! In: a [`SceneFile`] with its text (for line numbers) and the assets folder. Out: a scene, or an error
//! with file, line and key.

use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

use glam::Affine3A;

use super::builder::Builder;
use super::entry::{At, Entry};
use super::materials::edit_materials;
use super::motion::{animation_of, check_extent, check_not_mirrored, transform_of};
use super::read_files::{ReadFiles, ReadModels};
use super::schema::{CameraEntry, InstanceEntry, SceneFile};
use super::{environment, lights, models};
use crate::formats::error::SceneError;
use crate::formats::{default_view, obj};
use crate::scene::{Camera, Instance, Scene};

/// Builds a scene from the text of the scene file at `path`; reads what is not in `read`, and adds it there.
pub(crate) fn load_toml(
    path: &Path,
    text: &str,
    assets: Option<&Path>,
    read: &mut ReadFiles,
) -> Result<Scene, SceneError> {
    let file = SceneFile::parse(path, text)?;
    build(path, text, &file, assets, read)
}

impl ReadFiles {
    /// Builds a scene from the text of a scene file, whose paths must be absolute; reads only what is not here yet.
    ///
    /// # Errors
    /// Those of a scene file.
    pub fn scene_of_text(&mut self, text: &str, assets: Option<&Path>) -> Result<Scene, SceneError> {
        load_toml(Path::new("recorded scene"), text, assets, self)
    }
}

/// Builds the scene of `file`, whose content was `text`; reads what is not in `read`, and adds it there.
fn build(
    path: &Path,
    text: &str,
    file: &SceneFile,
    assets: Option<&Path>,
    read: &mut ReadFiles,
) -> Result<Scene, SceneError> {
    let mut builder = Builder {
        path,
        text,
        assets,
        scene: Scene::new(&file.name.clone().unwrap_or_else(|| obj::stem(path))),
        models: HashMap::new(),
        instances: HashMap::new(),
        read: std::mem::take(read),
    };
    let built = builder.build(file);
    *read = builder.read;
    built.map(|()| builder.scene)
}

impl Builder<'_> {
    fn build(&mut self, file: &SceneFile) -> Result<(), SceneError> {
        let top = self.entry(At::File, "scene");
        self.add_models(file)?;
        if let Some(metres) = file.metres_per_unit {
            if !(metres > 0.0 && metres.is_finite()) {
                return Err(top.error(format!("metres_per_unit must be above 0 and finite, is {metres}")));
            }
            self.scene.metres_per_unit = Some(metres);
        }
        edit_materials(self, &file.materials)?;
        if let Some(background) = file.background {
            self.scene.background = top.power("background", background)?;
        }
        if let Some(environment) = &file.environment {
            let entry = self.entry(At::Table("environment"), "environment");
            if file.background.is_some() {
                return Err(entry.error("is seen, so the key background is not allowed; remove it"));
            }
            let environment = environment::environment_of(self, &entry, environment)?;
            self.scene.environment = Some(environment);
        }
        for (index, instance) in file.instances.iter().enumerate() {
            let entry =
                self.entry(At::Entry("instances", index), format!("instance \"{}\"", instance.shown_name()));
            self.add_instance(&entry, instance)?;
        }
        for (index, light) in file.lights.iter().enumerate() {
            lights::add_light(self, index, light)?;
        }
        lights::add_emissive_instances(&mut self.scene);
        match &file.camera {
            Some(camera) => {
                let entry = self.entry(At::Table("camera"), "camera");
                self.set_camera(&entry, camera)?;
            }
            None => default_view::frame(&mut self.scene),
        }
        self.warn_of_darkness();
        self.scene.settings = self.settings(file)?;
        if !file.recording.is_sorted_by(|a, b| a.frame < b.frame) {
            return Err(top.error("the frames of [[recording]] must be in ascending order"));
        }
        self.scene.recording = Arc::new(file.recording.clone());
        Ok(())
    }

    fn add_models(&mut self, file: &SceneFile) -> Result<(), SceneError> {
        let mut known_models = 0;
        if let Some(known) = self.read.models_of(file) {
            self.scene = Scene { name: self.scene.name.clone(), ..known.scene.clone() };
            self.models.clone_from(&known.meshes);
            known_models = known.len();
        }
        let new = file.models.get(known_models..).unwrap_or_default();
        if new.is_empty() && known_models > 0 {
            return Ok(());
        }
        for (index, model) in new.iter().enumerate() {
            models::add_model(self, known_models + index, model)?;
        }
        self.scene.anchor_meshes();
        self.read.models = Some(ReadModels::new(file, &self.scene, &self.models));
        Ok(())
    }

    /// The flattened `[settings]`; keys and values were checked by the parser.
    fn settings(&self, file: &SceneFile) -> Result<toml::Table, SceneError> {
        if file.settings.is_none() {
            return Ok(toml::Table::new());
        }
        let mut table: toml::Table = toml::from_str(self.text)
            .map_err(|error| SceneError::invalid(self.path, None, error.message()))?;
        match table.remove("settings") {
            Some(toml::Value::Table(settings)) => crate::settings::flat(&settings)
                .map_err(|error| SceneError::invalid(self.path, None, error.to_string())),
            _ => Ok(toml::Table::new()),
        }
    }

    fn warn_of_darkness(&mut self) {
        if self.scene.lights.is_empty() && self.scene.environment.is_none() {
            let warning = format!(
                "{}: the scene has no light (no [[lights]], no emissive material), so only the background is not black",
                self.path.display()
            );
            self.scene.warnings.push(warning);
        }
        if !self.scene.instances.iter().any(|instance| instance.visible) {
            let warning = format!(
                "{}: the scene has no visible [[instances]], so only the background is visible",
                self.path.display()
            );
            self.scene.warnings.push(warning);
        }
    }

    fn add_instance(&mut self, entry: &Entry, instance: &InstanceEntry) -> Result<(), SceneError> {
        let Some(&mesh) = self.models.get(&instance.model) else {
            let mut known: Vec<&str> = self.models.keys().map(String::as_str).collect();
            known.sort_unstable();
            let known = if known.is_empty() { "none".to_owned() } else { known.join(", ") };
            return Err(entry.error(format!("unknown model \"{}\"; known are {known}", instance.model)));
        };
        let name = instance.shown_name().to_owned();
        let transform = transform_of(entry, instance)?;
        check_not_mirrored(entry, &transform, self.scene.is_emissive(mesh))?;
        check_extent(entry, &transform, self.scene.meshes[mesh].bounds())?;
        let animation = animation_of(entry, instance.animation.as_ref())?;
        let index = self.scene.instances.len();
        if instance.name.is_some() && self.instances.contains_key(&name) {
            return Err(entry.error("another instance has this name; rename one"));
        }
        self.instances.insert(name.clone(), index);
        self.scene.instances.push(Instance {
            transform,
            dynamic: instance.dynamic.unwrap_or(animation.is_some()) || animation.is_some(),
            animation,
            visible: instance.visible.unwrap_or(true),
            ..Instance::fixed(&name, mesh, Affine3A::IDENTITY)
        });
        Ok(())
    }

    fn set_camera(&mut self, entry: &Entry, camera: &CameraEntry) -> Result<(), SceneError> {
        let eye = entry.place("eye", camera.eye)?;
        let target = entry.place("target", camera.target)?;
        if eye == target {
            return Err(entry.error("eye and target must differ"));
        }
        let up = entry.direction("up", camera.up.unwrap_or([0.0, 1.0, 0.0]))?;
        let forward = entry.direction("target - eye", (target - eye).to_array())?;
        if forward.cross(up).length() < 1e-4 {
            return Err(entry.error("up must not be parallel to the view direction"));
        }
        let vfov = entry.number("vfov_deg", camera.vfov_deg.unwrap_or(45.0))?;
        if !(0.01..=170.0).contains(&vfov) {
            return Err(entry.error(format!("vfov_deg must be from 0.01 to 170, is {vfov}")));
        }
        self.scene.camera_animation = animation_of(entry, camera.animation.as_ref())?;
        let placed = Camera { up, vertical_fov: vfov.to_radians(), ..Camera::looking(eye, target) };
        let far = camera.far.map_or(Ok(f32::INFINITY), |far| entry.number("far", far))?;
        let near = entry.number("near", camera.near.unwrap_or(placed.near.min(1e-3 * far)))?;
        if near <= 0.0 || near >= far {
            return Err(entry.error(format!("near must be above 0 and below far (near {near}, far {far})")));
        }
        self.scene.camera = Camera { near, far, ..placed };
        self.scene.files.cameras = 1;
        Ok(())
    }
}
