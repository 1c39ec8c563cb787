//! Transforms and animations of a scene file.
//!
//! In: entries. Out: where an object is, and how it moves.

use glam::{Affine3A, BVec3, EulerRot, Quat, Vec3};

use super::entry::Entry;
use super::schema::{AnimationEntry, InstanceEntry, RotationEntry, ScaleEntry};
use crate::formats::error::SceneError;
use crate::scene::{Animation, Keyframe, MAX_COORDINATE, Rotation};

/// Largest magnitude of a keyframe's time, seconds: about 30 years.
const MAX_TIME: f64 = 1e9;

/// Object to world of an instance at rest: scaled, rotated, then translated.
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
pub(super) fn check_extent(
    entry: &Entry,
    transform: &Affine3A,
    bounds: (Vec3, Vec3),
) -> Result<(), SceneError> {
    let (low, high) = bounds;
    let corner = |i: u32| Vec3::select(BVec3::new(i & 1 == 0, i & 2 == 0, i & 4 == 0), low, high);
    let farthest = (0..8).map(|i| transform.transform_point3(corner(i)).abs().max_element());
    if farthest.fold(0.0, f32::max) > MAX_COORDINATE {
        return Err(entry.error(format!("must lie within +-{MAX_COORDINATE:e}; scale it down")));
    }
    Ok(())
}

/// Fails for a mirrored emissive instance: mirroring flips the winding, which defines the emitting side.
pub(super) fn check_not_mirrored(entry: &Entry, transform: &Affine3A, emits: bool) -> Result<(), SceneError> {
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
    owner: &Entry,
    animation: Option<&AnimationEntry>,
) -> Result<Option<Animation>, SceneError> {
    let Some(animation) = animation else {
        return Ok(None);
    };
    let entry = owner.animation();
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
            ..Keyframe::default()
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
    Ok(Some(Animation { keyframes, rotation, repeat: animation.repeat, sampled: false }))
}
