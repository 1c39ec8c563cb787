//! Overrides of the camera of a scene, such as those of the command line.

use std::sync::Arc;

use glam::Vec3;
use serde::{Deserialize, Serialize};

use super::camera::Camera;
use super::contents::Scene;

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
    /// Overrides parts of the camera. Another eye or target removes its animation; another eye also takes
    /// away near and far planes of the file. If the up vector is parallel to the view direction, -z or y replaces it.
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
            let Camera { near, far, .. } = Camera::looking(camera.eye, camera.target);
            (camera.near, camera.far) = (near, far);
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
    use super::*;
    use crate::scene::{Animation, Instance, Mesh, RecordedFrame, Rotation};

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
    fn another_eye_sees_near_and_far() {
        let mut scene = moving();
        let bounds = scene.bounding_sphere(&scene.pose(0.0));
        let eye = bounds.center + 40.0 * bounds.radius * Vec3::X;
        scene.override_camera(&CameraOverride { eye: Some(eye), ..Default::default() }).unwrap();
        let Camera { near, far, .. } = scene.camera;
        assert!(near < 1e-2 * bounds.radius && far == f32::INFINITY, "{near} {far}");
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
