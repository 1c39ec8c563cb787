//! A default camera and light for a bare model.
//!
//! In: a scene with the model, and what the file has of a camera and lights. Out: the scene with a camera, in front of the
//! model or, if that shows more of its surface, inside; and, unless its own lights light the view, a soft sky, or a point
//! light where the sky hardly reaches. A warning reports each that was made up.

mod lights;
mod parts;
mod samples;
mod survey;

use glam::Vec3;

use crate::builtin;
use crate::scene::{BoundingSphere, Camera, CameraOverride, Light, LightKind, Scene};
use survey::ModelSurvey;

/// Least radius of a model: squares of lengths in smaller ones are zero.
const LEAST_RADIUS: f32 = 1e-15;

/// Direction from the model's centre to the camera: in front, slightly to the right and above.
const VIEW: Vec3 = Vec3::new(0.45, 0.35, 1.0);

const VERTICAL_FOV_DEGREES: f32 = 40.0;

/// A view from inside is preferred if it shows at least this fraction of the surface that the view from outside shows:
/// the hull of an interior is visible from outside, too.
const INSIDE_PREFERENCE: f32 = 0.8;

/// The same where there is less room inside than the model's parts take: a hollow object is shown from outside, unless only back
/// faces are seen there.
const HOLLOW_PREFERENCE: f32 = 2.0;

/// Fraction of the visible surface that the model's own lights must light, so that no light is added.
const MIN_LIT_FRACTION: f32 = 0.5;

/// Fraction of the directions above the visible surface that must lead to the sky, so that it is the light.
const MIN_OPEN_FRACTION: f32 = 0.3;

/// Places a camera unless the file has one (`given`) or `seen_by` an eye point,
/// and a light unless its own light what is seen. The error completes a sentence about the file.
pub(crate) fn add_default_camera_and_light(
    scene: &mut Scene,
    given: Option<Camera>,
    seen_by: &CameraOverride,
) -> Result<(), String> {
    let radius = bounds_of(scene).radius;
    if radius < LEAST_RADIUS {
        return Err(format!("has hardly any extent (its radius is {radius:e}); scale the model up"));
    }
    match given {
        Some(camera) => scene.camera = camera,
        None => place_in_front(scene),
    }
    let is_placed = given.is_none() && seen_by.eye.is_none();
    let mut seen = scene.clone();
    // One that cannot be is told where it is applied.
    let _ = seen.override_camera(seen_by);
    let survey = ModelSurvey::new(&seen);
    let outside_shows = survey.shown_by(&seen.camera);
    let inside = if is_placed { survey.best_view() } else { None };
    let inside = inside.filter(|view| {
        view.shown > outside_shows * if view.is_roomy { INSIDE_PREFERENCE } else { HOLLOW_PREFERENCE }
    });
    let camera = inside.as_ref().map_or(seen.camera, |view| view.camera);
    let nearest = survey.nearest_in(&camera);
    let lit = !scene.lights.is_empty() && survey.lit_by_own_lights(&camera) >= MIN_LIT_FRACTION;
    let is_open = survey.open_to_sky(&camera) >= MIN_OPEN_FRACTION;
    let light = if lit || is_open { None } else { survey.best_light(&camera) };
    survey.into_bvh().keep(scene);
    if inside.is_some() {
        place_inside(scene, camera, nearest);
    }
    if is_placed {
        warn_of_camera(scene, if inside.is_some() { "inside" } else { "in front" });
    }
    if let Some(place) = light {
        add_light(scene, place.position, place.intensity);
    } else if !lit {
        add_sky(scene);
    }
    Ok(())
}

fn bounds_of(scene: &Scene) -> BoundingSphere {
    scene.bounding_sphere(&scene.pose(0.0))
}

/// Sets a camera inside the model, with a near plane in front of the nearest visible surface, at distance `nearest`.
fn place_inside(scene: &mut Scene, mut camera: Camera, nearest: Option<f32>) {
    camera.near = nearest.map_or(camera.near, |nearest| camera.near.min(0.25 * nearest));
    scene.camera = camera;
}

fn warn_of_camera(scene: &mut Scene, place: &str) {
    let (eye, target) = (scene.camera.eye, scene.camera.target);
    let digits = decimals(bounds_of(scene).radius);
    scene.warnings.push(format!(
        "{}: no camera given; placed one {place} at {eye:.digits$} that looks at {target:.digits$}",
        scene.name
    ));
}

/// Decimals of which numbers of this size have about four digits, whatever the unit of the model.
fn decimals(size: f32) -> usize {
    (3.0 - size.log10().floor()).clamp(0.0, 20.0) as usize
}

/// Places the camera in front of the scene, with a warning.
pub(crate) fn frame(scene: &mut Scene) {
    place_in_front(scene);
    warn_of_camera(scene, "in front");
}

/// Places the camera so that the whole scene is in view, also in a square picture.
fn place_in_front(scene: &mut Scene) {
    let bounds = bounds_of(scene);
    let half_fov = 0.5 * VERTICAL_FOV_DEGREES.to_radians();
    let distance = bounds.radius / half_fov.sin();
    scene.camera = Camera {
        vertical_fov: 2.0 * half_fov,
        ..Camera::looking(bounds.center + VIEW.normalize() * distance, bounds.center)
    };
}

/// Why a light is made up.
fn need_of_light(scene: &Scene) -> &'static str {
    if scene.lights.is_empty() { "no light given" } else { "its own lights leave most of the view dark" }
}

fn add_sky(scene: &mut Scene) {
    let why = need_of_light(scene);
    let sky = builtin::sky();
    scene.environment = Some(sky);
    scene.warnings.push(format!("{}: {why}; put it under a soft sky", scene.name));
}

fn add_light(scene: &mut Scene, position: Vec3, intensity: f32) {
    let why = need_of_light(scene);
    let light = Light {
        name: "made up".into(),
        kind: LightKind::Point { intensity: Vec3::splat(intensity) },
        position,
        direction: Vec3::NEG_Y,
        radius: 0.0,
        half_angle: 0.0,
        animation: None,
    };
    // First, as lights of a scene file come before those of emissive materials.
    scene.lights.insert(0, light);
    let [digits, places] = [intensity, bounds_of(scene).radius].map(decimals);
    scene.warnings.push(format!(
        "{}: {why}; placed a point light of {intensity:.digits$} W/sr at {position:.places$}",
        scene.name
    ));
}
