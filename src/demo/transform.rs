//! Lights, instances and keys of the document, translated, rotated and scaled.

use glam::{Quat, Vec3};

use crate::formats::{AxisAngle, InstanceEntry, KeyframeEntry, LightEntry, RotationEntry, ScaleEntry};
use crate::scene::{Camera, Keyframe, LightType};

fn plus(place: [f32; 3], way: Vec3) -> [f32; 3] {
    (Vec3::from_array(place) + way).to_array()
}

/// An instance translated by `way`.
pub(super) fn moved_instance(entry: &InstanceEntry, way: Vec3) -> InstanceEntry {
    InstanceEntry { translation: Some(plus(entry.translation.unwrap_or_default(), way)), ..entry.clone() }
}

/// A rotation followed by `turn`.
fn turned(rotation: Option<RotationEntry>, turn: Quat) -> RotationEntry {
    let now = match rotation {
        None => Quat::IDENTITY,
        Some(RotationEntry::Euler(degrees)) => {
            let [x, y, z] = degrees.map(f32::to_radians);
            Quat::from_euler(glam::EulerRot::XYZEx, x, y, z)
        }
        Some(RotationEntry::AxisAngle(turn)) => Quat::from_axis_angle(
            Vec3::from_array(turn.axis).normalize_or(Vec3::Y),
            turn.degrees.to_radians(),
        ),
    };
    let (axis, angle) = (turn * now).normalize().to_axis_angle();
    RotationEntry::AxisAngle(AxisAngle { axis: axis.to_array(), degrees: angle.to_degrees() })
}

/// An instance rotated by `turn` after its own rotation.
pub(super) fn rotated_instance(entry: &InstanceEntry, turn: Quat) -> InstanceEntry {
    InstanceEntry { rotation: Some(turned(entry.rotation, turn)), ..entry.clone() }
}

/// A key at `time` of a motion that is `now` there.
pub(super) fn key_of(time: f64, now: &Keyframe) -> KeyframeEntry {
    let translation = (now.translation != Vec3::ZERO).then(|| now.translation.to_array());
    let rotation = (now.rotation.angle_between(Quat::IDENTITY) > 1e-4).then(|| turned(None, now.rotation));
    KeyframeEntry { time, translation, rotation }
}

/// A key whose object is translated by `way`.
pub(super) fn moved_key(key: &KeyframeEntry, way: Vec3) -> KeyframeEntry {
    KeyframeEntry { translation: Some(plus(key.translation.unwrap_or_default(), way)), ..key.clone() }
}

/// A key whose object is rotated by `turn` in its place.
pub(super) fn rotated_key(key: &KeyframeEntry, turn: Quat) -> KeyframeEntry {
    KeyframeEntry { rotation: Some(turned(key.rotation, turn)), ..key.clone() }
}

/// An instance larger by `factor` along all axes.
pub(super) fn scaled_instance(entry: &InstanceEntry, factor: f32) -> InstanceEntry {
    let scale = match entry.scale {
        Some(ScaleEntry::PerAxis(scale)) => ScaleEntry::PerAxis(scale.map(|axis| axis * factor)),
        Some(ScaleEntry::Uniform(scale)) => ScaleEntry::Uniform(scale * factor),
        None => ScaleEntry::Uniform(factor),
    };
    InstanceEntry { scale: Some(scale), ..entry.clone() }
}

/// A light translated by `way`.
pub(super) fn moved_light(entry: &LightEntry, way: Vec3) -> LightEntry {
    LightEntry {
        position: entry.position.map(|position| plus(position, way)),
        polygon: entry.polygon.map(|polygon| polygon.map(|corner| plus(corner, way))),
        ..entry.clone()
    }
}

/// Moves a light to the camera.
pub(super) fn carry(light: &mut LightEntry, camera: &Camera) {
    if matches!(light.kind, LightType::Point | LightType::Spot) {
        light.position = Some(camera.eye.to_array());
    }
    if matches!(light.kind, LightType::Spot | LightType::Directional) {
        light.direction = Some(camera.forward().to_array());
    }
}

/// A light rotated in its place.
pub(super) fn rotated_light(entry: &LightEntry, turn: Quat) -> LightEntry {
    LightEntry {
        direction: entry.direction.map(|direction| (turn * Vec3::from_array(direction)).to_array()),
        polygon: entry.polygon.map(|polygon| about_middle(polygon, |off| turn * off)),
        ..entry.clone()
    }
}

/// A light whose surface is larger by `factor`; what each part of it sends stays.
pub(super) fn scaled_light(entry: &LightEntry, factor: f32) -> LightEntry {
    LightEntry {
        radius: entry.radius.map(|radius| radius * factor),
        polygon: entry.polygon.map(|polygon| about_middle(polygon, |off| factor * off)),
        ..entry.clone()
    }
}

/// A polygon whose corners go where `place` puts them from its middle.
fn about_middle(polygon: [[f32; 3]; 4], place: impl Fn(Vec3) -> Vec3) -> [[f32; 3]; 4] {
    let middle = polygon.into_iter().map(Vec3::from_array).sum::<Vec3>() / 4.0;
    polygon.map(|corner| (middle + place(Vec3::from_array(corner) - middle)).to_array())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turns_of_an_instance_add_up() {
        let text = "model = \"m\"\nrotation = [0, 90, 0]";
        let entry: InstanceEntry = toml::from_str(text).unwrap();
        let turned = rotated_instance(&entry, Quat::from_rotation_y(30f32.to_radians()));
        let Some(RotationEntry::AxisAngle(turn)) = turned.rotation else { panic!() };
        assert!(Vec3::from_array(turn.axis).distance(Vec3::Y) < 1e-5 && (turn.degrees - 120.0).abs() < 1e-3);
    }

    #[test]
    fn a_larger_square_stays_in_its_place() {
        let polygon = Some([[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 0.0, 2.0], [0.0, 0.0, 2.0]]);
        let light = LightEntry { polygon, ..LightEntry::of(LightType::Area) };
        let larger = [[-1.0, 0.0, -1.0], [3.0, 0.0, -1.0], [3.0, 0.0, 3.0], [-1.0, 0.0, 3.0]];
        assert_eq!(scaled_light(&light, 2.0).polygon, Some(larger));
    }
}
