//! Pictures and reports on disk: PNG (tone-mapped), EXR (linear) and JSON.
//!
//! Targets are checked before rendering ([`PictureTarget::new`]), and files are written atomically ([`OutputFile`]).

mod exr;
mod file;
mod numbered;
mod picture;
mod png;
mod target;
mod tone_map;

pub use file::{Growing, OutputFile};
pub use numbered::NumberedPath;
pub use picture::{Layer, Picture};
pub use target::PictureTarget;
pub use tone_map::{automatic_exposure, tone_map};

use std::io;
use std::path::PathBuf;

/// Why a file cannot be written or read; each names the file.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    /// Neither `.png` nor `.exr`.
    #[error("{0}: unknown kind of picture; the name must end in .png or .exr")]
    UnknownExtension(PathBuf),
    /// Layers in a format without layers.
    #[error("{0}: --layers needs an .exr file; a .png has no layers")]
    LayersInPng(PathBuf),
    /// An invalid `{frame...}` placeholder.
    #[error(
        "{path}: {placeholder} is not a valid placeholder; write {{frame}} or, for four digits, {{frame:04}}, in the file's name"
    )]
    Placeholder {
        /// The name with the placeholder.
        path: PathBuf,
        /// The invalid part.
        placeholder: String,
    },
    /// The folder does not exist.
    #[error("{file}: there is no folder {folder}; create it first")]
    NoFolder {
        /// The file to write.
        file: PathBuf,
        /// Its folder.
        folder: PathBuf,
    },
    /// The path exists but is not a regular file.
    #[error("{0}: exists and is not a regular file; give another name")]
    NotAFile(PathBuf),
    /// The file does not exist or cannot be read.
    #[error("{path}: cannot be read: {}", plain(source))]
    Read {
        /// The file.
        path: PathBuf,
        /// The system's error.
        source: io::Error,
    },
    /// Not an OpenEXR file, or a corrupt one.
    #[error("{path}: is not a valid OpenEXR picture: {reason}")]
    Decode {
        /// The file.
        path: PathBuf,
        /// The decoder's error.
        reason: String,
    },
    /// The file cannot be written.
    #[error("{path}: cannot be written: {}", plain(source))]
    Write {
        /// The file.
        path: PathBuf,
        /// The system's error.
        source: io::Error,
    },
    /// The picture cannot be encoded.
    #[error("{path}: cannot be encoded: {reason}")]
    Encode {
        /// The file.
        path: PathBuf,
        /// The encoder's error.
        reason: String,
    },
}

impl OutputError {
    /// Whether the name itself is invalid, independent of the file system.
    pub fn is_usage(&self) -> bool {
        matches!(self, Self::UnknownExtension(_) | Self::LayersInPng(_) | Self::Placeholder { .. })
    }
}

/// The system's error, without the path of the temporary file that tempfile adds.
fn plain(error: &io::Error) -> String {
    match error.raw_os_error().or_else(|| source_code(error)) {
        Some(code) => io::Error::from_raw_os_error(code).to_string(),
        None => error.to_string(),
    }
}

fn source_code(error: &io::Error) -> Option<i32> {
    error.get_ref()?.source()?.downcast_ref::<io::Error>()?.raw_os_error()
}
