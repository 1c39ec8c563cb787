//! Why a file cannot be written or read.

use std::io;
use std::path::PathBuf;

/// Why a file cannot be written or read; each names the file.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    /// Neither `.png` nor `.exr`.
    #[error("{0}: unknown kind of picture; the name must end in .png or .exr")]
    UnknownExtension(PathBuf),
    /// Neither `.svg` nor `.png`.
    #[error("{0}: unknown kind of plot; the name must end in .svg or .png")]
    UnknownPlot(PathBuf),
    /// Layers in a format without layers.
    #[error("{0}: --layers needs an .exr file; a .png has no layers")]
    LayersInPng(PathBuf),
    /// An invalid `{frame...}` placeholder in a name.
    #[error(
        "{0}: {1} is not a valid placeholder; write {{frame}} or, for four digits, {{frame:04}}, in the file's name"
    )]
    Placeholder(PathBuf, String),
    /// The folder of a file does not exist.
    #[error("{0}: there is no folder {1}; create it first")]
    NoFolder(PathBuf, PathBuf),
    /// A folder, or no name of a file.
    #[error("{0}: is a folder, not a file; give another name")]
    NotAFile(PathBuf),
    /// The file exists, and nobody may write to it.
    #[error("{0}: is read-only; make it writable, or give another name")]
    ReadOnly(PathBuf),
    /// A picture for a person's eyes would be bytes on a terminal.
    #[error("--out -: standard output is a terminal; redirect it to a file or a program")]
    Terminal,
    /// The file does not exist or cannot be read.
    #[error("{path}: cannot be read: {}", plain(source))]
    Read {
        /// The file.
        path: PathBuf,
        /// The system's error.
        source: io::Error,
    },
    /// Not an OpenEXR file, or a corrupt one, for the decoder's reason.
    #[error("{0}: is not a valid OpenEXR picture: {1}")]
    Decode(PathBuf, String),
    /// The file cannot be written.
    #[error("{path}: cannot be written: {}", plain(source))]
    Write {
        /// The file.
        path: PathBuf,
        /// The system's error.
        source: io::Error,
    },
    /// The picture or plot cannot be encoded, for the encoder's reason.
    #[error("{0}: cannot be encoded: {1}")]
    Encode(PathBuf, String),
}

impl OutputError {
    /// Whether the name itself is invalid, independent of the file system.
    pub fn is_usage(&self) -> bool {
        matches!(
            self,
            Self::UnknownExtension(_)
                | Self::UnknownPlot(_)
                | Self::LayersInPng(_)
                | Self::Placeholder(..)
                | Self::Terminal
        )
    }
}

/// The system's error, without the path of the temporary file that tempfile adds.
fn plain(error: &io::Error) -> String {
    let within = || error.get_ref()?.source()?.downcast_ref::<io::Error>()?.raw_os_error();
    match error.raw_os_error().or_else(within) {
        Some(code) => io::Error::from_raw_os_error(code).to_string(),
        None => error.to_string(),
    }
}
