//! How a surface reads a texture: one description for each use, the same for raster, shader rays and CPU rays.
//!
//! In: interpolated texture coordinates. Out: a place on the image.

use glam::{Mat2, Vec2, Vec4};

/// Continuation of an image beyond its borders.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Wrap {
    /// The image again.
    #[default]
    Repeat,
    /// The image again, every other time mirrored.
    Mirror,
    /// The texels of its border.
    Clamp,
}

impl Wrap {
    /// Both axes repeat.
    pub const REPEAT: [Self; 2] = [Self::Repeat; 2];

    /// The place in [0, 1] that is read at `x`; 0 if `x` is not finite or too large to have a fraction.
    #[inline(always)]
    pub(crate) fn place(self, x: f32) -> f32 {
        match self {
            Self::Repeat => fraction(x),
            Self::Mirror => 1.0 - (2.0 * fraction(0.5 * x) - 1.0).abs(),
            Self::Clamp if x.is_nan() => 0.0,
            Self::Clamp => x.clamp(0.0, 1.0),
        }
    }

    /// Number in shaders; twin: `wrapped` in shaders/include/wrap.glsl.
    pub(crate) fn number(self) -> u32 {
        match self {
            Self::Repeat => 0,
            Self::Mirror => 1,
            Self::Clamp => 2,
        }
    }
}

/// The place on an image that is read at `uv`, both in [0, 1].
#[inline(always)]
pub(crate) fn wrapped(uv: Vec2, [u, v]: [Wrap; 2]) -> Vec2 {
    Vec2::new(u.place(uv.x), v.place(uv.y))
}

/// `x - floor(x)`, in [0, 1]; 0 if `x` is not finite or too large to have a fraction. Avoids `floor`, which is a
/// function call without SSE4.1.
#[inline(always)]
fn fraction(x: f32) -> f32 {
    let x = if x.abs() < 8_388_608.0 { x } else { 0.0 };
    let rest = x - (x as i32) as f32;
    if rest < 0.0 { rest + 1.0 } else { rest }
}

/// Minification of an image, as samplers have it (glTF's `minFilter`). Rays on the CPU read the full image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Minified {
    /// Whether a level shows its texels as they are, the nearest; otherwise it is interpolated.
    pub nearest: bool,
    /// Which levels of the mip chain are read.
    pub levels: MipLevels,
}

/// The levels of a mip chain that are read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum MipLevels {
    /// The two that fit best, interpolated.
    #[default]
    Interpolated,
    /// The one that fits best.
    Nearest,
    /// The full image alone.
    First,
}

/// A texture as a material uses it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextureUse {
    /// Index into `Scene::textures`.
    pub texture: usize,
    /// Which of the vertices' texture coordinates: 0 or 1.
    pub set: usize,
    /// Applied to the coordinates first (KHR_texture_transform).
    pub matrix: Mat2,
    /// Added then.
    pub offset: Vec2,
    /// Wrap modes along u and v.
    pub wrap: [Wrap; 2],
    /// Whether a magnified image shows its texels as they are, the nearest; otherwise it is interpolated.
    pub nearest: bool,
    /// Minification.
    pub minified: Minified,
}

impl From<usize> for TextureUse {
    /// The texture of this index by the first coordinates, repeating.
    fn from(texture: usize) -> Self {
        let (matrix, offset) = (Mat2::IDENTITY, Vec2::ZERO);
        Self {
            texture,
            set: 0,
            matrix,
            offset,
            wrap: Wrap::REPEAT,
            nearest: false,
            minified: Minified::default(),
        }
    }
}

impl TextureUse {
    /// The coordinates on the image, before wrapping.
    #[inline]
    pub fn coordinates(&self, uvs: [Vec2; 2]) -> Vec2 {
        self.matrix * uvs[self.set] + self.offset
    }
}

/// Interpolated attributes of a surface's vertices besides position and normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Attributes {
    /// Two sets of texture coordinates, origin at the image's top left.
    pub uvs: [Vec2; 2],
    /// Linear colour and alpha, by which the base colour is multiplied.
    pub colour: Vec4,
}

impl Default for Attributes {
    fn default() -> Self {
        Vec2::ZERO.into()
    }
}

impl From<Vec2> for Attributes {
    /// White, with both sets the same.
    #[inline]
    fn from(uv: Vec2) -> Self {
        Self { uvs: [uv; 2], colour: Vec4::ONE }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn images_go_on_beyond_their_borders() {
        for (wrap, expected) in [
            (Wrap::Repeat, [0.75, 0.25, 0.25, 0.5]),
            (Wrap::Mirror, [0.25, 0.25, 0.75, 0.5]),
            (Wrap::Clamp, [0.0, 0.25, 1.0, 1.0]),
        ] {
            for (x, expected) in [-0.25, 0.25, 1.25, 2.5].into_iter().zip(expected) {
                assert_eq!(wrap.place(x), expected, "{wrap:?} at {x}");
            }
            for odd in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e30] {
                assert!((0.0..=1.0).contains(&wrap.place(odd)), "{wrap:?} at {odd}");
            }
        }
    }
}
