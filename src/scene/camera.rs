//! A pinhole camera.

use glam::{Mat4, Quat, Vec3};

use super::animation::Motion;

/// Where the picture is taken from. Right-handed, y up; Vulkan clip space with reversed depth is the
/// renderer's business.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Eye point, world space.
    pub eye: Vec3,
    /// A point in the middle of the picture.
    pub target: Vec3,
    /// Which way is up in the picture; not parallel to the view direction.
    pub up: Vec3,
    /// Vertical field of view, radians.
    pub vertical_fov: f32,
    /// Nearest depth drawn, > 0.
    pub near: f32,
    /// Farthest depth drawn, > near.
    pub far: f32,
}

impl Camera {
    /// A camera at `eye` that looks at `target`, y up, with 40 degrees of vertical field of view and depths
    /// from a thousandth to a hundred times the distance between the two.
    pub fn looking(eye: Vec3, target: Vec3) -> Self {
        let distance = eye.distance(target);
        Self {
            eye,
            target,
            up: Vec3::Y,
            vertical_fov: 40f32.to_radians(),
            near: 1e-3 * distance,
            far: 100.0 * distance,
        }
    }

    /// This camera where `motion` has brought its eye.
    pub fn moved(&self, motion: &Motion) -> Self {
        let target = if motion.rotation == Quat::IDENTITY {
            self.target + (motion.position - self.eye)
        } else {
            motion.position + motion.rotation * (self.target - self.eye)
        };
        Self { eye: motion.position, target, up: motion.rotation * self.up, ..*self }
    }

    /// Unit view direction.
    pub fn forward(&self) -> Vec3 {
        (self.target - self.eye).normalize_or(Vec3::NEG_Z)
    }

    /// World to view: x right, y up, looking down -z.
    pub fn view_matrix(&self) -> Mat4 {
        glam::camera::rh::view::look_at_mat4(self.eye, self.target, self.up)
    }

    /// What pixels see: `ray + x ray_x + y ray_y` for a pixel at (x, y), from (-1, -1) at the top left to
    /// (1, 1) at the bottom right, of a picture of the given width over height; 1 long along the view axis.
    pub fn pixel_rays(&self, aspect: f32) -> [Vec3; 3] {
        let view = self.view_matrix();
        let (right, up, back) = (view.row(0).truncate(), view.row(1).truncate(), view.row(2).truncate());
        let tan_y = (self.vertical_fov * 0.5).tan();
        [-back, right * tan_y * aspect, -up * tan_y]
    }

    /// View to Vulkan clip space (y down, depth 0 to 1) for a picture of the given width over height.
    pub fn projection_matrix(&self, aspect: f32) -> Mat4 {
        glam::camera::rh::proj::vulkan::perspective(self.vertical_fov, aspect, self.near, self.far)
    }
}
