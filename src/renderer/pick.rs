//! The surface under a pixel.

use glam::Vec2;

use super::Renderer;
use crate::bvh::Ray;
use crate::scene::{Camera, Pose, Side, SurfacePoint, WorldSurface};

/// The surface under a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Picked {
    /// Index into the scene's instances.
    pub instance: usize,
    /// Index into its mesh's triangles.
    pub triangle: u32,
    /// Index into the scene's materials.
    pub material: usize,
    /// World-space distance from the eye.
    pub distance: f32,
    /// Where it is, and which way the side that is seen faces.
    pub surface: WorldSurface,
}

/// The world-space ray through a place of a picture of `size` pixels; (0, 0) is the upper left corner. Its
/// direction is 1 long along the view axis.
pub fn camera_ray(camera: &Camera, size: [u32; 2], pixel: Vec2) -> Ray {
    let extent = Vec2::new(size[0] as f32, size[1] as f32);
    let [ray, ray_x, ray_y] = camera.pixel_rays(extent.x / extent.y);
    let at = pixel / extent * 2.0 - 1.0;
    let direction = ray + ray_x * at.x + ray_y * at.y;
    Ray { origin: camera.eye, direction, t_min: camera.near, t_max: camera.far }
}

impl Renderer {
    /// The surface at a place of the picture, with everything standing as in the last frame but the camera
    /// as in `pose`; none where there is none. The middle of the first pixel is (0.5, 0.5).
    pub fn pick(&self, pose: &Pose, pixel: Vec2) -> Option<Picked> {
        let pose = &*pose.about(self.anchor);
        let ray = camera_ray(&pose.camera, self.resolved.size, pixel);
        let hit = self.world(pose).visible(&ray)?;
        let point = SurfacePoint { triangle: hit.triangle, barycentrics: hit.barycentrics };
        let side = Side::Facing(ray.direction);
        let mut surface = self.scene.surface_at(pose, hit.instance, point, side).surface;
        surface.position += self.anchor;
        let instance = hit.instance as usize;
        let mesh = &self.scene.meshes[self.scene.instances[instance].mesh];
        Some(Picked {
            instance,
            triangle: hit.triangle,
            material: mesh.triangle_materials[hit.triangle as usize] as usize,
            distance: hit.t * ray.direction.length(),
            surface,
        })
    }
}
