//! The `[environment]` of a scene file.
//!
//! In: its entry. Out: the environment, with its map read; warnings of what was wrong in that.

use std::path::Path;
use std::sync::Arc;

use glam::Vec3;

use super::environment::{Environment, EnvironmentMap};
use super::error::SceneError;
use super::scene_build::{Builder, Entry};
use super::scene_file::EnvironmentEntry;

/// Builds the environment of an entry.
pub(super) fn environment_of(
    builder: &mut Builder,
    entry: &Entry,
    given: &EnvironmentEntry,
) -> Result<Environment, SceneError> {
    let strength = entry.number("strength", given.strength.unwrap_or(1.0))?;
    if strength < 0.0 {
        return Err(entry.error(format!("strength must not be negative, is {strength}")));
    }
    let file = match (&given.map, &given.asset) {
        (Some(_), Some(_)) => return Err(entry.error("needs at most one of the keys map and asset")),
        (Some(map), None) => Some(builder.path.parent().unwrap_or(Path::new("")).join(map)),
        (None, Some(asset)) => match builder.assets {
            Some(folder) => Some(folder.join(asset)),
            None => {
                return Err(entry.error(format!(
                    "asset {} is not shipped; set --assets or GLOWWORM_ASSETS to the folder that holds it",
                    asset.display()
                )));
            }
        },
        (None, None) => None,
    };
    let colour = match (given.colour, &file) {
        (Some(colour), _) => entry.power("colour", colour)?,
        (None, Some(_)) => Vec3::ONE,
        (None, None) => return Err(entry.error("needs a colour, a map or an asset")),
    };
    let radiance = colour * strength;
    if !radiance.is_finite() {
        return Err(entry.error("colour times strength is too large"));
    }
    let rotation = entry.number("rotation_deg", given.rotation_deg.unwrap_or(0.0))?.to_radians();
    let Some(file) = file else { return Ok(Environment::constant(radiance)) };
    let (map, replaced) = EnvironmentMap::read(&file)
        .map_err(|problem| entry.error(format!("map {} {problem}", file.display())))?;
    if replaced > 0 {
        let line =
            format!("{}: {replaced} texels are not finite or negative; they are black", file.display());
        builder.scene.warnings.push(line);
    }
    Ok(Environment { radiance, map: Some(Arc::new(map)), rotation })
}
