//! Built-in scenes: the Cornell box, procedural models, and the embedded scene files of `scenes/`, which place, light
//! and animate procedural or downloadable models.

mod atrium;
mod atrium_plan;
mod atrium_upper;
mod carving;
mod cathedral;
mod cathedral_ends;
mod cathedral_plan;
mod cathedral_windows;
mod chairs;
#[cfg(test)]
mod checks;
mod cloth;
mod columns;
mod cornell;
mod drapery;
mod fittings;
mod furniture;
mod material_grid;
mod meeting_paints;
mod meeting_room;
mod noise;
mod palette;
mod part;
mod paths;
mod pictures;
mod plants;
mod shapes;
mod sky;
mod stone;
#[cfg(test)]
mod tests;
mod textile;
mod torus;
mod vault;
mod walls;
mod wood;

pub(crate) use cornell::cornell_box;
pub(crate) use sky::sky;

use std::sync::Arc;

use crate::scene::{AlphaMask, Material, Mesh, Scene, Texture};
use palette::Palette;
use part::Part;

/// Names of the built-in scenes.
pub const NAMES: [&str; 16] = [
    "playroom",
    "cornell-box",
    "atrium",
    "atrium-drapery",
    "cathedral",
    "meeting-room",
    "material-grid",
    "sponza",
    "crytek-sponza",
    "sibenik",
    "sibenik-spot",
    "conference",
    "conference-torus",
    "classroom",
    "living-room",
    "damaged-helmet",
];

/// The scenes of the benchmark: those of Tonna 2019, figure 24, or procedural substitutes.
pub const BENCH_SCENES: [&str; 5] = ["cornell-box", "atrium", "atrium-drapery", "cathedral", "meeting-room"];

/// The scenes of the benchmark with the original models, which are not shipped.
pub const BENCH_SCENES_OF_ASSETS: [&str; 5] =
    ["cornell-box", "sponza", "crytek-sponza", "sibenik-spot", "conference-torus"];

/// Names of the procedural models, for the key `builtin` in scene files.
pub(crate) const MODELS: [&str; 7] = [
    "cornell-box",
    "material-grid",
    "atrium",
    "atrium-drapery",
    "cathedral",
    "meeting-room",
    "two-coloured torus",
];

/// The embedded scene file of a built-in scene, if it has one.
pub(crate) fn scene_file(name: &str) -> Option<&'static str> {
    match name {
        "playroom" => Some(include_str!("../../scenes/playroom.toml")),
        "atrium" => Some(include_str!("../../scenes/atrium.toml")),
        "atrium-drapery" => Some(include_str!("../../scenes/atrium-drapery.toml")),
        "cathedral" => Some(include_str!("../../scenes/cathedral.toml")),
        "meeting-room" => Some(include_str!("../../scenes/meeting-room.toml")),
        "material-grid" => Some(include_str!("../../scenes/material-grid.toml")),
        "sponza" => Some(include_str!("../../scenes/sponza.toml")),
        "crytek-sponza" => Some(include_str!("../../scenes/crytek-sponza.toml")),
        "sibenik" => Some(include_str!("../../scenes/sibenik.toml")),
        "sibenik-spot" => Some(include_str!("../../scenes/sibenik-spot.toml")),
        "conference" => Some(include_str!("../../scenes/conference.toml")),
        "conference-torus" => Some(include_str!("../../scenes/conference-torus.toml")),
        "classroom" => Some(include_str!("../../scenes/classroom.toml")),
        "living-room" => Some(include_str!("../../scenes/living-room.toml")),
        "damaged-helmet" => Some(include_str!("../../scenes/damaged-helmet.toml")),
        _ => None,
    }
}

/// A procedural mesh with its materials, textures and masks; indices start at 0.
pub(crate) struct Model {
    mesh: Mesh,
    materials: Vec<Material>,
    textures: Vec<Texture>,
    alpha_masks: Vec<AlphaMask>,
}

/// The model of this name, one of [`MODELS`].
pub(crate) fn model(name: &str) -> Option<Model> {
    let plain = match name {
        "cornell-box" => Some(cornell::cornell_model()),
        "material-grid" => Some(material_grid::model()),
        _ => None,
    };
    if let Some((mesh, materials)) = plain {
        return Some(Model { mesh, materials, textures: vec![], alpha_masks: vec![] });
    }
    let mut palette = Palette::default();
    let part = assemble(name, &mut palette)?;
    let paints = palette.finish();
    Some(Model {
        mesh: part.into_mesh(name, &paints.tiles),
        materials: paints.materials,
        textures: paints.textures,
        alpha_masks: paints.alpha_masks,
    })
}

/// The solids and open surfaces of a model.
fn assemble(name: &str, palette: &mut Palette) -> Option<Part> {
    match name {
        "atrium" => {
            let paints = atrium_plan::Paints::new(palette);
            let lower = atrium::lower_column(&paints, 14).part();
            let upper = atrium_upper::column(&paints, 8).part();
            Some(atrium::building(&paints, [&lower, &upper]))
        }
        "atrium-drapery" => Some(drapery::model(palette)),
        "cathedral" => Some(cathedral::model(palette)),
        "meeting-room" => Some(meeting_room::model(palette)),
        "two-coloured torus" => Some(torus::model(palette)),
        _ => None,
    }
}

impl Model {
    /// Adds it to a scene; returns the index of its mesh.
    pub fn add_to(mut self, scene: &mut Scene) -> usize {
        let (materials, textures, masks) =
            (scene.materials.len(), scene.textures.len(), scene.alpha_masks.len());
        for material in &mut self.mesh.triangle_materials {
            *material += materials as u32;
        }
        for material in &mut self.materials {
            if let Some(texture) = &mut material.base_colour_texture {
                texture.texture += textures;
            }
            material.alpha_mask = material.alpha_mask.map(|mask| mask + masks);
        }
        scene.materials.extend(self.materials);
        scene.textures.extend(self.textures.into_iter().map(Arc::new));
        scene.alpha_masks.extend(self.alpha_masks);
        scene.meshes.push(self.mesh.into());
        scene.meshes.len() - 1
    }
}
