//! A rendered frame in memory.

/// A rendered frame. Pixels go by rows from the top left; every buffer has `width * height` of them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Picture {
    /// Width in pixels, at least 1.
    pub width: usize,
    /// Height in pixels, at least 1.
    pub height: usize,
    /// Radiance, linear, W/m^2/sr, before exposure.
    pub colour: Vec<[f32; 3]>,
    /// What is shown: exposed, tone-mapped, sRGB; the fourth channel is not used.
    pub display: Vec<[u8; 4]>,
    /// What else was asked for (`--layers`).
    pub layers: Vec<Layer>,
}

/// A named part of a picture, such as the normals.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Layer {
    /// Its name: direct, indirect, albedo, normal, position, depth, specular, instance or motion.
    pub name: String,
    /// Its channels by name (`R`, `G`, `B` for colours, `X`, `Y`, `Z` for vectors, `Z` for depth).
    pub channels: Vec<(String, Vec<f32>)>,
}
