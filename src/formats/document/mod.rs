//! An editable scene file.
//!
//! In: a scene by name or file. Out: its entries, the light or placement of a single entry, and the text of an
//! equivalent scene file. Scenes without a scene file get a generated one.

mod text;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::{Affine3A, Mat3, Vec3};

use super::error::SceneError;
use super::gltf;
use super::load::{self, Source};
use super::scene_file::entry::{Entry, degrees_of};
use super::scene_file::environment::numbers_of;
use super::scene_file::lights::{entry_of, single_light};
use super::scene_file::motion::{animation_of, transform_of};
use super::scene_file::schema::{
    AnimationEntry, CameraEntry, EnvironmentEntry, InstanceEntry, LightEntry, ModelEntry, Primitive,
    SceneFile,
};
use super::scene_file::{MaterialEdit, ReadFiles, load_toml};
use crate::scene::{Animation, Camera, Light, LightType, Scene};

/// The Cornell box as a scene file.
const CORNELL_BOX: &str = "name = \"cornell-box\"
[[models]]
name = \"cornell-box\"
builtin = \"cornell-box\"
[[instances]]
model = \"cornell-box\"
";

/// A scene being edited.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneDocument {
    file: SceneFile,
    /// The `[settings]` table.
    settings: toml::Table,
    /// The file that error messages name.
    path: PathBuf,
    /// The scene file that it was opened from, if there is one.
    origin: Option<Arc<Origin>>,
}

/// A scene file as it was opened.
#[derive(Debug, PartialEq)]
struct Origin {
    text: String,
    /// What it holds, as in [`SceneDocument::table`].
    table: toml::Table,
}

/// What a model is made from.
#[derive(Clone, Debug, PartialEq)]
pub enum ModelSource {
    /// A shape about the origin, of edge length or radius 1.
    Shape(Primitive),
    /// An `.obj`, `.gltf` or `.glb`.
    File(PathBuf),
}

/// Rest transform and animation of an instance.
#[derive(Clone, Debug, PartialEq)]
pub struct Placement {
    /// Object to world at rest.
    pub transform: Affine3A,
    /// Its animation, if any.
    pub animation: Option<Animation>,
}

impl SceneDocument {
    /// Opens a scene and builds it; returns what was read for it, too. `assets` is the folder of the downloadable models.
    ///
    /// # Errors
    /// Those of [`load_scene`](crate::formats::load_scene).
    pub fn open(name: &str, assets: Option<&Path>) -> Result<(Self, Scene, ReadFiles), SceneError> {
        let mut read = ReadFiles::default();
        let mut scene = load::load_with(name, assets, &load::LoadOptions::default(), &mut read)?;
        let source = load::find(name)?;
        let (path, text) = match &source {
            Source::File(path, text) => (path.clone(), text.clone()),
            Source::Model(path) => (path.with_extension("toml"), scene_file_of_model(path, &scene.name)),
            Source::CornellBox => ("cornell-box.toml".into(), CORNELL_BOX.to_owned()),
        };
        let (file, settings) = (SceneFile::parse(&path, &text)?, scene.settings.clone());
        let mut document = Self { file, settings, path, origin: None };
        document.make_paths_absolute();
        // The recording belongs to the unedited scene.
        document.file.recording.clear();
        document.complete(&scene);
        match &source {
            Source::File(..) => {
                document.origin = Some(Arc::new(Origin { text, table: document.table(Vec::new()) }));
            }
            // As a model of a scene file it is one mesh at rest.
            Source::Model(path) if gltf::is_gltf(path) => scene = document.build(assets, &mut read)?,
            _ => {}
        }
        let read = read.named(&document.file, &scene);
        Ok((document, scene, read))
    }

    /// Builds the scene; reads what is not in `read`, and adds it there.
    ///
    /// # Errors
    /// Those of a scene file.
    pub fn build(&self, assets: Option<&Path>, read: &mut ReadFiles) -> Result<Scene, SceneError> {
        load_toml(&self.path, &self.text(), assets, read)
    }

    /// The instance entries. Entry `i` is instance `i` of the scene.
    pub fn instances(&self) -> impl ExactSizeIterator<Item = &InstanceEntry> {
        self.file.instances.iter()
    }

    /// An instance entry, for editing.
    pub fn instance_mut(&mut self, index: usize) -> Option<&mut InstanceEntry> {
        self.file.instances.get_mut(index)
    }

    /// Appends an instance entry.
    pub fn add_instance(&mut self, instance: InstanceEntry) {
        self.file.instances.push(instance);
    }

    /// Removes an instance entry; does nothing if there is none at `index`.
    pub fn remove_instance(&mut self, index: usize) {
        if index < self.file.instances.len() {
            self.file.instances.remove(index);
        }
    }

    /// Names of the models.
    pub fn models(&self) -> impl Iterator<Item = &str> {
        self.file.models.iter().map(|model| model.name.as_str())
    }

    /// Adds a model under a name that no other has, which begins with that of the shape or the file; returns the name.
    pub fn add_model(&mut self, source: ModelSource) -> String {
        let (stem, path, primitive) = match source {
            ModelSource::Shape(shape) => (shape.label().to_owned(), None, Some(shape)),
            ModelSource::File(path) => {
                let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
                (stem, Some(std::fs::canonicalize(&path).unwrap_or(path)), None)
            }
        };
        let is_taken = |name: &String| self.models().any(|known| known == name);
        let numbered = (2..).map(|number| format!("{stem} {number}"));
        let mut names = std::iter::once(stem.clone()).chain(numbered);
        let name = names.find(|name| !is_taken(name)).unwrap_or(stem);
        let model = ModelEntry { path, primitive, name: name.clone(), ..ModelEntry::default() };
        self.file.models.push(model);
        name
    }

    /// The light entries.
    pub fn lights(&self) -> impl ExactSizeIterator<Item = &LightEntry> {
        self.file.lights.iter()
    }

    /// A light entry, for editing.
    pub fn light_mut(&mut self, index: usize) -> Option<&mut LightEntry> {
        self.file.lights.get_mut(index)
    }

    /// Appends a light entry.
    pub fn add_light(&mut self, light: LightEntry) {
        self.file.lights.push(light);
    }

    /// Removes a light entry; does nothing if there is none at `index`.
    pub fn remove_light(&mut self, index: usize) {
        if index < self.file.lights.len() {
            self.file.lights.remove(index);
        }
    }

    /// The edit of the materials of this name, if there is one.
    pub fn material_edit(&self, name: &str) -> Option<&MaterialEdit> {
        self.file.materials.iter().find(|edit| edit.name == name)
    }

    /// Sets the edit of the materials of its name.
    ///
    /// # Errors
    /// Those of a scene file, for this entry.
    pub fn set_material(&mut self, edit: MaterialEdit) -> Result<(), SceneError> {
        edit.check_alone(&self.path)?;
        let edits = &mut self.file.materials;
        let place = edits.iter().position(|known| known.name == edit.name);
        match place {
            Some(place) if edit.is_empty() => drop(edits.remove(place)),
            Some(place) => edits[place] = edit,
            None if edit.is_empty() => {}
            None => edits.push(edit),
        }
        Ok(())
    }

    /// The environment's entry, if there is one.
    pub fn environment(&self) -> Option<&EnvironmentEntry> {
        self.file.environment.as_ref()
    }

    /// Sets the environment, which takes the place of a background. A map's path is relative to the current folder.
    ///
    /// # Errors
    /// Those of a scene file, for the numbers of the entry.
    pub fn set_environment(&mut self, environment: Option<EnvironmentEntry>) -> Result<(), SceneError> {
        let Some(mut environment) = environment else {
            self.file.environment = None;
            return Ok(());
        };
        self.environment_numbers(&environment)?;
        if let Some(path) = &mut environment.map {
            *path = std::fs::canonicalize(&*path).unwrap_or_else(|_| path.clone());
        }
        self.file.environment = Some(environment);
        self.file.background = None;
        Ok(())
    }

    /// Radiance, W/m^2/sr, or with a map its factor, and rotation, radians, of an environment.
    ///
    /// # Errors
    /// Those of a scene file, for this entry.
    pub fn environment_numbers(&self, environment: &EnvironmentEntry) -> Result<(Vec3, f32), SceneError> {
        numbers_of(&Entry::edited(&self.path, "environment"), environment)
    }

    /// This document with the materials and the environment of another.
    #[must_use]
    pub fn with_appearance_of(&self, other: &Self) -> Self {
        let file = SceneFile {
            materials: other.file.materials.clone(),
            environment: other.file.environment.clone(),
            background: other.file.background,
            ..self.file.clone()
        };
        Self { file, ..self.clone() }
    }

    /// Whether materials and the environment are those of another document, but for the environment's numbers.
    pub fn has_appearance_of(&self, other: &Self) -> bool {
        let map = |document: &Self| document.environment().map(EnvironmentEntry::without_numbers);
        self.file.materials == other.file.materials && map(self) == map(other)
    }

    /// Index of the scene's light for entry `index`; none for a black area light.
    pub fn scene_light(&self, index: usize) -> Option<usize> {
        let emits = |light: &LightEntry| light.kind != LightType::Area || light.radiance != Some([0.0; 3]);
        let mut before = self.lights().take(index);
        let light = self.lights().nth(index)?;
        emits(light).then(|| before.by_ref().filter(|light| emits(light)).count())
    }

    /// Index of the scene's instance for light entry `index`, if that is an area light with a polygon.
    pub fn light_instance(&self, index: usize) -> Option<usize> {
        let has_polygon = |light: &&LightEntry| light.polygon.is_some();
        self.lights().nth(index).filter(|light| has_polygon(light))?;
        Some(self.file.instances.len() + self.lights().take(index).filter(has_polygon).count())
    }

    /// Builds the light of a single entry; none for an area light.
    ///
    /// # Errors
    /// Those of a scene file, for this entry.
    pub fn light(&self, entry: &LightEntry) -> Result<Option<Light>, SceneError> {
        single_light(&self.path, entry)
    }

    /// The placement of an instance entry.
    ///
    /// # Errors
    /// Those of a scene file, for this entry.
    pub fn placement(&self, instance: &InstanceEntry) -> Result<Placement, SceneError> {
        let entry = Entry::edited(&self.path, format!("instance \"{}\"", instance.shown_name()));
        Ok(Placement {
            transform: transform_of(&entry, instance)?,
            animation: animation_of(&entry, instance.animation.as_ref())?,
        })
    }

    /// The placement of an area light's instance whose mesh was built for the polygon `made`.
    ///
    /// # Errors
    /// Those of a scene file, for this entry.
    pub fn polygon_placement(
        &self,
        light: &LightEntry,
        made: [[f32; 3]; 4],
    ) -> Result<Placement, SceneError> {
        let entry = Entry::edited(&self.path, "area light");
        let now = light.polygon.unwrap_or(made);
        let (rotation, centre) = (frame_of(now) * frame_of(made).inverse(), centre_of(now));
        let only_translated =
            (rotation - Mat3::IDENTITY).to_cols_array().iter().all(|part| part.abs() < 1e-4);
        let transform = if only_translated {
            Affine3A::from_translation(centre)
        } else {
            Affine3A::from_mat3_translation(rotation, centre)
        };
        Ok(Placement { transform, animation: animation_of(&entry, light.animation.as_ref())? })
    }

    /// The motion of an animation.
    ///
    /// # Errors
    /// Those of a scene file, for this entry; one that neither has keys nor rotates is one, too.
    pub fn animation(&self, animation: &AnimationEntry) -> Result<Animation, SceneError> {
        let entry = Entry::edited(&self.path, "animation");
        animation_of(&entry, Some(animation)).map(Option::unwrap_or_default)
    }

    /// Sets the camera, without animation.
    pub fn set_camera(&mut self, camera: &Camera) {
        let vfov_deg = match &self.file.camera {
            Some(known) if known.vfov_deg.unwrap_or(45.0).to_radians() == camera.vertical_fov => {
                known.vfov_deg
            }
            _ => Some(degrees_of(camera.vertical_fov)),
        };
        let entry = CameraEntry {
            eye: camera.eye.to_array(),
            target: camera.target.to_array(),
            up: Some(camera.up.to_array()),
            vfov_deg,
            near: Some(camera.near),
            far: camera.far.is_finite().then_some(camera.far),
            animation: None,
        };
        self.file.camera = Some(entry);
    }

    /// Sets the defaults of the settings.
    pub fn set_settings(&mut self, settings: toml::Table) {
        self.settings = settings;
    }

    /// Adds entries for the defaults in `scene` that the file omits: name, camera, lights, sky.
    fn complete(&mut self, scene: &Scene) {
        self.file.name = Some(scene.name.clone());
        self.file.metres_per_unit = scene.metres_per_unit;
        if self.file.camera.is_none() {
            self.set_camera(&scene.camera);
        }
        if self.file.lights.is_empty() {
            let plain = scene.lights.iter().filter_map(entry_of);
            self.file.lights.extend(plain);
        }
        // Only a made-up sky is not in the file.
        if self.file.environment.is_none() && scene.environment.is_some() {
            self.file.environment = Some(EnvironmentEntry::sky());
        }
    }

    fn make_paths_absolute(&mut self) {
        let folder = self.path.parent().unwrap_or(Path::new("")).to_owned();
        let models = self.file.models.iter_mut().filter_map(|model| model.path.as_mut());
        let map = self.file.environment.as_mut().and_then(|entry| entry.map.as_mut());
        for path in models.chain(map) {
            let joined = folder.join(&*path);
            *path = std::fs::canonicalize(&joined).unwrap_or(joined);
        }
    }
}

/// A scene file for a bare model.
fn scene_file_of_model(path: &Path, name: &str) -> String {
    let file = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let text = |text: &str| toml::Value::String(text.to_owned()).to_string();
    format!(
        "[[models]]\nname = {name}\npath = {file}\n[[instances]]\nmodel = {name}\n",
        name = text(name),
        file = text(&file)
    )
}

fn centre_of(polygon: [[f32; 3]; 4]) -> Vec3 {
    polygon.into_iter().map(Vec3::from_array).sum::<Vec3>() / 4.0
}

/// Two sides and the normal of a polygon.
fn frame_of(polygon: [[f32; 3]; 4]) -> Mat3 {
    let [a, b, _, d] = polygon.map(Vec3::from_array);
    Mat3::from_cols(b - a, d - a, (b - a).cross(d - a).normalize_or(Vec3::Y))
}
