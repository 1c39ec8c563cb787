//! Textures: the sRGB transfer function, mip chains and filters.
//!
//! In: texels. Out: [`Texture`]s with every mip level, filtered in linear light.

use std::ops::{Add, Mul, Sub};
use std::sync::LazyLock;

use exr::prelude::f16;
use glam::{UVec2, Vec2, Vec3, Vec4};

use super::material::Texture;
use super::texture_use::{TextureUse, Wrap, wrapped};
use crate::memory;

/// Largest width and height of a texture, texels: the limit of common devices.
const MAX_EXTENT: u32 = 16_384;

static SRGB_TO_LINEAR: LazyLock<[f32; 256]> =
    LazyLock::new(|| std::array::from_fn(|i| srgb_decoded(i as f32 / 255.0)));

static BYTE_TO_LINEAR: LazyLock<[f32; 256]> = LazyLock::new(|| std::array::from_fn(|i| i as f32 / 255.0));

/// Decodes one sRGB channel to linear, both in [0, 1] (IEC 61966-2-1).
pub(crate) fn srgb_decoded(s: f32) -> f32 {
    if s <= 0.04045 { s / 12.92 } else { ((s + 0.055) / 1.055).powf(2.4) }
}

/// Decodes one 8-bit sRGB channel to linear [0, 1] (IEC 61966-2-1).
pub fn srgb_to_linear(encoded: u8) -> f32 {
    SRGB_TO_LINEAR[encoded as usize]
}

/// Encodes one linear channel, clamped to [0, 1], as 8-bit sRGB (IEC 61966-2-1).
pub fn linear_to_srgb(linear: f32) -> u8 {
    let l = linear.clamp(0.0, 1.0);
    let s = if l <= 0.003_130_8 { l * 12.92 } else { 1.055 * l.powf(1.0 / 2.4) - 0.055 };
    (s * 255.0 + 0.5) as u8
}

/// Largest finite half float: brighter texels are that bright.
const MOST_HALF: f32 = 65_504.0;

/// Bytes of a texel of 8 bits a channel, and of half floats.
const TEXEL_BYTES: [usize; 2] = [4, 8];

impl Texture {
    /// Builds the mip chain of `width` x `height` RGBA8 texels (sRGB colour, linear alpha), rows from the top.
    ///
    /// # Panics
    /// If `texels` is not `4 * width * height` bytes long, or empty.
    pub fn from_rgba8(name: &str, width: u32, height: u32, texels: Vec<u8>) -> Self {
        Self { name: name.to_owned(), linear: false, half: false, levels: vec![(width, height, texels)] }
            .complete()
    }

    /// Builds the mip chain of texels of linear colour.
    ///
    /// # Panics
    /// As above.
    pub fn linear_from_rgba8(name: &str, width: u32, height: u32, texels: Vec<u8>) -> Self {
        Self { name: name.to_owned(), linear: true, half: false, levels: vec![(width, height, texels)] }
            .complete()
    }

    /// Width and height in texels.
    pub fn size(&self) -> UVec2 {
        UVec2::new(self.levels[0].0, self.levels[0].1)
    }

    /// Builds the mip chain of texels that are kept as half floats, of linear colour; `linear`: they are data, which has no transparency.
    ///
    /// # Panics
    /// If there are not `width * height` texels, or none.
    pub fn half_from_rgba(name: &str, [width, height]: [u32; 2], texels: &[Vec4], linear: bool) -> Self {
        let texels = texels.iter().flat_map(|&texel| half_texel(texel)).collect();
        Self { name: name.to_owned(), linear, half: true, levels: vec![(width, height, texels)] }.complete()
    }

    /// Adds the mip chain to level 0.
    fn complete(mut self) -> Self {
        let (width, height, texels) = &self.levels[0];
        let (width, height) = (*width, *height);
        let bytes = TEXEL_BYTES[usize::from(self.half)] * width as usize * height as usize;
        assert!(bytes > 0 && texels.len() == bytes);
        while let Some(&(w, h, _)) = self.levels.last()
            && (w > 1 || h > 1)
        {
            let smaller = self.half_of(self.levels.len() - 1);
            self.levels.push(smaller);
        }
        self.levels.drain(..surplus_levels(width, height));
        self
    }

    /// The fallback for an unreadable image: an 8 x 8 magenta and black checkerboard.
    pub fn missing(name: &str) -> Self {
        let texels =
            (0..64).flat_map(|i| if (i % 8 + i / 8) % 2 == 0 { [255, 0, 255, 255] } else { [0, 0, 0, 255] });
        Self::from_rgba8(name, 8, 8, texels.collect())
    }

    /// Mean linear colour.
    pub fn mean(&self) -> Vec3 {
        self.texel(self.levels.len() - 1, 0).truncate()
    }

    /// Linear colour at `uv`: level 0, bilinear, repeating, origin top left.
    pub fn sample(&self, uv: Vec2) -> Vec3 {
        self.filter(self.footprint(uv, &0.into()))
    }

    /// Linear colour with alpha, as a material reads it; `uv` are coordinates on the image.
    pub fn sample_rgba(&self, uv: Vec2, texture: &TextureUse) -> Vec4 {
        self.footprint(uv, texture).interpolate(|place| self.texel(0, place))
    }

    /// Linear colour and alpha of texel `place` of a level, by rows from the top.
    pub fn texel(&self, level: usize, place: u32) -> Vec4 {
        let texels = &self.levels[level].2;
        if self.half {
            let bytes = &texels[8 * place as usize..];
            return Vec4::from_array(std::array::from_fn(|c| half_value([bytes[2 * c], bytes[2 * c + 1]])));
        }
        let texel = &texels[4 * place as usize..];
        let [r, g, b] = std::array::from_fn(|c| self.table()[texel[c] as usize]);
        Vec4::new(r, g, b, BYTE_TO_LINEAR[texel[3] as usize])
    }

    fn table(&self) -> &'static [f32; 256] {
        if self.linear { &BYTE_TO_LINEAR } else { &SRGB_TO_LINEAR }
    }

    /// Interpolates four texels bilinearly, in linear light.
    pub(crate) fn filter(&self, footprint: Footprint) -> Vec3 {
        if self.half {
            return footprint.interpolate(|place| self.texel(0, place)).truncate();
        }
        let texels = &self.levels[0].2;
        let table = self.table();
        let texel = |place: u32| {
            let texel: &[u8; 4] = texels[4 * place as usize..].first_chunk().expect("texels have four bytes");
            Vec3::new(table[texel[0] as usize], table[texel[1] as usize], table[texel[2] as usize])
        };
        footprint.interpolate(texel)
    }

    /// Prefetches the texels of the filter at `uv`.
    pub(crate) fn prefetch(&self, uv: Vec2, texture: &TextureUse) -> Footprint {
        let texels = &self.levels[0].2;
        let footprint = self.footprint(uv, texture);
        let bytes = TEXEL_BYTES[usize::from(self.half)];
        memory::prefetch(&texels[bytes * footprint.top[0] as usize]);
        memory::prefetch(&texels[bytes * footprint.bottom[0] as usize]);
        footprint
    }

    /// The filter at `uv`, on the image, as a material reads it.
    #[inline(always)]
    pub(crate) fn footprint(&self, uv: Vec2, texture: &TextureUse) -> Footprint {
        let (width, height, _) = self.levels[0];
        Footprint::new([width, height], uv, texture.wrap, texture.nearest)
    }
}

/// A bilinear filter: the indices of four texels of level 0, and the interpolation weights. Twin: `footprint_at` in
/// shaders/include/bilinear.glsl.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Footprint {
    /// Left and right texel of the upper row.
    top: [u32; 2],
    bottom: [u32; 2],
    fraction: Vec2,
}

impl Footprint {
    /// The filter at `uv` on an image of this size; the nearest texel alone if `nearest`.
    #[inline(always)]
    pub(super) fn new([width, height]: [u32; 2], uv: Vec2, wrap: [Wrap; 2], nearest: bool) -> Self {
        let size = Vec2::new(width as f32, height as f32);
        let place = wrapped(uv, wrap) * size;
        // Offset by one texel, which keeps it non-negative.
        let at = if nearest { place.as_uvec2().as_vec2().min(size - 1.0) + 1.0 } else { place + 0.5 };
        let next = at.as_uvec2();
        let ([left, right], [top, bottom]) =
            (neighbours(next.x, width, wrap[0]), neighbours(next.y, height, wrap[1]));
        Self {
            top: [top * width + left, top * width + right],
            bottom: [bottom * width + left, bottom * width + right],
            fraction: at - next.as_vec2(),
        }
    }

    /// Interpolates what `texel` gives. Equal texels give their value, bit for bit.
    #[inline(always)]
    pub(super) fn interpolate<T>(self, texel: impl Fn(u32) -> T) -> T
    where
        T: Copy + Add<Output = T> + Sub<Output = T> + Mul<f32, Output = T>,
    {
        let between = |[left, right]: [T; 2], part: f32| left + (right - left) * part;
        let row = |places: [u32; 2]| between(places.map(&texel), self.fraction.x);
        between([row(self.top), row(self.bottom)], self.fraction.y)
    }
}

/// The texels `next - 1` and `next`, with `next` from 0 to `size`: wrapped around, or those of the border.
#[inline(always)]
fn neighbours(next: u32, size: u32, wrap: Wrap) -> [u32; 2] {
    if wrap != Wrap::Repeat {
        return [next.saturating_sub(1).min(size - 1), next.min(size - 1)];
    }
    let first = if next == 0 { size - 1 } else { (next - 1).min(size - 1) };
    let second = if first + 1 == size { 0 } else { first + 1 };
    [first, second]
}

fn half_value(bytes: [u8; 2]) -> f32 {
    f16::from_le_bytes(bytes).to_f32()
}

/// A texel of half floats; NaN and values below 0 become 0.
fn half_texel(texel: Vec4) -> [u8; 8] {
    let bounded = |value: f32| if value > 0.0 { value.min(MOST_HALF) } else { 0.0 };
    let half = |value: f32| f16::from_f32(bounded(value)).to_le_bytes();
    bytemuck::cast(texel.to_array().map(half))
}

/// How many levels of an image's mip chain are too large for a texture.
pub(crate) fn surplus_levels(width: u32, height: u32) -> usize {
    let extent = width.max(height);
    (0..).find(|&level| extent >> level <= MAX_EXTENT).unwrap_or(0) as usize
}

/// The texels along one axis under a texel of the next level, with their box filter weights.
fn taps(i: u32, from: u32, to: u32) -> impl Iterator<Item = (u32, f32)> {
    let scale = from as f32 / to as f32;
    let (start, end) = (i as f32 * scale, (i + 1) as f32 * scale);
    (start as u32..from.min(end.ceil() as u32)).map(move |x| {
        let overlap = end.min((x + 1) as f32) - start.max(x as f32);
        (x, overlap.max(0.0) / scale)
    })
}

impl Texture {
    /// The mip level after `level`: a box filter in linear light, colour weighted by alpha so that transparent texels do not
    /// bleed into opaque ones.
    fn half_of(&self, level: usize) -> (u32, u32, Vec<u8>) {
        let (width, height, _) = self.levels[level];
        let encode =
            |value: f32| if self.linear { (value * 255.0 + 0.5) as u8 } else { linear_to_srgb(value) };
        let (w, h) = ((width / 2).max(1), (height / 2).max(1));
        let mut out = Vec::with_capacity(TEXEL_BYTES[usize::from(self.half)] * w as usize * h as usize);
        for y in 0..h {
            for x in 0..w {
                let (mut colour, mut plain, mut alpha) = (Vec3::ZERO, Vec3::ZERO, 0.0);
                for (sy, wy) in taps(y, height, h) {
                    for (sx, wx) in taps(x, width, w) {
                        let texel = self.texel(level, sy * width + sx);
                        // Data has no transparency.
                        let a = if self.linear { 1.0 } else { texel.w };
                        colour += texel.truncate() * (a * wx * wy);
                        plain += texel.truncate() * (wx * wy);
                        alpha += a * wx * wy;
                    }
                }
                let mean = if alpha > 0.0 { colour / alpha } else { plain };
                if self.half {
                    out.extend(half_texel(mean.extend(alpha)));
                    continue;
                }
                out.extend(mean.to_array().map(encode));
                out.push((alpha.clamp(0.0, 1.0) * 255.0 + 0.5) as u8);
            }
        }
        (w, h, out)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn checkerboard(width: u32, height: u32) -> Texture {
        let texels = (0..width * height).flat_map(|i| {
            let v = if (i % width + i / width).is_multiple_of(2) { 255 } else { 0 };
            [v, v, v, 255]
        });
        Texture::from_rgba8("checkerboard", width, height, texels.collect())
    }

    #[test]
    fn checkerboard_is_averaged_in_linear_light() {
        let texture = checkerboard(8, 8);
        let sizes: Vec<_> = texture.levels.iter().map(|level| (level.0, level.1)).collect();
        assert_eq!(sizes, [(8, 8), (4, 4), (2, 2), (1, 1)]);
        // Half of the light is 188 in sRGB, not 128.
        for level in &texture.levels[1..] {
            assert!(level.2.chunks(4).all(|texel| texel == [188, 188, 188, 255]), "{level:?}");
        }
    }

    #[test]
    fn odd_sizes_keep_the_mean() {
        for (width, height) in [(5, 3), (7, 1), (1, 9), (6, 5)] {
            let texels = (0..width * height).flat_map(|i| [(i * 37 % 256) as u8, 0, 255, 255]);
            let texture = Texture::from_rgba8("odd", width, height, texels.collect());
            let mean = |level: &(u32, u32, Vec<u8>)| {
                level.2.chunks(4).map(|texel| srgb_to_linear(texel[0])).sum::<f32>()
                    / (level.0 * level.1) as f32
            };
            let first = mean(&texture.levels[0]);
            for level in &texture.levels {
                assert!((mean(level) - first).abs() < 0.01, "{width}x{height}: {} {first}", mean(level));
            }
            assert_eq!(texture.levels.last().map(|level| (level.0, level.1)), Some((1, 1)));
        }
    }

    #[test]
    fn textures_that_are_too_large_are_shrunk() {
        let texels: Vec<u8> =
            (0..40_000).flat_map(|x| [if x % 2 == 0 { 0 } else { 255 }, 9, 9, 255]).collect();
        let texture = Texture::from_rgba8("long", 40_000, 1, texels);
        let (width, height, first) = &texture.levels[0];
        assert_eq!((*width, *height), (10_000, 1));
        assert!(first.chunks(4).all(|texel| texel == [188, 9, 9, 255]));
    }

    #[test]
    fn srgb_round_trips() {
        for i in 0..=255 {
            assert_eq!(linear_to_srgb(srgb_to_linear(i)), i);
        }
    }

    #[test]
    fn sampling_is_bilinear_and_repeats() {
        let texels = vec![0, 0, 0, 255, 255, 255, 255, 255];
        let texture = Texture::from_rgba8("two", 2, 1, texels);
        for (u, expected) in [(0.25, 0.0), (0.75, 1.0), (0.5, 0.5), (0.0, 0.5), (1.75, 1.0), (-0.25, 1.0)] {
            let got = texture.sample(Vec2::new(u, 3.3)).x;
            assert!((got - expected).abs() < 1e-5, "{u}: {got}");
        }
        assert!(texture.sample(Vec2::new(f32::NAN, f32::INFINITY)).is_finite());
    }

    #[test]
    fn deep_texels_keep_their_depth() {
        let texels: Vec<Vec4> = (0..64).map(|i| Vec4::splat((0.5 + i as f32 / 2048.0).min(1.0))).collect();
        let texture = Texture::half_from_rgba("deep", [64, 1], &texels, false);
        for (place, texel) in (0..).zip(&texels) {
            assert_eq!(texture.texel(0, place), *texel);
            assert_eq!(texture.sample(Vec2::new((place as f32 + 0.5) / 64.0, 0.5)), texel.truncate());
        }
        let bright = Texture::half_from_rgba("bright", [2, 1], &[Vec4::splat(8.0), Vec4::ZERO], true);
        assert_eq!((bright.mean(), bright.levels.len()), (Vec3::splat(4.0), 2));
    }

    #[test]
    fn transparent_texels_do_not_bleed() {
        let texels = vec![255, 0, 0, 255, 0, 255, 0, 0];
        let texture = Texture::from_rgba8("leaf", 2, 1, texels);
        assert_eq!(texture.levels[1].2, [255, 0, 0, 128]);
    }
}
