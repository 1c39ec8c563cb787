//! Records camera, edits and settings, for `render` to replay to the same pictures.

use std::path::PathBuf;

use super::screenshot::Saving;
use super::stage::Stage;
use crate::formats::SceneDocument;
use crate::scene::{Pose, RecordedFrame};
use crate::settings::Settings;

/// A recording in progress, from the first frame of a renderer.
pub(super) struct Recorder {
    document: SceneDocument,
    frames: Vec<RecordedFrame>,
    next: u64,
    last_pose: Option<Pose>,
    last_settings: Settings,
    /// Scene file of a rebuilt renderer, for the next frame.
    new_scene: Option<String>,
    /// Scene file of an edited scene with which the renderer goes on, for the next frame.
    edited: Option<String>,
}

impl Recorder {
    /// Starts with the next frame, the first of the stage's renderer.
    pub fn new(stage: &Stage) -> Self {
        Self {
            document: stage.made_document(),
            frames: Vec::new(),
            next: 0,
            last_pose: None,
            last_settings: stage.settings.clone(),
            new_scene: None,
            edited: None,
        }
    }

    /// Notes that the stage's renderer was rebuilt.
    pub fn renewed(&mut self, stage: &Stage) {
        self.new_scene = Some(stage.made_document().text());
        self.edited = None;
        self.last_pose = None;
    }

    /// Notes that the stage's renderer goes on with an edited scene.
    pub fn edited(&mut self, stage: &Stage) {
        self.edited = Some(stage.made_document().text());
        self.last_pose = None;
    }

    /// Records a frame.
    pub fn frame(&mut self, stage: &Stage) {
        let mut frame = RecordedFrame::between(self.next, self.last_pose.as_ref(), &stage.pose);
        frame.scene = self.new_scene.take();
        frame.edited = self.edited.take();
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
        // Include the last frame even if nothing moved in it.
        let last = self.next.saturating_sub(1);
        if self.frames.last().is_none_or(|frame| frame.frame != last) {
            self.frames.push(RecordedFrame { frame: last, ..RecordedFrame::default() });
        }
        Saving::text(path, self.document.text_with(self.frames))
    }
}
