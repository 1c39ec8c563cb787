//! The scene that is shown, with its renderer.

use glam::Vec3;

use super::loader::Built;
use crate::bvh::{Hit, Ray};
use crate::renderer::{RenderError, Renderer};
use crate::report::FrameReport;
use crate::scene::{Camera, Pose, Scene};
use crate::settings::Settings;

/// A scene on show.
pub(super) struct Stage {
    /// As it was asked for.
    pub name: String,
    pub settings: Settings,
    pub renderer: Renderer,
    /// Where everything rests; without meshes.
    pub rest: Scene,
    /// Radius of the scene's bounding sphere.
    pub radius: f32,
    /// The pose of the last frame.
    pub pose: Pose,
    /// What was measured of the last frame that the device has finished.
    pub report: FrameReport,
}

impl Stage {
    pub fn new(built: Built) -> Self {
        let Built { name, scene, settings, renderer, .. } = built;
        let rest = scene.without_meshes();
        let pose = rest.pose(0.0);
        let (low, high) = renderer.bvh().bounds();
        let radius = 0.5 * low.distance(high);
        Self { name, settings, renderer, rest, radius, pose, report: FrameReport::default() }
    }

    /// Draws the next frame with everything where it is at `time`, seen by `camera`.
    pub fn render(&mut self, time: f64, camera: Camera) -> Result<(), RenderError> {
        self.pose = Pose { camera, ..self.rest.pose(time) };
        self.renderer.render(&self.pose)?;
        if let Some(report) = self.renderer.take_reports().last() {
            self.report = *report;
        }
        Ok(())
    }

    /// The nearest surface at a place in the picture, from (0, 0) at the top left to (1, 1).
    pub fn pick(&self, at: [f32; 2]) -> Option<(Vec3, Hit)> {
        let ray = self.ray(at);
        let hit = self.renderer.bvh().intersect(&ray)?;
        Some((ray.origin + ray.direction * hit.t, hit))
    }

    /// The ray through a place in the picture.
    pub fn ray(&self, [x, y]: [f32; 2]) -> Ray {
        let camera = &self.pose.camera;
        let [middle, across, down] = camera.pixel_rays(self.aspect());
        let direction = middle + across * (2.0 * x - 1.0) + down * (2.0 * y - 1.0);
        Ray { origin: camera.eye, direction, t_min: camera.near, t_max: camera.far }
    }

    /// The command line that renders this scene with these settings.
    pub fn command_line(&self) -> String {
        let quoted = |text: &str| {
            let plain = |c: char| c.is_alphanumeric() || "-_./".contains(c);
            if text.chars().all(plain) { text.to_owned() } else { format!("'{}'", text.replace('\'', "'\\''")) }
        };
        let options: String = self
            .settings
            .differing_options()
            .into_iter()
            .map(|(option, value)| format!(" --{option}={value}"))
            .collect();
        let out = format!("{}.png", self.rest.name);
        format!("glowworm render {}{options} --out {}", quoted(&self.name), quoted(&out))
    }

    /// Width over height of the picture.
    pub fn aspect(&self) -> f32 {
        self.settings.size[0] as f32 / self.settings.size[1] as f32
    }
}
