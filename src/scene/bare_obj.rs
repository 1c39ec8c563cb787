//! A view and a light for an `.obj` that comes alone.
//!
//! In: a scene that holds the model. Out: the same with a camera in front of it, from which all of it is
//! seen, and a point light unless the model has emissive materials; a line for each is added to the
//! warnings, so that people know what was made up.

use glam::Vec3;

use super::camera::Camera;
use super::light::{Light, LightKind};
use super::{BoundingSphere, Scene};

/// From the model's middle towards the camera: in front, a little to the right and above.
const VIEW: Vec3 = Vec3::new(0.45, 0.35, 1.0);

/// From the model's middle to the light, in bounding radii.
const LIGHT: Vec3 = Vec3::new(0.6, 1.6, 1.2);

const VERTICAL_FOV_DEGREES: f32 = 40.0;

/// Places the camera so that the whole scene is in view, also in a square picture.
pub(super) fn frame(scene: &mut Scene) {
    let bounds = scene.bounding_sphere(&scene.pose(0.0));
    let half_fov = 0.5 * VERTICAL_FOV_DEGREES.to_radians();
    let distance = bounds.radius / half_fov.sin();
    let mut camera = Camera {
        vertical_fov: 2.0 * half_fov,
        ..Camera::looking(bounds.center + VIEW.normalize() * distance, bounds.center)
    };
    fit_depths(&mut camera, &bounds, 0.0);
    scene.camera = camera;
    scene.warnings.push(format!(
        "{}: no camera given; placed one at {:.3} that looks at {:.3}",
        scene.name, scene.camera.eye, scene.camera.target
    ));
}

/// Places a point light above and in front, unless there is a light.
pub(super) fn light(scene: &mut Scene) {
    if !scene.lights.is_empty() {
        return;
    }
    let bounds = scene.bounding_sphere(&scene.pose(0.0));
    let offset = LIGHT * bounds.radius;
    let position = bounds.center + offset;
    // An irradiance of pi in the middle: white paper there has radiance 1.
    let intensity = std::f32::consts::PI * offset.length_squared();
    scene.lights.push(Light {
        name: "made up".into(),
        kind: LightKind::Point { intensity: Vec3::splat(intensity) },
        position,
        direction: Vec3::NEG_Y,
        animation: None,
    });
    scene.warnings.push(format!(
        "{}: no light given; placed a point light of {intensity:.3} W/sr at {position:.3}",
        scene.name
    ));
}

/// Sets `near` and `far` so that all of `bounds` is drawn from wherever the eye comes within `reach`.
pub(super) fn fit_depths(camera: &mut Camera, bounds: &BoundingSphere, reach: f32) {
    let away = camera.eye.distance(bounds.center) + reach;
    camera.far = 1.01 * (away + bounds.radius);
    camera.near = 2e-4 * camera.far;
}
