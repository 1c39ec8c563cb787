//! Why pictures cannot be compared.

use std::io;
use std::path::PathBuf;

use crate::output::OutputError;

/// Why pictures cannot be compared; each names the file and, where there is one, the pixel.
#[derive(Debug, thiserror::Error)]
pub enum MetricsError {
    /// The operating system refused.
    #[error("{path}: cannot be read: {source}")]
    Read {
        /// What was to be read.
        path: PathBuf,
        /// Why it could not be.
        source: io::Error,
    },
    /// Not a picture of a known kind.
    #[error("{0}: neither a PNG nor an OpenEXR file")]
    Foreign(PathBuf),
    /// Broken or cut short.
    #[error("{path}: broken or of a kind that is not supported: {reason}")]
    Decode {
        /// The file.
        path: PathBuf,
        /// What the decoder says.
        reason: String,
    },
    /// Too large to be real.
    #[error("{path}: {width}x{height} pixels; at most {most}x{most} can be compared")]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// Its width in pixels.
        width: usize,
        /// Its height in pixels.
        height: usize,
        /// The largest side.
        most: usize,
    },
    /// No colours where they were looked for.
    #[error("{path}: has no layer{layer} with channels R, G and B, or Y; it has {there}")]
    NoColours {
        /// The file.
        path: PathBuf,
        /// The layer that was asked for, with a space before it.
        layer: String,
        /// What is there instead.
        there: String,
    },
    /// A layer was asked for in a format without layers.
    #[error("{0}: a PNG has no layers; leave --layer and --reference-layer out")]
    LayerOfPng(PathBuf),
    /// A value that cannot be compared.
    #[error("{name}: pixel ({x}, {y}) has a {channel} of {value}; only finite values can be compared")]
    NotFinite {
        /// The picture.
        name: String,
        /// Column, from the left.
        x: usize,
        /// Row, from the top.
        y: usize,
        /// Red, green or blue.
        channel: &'static str,
        /// The value: NaN or infinite.
        value: f32,
    },
    /// The number of pixels is not width times height.
    #[error("{name}: {pixels} pixels are not {width}x{height}")]
    PixelCount {
        /// The picture.
        name: String,
        /// How many there are.
        pixels: usize,
        /// Width in pixels.
        width: usize,
        /// Height in pixels.
        height: usize,
    },
    /// Two pictures of different size.
    #[error(
        "{image} has {}x{} pixels, {reference} {}x{}: pixel ({}, {}) is in one only",
        size[0], size[1], reference_size[0], reference_size[1],
        size[0].min(reference_size[0]), size[1].min(reference_size[1])
    )]
    Size {
        /// The one.
        image: String,
        /// Its width and height in pixels.
        size: [usize; 2],
        /// The other.
        reference: String,
        /// Its width and height in pixels.
        reference_size: [usize; 2],
    },
    /// Display values against linear ones.
    #[error(
        "{display} (PNG) holds display values, {linear} (EXR) linear ones; compare PNG with PNG or EXR with EXR"
    )]
    Encoding {
        /// The picture of display values.
        display: String,
        /// The picture of linear values.
        linear: String,
    },
    /// A sequence without pictures.
    #[error("{0}: there is no picture of this sequence")]
    NoFrames(PathBuf),
    /// A picture of a sequence is not there.
    #[error("{missing}: is not there, but {there} is; --frames FIRST-LAST compares a part of a sequence")]
    MissingFrame {
        /// What is missing.
        missing: PathBuf,
        /// The picture that calls for it.
        there: PathBuf,
    },
    /// The name of a sequence is wrong.
    #[error(transparent)]
    Name(#[from] OutputError),
}

impl MetricsError {
    /// Whether the arguments are wrong, whatever the files hold.
    pub fn is_usage(&self) -> bool {
        match self {
            Self::LayerOfPng(_) => true,
            Self::Name(error) => error.is_usage(),
            _ => false,
        }
    }
}
