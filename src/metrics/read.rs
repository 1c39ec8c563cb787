//! Reads pictures: PNG as display values, OpenEXR and Radiance HDR as linear values. The signature determines the format.
//!
//! In a PNG, grey becomes RGB, alpha and colour profiles are ignored; the values count as sRGB.

use std::io::Cursor;
use std::path::Path;

use image::{ImageFormat, ImageReader, Limits};

use super::error::MetricsError;
use super::image::Image;
use super::read_exr::{check_size, read_exr};
use crate::output::OutputError;
use crate::untrusted::guarded;

const PNG_MAGIC: &[u8] = &[0x89, b'P', b'N', b'G', b'\r', b'\n', 0x1a, b'\n'];
const HDR_MAGIC: &[u8] = b"#?";
const EXR_MAGIC: &[u8] = &[0x76, 0x2f, 0x31, 0x01];

impl Image {
    /// Reads a `.png` (8 or 16 bits), `.hdr` or `.exr` (half, float or uint). `layer` names a layer of an EXR: a part, or the
    /// prefix of channels like `NAME.R`; by default the first layer with R, G and B, or with Y alone, which is grey.
    ///
    /// # Errors
    /// Each names the file: if it cannot be read or decoded, has another format, has no such layer, or has a pixel
    /// that is not finite.
    pub fn read(path: &Path, layer: Option<&str>) -> Result<Self, MetricsError> {
        let bytes =
            std::fs::read(path).map_err(|source| OutputError::Read { path: path.to_path_buf(), source })?;
        Self::decode(path, &bytes, layer)
    }

    /// Reads, like [`Self::read`], the content `bytes` of the file `path`.
    ///
    /// # Errors
    /// The same as those of [`Self::read`].
    pub fn decode(path: &Path, bytes: &[u8], layer: Option<&str>) -> Result<Self, MetricsError> {
        let name = path.display().to_string();
        if bytes.starts_with(EXR_MAGIC) {
            let (size, pixels) = read_exr(path, bytes, layer)?;
            let layer = layer.map(|layer| format!(", layer {layer}")).unwrap_or_default();
            return Self::from_linear(name + &layer, size, pixels);
        }
        let format = match bytes {
            _ if bytes.starts_with(PNG_MAGIC) => ImageFormat::Png,
            _ if bytes.starts_with(HDR_MAGIC) => ImageFormat::Hdr,
            _ => return Err(MetricsError::Foreign(path.to_path_buf())),
        };
        if layer.is_some() {
            return Err(MetricsError::NoLayers(path.to_path_buf()));
        }
        let (size, pixels) = read(path, bytes, format)?;
        match format {
            ImageFormat::Hdr => Self::from_linear(name, size, pixels),
            _ => Self::from_display(name, size, pixels),
        }
    }
}

/// Width and height, and pixels: of a PNG in [0, 1].
fn read(path: &Path, bytes: &[u8], format: ImageFormat) -> Result<([usize; 2], Vec<[f32; 3]>), MetricsError> {
    let decode_error = |error: image::ImageError| MetricsError::Decode(path.to_path_buf(), error.to_string());
    let reader = || ImageReader::with_format(Cursor::new(bytes), format);
    let (width, height) = reader().into_dimensions().map_err(decode_error)?;
    let size = [width as usize, height as usize];
    check_size(path, size)?;
    let mut reader = reader();
    reader.limits(Limits::no_limits());
    let decoded = guarded(|| reader.decode()).map_err(|why| MetricsError::Decode(path.to_path_buf(), why))?;
    let decoded = decoded.map_err(decode_error)?.into_rgb32f();
    Ok((size, decoded.pixels().map(|pixel| pixel.0).collect()))
}
