//! Pictures and reports on disk: PNG (tone-mapped), EXR (linear) and JSON.
//!
//! Targets are checked before rendering ([`PictureTarget::new`]), and files are written atomically ([`OutputFile`]).

mod error;
mod exr;
mod file;
mod numbered;
mod picture;
mod png;
mod target;
mod temporary;
mod tone_map;

pub use error::OutputError;
pub use file::{Growing, OutputFile};
pub use numbered::NumberedPath;
pub use picture::{Layer, Picture};
pub use target::PictureTarget;
pub use temporary::exit;
pub use tone_map::{Tones, automatic_exposure, tone_map};
