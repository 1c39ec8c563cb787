//! Normal maps from heights (MTL's bump maps).
//!
//! In: an image. Out: a linear texture of unit normals n as (n + 1) / 2: x to the right on the image, y up, z off the surface.

use glam::{Vec2, Vec3, Vec4};
use image::{DynamicImage, ImageBuffer, Luma};

use crate::formats::images::is_deep;
use crate::scene::Texture;

/// How far white lies above black, in widths of the image, where the multiplier is 1.
const HEIGHT: f32 = 0.01;

/// How much more blue than red makes an image one of normals, on average, out of 255.
const BLUISH: f32 = 40.0;

/// Whether an image shows normals rather than heights, which are grey: most normals point off the surface, which is blue.
pub(crate) fn is_normal_map(image: &DynamicImage) -> bool {
    let texels = image.to_rgb8();
    let sum: f64 = texels.pixels().map(|texel| f64::from(texel.0[2]) - f64::from(texel.0[0])).sum();
    sum > f64::from(BLUISH) * f64::from(texels.width()) * f64::from(texels.height())
}

/// The normals of a relief of these heights, times `multiplier`: central differences, as the image repeats.
pub(crate) fn of_heights(name: &str, image: &DynamicImage, multiplier: f32) -> Texture {
    let heights = image.to_luma32f();
    let (width, height) = heights.dimensions();
    let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let normals = places.map(|(x, y)| {
        let slope = slope(&heights, x, y) * (HEIGHT * multiplier * width as f32);
        Vec3::new(-slope.x, slope.y, 1.0).normalize()
    });
    if is_deep(image) {
        let texels: Vec<Vec4> = normals.map(|normal| (normal * 0.5 + 0.5).extend(1.0)).collect();
        return Texture::half_from_rgba(name, [width, height], &texels, true);
    }
    let texels = normals.flat_map(|normal| {
        let [r, g, b] = (normal * 127.5 + 127.5).round().to_array().map(|value| value as u8);
        [r, g, b, 255]
    });
    Texture::linear_from_rgba8(name, width, height, texels.collect())
}

/// Rise a texel, to the right and downwards.
fn slope(heights: &ImageBuffer<Luma<f32>, Vec<f32>>, x: u32, y: u32) -> Vec2 {
    let (width, height) = heights.dimensions();
    let at = |x: u32, y: u32| heights.get_pixel(x % width, y % height).0[0];
    let right = at(x + 1, y) - at(x + width - 1, y);
    let down = at(x, y + 1) - at(x, y + height - 1);
    Vec2::new(right, down) * 0.5
}

#[cfg(test)]
mod tests {
    use image::GrayImage;

    use super::*;

    #[test]
    fn a_ramp_has_its_slope() {
        // Rises by 2 of 255 a texel to the right, which is 0.02 a width of 64 texels: 0.01 x 64 x 2/255.
        let image = DynamicImage::ImageLuma8(GrayImage::from_fn(64, 16, |x, _| image::Luma([(2 * x) as u8])));
        assert!(!is_normal_map(&image));
        for multiplier in [1.0f32, -3.0, 40.0] {
            let map = of_heights("ramp", &image, multiplier);
            let normal = map.sample(Vec2::new(0.5, 0.5)) * 2.0 - 1.0;
            let expected = Vec3::new(-multiplier * 0.64 * 2.0 / 255.0, 0.0, 1.0).normalize();
            assert!(normal.angle_between(expected) < 0.01, "{multiplier}: {normal} {expected}");
        }
        let up = DynamicImage::ImageLuma8(GrayImage::from_fn(16, 64, |_, y| image::Luma([(2 * y) as u8])));
        let normal = of_heights("ramp", &up, 40.0).sample(Vec2::new(0.5, 0.5)) * 2.0 - 1.0;
        // It falls towards the top of the image, so the normal leans there.
        assert!(normal.y > 0.04 && normal.x.abs() < 0.01, "{normal}");
    }

    #[test]
    fn images_of_normals_are_told_from_heights() {
        let flat = DynamicImage::ImageRgb8(image::RgbImage::from_pixel(4, 4, image::Rgb([128, 128, 255])));
        assert!(is_normal_map(&flat));
        assert!(!is_normal_map(&DynamicImage::ImageRgb8(image::RgbImage::from_pixel(
            4,
            4,
            image::Rgb([90; 3])
        ))));
    }
}
