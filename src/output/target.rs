//! The picture output of a run: one file, a sequence numbered by `{frame}`, or a PNG on standard output.

use std::io::{self, ErrorKind, IsTerminal, Write};
use std::path::{Path, PathBuf};

use super::error::OutputError;
use super::file::OutputFile;
use super::numbered::NumberedPath;
use super::picture::Picture;
use super::png;

/// The `--out` of a run: file name, format, and whether layers are written.
#[derive(Clone, Debug, PartialEq)]
pub struct PictureTarget {
    name: NumberedPath,
    is_standard_output: bool,
    is_exr: bool,
    layers: bool,
}

impl PictureTarget {
    /// Parses a target such as `a.png`, `frames/{frame:04}.exr` or `-` and checks that it is writable, with `layers` or
    /// without.
    pub fn new(path: &Path, layers: bool) -> Result<Self, OutputError> {
        let is_standard_output = path == "-";
        let is = |kind: &str| path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case(kind));
        let is_exr = is("exr");
        if !is_exr && !is("png") && !is_standard_output {
            return Err(OutputError::UnknownExtension(path.to_path_buf()));
        }
        if layers && !is_exr {
            return Err(OutputError::LayersInPng(path.to_path_buf()));
        }
        let name = NumberedPath::new(if is_standard_output { Path::new("standard output") } else { path })?;
        if !is_standard_output {
            OutputFile::new(name.path_of(0))?;
        } else if io::stdout().is_terminal() {
            return Err(OutputError::Terminal);
        }
        Ok(Self { name, is_standard_output, is_exr, layers })
    }

    /// Its name as it was given, or "standard output".
    pub fn name(&self) -> &Path {
        self.name.path()
    }

    /// Whether the picture goes to standard output, where then nothing else may.
    pub fn is_standard_output(&self) -> bool {
        self.is_standard_output
    }

    /// Whether frame `frame` of `frames` is to be written: every one of a sequence, else the last.
    pub fn wants(&self, frame: u64, frames: u64) -> bool {
        self.name.is_sequence() || frame + 1 == frames
    }

    /// The file of frame `frame`, if it is one.
    pub fn picture(&self, frame: u64) -> Option<PathBuf> {
        (!self.is_standard_output).then(|| self.path_of(frame))
    }

    /// The files of the first `frames` pictures.
    pub fn pictures(&self, frames: u64) -> impl Iterator<Item = PathBuf> {
        (0..frames).filter(move |&frame| self.wants(frame, frames)).filter_map(|frame| self.picture(frame))
    }

    /// Whether `file` is one of the first `frames` pictures.
    pub fn writes_to(&self, file: &OutputFile, frames: u64) -> bool {
        !self.is_standard_output && self.name.covers(file, 0..frames)
    }

    /// Whether layers are written.
    pub fn layers(&self) -> bool {
        self.layers
    }

    /// Writes frame `frame`; returns its file.
    pub fn write(&self, picture: &Picture, frame: u64) -> Result<PathBuf, OutputError> {
        let path = self.name.path_of(frame);
        if self.is_standard_output {
            print(picture, &path)?;
            return Ok(path);
        }
        let file = OutputFile::new(&path)?;
        if self.is_exr {
            file.save_exr(picture)?
        } else {
            file.save_picture(picture)?
        }
        Ok(path)
    }

    /// Whether the format stores linear radiance.
    pub fn is_linear(&self) -> bool {
        self.is_exr
    }

    /// Name of the picture of frame `frame`; "standard output" where it goes there.
    pub fn path_of(&self, frame: u64) -> PathBuf {
        self.name.path_of(frame)
    }
}

/// Writes a PNG to standard output. A reader that has gone away is no error.
fn print(picture: &Picture, name: &Path) -> Result<(), OutputError> {
    let mut bytes = Vec::new();
    png::encode_picture(&mut bytes, picture, name)?;
    let mut output = io::stdout().lock();
    match output.write_all(&bytes).and_then(|()| output.flush()) {
        Err(source) if source.kind() != ErrorKind::BrokenPipe => {
            Err(OutputError::Write { path: name.to_owned(), source })
        }
        _ => Ok(()),
    }
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
    }

    #[test]
    fn a_sequence_takes_every_frame() {
        let target = target("{frame}.exr", true).unwrap();
        assert!(target.wants(0, 3) && target.wants(2, 3));
    }

    #[test]
    fn wrong_targets_are_refused_in_one_line() {
        for (name, layers, says) in [
            ("a", false, "must end in .png or .exr"),
            ("a.jpg", false, "must end in .png or .exr"),
            ("a.png", true, "--layers needs an .exr"),
            ("a{frame:4}.png", false, "{frame:4} is not a valid placeholder"),
            ("a{frame:0x}.png", false, "{frame:0x} is not a valid placeholder"),
            ("a{frame.png", false, "{frame is not a valid placeholder"),
            ("{frame}{frame}.png", false, "a second {frame}"),
            ("{frame}/a.png", false, "in the folder's name"),
            ("no such folder/a.png", false, "no folder"),
        ] {
            let error = target(name, layers).unwrap_err().to_string();
            assert!(error.contains(says) && !error.contains('\n'), "{error}");
        }
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
