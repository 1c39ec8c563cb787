//! PNG: display values, 8 bits a channel, sRGB.

use std::io::Write;
use std::path::Path;

use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder, ImageError};

use super::error::OutputError;
use super::file::OutputFile;
use super::picture::Picture;

/// Writes 8-bit RGB pixels as a PNG, in rows from the top left. `size` is width and height; `path` is for errors.
///
/// # Panics
/// If `pixels` is not `3 * width * height` bytes long.
fn encode(writer: impl Write, size: [u32; 2], pixels: &[u8], path: &Path) -> Result<(), OutputError> {
    let encoded = PngEncoder::new(writer).write_image(pixels, size[0], size[1], ExtendedColorType::Rgb8);
    encoded.map_err(|error| match error {
        ImageError::IoError(source) => OutputError::Write { path: path.to_path_buf(), source },
        other => OutputError::Encode(path.to_path_buf(), other.to_string()),
    })
}

/// Writes a picture's display values as a PNG; `path` is for errors.
pub(super) fn encode_picture(writer: impl Write, picture: &Picture, path: &Path) -> Result<(), OutputError> {
    // Without the unused fourth channel.
    let pixels: Vec<u8> = picture.display.iter().flat_map(|&[r, g, b, _]| [r, g, b]).collect();
    let (width, height) = (picture.width, picture.height);
    match [width, height].map(u32::try_from) {
        [Ok(width), Ok(height)] => encode(writer, [width, height], &pixels, path),
        _ => {
            let reason = format!("{width}x{height} pixels are too many");
            Err(OutputError::Encode(path.to_path_buf(), reason))
        }
    }
}

impl OutputFile {
    /// Writes a PNG of 8-bit RGB pixels, in rows from the top left. `size` is width and height.
    ///
    /// # Panics
    /// If `pixels` is not `3 * width * height` bytes long.
    pub fn save_png(&self, size: [u32; 2], pixels: &[u8]) -> Result<(), OutputError> {
        self.save(|writer| encode(writer, size, pixels, self.path()))
    }

    /// Writes a picture's display values as a PNG.
    pub fn save_picture(&self, picture: &Picture) -> Result<(), OutputError> {
        self.save(|writer| encode_picture(writer, picture, self.path()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn display_values_round_trip() {
        let display: Vec<[u8; 4]> = (0..6).map(|i| [i, 255 - i, 10 * i, 99]).collect();
        let picture = Picture { width: 3, height: 2, display, ..Picture::default() };
        let folder = tempfile::tempdir().unwrap();
        let file = OutputFile::new(folder.path().join("a.png")).unwrap();
        file.save_picture(&picture).unwrap();
        let decoded = image::open(file.path()).unwrap();
        assert_eq!(decoded.color(), image::ColorType::Rgb8);
        let decoded = decoded.into_rgb8();
        assert_eq!(decoded.dimensions(), (3, 2));
        assert_eq!(decoded.get_pixel(2, 1).0, [5, 250, 50]);
        assert_eq!(decoded.get_pixel(0, 0).0, [0, 255, 0]);
    }
}
