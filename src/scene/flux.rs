//! The flux of lights.

use std::f32::consts::PI;

use glam::{Affine3A, Vec3};

use super::bounds::BoundingSphere;
use super::contents::{Pose, Scene};
use super::light::{Light, LightKind};

impl Light {
    /// Emitted flux in W, which its extent leaves as it is; `pose` places the instances of area lights. The flux of a
    /// directional light is that through a disc perpendicular to its direction that covers `bounds`, the scene's bounding
    /// sphere.
    pub fn flux(&self, scene: &Scene, pose: &Pose, bounds: &BoundingSphere) -> Vec3 {
        match &self.kind {
            LightKind::Point { intensity } => *intensity * (4.0 * PI),
            LightKind::Spot { intensity, inner_angle, outer_angle, falloff } => {
                // The falloff counts for its mean over its solid angle.
                let (inner, outer) = (inner_angle.cos(), outer_angle.cos());
                *intensity * (2.0 * PI * (1.0 - inner + falloff.mean() as f32 * (inner - outer)))
            }
            LightKind::Directional { irradiance } => *irradiance * (PI * bounds.radius * bounds.radius),
            LightKind::Area { instance, triangles } => {
                let mesh = &scene.meshes[scene.instances[*instance].mesh];
                let transform = &pose.instances[*instance];
                let power = triangles.iter().map(|emitter| {
                    let corners = emitter.interpolate(mesh.triangle_positions(emitter.triangle));
                    emitter.radiance.as_dvec3() * f64::from(world_area(corners, transform))
                });
                (power.sum::<glam::DVec3>() * std::f64::consts::PI).as_vec3()
            }
        }
    }
}

fn world_area(corners: [Vec3; 3], transform: &Affine3A) -> f32 {
    let [a, b, c] = corners.map(|corner| transform.transform_point3(corner));
    0.5 * (b - a).cross(c - a).length()
}
