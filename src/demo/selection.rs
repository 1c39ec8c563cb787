//! Selectable entries of the document: their names, their positions, and which one is at a position of the picture.

use glam::{Vec2, Vec3};

use super::action::{Entry, Selected};
use super::session::Session;
use crate::scene::{LightKind, LightType};

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

    /// The name of an entry, to be read.
    pub fn name_of(&self, selected: Selected) -> String {
        match selected {
            Selected::Light(index) => {
                let Some(light) = self.document.lights().nth(index) else { return String::new() };
                let name = light.name.clone().unwrap_or_else(|| format!("light {}", index + 1));
                format!("{name} ({})", label(light.kind))
            }
            Selected::Instance(index) => {
                let instance = self.document.instances().nth(index);
                instance.map_or_else(String::new, |known| known.name.as_ref().unwrap_or(&known.model).clone())
            }
        }
    }

    /// Current position of an entry, world space.
    pub fn place_of(&self, selected: Selected) -> Option<Vec3> {
        let place = |instance: usize| Some(self.pose.instances.get(instance)?.translation.into());
        let index = match selected {
            Selected::Instance(index) => return place(index),
            Selected::Light(index) => index,
        };
        if let Some(instance) = self.document.light_instance(index) {
            return place(instance);
        }
        let light = self.pose.lights.get(self.document.scene_light(index)?)?;
        match light.kind {
            LightKind::Point { .. } | LightKind::Spot { .. } => Some(light.position),
            // It has no position; place its handles at the scene's centre.
            LightKind::Directional { .. } => {
                let (low, high) = self.renderer.bounds();
                Some(0.5 * (low + high))
            }
            LightKind::Area { instance, .. } => place(instance),
        }
    }

    /// The entry that moves with a selected one: the instance that an area light names, or else the entry itself.
    pub fn animated(&self, selected: Selected) -> Selected {
        let Selected::Light(index) = selected else { return selected };
        let light = self.document.lights().nth(index);
        let instance = light
            .and_then(|light| light.instance.as_ref())
            .and_then(|name| self.document.instances().position(|instance| instance.shown_name() == name));
        instance.map_or(selected, Selected::Instance)
    }

    /// The entry whose surface is at a position of the picture; none for what surrounds the camera, so that no click moves a building.
    pub fn selected_at(&self, at: Vec2) -> Option<Selected> {
        let instance =
            self.pick(at).map(|picked| picked.instance).filter(|instance| !self.surrounds(*instance))?;
        if instance < self.document.instances().len() {
            return Some(Selected::Instance(instance));
        }
        let mut lights = 0..self.document.lights().len();
        lights.find(|&light| self.document.light_instance(light) == Some(instance)).map(Selected::Light)
    }

    /// Whether the camera is inside of an instance's bounds.
    fn surrounds(&self, instance: usize) -> bool {
        let (Some(known), Some(transform)) =
            (self.scene.instances.get(instance), self.pose.instances.get(instance))
        else {
            return false;
        };
        let mesh = &self.scene.meshes[known.mesh];
        let (low, high) = mesh.bounds();
        let eye = transform.inverse().transform_point3(self.pose.camera.eye);
        eye.cmpge(low).all() && eye.cmple(high).all()
    }
}

/// Name of a kind of light.
pub(super) fn label(kind: LightType) -> &'static str {
    match kind {
        LightType::Point => "point",
        LightType::Spot => "spot",
        LightType::Directional => "directional",
        LightType::Area => "area",
    }
}
