//! What the files of a scene hold, kept so that an edited scene is built without reading them again.

use std::collections::HashMap;
use std::sync::Arc;

use super::schema::{EnvironmentEntry, ModelEntry, SceneFile};
use crate::scene::{EnvironmentMap, Material, Scene};

/// Models and the environment's map as they were read. Copies share meshes, textures and map.
#[derive(Clone, Debug, Default)]
pub struct ReadFiles {
    pub(super) models: Option<ReadModels>,
    pub(super) map: Option<ReadMap>,
}

/// The models of a scene file.
#[derive(Clone, Debug)]
pub(super) struct ReadModels {
    entries: Vec<ModelEntry>,
    /// Meshes, materials, textures, masks and warnings; nothing else.
    pub scene: Scene,
    /// Mesh of each model, by name.
    pub meshes: HashMap<String, usize>,
}

/// The map of an environment.
#[derive(Clone, Debug)]
pub(super) struct ReadMap {
    /// The entry without its numbers.
    entry: EnvironmentEntry,
    pub map: Option<Arc<EnvironmentMap>>,
    pub warnings: Vec<String>,
}

impl ReadModels {
    /// Number of the models.
    pub fn len(&self) -> usize {
        self.entries.len()
    }

    /// The models of `file` that were added to `scene`.
    pub fn new(file: &SceneFile, scene: &Scene, meshes: &HashMap<String, usize>) -> Self {
        let entries = entries(file);
        Self { entries, scene: scene.clone(), meshes: meshes.clone() }
    }
}

impl ReadMap {
    pub fn new(entry: &EnvironmentEntry, map: Option<Arc<EnvironmentMap>>, warnings: Vec<String>) -> Self {
        Self { entry: entry.without_numbers(), map, warnings }
    }
}

impl ReadFiles {
    /// The models, if `file` begins with them, or they with those of `file`: models are added and no longer used.
    pub(super) fn models_of(&self, file: &SceneFile) -> Option<&ReadModels> {
        let entries = entries(file);
        let alike =
            |models: &&ReadModels| models.entries.iter().zip(&entries).all(|(known, entry)| known == entry);
        self.models.as_ref().filter(alike)
    }

    /// The map, if it is that of `entry`.
    pub(super) fn map_of(&self, entry: &EnvironmentEntry) -> Option<&ReadMap> {
        self.map.as_ref().filter(|map| map.entry == entry.without_numbers())
    }

    /// What was read for `scene`, which is now written as `file`. A scene without a scene file is one model.
    pub(crate) fn named(self, file: &SceneFile, scene: &Scene) -> Self {
        let models = self.models.unwrap_or_else(|| {
            let names = file.models.iter().map(|model| model.name.clone());
            let parts = Scene {
                meshes: scene.meshes.clone(),
                materials: scene.materials.clone(),
                textures: scene.textures.clone(),
                alpha_masks: scene.alpha_masks.clone(),
                ..Scene::new(&scene.name)
            };
            ReadModels { entries: Vec::new(), scene: parts, meshes: names.zip(0..).collect() }
        });
        let map = file.environment.as_ref().map(|entry| {
            let map = scene.environment.as_ref().and_then(|environment| environment.map.clone());
            ReadMap::new(entry, map, Vec::new())
        });
        Self { models: Some(ReadModels { entries: entries(file), ..models }), map }
    }

    /// The materials of the models as their files have them: the first ones of the scene, before any edit.
    pub fn materials(&self) -> &[Material] {
        self.models.as_ref().map_or(&[], |models| &models.scene.materials)
    }
}

fn entries(file: &SceneFile) -> Vec<ModelEntry> {
    file.models.clone()
}
