//! A pinhole camera.

use glam::{Mat3A, Mat4, Quat, Vec2, Vec3, Vec4};
use serde::{Deserialize, Serialize};

use super::animation::Motion;

/// Least sine of the angle between view direction and up vector.
const LEAST_SINE: f32 = 1e-4;

/// A pinhole camera. Right-handed world space, y up.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Camera {
    /// Eye point, world space.
    pub eye: Vec3,
    /// A point at the centre of the picture.
    pub target: Vec3,
    /// Up vector; not parallel to the view direction.
    pub up: Vec3,
    /// Vertical field of view, radians.
    pub vertical_fov: f32,
    /// View depth of the near plane, > 0.
    pub near: f32,
    /// View depth of the far plane, > near; infinity: none.
    pub far: f32,
    /// How far the pixels' rays are shifted to the right and down, where the picture reaches from -1 to 1: for antialiasing.
    #[serde(skip)]
    pub shift: Vec2,
}

impl Camera {
    /// A camera at `eye` that looks at `target`, y up, with 40 degrees of vertical field of view, no far plane, and a near plane at a
    /// small part of the distance between the two: reversed depth in floats is as precise with any.
    pub fn looking(eye: Vec3, target: Vec3) -> Self {
        let distance = eye.distance(target);
        Self {
            eye,
            target,
            up: Vec3::Y,
            vertical_fov: 40f32.to_radians(),
            near: 1e-5 * distance,
            far: f32::INFINITY,
            shift: Vec2::ZERO,
        }
    }

    /// This camera moved by `motion`. A motion that stretches view direction and up vector onto one line only turns them.
    pub fn moved(&self, motion: &Motion) -> Self {
        let eye = motion.position;
        let way = self.target - self.eye;
        let [forward, up] = [way, self.up].map(|direction| motion.turn(direction));
        if (motion.rotation, motion.stretch) == (Quat::IDENTITY, Mat3A::IDENTITY) {
            return Self { eye, target: self.target + (eye - self.eye), ..*self };
        }
        if forward.normalize_or_zero().cross(up.normalize_or_zero()).length() < LEAST_SINE {
            return Self { eye, target: eye + motion.rotation * way, up: motion.rotation * self.up, ..*self };
        }
        Self { eye, target: eye + forward, up, ..*self }
    }

    /// Unit view direction.
    pub fn forward(&self) -> Vec3 {
        (self.target - self.eye).normalize_or(Vec3::NEG_Z)
    }

    /// World to view: x right, y up, looking down -z.
    pub fn view_matrix(&self) -> Mat4 {
        glam::camera::rh::view::look_at_mat4(self.eye, self.target, self.up)
    }

    /// Camera rays `[axis, right, down]`: the ray through (x, y), from (-1, -1) at the top left to (1, 1) at the
    /// bottom right of a picture of the given width over height, is `axis + x right + y down`, with view depth 1.
    pub fn pixel_rays(&self, aspect: f32) -> [Vec3; 3] {
        let view = self.view_matrix();
        let (right, up, back) = (view.row(0).truncate(), view.row(1).truncate(), view.row(2).truncate());
        let tan_y = (self.vertical_fov * 0.5).tan();
        let (right, down) = (right * tan_y * aspect, -up * tan_y);
        [-back + self.shift.x * right + self.shift.y * down, right, down]
    }

    /// View to Vulkan clip space for a picture of the given width over height: y down, reversed depth, 1 at the near plane and 0 at the
    /// far one, which keeps the precision of floats at any distance.
    pub fn projection_matrix(&self, aspect: f32) -> Mat4 {
        use glam::camera::rh::proj::vulkan::{perspective, perspective_infinite_reverse};
        let centred = match self.far {
            f32::INFINITY => perspective_infinite_reverse(self.vertical_fov, aspect, self.near),
            far => perspective(self.vertical_fov, aspect, far, self.near),
        };
        let shift = Mat4::from_cols(Vec4::X, Vec4::Y, Vec4::Z, (-self.shift).extend(0.0).extend(1.0));
        if self.shift == Vec2::ZERO { centred } else { shift * centred }
    }
}
