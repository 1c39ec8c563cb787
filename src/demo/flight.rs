//! Camera controller: fly, look, orbit, bookmarks.

use std::collections::BTreeMap;

use glam::{Quat, Vec3};
use winit::keyboard::KeyCode;

use crate::scene::Camera;

/// Radians per pixel.
const LOOK_SPEED: f32 = 0.004;
/// Speed factor with shift.
const RUN: f32 = 4.0;
/// Narrowest and widest vertical field of view, radians.
const FIELDS: [f32; 2] = [0.02, 2.4];
/// Limit of the cosine between view direction and up axis.
const STEEPEST: f32 = 0.998;

/// Speed in a scene of known scale, metres per second, and at most in radii of the scene per second.
const WALK: f32 = 2.0;
const FASTEST_WALK: f32 = 0.2;

/// State of the camera controller.
pub(super) struct Flight {
    /// Where the user moved the camera; none: the scene's own camera, which may be animated.
    pub moved: Option<Camera>,
    pub bookmarks: BTreeMap<usize, Camera>,
    /// Speed, scene units per second.
    pub speed: f32,
    metres_per_unit: Option<f32>,
    held: Vec<KeyCode>,
    pub running: bool,
}

impl Flight {
    /// A controller for a scene of this radius, scene units, and scale, if that is known.
    pub fn new(radius: f32, metres_per_unit: Option<f32>) -> Self {
        let walk = metres_per_unit.map_or(f32::INFINITY, |metres| WALK / metres);
        let speed = walk.min(FASTEST_WALK * radius);
        Self {
            moved: None,
            bookmarks: BTreeMap::new(),
            speed,
            metres_per_unit,
            held: Vec::new(),
            running: false,
        }
    }

    /// The speed, to be read.
    pub fn speed_text(&self) -> String {
        match self.metres_per_unit {
            Some(metres) => format!("{:.2} m/s", self.speed * metres),
            None => format!("{:.3} units/s", self.speed),
        }
    }

    /// The camera to draw with, given the scene's own.
    pub fn camera(&self, own: &Camera) -> Camera {
        self.moved.unwrap_or(*own)
    }

    /// Handles a key press or release.
    pub fn key(&mut self, code: KeyCode, pressed: bool) {
        self.held.retain(|held| *held != code);
        if pressed && direction_of(code).is_some() {
            self.held.push(code);
        }
    }

    /// Releases all keys, as when the window loses the focus.
    pub fn release(&mut self) {
        self.held.clear();
        self.running = false;
    }

    /// Moves by the held keys for `seconds`.
    pub fn advance(&mut self, own: &Camera, seconds: f32) {
        let direction: Vec3 = self.held.iter().filter_map(|code| direction_of(*code)).sum();
        let Some(direction) = direction.try_normalize() else { return };
        let mut camera = self.camera(own);
        let forward = camera.forward();
        let up = upright(&camera);
        let right = forward.cross(up).normalize_or(Vec3::X);
        let run = if self.running { RUN } else { 1.0 };
        let step =
            (right * direction.x + up * direction.y - forward * direction.z) * (self.speed * run * seconds);
        camera.eye += step;
        camera.target += step;
        self.moved = Some(camera);
    }

    /// Rotates the view direction by a pointer motion in pixels.
    pub fn look(&mut self, own: &Camera, pixels: [f32; 2]) {
        let mut camera = self.camera(own);
        let distance = camera.target.distance(camera.eye);
        let forward = turned(&camera, pixels.map(|delta| -delta * LOOK_SPEED));
        camera.target = camera.eye + forward * distance;
        self.moved = Some(camera);
    }

    /// Narrows the field of view by a tenth a notch.
    pub fn zoom(&mut self, own: &Camera, notches: f32) {
        let mut camera = self.camera(own);
        camera.vertical_fov = (camera.vertical_fov * 0.9f32.powf(notches)).clamp(FIELDS[0], FIELDS[1]);
        self.moved = Some(camera);
    }

    /// Orbits the camera around `pivot` by a pointer motion in pixels.
    pub fn orbit(&mut self, own: &Camera, pivot: Vec3, pixels: [f32; 2]) {
        let mut camera = self.camera(own);
        let before = camera.forward();
        let after = turned(&camera, pixels.map(|delta| -delta * LOOK_SPEED));
        let up = upright(&camera);
        let heading = |forward: Vec3| forward.reject_from(up).normalize_or(Vec3::NEG_Z);
        let yaw = Quat::from_rotation_arc(heading(before), heading(after));
        let pitch = Quat::from_rotation_arc(yaw * before, after);
        let turn = pitch * yaw;
        let distance = camera.target.distance(camera.eye);
        camera.eye = pivot + turn * (camera.eye - pivot);
        camera.target = camera.eye + after * distance;
        self.moved = Some(camera);
    }

    /// Changes the speed by wheel notches.
    pub fn change_speed(&mut self, notches: f32) {
        self.speed = (self.speed * 1.2f32.powf(notches)).clamp(1e-6, 1e9);
    }
}

/// Direction of a movement key, in camera axes.
fn direction_of(code: KeyCode) -> Option<Vec3> {
    match code {
        KeyCode::KeyW => Some(Vec3::NEG_Z),
        KeyCode::KeyS => Some(Vec3::Z),
        KeyCode::KeyA => Some(Vec3::NEG_X),
        KeyCode::KeyD => Some(Vec3::X),
        KeyCode::KeyQ => Some(Vec3::NEG_Y),
        KeyCode::KeyE => Some(Vec3::Y),
        _ => None,
    }
}

/// The world axis that is up for this camera. Scene files often give the camera's own up vector.
fn upright(camera: &Camera) -> Vec3 {
    let right = camera.forward().cross(camera.up);
    let level = right.normalize_or(Vec3::X).y.abs() < 1e-3;
    if level { Vec3::Y * camera.up.y.signum() } else { camera.up.normalize_or(Vec3::Y) }
}

/// The view direction after a rotation by angles (to the left, upwards).
fn turned(camera: &Camera, [left, upwards]: [f32; 2]) -> Vec3 {
    let up = upright(camera);
    let forward = Quat::from_axis_angle(up, left) * camera.forward();
    let right = forward.cross(up).normalize_or(Vec3::X);
    let tilted = Quat::from_axis_angle(right, upwards) * forward;
    if tilted.dot(up).abs() < STEEPEST { tilted.normalize() } else { forward.normalize() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn orbiting_keeps_the_distance_and_the_pivots_place() {
        let own = Camera::looking(Vec3::new(0.0, 1.0, 4.0), Vec3::ZERO);
        let pivot = Vec3::new(0.5, 0.2, 0.0);
        let mut flight = Flight::new(1.0, None);
        let place = |camera: &Camera| camera.view_matrix().transform_point3(pivot);
        let before = place(&own);
        for _ in 0..40 {
            flight.orbit(&own, pivot, [17.0, 5.0]);
        }
        let after = flight.camera(&own);
        assert!(after.eye.distance(own.eye) > 0.5);
        assert!(place(&after).distance(before) < 1e-3, "{before} {}", place(&after));
    }

    #[test]
    fn looking_never_turns_over() {
        let own = Camera::looking(Vec3::new(0.0, 1.0, 4.0), Vec3::ZERO);
        let mut flight = Flight::new(1.0, None);
        for _ in 0..500 {
            flight.look(&own, [3.0, 40.0]);
        }
        let camera = flight.camera(&own);
        assert!(camera.forward().y < -0.9 && camera.view_matrix().row(1).y > 0.0);
    }

    #[test]
    fn the_speed_is_that_of_a_walk_where_the_scale_is_known() {
        // A hall of 40 m in centimetres, a helmet in metres, and something of unknown scale.
        assert_eq!(Flight::new(2000.0, Some(0.01)).speed, 200.0);
        assert_eq!(Flight::new(2000.0, Some(0.01)).speed_text(), "2.00 m/s");
        assert_eq!(Flight::new(1.0, Some(1.0)).speed, 0.2);
        assert_eq!(Flight::new(2000.0, None).speed, 400.0);
    }

    #[test]
    fn keys_fly_until_let_go() {
        let own = Camera::looking(Vec3::new(0.0, 0.0, 4.0), Vec3::ZERO);
        let mut flight = Flight::new(1.0, None);
        flight.speed = 2.0;
        flight.key(KeyCode::KeyW, true);
        flight.advance(&own, 0.5);
        assert!((flight.camera(&own).eye.z - 3.0).abs() < 1e-5);
        flight.release();
        flight.advance(&own, 0.5);
        assert!((flight.camera(&own).eye.z - 3.0).abs() < 1e-5);
        flight.moved = None;
        assert_eq!(flight.camera(&own), own);
    }
}
