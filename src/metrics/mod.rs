//! Error metrics of a picture against its reference.
//!
//! In: two pictures of one size, both linear (EXR) or both of display values (PNG). Out: [`Metrics`], and an
//! error for each pixel. MAE and RMSE are in the units of the values. Luminance is always linear; display
//! values are decoded first. PSNR and SSIM are of display values; linear pictures are first exposed, clamped to [0, 1]
//! and encoded as sRGB.

mod colour;
mod compare;
mod convolve;
mod differences;
mod error;
mod flip;
mod flip_hdr;
mod image;
mod read;
mod read_exr;
mod sequence;
mod ssim;

pub use compare::{CompareOptions, Comparison, LuminanceMetrics, Metrics, PixelError, compare, pixel_errors};
pub use differences::Blocks;
pub use error::MetricsError;
pub use flip_hdr::Exposures;
pub use image::{Encoding, Image};
pub use sequence::{FrameMetrics, Sequence, SequenceMetrics, temporal_error};

#[cfg(test)]
mod tests;
