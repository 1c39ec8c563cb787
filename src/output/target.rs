//! Where the pictures of a run go: one file, or a sequence numbered by `{frame}`.

use std::path::{Path, PathBuf};

use super::{OutputError, OutputFile, Picture, exr, png};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    Png,
    Exr,
}

/// The `--out` of a run: its format, and for a sequence where in the name the frame number stands.
#[derive(Clone, Debug, PartialEq)]
pub struct PictureTarget {
    path: PathBuf,
    format: Format,
    layers: bool,
    sequence: Option<FramePlace>,
}

/// A name split at its `{frame:04}`.
#[derive(Clone, Debug, PartialEq, Eq)]
struct FramePlace {
    before: String,
    after: String,
    digits: usize,
}

impl PictureTarget {
    /// Reads a target such as `a.png` or `frames/{frame:04}.exr` and checks that it can be written,
    /// with layers if asked for.
    pub fn new(path: &Path, layers: bool) -> Result<Self, OutputError> {
        let format = match path.extension().and_then(|extension| extension.to_str()) {
            Some(extension) if extension.eq_ignore_ascii_case("png") => Format::Png,
            Some(extension) if extension.eq_ignore_ascii_case("exr") => Format::Exr,
            _ => return Err(OutputError::UnknownExtension(path.to_path_buf())),
        };
        if layers && format == Format::Png {
            return Err(OutputError::LayersInPng(path.to_path_buf()));
        }
        let sequence = frame_place(path)?;
        let target = Self { path: path.to_path_buf(), format, layers, sequence };
        OutputFile::new(target.path_of(0))?;
        Ok(target)
    }

    /// Whether frame `frame` of `frames` is to be written: every one of a sequence, else the last.
    pub fn wants(&self, frame: u64, frames: u64) -> bool {
        self.sequence.is_some() || frame + 1 == frames
    }

    /// Whether one of the first `frames` pictures would be written over `file`.
    pub fn writes_to(&self, file: &OutputFile, frames: u64) -> bool {
        let frame = self.sequence.as_ref().map_or(Some(0), |place| place.frame_of(file.path()));
        frame.is_some_and(|frame| frame < frames && file.is_same(&self.path_of(frame)))
    }

    /// Whether pictures are to be read back with their layers.
    pub fn layers(&self) -> bool {
        self.layers
    }

    /// Writes frame `frame` and says where to.
    pub fn write(&self, picture: &Picture, frame: u64) -> Result<PathBuf, OutputError> {
        let path = self.path_of(frame);
        let encode_error = |reason: String| OutputError::Encode { path: path.clone(), reason };
        let file = OutputFile::new(&path)?;
        file.save(|writer| match self.format {
            Format::Png => png::write(picture, writer).map_err(|error| match error {
                image::ImageError::IoError(source) => file.error(source),
                other => encode_error(other.to_string()),
            }),
            Format::Exr => exr::write(picture, writer).map_err(|error| match error {
                ::exr::error::Error::Io(source) => file.error(source),
                other => encode_error(other.to_string()),
            }),
        })?;
        Ok(path)
    }

    /// Whether pictures keep linear radiance.
    pub fn is_linear(&self) -> bool {
        self.format == Format::Exr
    }

    /// Name of the picture of frame `frame`.
    pub fn path_of(&self, frame: u64) -> PathBuf {
        match &self.sequence {
            None => self.path.clone(),
            Some(FramePlace { before, after, digits }) => {
                self.path.with_file_name(format!("{before}{frame:0digits$}{after}"))
            }
        }
    }
}

impl FramePlace {
    /// The frame whose picture has this file's name, if there is one.
    fn frame_of(&self, file: &Path) -> Option<u64> {
        let name = file.file_name()?.to_str()?;
        name.strip_prefix(&self.before)?.strip_suffix(&self.after)?.parse().ok()
    }
}

/// Finds the `{frame}` or `{frame:04}` in the name of the file.
fn frame_place(path: &Path) -> Result<Option<FramePlace>, OutputError> {
    const OPENING: &str = "{frame";
    let error = |placeholder: &str| OutputError::Placeholder {
        path: path.to_path_buf(),
        placeholder: placeholder.to_owned(),
    };
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

    fn target(name: &str, layers: bool) -> Result<PictureTarget, OutputError> {
        PictureTarget::new(&std::env::temp_dir().join(name), layers)
    }

    #[test]
    fn a_single_file_takes_the_last_frame() {
        let target = target("a.PNG", false).unwrap();
        assert!(!target.wants(0, 3) && !target.wants(1, 3) && target.wants(2, 3));
        assert_eq!(target.path_of(2), std::env::temp_dir().join("a.PNG"));
    }

    #[test]
    fn a_sequence_takes_every_frame() {
        let names = |name, frame| {
            let target = target(name, true).unwrap();
            assert!(target.wants(0, 3) && target.wants(2, 3));
            target.path_of(frame).file_name().unwrap().to_str().unwrap().to_owned()
        };
        assert_eq!(names("{frame}.exr", 12), "12.exr");
        assert_eq!(names("a-{frame:04}-b.exr", 12), "a-0012-b.exr");
        assert_eq!(names("a{frame:02}.exr", 1234), "a1234.exr");
    }

    #[test]
    fn wrong_targets_are_refused_in_one_line() {
        for (name, layers, says) in [
            ("a", false, "must end in .png or .exr"),
            ("a.jpg", false, "must end in .png or .exr"),
            ("a.png", true, "--layers needs an .exr"),
            ("a{frame:4}.png", false, "{frame:4} is not a place"),
            ("a{frame:0x}.png", false, "{frame:0x} is not a place"),
            ("a{frame.png", false, "{frame is not a place"),
            ("{frame}{frame}.png", false, "a second {frame}"),
            ("{frame}/a.png", false, "in the folder's name"),
            ("no such folder/a.png", false, "no folder"),
        ] {
            let error = target(name, layers).unwrap_err().to_string();
            assert!(error.contains(says) && !error.contains('\n'), "{error}");
        }
    }

    #[test]
    fn a_report_in_the_way_of_a_picture_is_noticed() {
        let folder = std::env::temp_dir();
        let file = |name: &str| OutputFile::new(folder.join(name)).unwrap();
        let sequence = target("a-{frame:03}.png", false).unwrap();
        for (name, frames, expected) in [
            ("a-002.png", 3, true),
            ("a-002.png", 2, false),
            ("a-2.png", 3, false),
            ("a-.png", 3, false),
            ("./a-000.png", 1, true),
        ] {
            assert_eq!(sequence.writes_to(&file(name), frames), expected, "{name}");
        }
        let single = target("a.png", false).unwrap();
        assert!(single.writes_to(&file("./a.png"), 1) && !single.writes_to(&file("a.json"), 1));
    }

    #[test]
    fn pictures_are_written_under_their_names() {
        let folder = tempfile::tempdir().unwrap();
        let picture = Picture {
            width: 2,
            height: 1,
            colour: vec![[0.5; 3], [2.0; 3]],
            display: vec![[1, 2, 3, 4]; 2],
            ..Picture::default()
        };
        for extension in ["png", "exr"] {
            let name = folder.path().join(format!("{{frame:03}}.{extension}"));
            let written = PictureTarget::new(&name, false).unwrap().write(&picture, 7).unwrap();
            assert_eq!(written, folder.path().join(format!("007.{extension}")));
            assert_eq!(image::image_dimensions(&written).unwrap(), (2, 1));
        }
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2);
    }
}
