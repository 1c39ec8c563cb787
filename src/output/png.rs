//! PNG: what is shown, 8 bits a channel, sRGB.

use std::io::Write;

use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder, ImageError, ImageResult};

use super::Picture;

/// Writes `picture.display` without its unused fourth channel.
pub(super) fn write(picture: &Picture, writer: impl Write) -> ImageResult<()> {
    let pixels: Vec<u8> = picture.display.iter().flat_map(|&[r, g, b, _]| [r, g, b]).collect();
    let (width, height) = (to_u32(picture.width)?, to_u32(picture.height)?);
    PngEncoder::new(writer).write_image(&pixels, width, height, ExtendedColorType::Rgb8)
}

fn to_u32(side: usize) -> ImageResult<u32> {
    use image::error::{ParameterError, ParameterErrorKind};
    u32::try_from(side)
        .map_err(|_| ImageError::Parameter(ParameterError::from_kind(ParameterErrorKind::DimensionMismatch)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_shown_comes_back() {
        let display: Vec<[u8; 4]> = (0..6).map(|i| [i, 255 - i, 10 * i, 99]).collect();
        let picture = Picture { width: 3, height: 2, display, ..Picture::default() };
        let mut bytes = Vec::new();
        write(&picture, &mut bytes).unwrap();
        let decoded = image::load_from_memory(&bytes).unwrap();
        assert_eq!(decoded.color(), image::ColorType::Rgb8);
        let decoded = decoded.into_rgb8();
        assert_eq!(decoded.dimensions(), (3, 2));
        assert_eq!(decoded.get_pixel(2, 1).0, [5, 250, 50]);
        assert_eq!(decoded.get_pixel(0, 0).0, [0, 255, 0]);
    }
}
