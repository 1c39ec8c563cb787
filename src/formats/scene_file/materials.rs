//! The `[[materials]]` of a scene file, applied to the materials of the models.

use super::builder::Builder;
use super::entry::At;
use super::material_edit::MaterialEdit;
use crate::formats::error::SceneError;

/// Edits the materials of the models.
pub(super) fn edit_materials(builder: &mut Builder, edits: &[MaterialEdit]) -> Result<(), SceneError> {
    for (index, edit) in edits.iter().enumerate() {
        let name = &edit.name;
        let entry = builder.entry(At::Entry("materials", index), format!("material \"{name}\""));
        if edits[..index].iter().any(|other| other.name == *name) {
            return Err(entry.error("another entry has this name; join them"));
        }
        edit.check(&entry)?;
        let mut found = false;
        for material in builder.scene.materials.iter_mut().filter(|material| material.name == *name) {
            edit.apply(material);
            found = true;
        }
        if !found {
            return Err(entry.error("no model has a material of this name; correct it or remove the entry"));
        }
    }
    Ok(())
}
