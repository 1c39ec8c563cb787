//! Records camera, edits and settings, for `render` to replay to the same pictures.

use std::path::PathBuf;

use super::saving::Saving;
use super::session::Session;
use crate::formats::SceneDocument;
use crate::scene::{Pose, RecordedFrame};
use crate::settings::Settings;

/// A recording in progress, from the first frame of a renderer.
pub(super) struct Recorder {
    document: SceneDocument,
    frames: Vec<RecordedFrame>,
    /// Frames so far.
    pub count: u64,
    last_pose: Option<Pose>,
    last_settings: Settings,
    /// Scene file of a rebuilt renderer, for the next frame.
    new_scene: Option<String>,
    /// Scene file of an edited scene with which the renderer goes on, for the next frame.
    edited: Option<String>,
}

/// State of the recording.
#[derive(Default)]
pub(super) enum Recording {
    #[default]
    Off,
    /// Starts with the renderer that is being built.
    Waiting,
    On(Box<Recorder>),
}

impl Recorder {
    /// Starts with the next frame, the first of the session's renderer.
    pub fn new(session: &Session) -> Self {
        Self {
            document: session.document_of_renderer(),
            frames: Vec::new(),
            count: 0,
            last_pose: None,
            last_settings: session.settings.clone(),
            new_scene: None,
            edited: None,
        }
    }

    /// Notes that the session's renderer was rebuilt, or else goes on with an edited scene.
    pub fn note_change(&mut self, session: &Session, is_rebuilt: bool) {
        let text = Some(session.document_of_renderer().text());
        (self.new_scene, self.edited) = if is_rebuilt { (text, None) } else { (self.new_scene.take(), text) };
        self.last_pose = None;
    }

    /// Records a frame.
    pub fn frame(&mut self, session: &Session) {
        let mut frame = RecordedFrame::between(self.count, self.last_pose.as_ref(), &session.pose);
        frame.scene = self.new_scene.take();
        frame.edited = self.edited.take();
        if frame.scene.is_some() || self.last_settings != session.settings {
            frame.settings = Some(session.settings.clone());
            self.last_settings.clone_from(&session.settings);
        }
        self.last_pose = Some(session.pose.clone());
        if !frame.is_empty() {
            self.frames.push(frame);
        }
        self.count += 1;
    }

    /// Writes the recording.
    pub fn save(mut self, path: PathBuf) -> Saving {
        // Include the last frame even if nothing moved in it.
        let last = self.count.saturating_sub(1);
        if self.frames.last().is_none_or(|frame| frame.frame != last) {
            self.frames.push(RecordedFrame { frame: last, ..RecordedFrame::default() });
        }
        Saving::text(path, self.document.text_with(self.frames))
    }
}
