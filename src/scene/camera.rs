//! A pinhole camera.

use glam::{Mat4, Vec3};

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
    /// World to view: x right, y up, looking down -z.
    pub fn view_matrix(&self) -> Mat4 {
        glam::camera::rh::view::look_at_mat4(self.eye, self.target, self.up)
    }

    /// View to Vulkan clip space (y down, depth 0 to 1) for a picture of the given width over height.
    pub fn projection_matrix(&self, aspect: f32) -> Mat4 {
        glam::camera::rh::proj::vulkan::perspective(self.vertical_fov, aspect, self.near, self.far)
    }
}
