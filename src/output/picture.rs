//! A rendered frame in memory.

use std::collections::BTreeMap;

/// A rendered frame. Pixels are in rows from the top left; every buffer has `width * height` of them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Picture {
    /// Width in pixels, at least 1.
    pub width: usize,
    /// Height in pixels, at least 1.
    pub height: usize,
    /// Radiance, linear, W/m^2/sr, before exposure.
    pub colour: Vec<[f32; 3]>,
    /// Display values: exposed, tone-mapped, sRGB; the fourth channel is unused.
    pub display: Vec<[u8; 4]>,
    /// Further layers (`--layers`).
    pub layers: Vec<Layer>,
    /// Metadata by name; stored in `.exr` only.
    pub notes: BTreeMap<String, String>,
}

/// A named part of a picture, such as the normals.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Layer {
    /// Name, such as direct, indirect, albedo, normal, position, depth or instance.
    pub name: String,
    /// Channels by name (`R`, `G`, `B` for colours, `X`, `Y`, `Z` for vectors, `Z` for depth).
    pub channels: Vec<(String, Vec<f32>)>,
}

impl Layer {
    /// A layer of colours, one a pixel.
    pub fn colour(name: &str, pixels: &[[f32; 3]]) -> Self {
        Self::of_channels(name, &["R", "G", "B"], pixels)
    }

    /// A layer of vectors, one a pixel.
    pub fn vector(name: &str, pixels: &[[f32; 3]]) -> Self {
        Self::of_channels(name, &["X", "Y", "Z"], pixels)
    }

    /// A layer of the first channels of each pixel, one for each name.
    ///
    /// # Panics
    /// If there are more names than values.
    pub fn of_channels<const N: usize>(name: &str, channels: &[&str], pixels: &[[f32; N]]) -> Self {
        let channel = |(index, name): (usize, &&str)| {
            ((*name).to_owned(), pixels.iter().map(|pixel| pixel[index]).collect())
        };
        Self { name: name.to_owned(), channels: channels.iter().enumerate().map(channel).collect() }
    }

    /// A layer of one channel.
    pub fn single(name: &str, channel: &str, values: Vec<f32>) -> Self {
        Self { name: name.to_owned(), channels: vec![(channel.to_owned(), values)] }
    }
}
