//! The `[environment]` of a scene file.
//!
//! In: its entry. Out: the environment, with its map read; warnings of what was wrong in that.

use std::path::Path;
use std::sync::Arc;

use glam::Vec3;

use super::builder::Builder;
use super::entry::Entry;
use super::models;
use super::read_files::ReadMap;
use super::schema::{EnvironmentEntry, SKY};
use crate::builtin;
use crate::formats::environment_map;
use crate::formats::error::SceneError;
use crate::scene::{Environment, EnvironmentMap};

/// Builds the environment of an entry.
pub(super) fn environment_of(
    builder: &mut Builder,
    entry: &Entry,
    given: &EnvironmentEntry,
) -> Result<Environment, SceneError> {
    let keys = [given.map.is_some(), given.asset.is_some(), given.builtin.is_some()];
    if keys.iter().filter(|given| **given).count() > 1 {
        return Err(entry.error("needs at most one of the keys map, asset and builtin"));
    }
    let (radiance, rotation) = numbers_of(entry, given)?;
    Ok(Environment { radiance, map: map_of(builder, entry, given)?, rotation })
}

/// Radiance, W/m^2/sr, or with a map its factor; and rotation, radians.
pub(crate) fn numbers_of(entry: &Entry, given: &EnvironmentEntry) -> Result<(Vec3, f32), SceneError> {
    let strength = entry.number("strength", given.strength.unwrap_or(1.0))?;
    if strength < 0.0 {
        return Err(entry.error(format!("strength must not be negative, is {strength}")));
    }
    let colour = match (given.colour, given.has_map()) {
        (Some(colour), _) => entry.power("colour", colour)?,
        (None, true) => Vec3::ONE,
        (None, false) => return Err(entry.error("needs a colour, a map, an asset or a builtin")),
    };
    let radiance = colour * strength;
    if !radiance.is_finite() {
        return Err(entry.error("colour times strength is too large"));
    }
    let rotation = entry.number("rotation_deg", given.rotation_deg.unwrap_or(0.0))?.to_radians();
    Ok((radiance, rotation))
}

/// The map of an entry, if it has one; that which was read last is not read again.
fn map_of(
    builder: &mut Builder,
    entry: &Entry,
    given: &EnvironmentEntry,
) -> Result<Option<Arc<EnvironmentMap>>, SceneError> {
    if let Some(known) = builder.read.map_of(given) {
        builder.scene.warnings.extend(known.warnings.iter().cloned());
        return Ok(known.map.clone());
    }
    let (map, warnings) = read_map(builder, entry, given)?;
    builder.scene.warnings.extend(warnings.iter().cloned());
    builder.read.map = Some(ReadMap::new(given, map.clone(), warnings));
    Ok(map)
}

/// Reads or makes a map; the warnings say what is not as in its file.
fn read_map(
    builder: &Builder,
    entry: &Entry,
    given: &EnvironmentEntry,
) -> Result<(Option<Arc<EnvironmentMap>>, Vec<String>), SceneError> {
    let file = if let Some(name) = &given.builtin {
        return match name.as_str() {
            SKY => Ok((builtin::sky().map, Vec::new())),
            _ => Err(entry.error(format!("unknown builtin \"{name}\"; the only one is \"{SKY}\""))),
        };
    } else if let Some(map) = &given.map {
        builder.path.parent().unwrap_or(Path::new("")).join(map)
    } else if let Some(asset) = &given.asset {
        models::find_asset(builder, asset, given.download.as_ref())?
    } else {
        return Ok((None, Vec::new()));
    };
    let read = environment_map::read(&file)
        .map_err(|problem| entry.error(format!("map {} {problem}", file.display())))?;
    let warnings = read.changes.iter().map(|change| format!("{}: {change}", file.display())).collect();
    Ok((Some(Arc::new(read.map)), warnings))
}
