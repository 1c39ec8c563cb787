//! A pinhole camera.

use std::sync::Arc;

use glam::{Mat4, Quat, Vec2, Vec3, Vec4};
use serde::{Deserialize, Serialize};

use super::animation::Motion;
use super::{BoundingSphere, Scene};

/// A pinhole camera. Right-handed world space, y up; the renderer derives its own reversed depth.
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
    /// View depth of the far plane, > near.
    pub far: f32,
    /// How far the pixels' rays are shifted to the right and down, where the picture reaches from -1 to 1: for antialiasing.
    #[serde(skip)]
    pub shift: Vec2,
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
            shift: Vec2::ZERO,
        }
    }

    /// This camera moved by `motion`.
    pub fn moved(&self, motion: &Motion) -> Self {
        let target = if motion.rotation == Quat::IDENTITY {
            self.target + (motion.position - self.eye)
        } else {
            motion.position + motion.rotation * (self.target - self.eye)
        };
        Self { eye: motion.position, target, up: motion.rotation * self.up, ..*self }
    }

    /// Sets `near` and `far` so that `bounds` is in their range from any eye point within `reach` of this one.
    pub fn fit_depths(&mut self, bounds: &BoundingSphere, reach: f32) {
        let away = self.eye.distance(bounds.center) + reach;
        self.far = 1.01 * (away + bounds.radius);
        self.near = 2e-4 * self.far;
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

    /// View to Vulkan clip space (y down, depth 0 to 1) for a picture of the given width over height.
    pub fn projection_matrix(&self, aspect: f32) -> Mat4 {
        let centred =
            glam::camera::rh::proj::vulkan::perspective(self.vertical_fov, aspect, self.near, self.far);
        let shift = Mat4::from_cols(Vec4::X, Vec4::Y, Vec4::Z, (-self.shift).extend(0.0).extend(1.0));
        if self.shift == Vec2::ZERO { centred } else { shift * centred }
    }
}

/// Overrides of parts of the scene's camera.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CameraOverride {
    /// Eye point, world space.
    pub eye: Option<Vec3>,
    /// A point at the centre of the picture.
    pub target: Option<Vec3>,
    /// Vertical field of view, radians.
    pub vertical_fov: Option<f32>,
}

impl CameraOverride {
    /// Whether nothing is overridden.
    pub fn is_none(&self) -> bool {
        *self == Self::default()
    }
}

impl Scene {
    /// Overrides parts of the camera. Another eye or target removes its animation; another eye also fits near and far
    /// to the scene's bounds. If the up vector is parallel to the view direction, -z or y replaces it.
    ///
    /// # Errors
    /// If eye and target are equal; the scene is unchanged then.
    pub fn override_camera(&mut self, parts: &CameraOverride) -> Result<(), &'static str> {
        let mut camera = self.camera;
        camera.eye = parts.eye.unwrap_or(camera.eye);
        camera.target = parts.target.unwrap_or(camera.target);
        camera.vertical_fov = parts.vertical_fov.unwrap_or(camera.vertical_fov);
        let forward = (camera.target - camera.eye).try_normalize().ok_or("eye and target must differ")?;
        let is_up = |up: &Vec3| forward.cross(*up).length() > 1e-3;
        camera.up = [camera.up, Vec3::NEG_Z, Vec3::Y].into_iter().find(is_up).unwrap_or(camera.up);
        let is_moved = parts.eye.is_some() || parts.target.is_some();
        if parts.eye.is_some() {
            camera.fit_depths(&self.bounding_sphere(&self.pose(0.0)), 0.0);
        }
        if is_moved {
            self.camera_animation = None;
        }
        self.camera = camera;
        if !parts.is_none() {
            for frame in Arc::make_mut(&mut self.recording) {
                match &mut frame.camera {
                    Some(recorded) if !is_moved => recorded.vertical_fov = camera.vertical_fov,
                    // A scene that was opened during the recording needs the overridden camera, too.
                    recorded => *recorded = frame.scene.is_some().then_some(camera),
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Animation, Instance, Mesh, RecordedFrame, Rotation};
    use super::*;

    fn moving() -> Scene {
        let mut scene = Scene::new("box");
        scene.meshes.push(Mesh::cuboid("box", Vec3::splat(0.5), 0).into());
        let placed = glam::Affine3A::from_translation(Vec3::splat(0.25));
        scene.instances.push(Instance::fixed("box", 0, placed));
        let rotation = Rotation { axis: Vec3::Y, speed: 1.0, pivot: Some(Vec3::ZERO) };
        scene.camera_animation = Some(Animation { rotation: Some(rotation), ..Animation::default() });
        scene.recording = Arc::new(vec![RecordedFrame {
            camera: Some(Camera::looking(Vec3::X, Vec3::ZERO)),
            ..RecordedFrame::default()
        }]);
        scene
    }

    #[test]
    fn each_part_is_overridden_separately() {
        let scene = moving();
        let mut wide = scene.clone();
        wide.override_camera(&CameraOverride { vertical_fov: Some(1.5), ..Default::default() }).unwrap();
        assert_eq!(wide.camera, Camera { vertical_fov: 1.5, ..scene.camera });
        assert_eq!(wide.camera_animation, scene.camera_animation);
        let recorded = wide.recording[0].camera.unwrap();
        assert_eq!((recorded.eye, recorded.vertical_fov), (Vec3::X, 1.5));

        let mut turned = scene.clone();
        turned.override_camera(&CameraOverride { target: Some(Vec3::Y), ..Default::default() }).unwrap();
        assert_eq!(turned.camera, Camera { target: Vec3::Y, ..scene.camera });
        assert_eq!((turned.camera_animation, turned.recording[0].camera), (None, None));

        let mut same = scene.clone();
        same.override_camera(&CameraOverride::default()).unwrap();
        assert_eq!((same.camera, same.recording[0].camera), (scene.camera, scene.recording[0].camera));
    }

    #[test]
    fn depth_range_contains_the_scene() {
        let mut scene = moving();
        let bounds = scene.bounding_sphere(&scene.pose(0.0));
        let eye = bounds.center + 40.0 * bounds.radius * Vec3::X;
        scene.override_camera(&CameraOverride { eye: Some(eye), ..Default::default() }).unwrap();
        let Camera { near, far, .. } = scene.camera;
        assert!(near < 39.0 * bounds.radius && far > 41.0 * bounds.radius, "{near} {far}");
        assert_eq!(scene.camera.up, Vec3::Y);
    }

    #[test]
    fn a_view_from_above_has_an_up_vector() {
        let mut scene = moving();
        let above = CameraOverride { eye: Some(Vec3::Y), target: Some(Vec3::ZERO), ..Default::default() };
        scene.override_camera(&above).unwrap();
        assert_eq!(scene.camera.up, Vec3::NEG_Z);
    }

    #[test]
    fn eye_and_target_must_differ() {
        let mut scene = moving();
        let camera = scene.camera;
        let parts = CameraOverride { eye: Some(camera.target), ..Default::default() };
        assert!(scene.override_camera(&parts).is_err());
        assert_eq!(scene.camera, camera);
    }
}
