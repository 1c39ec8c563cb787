//! Names of pictures: one file, or a sequence numbered by `{frame}`.

use std::io;
use std::ops::Range;
use std::path::{Path, PathBuf};

use super::error::OutputError;
use super::file::{OutputFile, folder_of};

/// The name of a picture, or of a sequence: then the frame number replaces `{frame}` or, with leading zeros,
/// `{frame:04}`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NumberedPath {
    path: PathBuf,
    place: Option<FramePlace>,
}

/// A name split at its `{frame:04}`.
#[derive(Clone, Debug, PartialEq, Eq)]
struct FramePlace {
    before: String,
    after: String,
    digits: usize,
}

impl NumberedPath {
    /// Parses a name such as `a.png` or `frames/{frame:04}.exr`.
    pub fn new(path: impl Into<PathBuf>) -> Result<Self, OutputError> {
        let path = path.into();
        let place = frame_place(&path)?;
        Ok(Self { path, place })
    }

    /// The name as it was given.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Whether it is a sequence.
    pub fn is_sequence(&self) -> bool {
        self.place.is_some()
    }

    /// The file of frame `frame`; the same for every frame of a single picture.
    pub fn path_of(&self, frame: u64) -> PathBuf {
        match &self.place {
            None => self.path.clone(),
            Some(FramePlace { before, after, digits }) => {
                self.path.with_file_name(format!("{before}{frame:0digits$}{after}"))
            }
        }
    }

    /// Whether `file` is this picture, or one of `frames` of this sequence.
    pub fn covers(&self, file: &OutputFile, frames: Range<u64>) -> bool {
        let frame = match &self.place {
            None => Some(frames.start),
            Some(place) => file.path().file_name().and_then(|name| place.frame_of(name.to_str()?)),
        };
        frame.is_some_and(|frame| frames.contains(&frame) && file.is_same(&self.path_of(frame)))
    }

    /// The frames of a sequence whose files exist, in ascending order.
    pub fn frames_on_disk(&self) -> io::Result<Vec<u64>> {
        let mut frames = Vec::new();
        for entry in std::fs::read_dir(folder_of(&self.path))? {
            let name = entry?.file_name();
            let frame = self.place.as_ref().zip(name.to_str()).and_then(|(place, name)| place.frame_of(name));
            // `7` and `07` parse to the same number, but only one of them belongs to this sequence.
            frames.extend(frame.filter(|&frame| self.path_of(frame).file_name() == Some(&name)));
        }
        frames.sort_unstable();
        Ok(frames)
    }
}

impl FramePlace {
    /// The frame number in this file name, if it belongs to the sequence.
    fn frame_of(&self, name: &str) -> Option<u64> {
        name.strip_prefix(&self.before)?.strip_suffix(&self.after)?.parse().ok()
    }
}

/// Finds the `{frame}` or `{frame:04}` in the name of the file.
fn frame_place(path: &Path) -> Result<Option<FramePlace>, OutputError> {
    const OPENING: &str = "{frame";
    let error = |placeholder: &str| OutputError::Placeholder(path.to_path_buf(), placeholder.to_owned());
    if path.parent().is_some_and(|folder| folder.to_string_lossy().contains(OPENING)) {
        return Err(error("a {frame} in the folder's name"));
    }
    let Some(name) = path.file_name().and_then(|name| name.to_str()) else {
        return Ok(None);
    };
    let Some((before, rest)) = name.split_once(OPENING) else {
        return Ok(None);
    };
    let Some((inside, after)) = rest.split_once('}') else {
        return Err(error(OPENING));
    };
    let digits = match inside.strip_prefix(":0") {
        None if inside.is_empty() => Some(1),
        None => None,
        Some(digits) => digits.parse().ok().filter(|digits| (1..=9).contains(digits)),
    };
    let digits = digits.ok_or_else(|| error(&format!("{OPENING}{inside}}}")))?;
    if after.contains(OPENING) {
        return Err(error("a second {frame}"));
    }
    Ok(Some(FramePlace { before: before.to_owned(), after: after.to_owned(), digits }))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn name_of(name: &str, frame: u64) -> String {
        let path = NumberedPath::new(name).unwrap().path_of(frame);
        path.file_name().unwrap().to_str().unwrap().to_owned()
    }

    #[test]
    fn the_frame_number_replaces_the_placeholder() {
        assert_eq!(name_of("a.png", 12), "a.png");
        assert_eq!(name_of("{frame}.exr", 12), "12.exr");
        assert_eq!(name_of("a-{frame:04}-b.exr", 12), "a-0012-b.exr");
        assert_eq!(name_of("a{frame:02}.exr", 1234), "a1234.exr");
    }

    #[test]
    fn files_of_the_sequence_are_covered() {
        let folder = std::env::temp_dir();
        let file = |name: &str| OutputFile::new(folder.join(name)).unwrap();
        let named = |name: &str| NumberedPath::new(folder.join(name)).unwrap();
        let sequence = named("a-{frame:03}.png");
        for (name, frames, expected) in [
            ("a-002.png", 0..3, true),
            ("a-002.png", 0..2, false),
            ("a-002.png", 3..5, false),
            ("a-2.png", 0..3, false),
            ("a-.png", 0..3, false),
            ("./a-000.png", 0..1, true),
        ] {
            assert_eq!(sequence.covers(&file(name), frames), expected, "{name}");
        }
        let single = named("a.png");
        assert!(single.covers(&file("./a.png"), 7..8) && !single.covers(&file("a.json"), 7..8));
    }

    #[test]
    fn the_frames_of_a_sequence_are_found() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["a-003.png", "a-001.png", "a-1000.png", "a-7.png", "a-x.png", "b-004.png", "a-005.exr"] {
            std::fs::write(folder.path().join(name), "").unwrap();
        }
        let frames = |name: &str| NumberedPath::new(folder.path().join(name)).unwrap().frames_on_disk();
        assert_eq!(frames("a-{frame:03}.png").unwrap(), [1, 3, 1000]);
        assert_eq!(frames("a-{frame}.png").unwrap(), [7, 1000]);
        assert_eq!(frames("c-{frame}.png").unwrap(), [0; 0]);
        assert!(NumberedPath::new("no such folder/{frame}.png").unwrap().frames_on_disk().is_err());
    }
}
