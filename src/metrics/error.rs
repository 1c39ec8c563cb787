//! Why pictures cannot be compared.

use std::io;
use std::path::PathBuf;

use crate::output::OutputError;

/// Why pictures cannot be compared; each names the file and, if known, the pixel.
#[derive(Debug, thiserror::Error)]
pub enum MetricsError {
    /// The file cannot be read.
    #[error("{path}: cannot be read: {source}")]
    Read {
        /// The file.
        path: PathBuf,
        /// The system's error.
        source: io::Error,
    },
    /// Not a supported file format.
    #[error("{0}: neither a PNG nor an OpenEXR file")]
    Foreign(PathBuf),
    /// Corrupt, truncated or an unsupported variant.
    #[error("{path}: cannot be decoded: {reason}")]
    Decode {
        /// The file.
        path: PathBuf,
        /// The decoder's error.
        reason: String,
    },
    /// Too large, probably corrupt.
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
    /// No colour channels.
    #[error("{path}: has no layer{layer} with channels R, G and B, or Y; it has {there}")]
    NoColours {
        /// The file.
        path: PathBuf,
        /// The requested layer, with a leading space; empty for any.
        layer: String,
        /// The parts and channels of the file.
        there: String,
    },
    /// A layer requested of a format without layers.
    #[error("{0}: a PNG has no layers; leave --layer and --reference-layer out")]
    LayerOfPng(PathBuf),
    /// A non-finite value.
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
    #[error("{name}: has {pixels} pixels, but its size is {width}x{height}")]
    PixelCount {
        /// The picture.
        name: String,
        /// Number of pixels.
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
        /// The picture.
        image: String,
        /// Its width and height in pixels.
        size: [usize; 2],
        /// The reference.
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
    #[error("{0}: there is no picture of this sequence; check the name")]
    NoFrames(PathBuf),
    /// A picture of a sequence is missing.
    #[error(
        "{missing}: is missing, but {there} exists; select a part of the sequence with --frames FIRST-LAST"
    )]
    MissingFrame {
        /// The missing file.
        missing: PathBuf,
        /// The picture that needs it.
        there: PathBuf,
    },
    /// The name of a sequence is wrong.
    #[error(transparent)]
    Name(#[from] OutputError),
}

impl MetricsError {
    /// Whether the arguments are wrong, independent of the files' content.
    pub fn is_usage(&self) -> bool {
        match self {
            Self::LayerOfPng(_) => true,
            Self::Name(error) => error.is_usage(),
            _ => false,
        }
    }
}
