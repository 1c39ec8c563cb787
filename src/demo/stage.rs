//! The scene that is shown, with its renderer.

use glam::Vec2;

use super::loader::Built;
use crate::bvh::Ray;
use crate::renderer::{Picked, RenderError, Renderer, camera_ray};
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
    pub fn pick(&self, at: Vec2) -> Option<Picked> {
        self.renderer.pick(&self.pose, at * self.extent())
    }

    /// The ray through a place in the picture.
    pub fn ray(&self, at: Vec2) -> Ray {
        camera_ray(&self.pose.camera, self.settings.size, at * self.extent())
    }

    fn extent(&self) -> Vec2 {
        Vec2::from_array(self.settings.size.map(|side| side as f32))
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
}
