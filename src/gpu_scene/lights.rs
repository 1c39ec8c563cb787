//! Point, spot and directional lights as shaders read them.

use super::structs::LightData;
use crate::scene::{Light, LightKind, Pose, SpotFalloff};

/// The lights of a pose that have no area, in the scene's order; with their extent where shadows are soft.
pub fn lights_of(pose: &Pose, soft: bool) -> Vec<LightData> {
    let extent =
        |light: LightData| if soft { light } else { LightData { radius: 0.0, half_angle: 0.0, ..light } };
    pose.lights.iter().filter_map(light_data).map(extent).collect()
}

fn light_data(light: &Light) -> Option<LightData> {
    let (kind, power, inner, outer) = match light.kind {
        LightKind::Point { intensity } => (0, intensity, 0.0, 0.0),
        LightKind::Spot { intensity, inner_angle, outer_angle, falloff } => (
            if falloff == SpotFalloff::Smooth { 1 } else { 3 },
            intensity,
            inner_angle.cos(),
            outer_angle.cos(),
        ),
        LightKind::Directional { irradiance } => (2, irradiance, 0.0, 0.0),
        LightKind::Area { .. } => return None,
    };
    Some(LightData {
        position: light.position.extend(inner),
        direction: light.direction.extend(outer),
        power: power.extend(0.0),
        kind,
        radius: light.radius,
        half_angle: light.half_angle,
        ..LightData::default()
    })
}
