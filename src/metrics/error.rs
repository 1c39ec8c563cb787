//! Why pictures cannot be compared.

use std::path::PathBuf;

use crate::output::OutputError;

/// Why pictures cannot be compared; each names the file and, if known, the pixel.
#[derive(Debug, thiserror::Error)]
pub enum MetricsError {
    /// Not a supported file format.
    #[error("{0}: neither a PNG nor a Radiance HDR nor an OpenEXR file")]
    Foreign(PathBuf),
    /// Corrupt, truncated or an unsupported variant, for the decoder's reason.
    #[error("{0}: cannot be decoded: {1}")]
    Decode(PathBuf, String),
    /// Too large, probably corrupt: its width and height, and the largest side.
    #[error("{0}: {1}x{2} pixels; at most {3}x{3} can be compared")]
    TooLarge(PathBuf, usize, usize, usize),
    /// No colour channels in the layer (with a leading space; empty for any), but these parts and channels.
    #[error("{0}: has no layer{1} with channels R, G and B, or Y; it has {2}")]
    NoColours(PathBuf, String, String),
    /// A layer requested of a format without layers.
    #[error("{0}: only OpenEXR files have layers; leave --layer and --reference-layer out")]
    NoLayers(PathBuf),
    /// A non-finite value: the pixel, its channel and the value.
    #[error("{0} has a {1} of {2}; only finite values can be compared")]
    NotFinite(String, &'static str, f32),
    /// The number of pixels is not width times height.
    #[error("{0}: has {1} pixels, but its size is {2}x{3}")]
    PixelCount(String, usize, usize, usize),
    /// Two pictures of different size.
    #[error(
        "{image} has {}x{} pixels, {reference} {}x{}: pixel ({}, {}) is in one only",
        size[0], size[1], reference_size[0], reference_size[1],
        size[0].min(reference_size[0]), size[1].min(reference_size[1])
    )]
    Size {
        /// The picture.
        image: String,
        /// Width and height in pixels.
        size: [usize; 2],
        /// The reference.
        reference: String,
        /// Width and height of the reference in pixels.
        reference_size: [usize; 2],
    },
    /// A picture of display values against one of linear values.
    #[error("{0} (PNG) holds display values, {1} linear ones; compare PNG with PNG or EXR with EXR")]
    Encoding(String, String),
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
    /// A file cannot be read, or the name of a sequence is wrong.
    #[error(transparent)]
    Output(#[from] OutputError),
}

impl MetricsError {
    /// Whether the arguments are wrong, independent of the files' content.
    pub fn is_usage(&self) -> bool {
        match self {
            Self::NoLayers(_) => true,
            Self::Output(error) => error.is_usage(),
            _ => false,
        }
    }
}
