//! The `[[lights]]` of a scene file.
//!
//! In: one entry. Out: a light in the scene under construction; an area light also becomes a mesh of two
//! emissive triangles and an instance of it, or makes an instance's triangles emissive.

use std::path::Path;

use glam::{Affine3A, Vec3};

use super::builder::Builder;
use super::entry::{At, Entry, degrees_of};
use super::motion::{animation_of, check_not_mirrored};
use super::schema::LightEntry;
use crate::formats::error::SceneError;
use crate::scene::{
    Instance, Light, LightKind, LightType, MAX_COORDINATE, Material, Mesh, Scene, SpotFalloff,
};

/// Adds the light of entry `index`.
pub(super) fn add_light(builder: &mut Builder, index: usize, light: &LightEntry) -> Result<(), SceneError> {
    let name = light.name.clone().unwrap_or_else(|| format!("light {}", builder.scene.lights.len() + 1));
    let entry = builder.entry(At::Entry("lights", index), format!("light \"{name}\""));
    check_keys(&entry, light)?;
    if light.kind == LightType::Area {
        return match &light.instance {
            Some(instance) => light_instance(builder, &entry, light, instance),
            None => add_quad(builder, &entry, light, &name),
        };
    }
    let light = plain_light(&entry, light, name)?;
    builder.scene.lights.push(light);
    Ok(())
}

/// A point, spot or directional light; the keys were checked.
fn plain_light(entry: &Entry, light: &LightEntry, name: String) -> Result<Light, SceneError> {
    let position = |key| entry.place(key, entry.required(key, light.position)?);
    let intensity = |key| entry.power(key, entry.required(key, light.intensity)?);
    let direction = |key| entry.direction(key, entry.required(key, light.direction)?);
    let (kind, position, direction) = match light.kind {
        LightType::Point => {
            (LightKind::Point { intensity: intensity("intensity")? }, position("position")?, Vec3::NEG_Y)
        }
        LightType::Spot => {
            (spot(entry, light, intensity("intensity")?)?, position("position")?, direction("direction")?)
        }
        LightType::Directional | LightType::Area => {
            let irradiance = entry.power("irradiance", entry.required("irradiance", light.irradiance)?)?;
            (LightKind::Directional { irradiance }, Vec3::ZERO, direction("direction")?)
        }
    };
    let (radius, half_angle) = extent(entry, light)?;
    let animation = animation_of(entry, light.animation.as_ref())?;
    Ok(Light { name, kind, position, direction, radius, half_angle, animation })
}

/// Radius and half angle (radians) of what shines.
fn extent(entry: &Entry, light: &LightEntry) -> Result<(f32, f32), SceneError> {
    let radius = light.radius.unwrap_or(0.0);
    if !(0.0..=MAX_COORDINATE).contains(&radius) {
        return Err(entry.error(format!("radius must be from 0 to {MAX_COORDINATE:e}, is {radius}")));
    }
    let degrees = light.angle_deg.unwrap_or(0.0);
    if !(0.0..=90.0).contains(&degrees) {
        return Err(entry.error(format!("angle_deg must be from 0 to 90, is {degrees}")));
    }
    Ok((radius, degrees.to_radians()))
}

/// The light of a single entry; none for an area light, which needs the scene.
pub(crate) fn single_light(path: &Path, light: &LightEntry) -> Result<Option<Light>, SceneError> {
    let name = light.name.clone().unwrap_or_else(|| "light".to_owned());
    let entry = Entry::edited(path, format!("light \"{name}\""));
    check_keys(&entry, light)?;
    match light.kind {
        LightType::Area => check_area(&entry, light).map(|()| None),
        _ => plain_light(&entry, light, name).map(Some),
    }
}

/// Validates an area light's entry, except for the instance that it may name.
fn check_area(entry: &Entry, light: &LightEntry) -> Result<(), SceneError> {
    entry.power("radiance", entry.required("radiance", light.radiance)?)?;
    animation_of(entry, light.animation.as_ref())?;
    match light.polygon {
        Some(polygon) => check_quad(entry, &corners_of(entry, polygon)?),
        None => Ok(()),
    }
}

fn corners_of(entry: &Entry, polygon: [[f32; 3]; 4]) -> Result<[Vec3; 4], SceneError> {
    let mut corners = [Vec3::ZERO; 4];
    for (corner, given) in corners.iter_mut().zip(polygon) {
        *corner = entry.place("polygon", given)?;
    }
    Ok(corners)
}

/// Adds area lights for the emissive instances that no light of the file names.
pub(super) fn add_emissive_instances(scene: &mut Scene) {
    for instance in 0..scene.instances.len() {
        let is_named =
            |light: &Light| matches!(light.kind, LightKind::Area { instance: i, .. } if i == instance);
        if !scene.lights.iter().any(is_named) {
            scene.add_area_light(instance);
        }
    }
}

fn check_keys(entry: &Entry, light: &LightEntry) -> Result<(), SceneError> {
    use LightType::{Area, Directional, Point, Spot};
    let polygon = light.polygon.is_some();
    for (key, given, kinds) in [
        ("position", light.position.is_some(), &[Point, Spot][..]),
        ("direction", light.direction.is_some(), &[Spot, Directional]),
        ("intensity", light.intensity.is_some(), &[Point, Spot]),
        ("irradiance", light.irradiance.is_some(), &[Directional]),
        ("inner_deg", light.inner_deg.is_some(), &[Spot]),
        ("outer_deg", light.outer_deg.is_some(), &[Spot]),
        ("radius", light.radius.is_some(), &[Point, Spot]),
        ("angle_deg", light.angle_deg.is_some(), &[Directional]),
        ("polygon", polygon, &[Area]),
        ("instance", light.instance.is_some(), &[Area]),
        ("radiance", light.radiance.is_some(), &[Area]),
        ("visible", light.visible.is_some(), &[Area]),
    ] {
        if given && !kinds.contains(&light.kind) {
            return Err(
                entry.error(format!("the key {key} is not allowed for a light of this type; remove it"))
            );
        }
    }
    if light.kind == Area && polygon == light.instance.is_some() {
        return Err(entry.error("an area light needs exactly one of the keys polygon and instance"));
    }
    if light.instance.is_some() && (light.visible.is_some() || light.animation.is_some()) {
        return Err(entry.error("set visible and animation at the instance that this light names"));
    }
    Ok(())
}

fn spot(entry: &Entry, light: &LightEntry, intensity: Vec3) -> Result<LightKind, SceneError> {
    let outer = entry.number("outer_deg", entry.required("outer_deg", light.outer_deg)?)?;
    let inner = entry.number("inner_deg", light.inner_deg.unwrap_or(0.8 * outer))?;
    if !(inner >= 0.0 && inner < outer && outer < 180.0) {
        return Err(entry.error(format!(
            "cone half angles must be 0 <= inner_deg < outer_deg < 180 (inner {inner}, outer {outer})"
        )));
    }
    Ok(LightKind::Spot {
        intensity,
        inner_angle: inner.to_radians(),
        outer_angle: outer.to_radians(),
        falloff: SpotFalloff::Smooth,
    })
}

/// Adds a quad as an area light, with its centre as origin, so that animation rotates it about its centre.
fn add_quad(builder: &mut Builder, entry: &Entry, light: &LightEntry, name: &str) -> Result<(), SceneError> {
    let radiance = entry.power("radiance", entry.required("radiance", light.radiance)?)?;
    let polygon = entry.required("polygon", light.polygon)?;
    let corners = corners_of(entry, polygon)?;
    check_quad(entry, &corners)?;
    let centre = corners.iter().sum::<Vec3>() / 4.0;
    let animation = animation_of(entry, light.animation.as_ref())?;
    let scene = &mut builder.scene;
    let material = scene.materials.len() as u32;
    scene.materials.push(Material::emitter(name, radiance));
    let mesh = Mesh::polygon(name, &corners.map(|corner| corner - centre), material);
    scene.meshes.push(mesh.into());
    scene.instances.push(Instance {
        dynamic: animation.is_some(),
        animation,
        visible: light.visible.unwrap_or(true),
        ..Instance::fixed(name, scene.meshes.len() - 1, Affine3A::from_translation(centre))
    });
    scene.add_area_light(scene.instances.len() - 1);
    Ok(())
}

fn check_quad(entry: &Entry, corners: &[Vec3; 4]) -> Result<(), SceneError> {
    let normal_at = |i: usize| {
        let (before, here, after) = (corners[(i + 3) % 4], corners[i], corners[(i + 1) % 4]);
        (here - before).cross(after - here).try_normalize()
    };
    let normals: Vec<Vec3> = (0..4).filter_map(normal_at).collect();
    // Collinear corners have no normal, and those of a bow tie have opposite ones.
    if normals.len() < 4 || normals.iter().any(|normal| normal.dot(normals[0]) < 0.99) {
        return Err(entry.error("polygon must be a flat convex quad of four distinct corners in order"));
    }
    Ok(())
}

/// Makes all triangles of an instance emissive, with its own copy of mesh and materials.
fn light_instance(
    builder: &mut Builder,
    entry: &Entry,
    light: &LightEntry,
    instance: &str,
) -> Result<(), SceneError> {
    let Some(&index) = builder.instances.get(instance) else {
        return Err(entry.error(format!("unknown instance \"{instance}\"")));
    };
    let radiance = entry.power("radiance", entry.required("radiance", light.radiance)?)?;
    let scene = &mut builder.scene;
    check_not_mirrored(entry, &scene.instances[index].transform, true)?;
    let mut mesh = Mesh::clone(&scene.meshes[scene.instances[index].mesh]);
    let mut emissive = std::collections::HashMap::new();
    for material in &mut mesh.triangle_materials {
        *material = *emissive.entry(*material).or_insert_with(|| {
            let plain = scene.materials[*material as usize].clone();
            // As for emissive MTL materials, `d` does not hide an emissive surface.
            let alpha_mask = plain.alpha_mask.filter(|&mask| !scene.alpha_masks[mask].is_empty());
            let emission = Material { emission: radiance, emission_texture: None, ..plain };
            scene.materials.push(Material { alpha_mask, ..emission });
            scene.materials.len() as u32 - 1
        });
    }
    scene.instances[index].mesh = scene.meshes.len();
    scene.meshes.push(mesh.into());
    let before = scene.lights.len();
    scene.add_area_light(index);
    if let (Some(name), Some(added)) = (&light.name, scene.lights.get_mut(before)) {
        added.name.clone_from(name);
    }
    Ok(())
}

/// The entry of a light; none for an area light.
pub(crate) fn entry_of(light: &Light) -> Option<LightEntry> {
    let entry = LightEntry { name: Some(light.name.clone()), ..LightEntry::of(LightType::Point) };
    let radius = (light.radius > 0.0).then_some(light.radius);
    let (position, direction) = (Some(light.position.to_array()), Some(light.direction.to_array()));
    match &light.kind {
        LightKind::Point { intensity } => {
            Some(LightEntry { position, intensity: Some(intensity.to_array()), radius, ..entry })
        }
        LightKind::Spot { intensity, inner_angle, outer_angle, .. } => Some(LightEntry {
            kind: LightType::Spot,
            position,
            direction,
            intensity: Some(intensity.to_array()),
            inner_deg: Some(degrees_of(*inner_angle)),
            outer_deg: Some(degrees_of(*outer_angle)),
            radius,
            ..entry
        }),
        LightKind::Directional { irradiance } => Some(LightEntry {
            kind: LightType::Directional,
            direction,
            irradiance: Some(irradiance.to_array()),
            angle_deg: (light.half_angle > 0.0).then(|| degrees_of(light.half_angle)),
            ..entry
        }),
        LightKind::Area { .. } => None,
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]
mod tests {
    use super::*;

    #[test]
    fn the_entry_of_a_light_makes_that_light() {
        let intensity = Vec3::new(1.0, 2.0, 3.0);
        for (kind, direction, [radius, half_angle]) in [
            (LightKind::Point { intensity }, Vec3::NEG_Y, [0.7, 0.0]),
            (
                LightKind::Spot {
                    intensity,
                    inner_angle: 0.2,
                    outer_angle: 0.5,
                    falloff: SpotFalloff::Smooth,
                },
                Vec3::X,
                [0.3, 0.0],
            ),
            (LightKind::Directional { irradiance: intensity }, Vec3::Z, [0.0, 0.123_456_79]),
        ] {
            let position = if half_angle > 0.0 { Vec3::ZERO } else { Vec3::new(0.1, 0.2, 0.3) };
            let name = "sun".to_owned();
            let light = Light { name, kind, position, direction, radius, half_angle, animation: None };
            let entry = entry_of(&light).unwrap();
            assert_eq!(single_light(Path::new("a.toml"), &entry).unwrap().unwrap(), light);
        }
    }
}
