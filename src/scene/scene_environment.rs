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
use super::{builtin, environment_file, scene_models};

/// Name of the map made by code.
pub(super) const SKY: &str = "sky";

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
    let keys = [given.map.is_some(), given.asset.is_some(), given.builtin.is_some()];
    if keys.iter().filter(|given| **given).count() > 1 {
        return Err(entry.error("needs at most one of the keys map, asset and builtin"));
    }
    let map = map_of(builder, entry, given)?;
    let colour = match (given.colour, &map) {
        (Some(colour), _) => entry.power("colour", colour)?,
        (None, Some(_)) => Vec3::ONE,
        (None, None) => return Err(entry.error("needs a colour, a map, an asset or a builtin")),
    };
    let radiance = colour * strength;
    if !radiance.is_finite() {
        return Err(entry.error("colour times strength is too large"));
    }
    let rotation = entry.number("rotation_deg", given.rotation_deg.unwrap_or(0.0))?.to_radians();
    Ok(Environment { radiance, map, rotation })
}

/// The map of an entry, if it has one.
fn map_of(
    builder: &mut Builder,
    entry: &Entry,
    given: &EnvironmentEntry,
) -> Result<Option<Arc<EnvironmentMap>>, SceneError> {
    let file = if let Some(name) = &given.builtin {
        return match name.as_str() {
            SKY => Ok(builtin::sky().map),
            _ => Err(entry.error(format!("unknown builtin \"{name}\"; the only one is \"{SKY}\""))),
        };
    } else if let Some(map) = &given.map {
        builder.path.parent().unwrap_or(Path::new("")).join(map)
    } else if let Some(asset) = &given.asset {
        scene_models::find_asset(builder, asset, given.download.as_ref())?
    } else {
        return Ok(None);
    };
    let read = environment_file::read(&file)
        .map_err(|problem| entry.error(format!("map {} {problem}", file.display())))?;
    let warnings = read.changes.iter().map(|change| format!("{}: {change}", file.display()));
    builder.scene.warnings.extend(warnings);
    Ok(Some(Arc::new(read.map)))
}
