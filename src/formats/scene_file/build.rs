//! Builds a [`Scene`] from a parsed scene file: resolves names and files and validates values.
//!
//! In: a [`SceneFile`] with its text (for line numbers) and the assets folder. Out: a scene, or an error
//! with file, line and key.

use std::collections::HashMap;
use std::ops::Range;
use std::path::Path;

use glam::{Affine3A, BVec3, EulerRot, Quat, Vec3};

use super::material_edit::edit_materials;
use super::read_files::{ReadFiles, ReadModels};
use super::schema::{
    AnimationEntry, CameraEntry, InstanceEntry, RotationEntry, ScaleEntry, SceneFile, line_of,
};
use super::{environment, lights, models};
use crate::formats::error::SceneError;
use crate::formats::{default_view, obj};
use crate::scene::{Animation, Camera, Instance, Keyframe, MAX_COORDINATE, Rotation, Scene};

/// Largest magnitude of a keyframe's time, seconds: about 30 years.
const MAX_TIME: f64 = 1e9;

/// Builds the scene of `file`, whose content was `text`; reads what is not in `read`, and adds it there.
pub(crate) fn build(
    path: &Path,
    text: &str,
    file: SceneFile,
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
    let built = builder.build(&file);
    *read = builder.read;
    built.map(|()| builder.scene)
}

/// A scene under construction.
pub(crate) struct Builder<'a> {
    pub path: &'a Path,
    text: &'a str,
    pub assets: Option<&'a Path>,
    pub scene: Scene,
    /// Mesh of each model, by name.
    pub models: HashMap<String, usize>,
    /// Index of each instance, by name.
    pub instances: HashMap<String, usize>,
    /// What was read of files.
    pub read: ReadFiles,
}

/// A table of the file, as error messages name it.
#[derive(Clone, Debug)]
pub(crate) struct Entry<'a> {
    path: &'a Path,
    text: &'a str,
    /// Byte range in the text. The line is counted only for an error, since counting takes linear time.
    span: Range<usize>,
    /// Type and name, such as `light "sun"`.
    what: String,
}

impl Entry<'_> {
    /// An error about this table.
    pub fn error(&self, problem: impl AsRef<str>) -> SceneError {
        let line = line_of(self.text, &self.span);
        SceneError::invalid(self.path, Some(line), format!("{}: {}", self.what, problem.as_ref()))
    }

    /// A vector; must be finite.
    pub fn vector(&self, key: &str, value: [f32; 3]) -> Result<Vec3, SceneError> {
        let vector = Vec3::from_array(value);
        if vector.is_finite() {
            Ok(vector)
        } else {
            Err(self.error(format!("{key} must be finite, is {vector}")))
        }
    }

    /// A point or size in scene units; must be finite and within [`MAX_COORDINATE`].
    pub fn place(&self, key: &str, value: [f32; 3]) -> Result<Vec3, SceneError> {
        let place = self.vector(key, value)?;
        if place.abs().max_element() > MAX_COORDINATE {
            return Err(self.error(format!("{key} must lie within +-{MAX_COORDINATE:e}, is {place}")));
        }
        Ok(place)
    }

    /// A number; must be finite.
    pub fn number(&self, key: &str, value: f32) -> Result<f32, SceneError> {
        if value.is_finite() {
            Ok(value)
        } else {
            Err(self.error(format!("{key} must be finite, is {value}")))
        }
    }

    /// A colour; must be finite and not negative.
    pub fn power(&self, key: &str, value: [f32; 3]) -> Result<Vec3, SceneError> {
        let colour = self.vector(key, value)?;
        if colour.min_element() < 0.0 {
            return Err(self.error(format!("{key} must not be negative, is {colour}")));
        }
        Ok(colour)
    }

    /// A number from 0 to 1.
    pub fn share(&self, key: &str, value: f32) -> Result<f32, SceneError> {
        let share = self.number(key, value)?;
        let fits = (0.0..=1.0).contains(&share);
        if fits { Ok(share) } else { Err(self.error(format!("{key} must be from 0 to 1, is {share}"))) }
    }

    /// A colour; each channel must be from 0 to 1.
    pub fn reflectance(&self, key: &str, value: [f32; 3]) -> Result<Vec3, SceneError> {
        let colour = self.power(key, value)?;
        let fits = colour.max_element() <= 1.0;
        if fits { Ok(colour) } else { Err(self.error(format!("{key} must not be above 1, is {colour}"))) }
    }

    /// A direction, normalised; must be finite and not zero.
    pub fn direction(&self, key: &str, value: [f32; 3]) -> Result<Vec3, SceneError> {
        let vector = self.vector(key, value)?.as_dvec3();
        let unit = vector.try_normalize();
        unit.map(|unit| unit.as_vec3()).ok_or_else(|| self.error(format!("{key} must not be zero")))
    }

    /// The value of a required key.
    pub fn required<T>(&self, key: &str, value: Option<T>) -> Result<T, SceneError> {
        value.ok_or_else(|| self.error(format!("the key {key} is missing")))
    }
}

impl<'a> Builder<'a> {
    /// Names the table at `span` for error messages.
    pub fn entry(&self, span: &Range<usize>, what: impl Into<String>) -> Entry<'a> {
        Entry { path: self.path, text: self.text, span: span.clone(), what: what.into() }
    }

    fn build(&mut self, file: &SceneFile) -> Result<(), SceneError> {
        let top = self.entry(&(0..0), "scene");
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
            let entry = self.entry(&environment.span(), "environment");
            if file.background.is_some() {
                return Err(entry.error("is seen, so the key background is not allowed; remove it"));
            }
            let environment = environment::environment_of(self, &entry, environment.as_ref())?;
            self.scene.environment = Some(environment);
        }
        for instance in &file.instances {
            let name = instance.as_ref().name.as_ref().unwrap_or(&instance.as_ref().model);
            let entry = self.entry(&instance.span(), format!("instance \"{name}\""));
            self.add_instance(&entry, instance.as_ref())?;
        }
        for light in &file.lights {
            lights::add_light(self, light)?;
        }
        lights::add_emissive_instances(&mut self.scene);
        match &file.camera {
            Some(camera) => {
                let entry = self.entry(&camera.span(), "camera");
                self.set_camera(&entry, camera.as_ref())?;
            }
            None => default_view::frame(&mut self.scene),
        }
        self.warn_of_darkness();
        self.scene.settings = self.settings(file)?;
        if !file.recording.is_sorted_by(|a, b| a.frame < b.frame) {
            return Err(top.error("the frames of [[recording]] must be in ascending order"));
        }
        self.scene.recording = std::sync::Arc::new(file.recording.clone());
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
        for model in new {
            models::add_model(self, model)?;
        }
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

    /// A builder that validates single entries without a file.
    pub fn of_entries(path: &'a Path) -> Self {
        Self {
            path,
            text: "",
            assets: None,
            scene: Scene::new(""),
            models: HashMap::new(),
            instances: HashMap::new(),
            read: ReadFiles::default(),
        }
    }

    fn add_instance(&mut self, entry: &Entry, instance: &InstanceEntry) -> Result<(), SceneError> {
        let Some(&mesh) = self.models.get(&instance.model) else {
            let mut known: Vec<&str> = self.models.keys().map(String::as_str).collect();
            known.sort_unstable();
            let known = if known.is_empty() { "none".to_owned() } else { known.join(", ") };
            return Err(entry.error(format!("unknown model \"{}\"; known are {known}", instance.model)));
        };
        let name = instance.name.clone().unwrap_or_else(|| instance.model.clone());
        let transform = transform_of(entry, instance)?;
        check_not_mirrored(entry, &transform, self.scene.is_emissive(mesh))?;
        check_extent(entry, &transform, self.scene.meshes[mesh].bounds())?;
        let animation = animation_of(self, entry, instance.animation.as_ref())?;
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
        self.scene.camera_animation = animation_of(self, entry, camera.animation.as_ref())?;
        let mut fitted = Camera { up, vertical_fov: vfov.to_radians(), ..Camera::looking(eye, target) };
        let bounds = self.scene.bounding_sphere(&self.scene.pose(0.0));
        let reach = self.scene.camera_animation.as_ref().map_or(0.0, |animation| animation.reach(eye));
        fitted.fit_depths(&bounds, reach);
        let far = entry.number("far", camera.far.unwrap_or(fitted.far))?;
        // A given far plane may be nearer than the fitted near plane.
        let near = camera.near.unwrap_or(fitted.near.min(1e-3 * far));
        let near = entry.number("near", near)?;
        if near <= 0.0 || near >= far {
            return Err(entry.error(format!("near must be above 0 and below far (near {near}, far {far})")));
        }
        self.scene.camera = Camera { near, far, ..fitted };
        Ok(())
    }
}

pub(crate) fn transform_of(entry: &Entry, instance: &InstanceEntry) -> Result<Affine3A, SceneError> {
    let translation = entry.place("translation", instance.translation.unwrap_or_default())?;
    let rotation = rotation_of(entry, instance.rotation)?;
    let scale = match instance.scale {
        None => Vec3::ONE,
        Some(ScaleEntry::Uniform(factor)) => Vec3::splat(entry.number("scale", factor)?),
        Some(ScaleEntry::PerAxis(factors)) => entry.vector("scale", factors)?,
    };
    if scale.abs().max_element() > MAX_COORDINATE {
        return Err(entry.error(format!("scale must lie within +-{MAX_COORDINATE:e}, is {scale}")));
    }
    let transform = Affine3A::from_scale_rotation_translation(scale, rotation, translation);
    if scale.abs().min_element() < 1e-9 || !transform.inverse().is_finite() {
        return Err(entry.error(format!("scale must not be zero in any axis, is {scale}")));
    }
    Ok(transform)
}

/// Fails if a mesh with these bounds has coordinates beyond [`MAX_COORDINATE`] under `transform`.
fn check_extent(entry: &Entry, transform: &Affine3A, bounds: (Vec3, Vec3)) -> Result<(), SceneError> {
    let (low, high) = bounds;
    let corner = |i: u32| Vec3::select(BVec3::new(i & 1 == 0, i & 2 == 0, i & 4 == 0), low, high);
    let farthest = (0..8).map(|i| transform.transform_point3(corner(i)).abs().max_element());
    if farthest.fold(0.0, f32::max) > MAX_COORDINATE {
        return Err(entry.error(format!("must lie within +-{MAX_COORDINATE:e}; scale it down")));
    }
    Ok(())
}

/// Fails for a mirrored emissive instance: mirroring flips the winding, which defines the emitting side.
pub(crate) fn check_not_mirrored(entry: &Entry, transform: &Affine3A, emits: bool) -> Result<(), SceneError> {
    if emits && transform.matrix3.determinant() < 0.0 {
        return Err(entry.error("an instance that emits light must not be mirrored by a negative scale"));
    }
    Ok(())
}

fn rotation_of(entry: &Entry, rotation: Option<RotationEntry>) -> Result<Quat, SceneError> {
    match rotation {
        None => Ok(Quat::IDENTITY),
        Some(RotationEntry::Euler(degrees)) => {
            let [x, y, z] = entry.vector("rotation", degrees)?.to_array().map(f32::to_radians);
            Ok(Quat::from_euler(EulerRot::XYZEx, x, y, z))
        }
        Some(RotationEntry::AxisAngle(turn)) => {
            let axis = entry.direction("rotation.axis", turn.axis)?;
            let degrees = entry.number("rotation.degrees", turn.degrees)?;
            Ok(Quat::from_axis_angle(axis, degrees.to_radians()))
        }
    }
}

/// The animation of a table, if it has one; keyframe times must be ascending.
pub(crate) fn animation_of(
    builder: &Builder,
    owner: &Entry,
    animation: Option<&toml::Spanned<AnimationEntry>>,
) -> Result<Option<Animation>, SceneError> {
    let Some(spanned) = animation else {
        return Ok(None);
    };
    let entry = builder.entry(&spanned.span(), format!("{}: animation", owner.what));
    let animation = spanned.as_ref();
    let mut keyframes: Vec<Keyframe> = Vec::with_capacity(animation.keyframes.len());
    for key in &animation.keyframes {
        let possible = key.time.abs() <= MAX_TIME;
        if !possible || keyframes.last().is_some_and(|last| last.time >= key.time) {
            return Err(entry.error(format!(
                "keyframe times must be ascending and within +-{MAX_TIME:e} seconds (time {})",
                key.time
            )));
        }
        keyframes.push(Keyframe {
            time: key.time,
            translation: entry.place("keyframes.translation", key.translation.unwrap_or_default())?,
            rotation: rotation_of(&entry, key.rotation)?,
        });
    }
    let rotation = match &animation.rotation {
        None => None,
        Some(spin) => Some(Rotation {
            axis: entry.direction("rotation.axis", spin.axis)?,
            speed: entry.number("rotation.degrees_per_second", spin.degrees_per_second)?.to_radians(),
            pivot: spin.pivot.map(|pivot| entry.place("rotation.pivot", pivot)).transpose()?,
        }),
    };
    if keyframes.is_empty() && rotation.is_none() {
        return Err(entry.error("needs keyframes or a rotation"));
    }
    Ok(Some(Animation { keyframes, rotation, repeat: animation.repeat }))
}
