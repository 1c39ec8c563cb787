//! Background writes of pictures and scene files.

use std::path::{Path, PathBuf};
use std::thread::JoinHandle;

use super::error::DemoError;
use super::session::{Saved, Session};
use crate::output::{OutputFile, PictureTarget};

/// Most files of one name in a folder.
const MOST: u32 = 9999;

/// A file being written.
pub(super) struct Saving {
    pub thread: JoinHandle<Result<PathBuf, String>>,
    /// The scene that it holds.
    pub scene: Option<SavedScene>,
}

/// The scene of a file that is being written, as it was.
pub(super) struct SavedScene {
    pub name: String,
    pub edits: u64,
    pub saved: Saved,
}

impl Saving {
    /// Writes a text file.
    pub fn text(path: PathBuf, text: String) -> Self {
        let write = move || {
            let file = OutputFile::new(&path).map_err(|error| error.to_string())?;
            file.save_text(&text).map_err(|error| error.to_string())?;
            Ok(path)
        };
        Self::of(write)
    }

    /// Runs `write` in a thread; it returns the path, or a one-line error.
    pub fn of(write: impl FnOnce() -> Result<PathBuf, String> + Send + 'static) -> Self {
        Self { thread: std::thread::spawn(write), scene: None }
    }

    pub fn is_done(&self) -> bool {
        self.thread.is_finished()
    }

    /// The path, or a one-line error.
    pub fn finish(self) -> Result<PathBuf, String> {
        self.thread.join().unwrap_or_else(|_| Err("the picture could not be written".to_owned()))
    }
}

/// Reads back the last frame's picture and writes it to the current folder under a new name.
pub(super) fn take(session: &Session, exr: bool) -> Result<Saving, DemoError> {
    let picture = session.renderer.read_picture(false)?;
    let stem = format!("glowworm-{}", session.live_scene.name.replace(['/', '\\'], "-"));
    Ok(Saving::of(move || {
        let path = free_name(&stem, if exr { ".exr" } else { ".png" })?;
        let target = PictureTarget::new(&path, false).map_err(|error| error.to_string())?;
        target.write(&picture, 0).map_err(|error| error.to_string())?;
        Ok(path)
    }))
}

/// An unused file name in the current folder; `extension` has its dot.
pub(super) fn free_name(stem: &str, extension: &str) -> Result<PathBuf, String> {
    (1..=MOST)
        .map(|number| PathBuf::from(format!("{stem}-{number:04}{extension}")))
        .find(|path| !Path::new(path).exists())
        .ok_or_else(|| format!("{stem}-{MOST}{extension} exists; move the files {stem}-* to another folder"))
}
