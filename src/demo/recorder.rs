//! Records what is done, to be replayed by `render` to the same pictures.

use std::path::PathBuf;

use super::screenshot::Saving;
use super::stage::Stage;
use crate::scene::{Pose, RecordedFrame, SceneDocument};
use crate::settings::Settings;

/// A recording in progress: from the first frame of a renderer on.
pub(super) struct Recorder {
    document: SceneDocument,
    frames: Vec<RecordedFrame>,
    next: u64,
    last_pose: Option<Pose>,
    last_settings: Settings,
    /// The renderer was made anew for this text.
    new_scene: Option<String>,
}

impl Recorder {
    /// Starts with the next frame, which is the first one of the stage's renderer.
    pub fn new(stage: &Stage) -> Self {
        Self {
            document: stage.made_document(),
            frames: Vec::new(),
            next: 0,
            last_pose: None,
            last_settings: stage.settings.clone(),
            new_scene: None,
        }
    }

    /// The renderer of the stage was made anew.
    pub fn renewed(&mut self, stage: &Stage) {
        self.new_scene = Some(stage.made_document().text());
        self.last_pose = None;
    }

    /// A frame was drawn.
    pub fn frame(&mut self, stage: &Stage) {
        let mut frame = RecordedFrame::between(self.next, self.last_pose.as_ref(), &stage.pose);
        frame.scene = self.new_scene.take();
        if frame.scene.is_some() || self.last_settings != stage.settings {
            frame.settings = Some(stage.settings.clone());
            self.last_settings.clone_from(&stage.settings);
        }
        self.last_pose = Some(stage.pose.clone());
        if !frame.is_empty() {
            self.frames.push(frame);
        }
        self.next += 1;
    }

    /// Frames so far.
    pub fn count(&self) -> u64 {
        self.next
    }

    /// Writes the recording.
    pub fn save(mut self, path: PathBuf) -> Saving {
        // The last frame counts even where nothing moved.
        let last = self.next.saturating_sub(1);
        if self.frames.last().is_none_or(|frame| frame.frame != last) {
            self.frames.push(RecordedFrame { frame: last, ..RecordedFrame::default() });
        }
        Saving::text(path, self.document.text_with(self.frames))
    }
}
