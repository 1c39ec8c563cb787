//! Pictures and reports on disk: PNG (tone-mapped), EXR (linear) and JSON.
//!
//! Where a picture goes is checked before it is rendered ([`PictureTarget::new`]), and whatever is
//! written appears under its name complete or not at all ([`OutputFile`]).

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

/// Why something cannot be written; each names the file.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    /// Neither `.png` nor `.exr`.
    #[error("{0}: unknown kind of picture; the name must end in .png or .exr")]
    UnknownExtension(PathBuf),
    /// Layers where the format has none.
    #[error("{0}: --layers needs an .exr file; a .png holds no layers")]
    LayersInPng(PathBuf),
    /// A `{frame...}` that means nothing.
    #[error(
        "{path}: {placeholder} is not a place for the frame number; write {{frame}} or, for four digits, {{frame:04}}, in the file's name"
    )]
    Placeholder {
        /// The name with the placeholder.
        path: PathBuf,
        /// The part at fault.
        placeholder: String,
    },
    /// The folder is not there.
    #[error("{file}: there is no folder {folder}; create it first")]
    NoFolder {
        /// What was to be written.
        file: PathBuf,
        /// The folder it should lie in.
        folder: PathBuf,
    },
    /// The name is taken by something that is not a file.
    #[error("{0}: is not a file that can be replaced")]
    NotAFile(PathBuf),
    /// There is no such file, or the operating system refused.
    #[error("{path}: cannot be read: {}", plain(source))]
    Read {
        /// What was to be read.
        path: PathBuf,
        /// Why it could not be.
        source: io::Error,
    },
    /// Not an OpenEXR file, or a broken one.
    #[error("{path}: is not a whole OpenEXR picture: {reason}")]
    Decode {
        /// What was to be read.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// The operating system refused.
    #[error("{path}: cannot be written: {}", plain(source))]
    Write {
        /// What was to be written.
        path: PathBuf,
        /// Why it could not be.
        source: io::Error,
    },
    /// The picture could not be put into its format.
    #[error("{path}: cannot be encoded: {reason}")]
    Encode {
        /// What was to be written.
        path: PathBuf,
        /// Why it could not be.
        reason: String,
    },
}

impl OutputError {
    /// Whether the name itself is wrong, wherever and whenever it were written.
    pub fn is_usage(&self) -> bool {
        matches!(self, Self::UnknownExtension(_) | Self::LayersInPng(_) | Self::Placeholder { .. })
    }
}

/// What the operating system said, without the path of the temporary file that tempfile adds.
fn plain(error: &io::Error) -> String {
    match error.raw_os_error().or_else(|| source_code(error)) {
        Some(code) => io::Error::from_raw_os_error(code).to_string(),
        None => error.to_string(),
    }
}

fn source_code(error: &io::Error) -> Option<i32> {
    error.get_ref()?.source()?.downcast_ref::<io::Error>()?.raw_os_error()
}
