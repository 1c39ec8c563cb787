//! Renders a scene frame by frame: as its animation has it, or as a person has recorded it in the window.

use std::path::PathBuf;
use std::sync::Arc;

use super::{RenderError, Renderer};
use crate::formats::ReadFiles;
use crate::scene::{Pose, RecordedFrame, Scene};
use crate::settings::Settings;
use crate::vulkan::Device;

/// The frames of a scene, in order.
pub struct Replay {
    renderer: Renderer,
    scene: Arc<Scene>,
    settings: Settings,
    pose: Pose,
    recording: Arc<Vec<RecordedFrame>>,
    frame: u64,
    /// Animation time of frame 0, seconds.
    start: f64,
    assets: Option<PathBuf>,
    /// Files that were read for scenes within the recording.
    read: ReadFiles,
    device: Arc<Device>,
}

impl Replay {
    /// Starts at frame 0, at the animation time `start`, seconds; before 0 nothing moves.
    pub fn new(
        device: &Arc<Device>,
        scene: &Arc<Scene>,
        settings: &Settings,
        assets: Option<PathBuf>,
        start: f64,
    ) -> Result<Self, RenderError> {
        let pose = scene.pose(start.max(0.0));
        Ok(Self {
            renderer: Renderer::new(device, scene, settings, &pose)?,
            scene: Arc::clone(scene),
            settings: settings.clone(),
            pose,
            recording: Arc::clone(&scene.recording),
            frame: 0,
            start,
            assets,
            read: ReadFiles::default(),
            device: Arc::clone(device),
        })
    }

    /// Draws the next frame.
    ///
    /// # Errors
    /// Those of the renderer, and where a recording does not fit its scene.
    pub fn next_frame(&mut self) -> Result<(), RenderError> {
        if self.recording.is_empty() {
            self.pose = self.scene.pose((self.start + self.frame as f64 * self.settings.time_step).max(0.0));
        } else {
            let recording = Arc::clone(&self.recording);
            let at = recording.partition_point(|recorded| recorded.frame < self.frame);
            if let Some(recorded) = recording.get(at).filter(|recorded| recorded.frame == self.frame) {
                self.take(recorded)?;
            }
        }
        self.frame += 1;
        self.renderer.render(&self.pose)
    }

    /// Brings everything to where it was recorded.
    fn take(&mut self, recorded: &RecordedFrame) -> Result<(), RenderError> {
        if let Some(text) = &recorded.scene {
            let scene = self.read.scene_of_text(text, self.assets.as_deref());
            self.scene = Arc::new(scene.map_err(|error| RenderError::Recording(error.to_string()))?);
            self.settings = recorded.settings.clone().unwrap_or_else(|| self.settings.clone());
            self.pose = self.scene.pose(0.0);
            let view = self.renderer.view().clone();
            self.renderer = Renderer::new(&self.device, &self.scene, &self.settings, &self.pose)?;
            self.renderer.set_view(&view)?;
        } else if let Some(settings) = &recorded.settings {
            settings.check().map_err(|error| RenderError::Recording(error.to_string()))?;
            self.renderer.set_settings(settings, &self.pose)?;
            self.settings.clone_from(settings);
        }
        if let Some(text) = &recorded.edited {
            let scene = self.read.scene_of_text(text, self.assets.as_deref());
            self.scene = Arc::new(scene.map_err(|error| RenderError::Recording(error.to_string()))?);
            self.pose = self.scene.pose(0.0);
            self.renderer.set_scene(&self.scene, &self.pose)?;
        }
        recorded.apply(&mut self.pose, &self.scene).map_err(RenderError::Recording)
    }

    /// Where everything stands in the last frame.
    pub fn pose(&self) -> &Pose {
        &self.pose
    }

    /// The renderer.
    pub fn renderer(&mut self) -> &mut Renderer {
        &mut self.renderer
    }
}
