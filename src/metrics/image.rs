//! A picture to compare.

use super::colour::{linear_to_srgb, luminance, srgb_to_linear};
use super::error::MetricsError;

/// The encoding of a picture's values.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Encoding {
    /// Proportional to radiance, as in an EXR.
    Linear,
    /// sRGB, 0 to 1, as in a PNG.
    Display,
}

/// RGB, in rows from the top left.
type Pixels = Vec<[f32; 3]>;

/// A picture of finite RGB values.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    name: String,
    size: [usize; 2],
    encoding: Encoding,
    pixels: Pixels,
}

impl Image {
    /// A picture of linear RGB. `name` appears in errors; `size` is width and height; pixels are in rows from the top
    /// left.
    ///
    /// # Errors
    /// If the number of pixels is not width times height or is 0, or a value is not finite.
    pub fn from_linear(
        name: impl Into<String>,
        size: [usize; 2],
        pixels: Pixels,
    ) -> Result<Self, MetricsError> {
        Self::new(name.into(), size, Encoding::Linear, pixels)
    }

    /// A picture of display values, sRGB in [0, 1]; otherwise like [`Self::from_linear`].
    ///
    /// # Errors
    /// The same as those of [`Self::from_linear`].
    pub fn from_display(
        name: impl Into<String>,
        size: [usize; 2],
        pixels: Pixels,
    ) -> Result<Self, MetricsError> {
        Self::new(name.into(), size, Encoding::Display, pixels)
    }

    fn new(name: String, size: [usize; 2], encoding: Encoding, pixels: Pixels) -> Result<Self, MetricsError> {
        let [width, height] = size;
        if pixels.is_empty() || width.checked_mul(height) != Some(pixels.len()) {
            return Err(MetricsError::PixelCount(name, pixels.len(), width, height));
        }
        let channels = pixels.iter().flatten();
        if let Some(at) = channels.clone().position(|value| !value.is_finite()) {
            let (pixel, channel) = (at / 3, ["red", "green", "blue"][at % 3]);
            let (x, y, value) = (pixel % width, pixel / width, pixels[pixel][at % 3]);
            let place = format!("{name}: pixel ({x}, {y})");
            return Err(MetricsError::NotFinite(place, channel, value));
        }
        Ok(Self { name, size, encoding, pixels })
    }

    /// Name in errors: the file, with its layer.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Width and height in pixels.
    pub fn size(&self) -> [usize; 2] {
        self.size
    }

    /// The encoding of the values.
    pub fn encoding(&self) -> Encoding {
        self.encoding
    }

    /// The values, in rows from the top left.
    pub fn pixels(&self) -> &[[f32; 3]] {
        &self.pixels
    }

    /// Linear RGB.
    pub(super) fn linear(&self) -> Vec<[f32; 3]> {
        match self.encoding {
            Encoding::Linear => self.pixels.clone(),
            Encoding::Display => self.mapped(srgb_to_linear),
        }
    }

    /// Linear luminance.
    pub(super) fn luminances(&self) -> Vec<f64> {
        match self.encoding {
            Encoding::Linear => self.pixels.iter().map(|&rgb| luminance(rgb)).collect(),
            Encoding::Display => self.pixels.iter().map(|rgb| luminance(rgb.map(srgb_to_linear))).collect(),
        }
    }

    /// Display values: a linear picture is exposed by `exposure` stops, clamped to [0, 1] and encoded as sRGB.
    pub(super) fn display(&self, exposure: f32) -> Vec<[f32; 3]> {
        match self.encoding {
            Encoding::Linear => self.mapped(|value| linear_to_srgb(value * exposure.exp2())),
            Encoding::Display => self.pixels.clone(),
        }
    }

    /// Display luminance, 0 to 1.
    pub(super) fn display_luminances(&self, exposure: f32) -> Vec<f64> {
        self.display(exposure).into_iter().map(luminance).collect()
    }

    fn mapped(&self, map: impl Fn(f32) -> f32) -> Vec<[f32; 3]> {
        self.pixels.iter().map(|&rgb| rgb.map(&map)).collect()
    }

    /// Fails if size or encoding differ.
    pub(super) fn check_comparable(&self, reference: &Self) -> Result<(), MetricsError> {
        if self.encoding != reference.encoding {
            let (display, linear) = match self.encoding {
                Encoding::Display => (self, reference),
                Encoding::Linear => (reference, self),
            };
            return Err(MetricsError::Encoding(display.name.clone(), linear.name.clone()));
        }
        if self.size != reference.size {
            return Err(MetricsError::Size {
                image: self.name.clone(),
                size: self.size,
                reference: reference.name.clone(),
                reference_size: reference.size,
            });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_pixel_that_is_not_finite_is_named() {
        for (value, text) in [(f32::NAN, "NaN"), (f32::INFINITY, "inf"), (f32::NEG_INFINITY, "-inf")] {
            let mut pixels = vec![[0.5; 3]; 12];
            pixels[6][1] = value;
            pixels[11][0] = value;
            let error = Image::from_linear("a.exr", [4, 3], pixels).unwrap_err().to_string();
            assert!(error.starts_with(&format!("a.exr: pixel (2, 1) has a green of {text}")), "{error}");
        }
    }

    #[test]
    fn the_pixels_must_fill_the_picture() {
        for (size, pixels) in [([0, 0], 0), ([2, 2], 3), ([usize::MAX, 2], 2)] {
            assert!(Image::from_display("a", size, vec![[0.0; 3]; pixels]).is_err());
        }
    }

    #[test]
    fn exposure_is_in_stops_and_for_linear_pictures() {
        let pixels = vec![[0.107_020_57, 0.5, 9.0]];
        let linear = Image::from_linear("a", [1, 1], pixels.clone()).unwrap();
        let [r, g, b] = linear.display(1.0)[0];
        assert!((r - 0.5).abs() < 1e-6 && (g - 1.0).abs() < 1e-6 && g == b);
        assert_eq!(Image::from_display("a", [1, 1], pixels.clone()).unwrap().display(1.0), pixels);
    }

    #[test]
    fn the_luminance_of_display_values_is_linear() {
        let image = Image::from_display("a", [1, 1], vec![[0.5; 3]]).unwrap();
        assert!((image.luminances()[0] - 0.214_041_14).abs() < 1e-6);
        assert!((image.linear()[0][0] - 0.214_041_14).abs() < 1e-6);
    }
}
