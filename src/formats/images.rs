//! Image files, decoded for textures.
//!
//! In: a file or its bytes. Out: an image, or what is wrong with it; texels of a texture.

use std::io::Cursor;
use std::path::Path;

use glam::Vec4;
use image::{DynamicImage, ImageFormat, Rgba32FImage};

use super::exr_images;
use crate::activity;
use crate::scene::texture::{srgb_decoded, surplus_levels};
use crate::scene::{AlphaMask, Texture};
use crate::untrusted::{guarded, wrong_format};

/// Largest width, height and number of texels of an image, which is shrunk if it is larger than a texture.
const MAX_IMAGE_EXTENT: u64 = 32_768;
const MAX_IMAGE_TEXELS: u64 = 1 << 29;

/// Most memory of an image, bytes.
const MAX_IMAGE_BYTES: u64 = 8 * MAX_IMAGE_TEXELS;

/// Images of more texels must have a byte for so many of them: formats compress at best so.
const MOST_UNDOUBTED: u64 = 1 << 26;
const MOST_TEXELS_PER_BYTE: u64 = 10_000;

/// Reads and decodes an image; the error completes a sentence in a warning.
pub(crate) fn read_image(path: &Path) -> Result<DynamicImage, String> {
    activity::begin(format!("decoding {}", path.display()));
    let unreadable = |error: std::io::Error| format!("could not be read ({error})");
    let bytes = std::fs::read(path).map_err(unreadable)?;
    // TGA has no signature, so fall back to the extension.
    decode_image(&bytes, ImageFormat::from_path(path).ok())
}

/// Decodes an image, of `format` if it has no signature; the error completes a sentence.
pub(crate) fn decode_image(bytes: &[u8], format: Option<ImageFormat>) -> Result<DynamicImage, String> {
    if let Some(why) = wrong_format(bytes) {
        return Err(why.to_owned());
    }
    let format = image::guess_format(bytes).ok().or(format).ok_or_else(|| {
        "could not be decoded: it is no PNG, JPEG, WebP, TIFF, DDS, BMP, TGA, EXR or HDR".to_owned()
    })?;
    // The decoder silently fills the missing part of a truncated JPEG with grey.
    if format == ImageFormat::Jpeg && !jpeg_is_complete(bytes) {
        return Err("is truncated".into());
    }
    guarded(|| decode_format(bytes, format))?
}

/// What is shown in place of an image that cannot be read, as [`Texture::missing`].
pub(crate) fn checkerboard() -> DynamicImage {
    let texel = |x, y| image::Rgb(if (x + y) % 2 == 0 { [255, 0, 255] } else { [0; 3] });
    DynamicImage::ImageRgb8(image::RgbImage::from_fn(8, 8, texel))
}

fn decode_format(bytes: &[u8], format: ImageFormat) -> Result<DynamicImage, String> {
    let undecodable = |error: image::ImageError| format!("could not be decoded ({error})");
    if format == ImageFormat::OpenExr {
        return decode_exr(bytes);
    }
    let reader = || image::ImageReader::with_format(Cursor::new(bytes), format);
    let (width, height) = reader().into_dimensions().map_err(undecodable)?;
    check_size(width.into(), height.into(), bytes)?;
    let mut limits = image::Limits::default();
    limits.max_alloc = Some(MAX_IMAGE_BYTES);
    let mut reader = reader();
    reader.limits(limits);
    reader.decode().map_err(undecodable)
}

/// The crate `image` would decode on threads of its own, of which a panic ends the program.
fn decode_exr(bytes: &[u8]) -> Result<DynamicImage, String> {
    let undecodable = |error: String| format!("could not be decoded ({error})");
    let layout = exr_images::Layout::read(bytes).map_err(undecodable)?;
    for [width, height] in [layout.size, layout.data_size] {
        check_size(width as u64, height as u64, bytes)?;
    }
    let [width, height] = layout.size.map(|extent| extent as u32);
    let create = move || Rgba32FImage::new(width, height);
    let set = |image: &mut Rgba32FImage, [x, y]: [usize; 2], texel| {
        image.put_pixel(x as u32, y as u32, image::Rgba(texel));
    };
    let image = layout.texels(Cursor::new(bytes), create, set).map_err(undecodable)?;
    Ok(DynamicImage::ImageRgba32F(image))
}

/// Checks the size before memory is taken, since a malformed file may claim any.
fn check_size(width: u64, height: u64, bytes: &[u8]) -> Result<(), String> {
    let extent = width.max(height);
    let texels = width.saturating_mul(height);
    if texels == 0 {
        return Err("is empty".into());
    }
    if extent > MAX_IMAGE_EXTENT {
        return Err(format!("is {width} x {height}, must be at most {MAX_IMAGE_EXTENT} a side"));
    }
    if texels > MAX_IMAGE_TEXELS {
        return Err(format!("has more than {MAX_IMAGE_TEXELS} texels"));
    }
    if texels > MOST_UNDOUBTED.max(MOST_TEXELS_PER_BYTE * bytes.len() as u64) {
        return Err(format!("claims to have {width} x {height} texels in {} bytes", bytes.len()));
    }
    Ok(())
}

/// If the texture of an image is smaller than that: their sizes.
pub(crate) fn shrinking(image: &DynamicImage) -> Option<String> {
    let (width, height) = (image.width(), image.height());
    let surplus = surplus_levels(width, height);
    let [small_width, small_height] = [width, height].map(|extent| (extent >> surplus).max(1));
    (surplus > 0).then(|| format!("{width} x {height} texels, shrunk to {small_width} x {small_height}"))
}

/// Whether a JPEG (ITU-T T.81) reaches its end-of-image marker. Skips segments, since an embedded thumbnail has its
/// own end-of-image marker.
fn jpeg_is_complete(bytes: &[u8]) -> bool {
    const END_OF_IMAGE: u8 = 0xd9;
    let mut at = 2;
    while let Some(&[mark, kind]) = bytes.get(at..at + 2).and_then(|pair| pair.first_chunk::<2>()) {
        match (mark, kind) {
            (0xff, END_OF_IMAGE) => return true,
            // Entropy-coded data, stuffed bytes, fill bytes and markers without a length.
            (..=0xfe, _) | (0xff, 0xff) => at += 1,
            (0xff, 0x00..=0x01 | 0xd0..=0xd8) => at += 2,
            (0xff, _) => {
                let length =
                    bytes.get(at + 2..at + 4).map_or(0, |l| usize::from(l[0]) << 8 | usize::from(l[1]));
                at += 2 + length.max(2);
            }
        }
    }
    false
}

/// Whether an image has more than 8 bits a channel: its textures are half floats, all others bytes.
pub(crate) fn is_deep(image: &DynamicImage) -> bool {
    use image::ColorType::{L8, La8, Rgb8, Rgba8};
    !matches!(image.color(), L8 | La8 | Rgb8 | Rgba8)
}

/// What the texels of an image are.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum Content {
    /// Numbers.
    Data,
    /// Colours, which integers encode as sRGB and floats as it is, and the share of the surface that is there.
    Colour,
    /// Colours of a surface that is whole, whatever the alpha of the image.
    OpaqueColour,
}

/// The texture of an image; `mask`: what colours have in place of its alpha.
pub(crate) fn texture(
    name: &str,
    image: &DynamicImage,
    content: Content,
    mask: Option<&AlphaMask>,
) -> Texture {
    let (width, height) = (image.width(), image.height());
    let data = content == Content::Data;
    let alpha = |place: usize, own: f32| match (content, mask) {
        (Content::OpaqueColour, _) => 1.0,
        (_, Some(mask)) => mask.texel_of([width, height], place),
        (_, None) => own,
    };
    if !is_deep(image) {
        let mut texels = image.to_rgba8().into_raw();
        for (place, texel) in texels.chunks_exact_mut(4).enumerate() {
            texel[3] = (alpha(place, f32::from(texel[3]) / 255.0) * 255.0).round() as u8;
        }
        return match data {
            true => Texture::linear_from_rgba8(name, width, height, texels),
            false => Texture::from_rgba8(name, width, height, texels),
        };
    }
    let is_float = matches!(image, DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_));
    let decoded = |value: f32| if data || is_float { value } else { srgb_decoded(value) };
    let texel = |(place, texel): (usize, &image::Rgba<f32>)| {
        let [r, g, b, a] = texel.0;
        Vec4::new(decoded(r), decoded(g), decoded(b), alpha(place, a.clamp(0.0, 1.0)))
    };
    let texels: Vec<Vec4> = image.to_rgba32f().pixels().enumerate().map(texel).collect();
    Texture::half_from_rgba(name, [width, height], &texels, data)
}

/// A texture of roughness (green) and metallic (blue), as glTF has it, from a grey image of each; 1 where there is none.
/// It has the size of the larger; the other's nearest texels are used.
pub(crate) fn metallic_roughness(
    roughness: Option<&DynamicImage>,
    metallic: Option<&DynamicImage>,
) -> Texture {
    let deep = [roughness, metallic].iter().flatten().any(|image| is_deep(image));
    let images = [roughness, metallic].map(|image| image.map(DynamicImage::to_luma16));
    let width = images.iter().flatten().map(image::ImageBuffer::width).max().unwrap_or(1);
    let height = images.iter().flatten().map(image::ImageBuffer::height).max().unwrap_or(1);
    let value = |image: &Option<image::ImageBuffer<image::Luma<u16>, Vec<u16>>>, x: u32, y: u32| {
        image.as_ref().map_or(u16::MAX, |image| {
            let at =
                |place: u32, of: u32, size: u32| (u64::from(place) * u64::from(of) / u64::from(size)) as u32;
            image.get_pixel(at(x, image.width(), width), at(y, image.height(), height)).0[0]
        })
    };
    let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let values = places.map(|(x, y)| [value(&images[0], x, y), value(&images[1], x, y)]);
    let name = "metallic and roughness";
    if deep {
        let texel = |values: [u16; 2]| {
            let [green, blue] = values.map(|value| f32::from(value) / 65_535.0);
            Vec4::new(1.0, green, blue, 1.0)
        };
        return Texture::half_from_rgba(name, [width, height], &values.map(texel).collect::<Vec<_>>(), true);
    }
    let texels = values.flat_map(|[green, blue]| [255, (green / 257) as u8, (blue / 257) as u8, 255]);
    Texture::linear_from_rgba8(name, width, height, texels.collect())
}

/// The opacity of each texel as a mask: the alpha channel if the image has one in use, else its luminance if `luminance` is
/// set.
pub(crate) fn opacity(image: &DynamicImage, luminance: bool) -> Option<AlphaMask> {
    let mask = |values: Vec<u16>| {
        let (size, wide) = ([image.width(), image.height()], is_deep(image));
        let bytes = match wide {
            true => values.into_iter().flat_map(u16::to_le_bytes).collect(),
            false => values.into_iter().map(|value| (value / 257) as u8).collect(),
        };
        AlphaMask { wide, ..AlphaMask::new(size, bytes) }
    };
    if image.color().has_alpha() {
        let alpha: Vec<u16> = image.to_rgba16().pixels().map(|texel| texel.0[3]).collect();
        if !luminance || alpha.iter().any(|&a| a != u16::MAX) {
            return Some(mask(alpha));
        }
    }
    luminance.then(|| mask(image.to_luma16().into_raw()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn images_that_are_too_large_say_so() {
        let sizes = |width| shrinking(&DynamicImage::new_luma8(width, 1));
        assert_eq!(sizes(40_000).as_deref(), Some("40000 x 1 texels, shrunk to 10000 x 1"));
        assert_eq!(sizes(16_384), None);
    }
}
