//! Textures: the sRGB transfer function, mip chains and alpha masks.
//!
//! In: texels. Out: [`Texture`]s with every mip level, filtered in linear light, and [`AlphaMask`]s.

use std::sync::LazyLock;

use glam::{UVec2, Vec2, Vec3, Vec4};

use super::material::{AlphaMask, Texture};
use super::texture_use::{Wrap, wrapped};
use crate::memory;

/// Alpha below this is transparent.
const ALPHA_THRESHOLD: f32 = 0.5;

/// Largest width and height of a texture, texels: what common devices can do.
const MAX_EXTENT: u32 = 16_384;

static SRGB_TO_LINEAR: LazyLock<[f32; 256]> = LazyLock::new(|| {
    std::array::from_fn(|i| {
        let s = i as f32 / 255.0;
        if s <= 0.04045 { s / 12.92 } else { ((s + 0.055) / 1.055).powf(2.4) }
    })
});

static BYTE_TO_LINEAR: LazyLock<[f32; 256]> = LazyLock::new(|| std::array::from_fn(|i| i as f32 / 255.0));

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

impl Texture {
    /// Builds the mip chain of `width` x `height` RGBA8 texels (sRGB colour, linear alpha), rows from the top.
    ///
    /// # Panics
    /// If `texels` is not `4 * width * height` bytes long, or empty.
    pub fn from_rgba8(name: &str, width: u32, height: u32, texels: Vec<u8>) -> Self {
        Self::new(name, [width, height], texels, false)
    }

    /// The same of linear colour.
    ///
    /// # Panics
    /// As above.
    pub fn linear_from_rgba8(name: &str, width: u32, height: u32, texels: Vec<u8>) -> Self {
        Self::new(name, [width, height], texels, true)
    }

    /// Width and height in texels.
    pub fn size(&self) -> UVec2 {
        UVec2::new(self.levels[0].0, self.levels[0].1)
    }

    fn new(name: &str, [width, height]: [u32; 2], texels: Vec<u8>, linear: bool) -> Self {
        assert!(width > 0 && height > 0 && texels.len() == 4 * width as usize * height as usize);
        let mut levels = vec![(width, height, texels)];
        while let Some((w, h, texels)) = levels.last()
            && (*w > 1 || *h > 1)
        {
            let smaller = half(*w, *h, texels, linear);
            levels.push(smaller);
        }
        levels.drain(..surplus_levels(width, height));
        Self { name: name.to_owned(), linear, levels }
    }

    /// The fallback for an unreadable image: an 8 x 8 magenta and black checkerboard.
    pub fn missing(name: &str) -> Self {
        let texels =
            (0..64).flat_map(|i| if (i % 8 + i / 8) % 2 == 0 { [255, 0, 255, 255] } else { [0, 0, 0, 255] });
        Self::from_rgba8(name, 8, 8, texels.collect())
    }

    /// Mean linear colour.
    pub fn mean(&self) -> Vec3 {
        let texel = self.levels.last().map_or(&[][..], |(_, _, texels)| texels);
        let table = self.table();
        Vec3::from_array(std::array::from_fn(|c| texel.get(c).map_or(0.0, |&value| table[value as usize])))
    }

    /// Linear colour at `uv`: level 0, bilinear, repeating, origin top left.
    pub fn sample(&self, uv: Vec2) -> Vec3 {
        self.sample_wrapped(uv, Wrap::REPEAT)
    }

    /// The same, where another wrap mode than repeating is chosen.
    pub fn sample_wrapped(&self, uv: Vec2, wrap: [Wrap; 2]) -> Vec3 {
        self.filter(self.footprint(uv, wrap))
    }

    /// The same with alpha.
    pub fn sample_rgba(&self, uv: Vec2, wrap: [Wrap; 2]) -> Vec4 {
        let footprint = self.footprint(uv, wrap);
        let alpha = |place: u32| f32::from(self.levels[0].2[4 * place as usize + 3]) / 255.0;
        let [top, bottom] = [footprint.top, footprint.bottom].map(|row| {
            let [left, right] = row.map(alpha);
            left + (right - left) * footprint.fraction.x
        });
        self.filter(footprint).extend(top + (bottom - top) * footprint.fraction.y)
    }

    fn table(&self) -> &'static [f32; 256] {
        if self.linear { &BYTE_TO_LINEAR } else { &SRGB_TO_LINEAR }
    }

    /// Interpolates four texels bilinearly, in linear light.
    pub(crate) fn filter(&self, footprint: Footprint) -> Vec3 {
        let texels = &self.levels[0].2;
        let table = self.table();
        let texel = |place: u32| {
            let texel: &[u8; 4] = texels[4 * place as usize..].first_chunk().expect("texels have four bytes");
            Vec3::new(table[texel[0] as usize], table[texel[1] as usize], table[texel[2] as usize])
        };
        let Footprint { top, bottom, fraction } = footprint;
        let top = texel(top[0]).lerp(texel(top[1]), fraction.x);
        let bottom = texel(bottom[0]).lerp(texel(bottom[1]), fraction.x);
        top.lerp(bottom, fraction.y)
    }

    /// Prefetches the texels of the bilinear filter at `uv`.
    pub(crate) fn prefetch(&self, uv: Vec2, wrap: [Wrap; 2]) -> Footprint {
        let texels = &self.levels[0].2;
        let footprint = self.footprint(uv, wrap);
        memory::prefetch(&texels[4 * footprint.top[0] as usize]);
        memory::prefetch(&texels[4 * footprint.bottom[0] as usize]);
        footprint
    }

    /// The texels of the bilinear filter at `uv`.
    #[inline(always)]
    fn footprint(&self, uv: Vec2, wrap: [Wrap; 2]) -> Footprint {
        let (width, height, _) = self.levels[0];
        // Offset by one texel, which keeps it non-negative.
        let at = wrapped(uv, wrap) * Vec2::new(width as f32, height as f32) + 0.5;
        let next = at.as_uvec2();
        let ([left, right], [top, bottom]) =
            (neighbours(next.x, width, wrap[0]), neighbours(next.y, height, wrap[1]));
        Footprint {
            top: [top * width + left, top * width + right],
            bottom: [bottom * width + left, bottom * width + right],
            fraction: at - next.as_vec2(),
        }
    }
}

/// A bilinear filter: the indices of four texels of level 0, and the interpolation weights.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Footprint {
    /// Left and right texel of the upper row.
    top: [u32; 2],
    bottom: [u32; 2],
    fraction: Vec2,
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

/// How many levels of an image's mip chain are too large for a texture.
pub(crate) fn surplus_levels(width: u32, height: u32) -> usize {
    let extent = width.max(height);
    (0..).find(|&level| extent >> level <= MAX_EXTENT).unwrap_or(0) as usize
}

impl AlphaMask {
    /// The mask of `opacity` (0 to 255 for each texel) times `dissolve`; none if all texels are opaque.
    pub fn from_opacity(width: u32, height: u32, opacity: &[u8], dissolve: f32) -> Option<Self> {
        let is_opaque = |&alpha: &u8| f32::from(alpha) / 255.0 * dissolve >= ALPHA_THRESHOLD;
        if opacity.iter().all(is_opaque) {
            return None;
        }
        let mut bits = vec![0u32; opacity.len().div_ceil(32)];
        for (i, alpha) in opacity.iter().enumerate() {
            bits[i / 32] |= u32::from(is_opaque(alpha)) << (i % 32);
        }
        Some(Self { width, height, bits, wrap: Wrap::REPEAT })
    }
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

/// The next mip level: a box filter in linear light, colour weighted by alpha so that transparent texels do not bleed
/// into opaque ones.
fn half(width: u32, height: u32, texels: &[u8], linear: bool) -> (u32, u32, Vec<u8>) {
    let decode = |byte: u8| if linear { BYTE_TO_LINEAR[byte as usize] } else { srgb_to_linear(byte) };
    let encode = |value: f32| if linear { (value * 255.0 + 0.5) as u8 } else { linear_to_srgb(value) };
    let (w, h) = ((width / 2).max(1), (height / 2).max(1));
    let mut out = Vec::with_capacity(4 * w as usize * h as usize);
    for y in 0..h {
        for x in 0..w {
            let (mut colour, mut plain, mut alpha) = (Vec3::ZERO, Vec3::ZERO, 0.0);
            for (sy, wy) in taps(y, height, h) {
                for (sx, wx) in taps(x, width, w) {
                    let i = 4 * (sy as usize * width as usize + sx as usize);
                    let texel = Vec3::from_array(std::array::from_fn(|c| decode(texels[i + c])));
                    // Data has no transparency.
                    let a = if linear { 1.0 } else { f32::from(texels[i + 3]) / 255.0 };
                    colour += texel * (a * wx * wy);
                    plain += texel * (wx * wy);
                    alpha += a * wx * wy;
                }
            }
            let mean = if alpha > 0.0 { colour / alpha } else { plain };
            out.extend(mean.to_array().map(encode));
            out.push((alpha.clamp(0.0, 1.0) * 255.0 + 0.5) as u8);
        }
    }
    (w, h, out)
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
    fn masks_hold_alpha_times_dissolve() {
        assert_eq!(AlphaMask::from_opacity(2, 1, &[255, 128], 1.0), None);
        let mask = AlphaMask::from_opacity(2, 1, &[255, 128], 0.9);
        assert_eq!(mask, Some(AlphaMask { width: 2, height: 1, bits: vec![1], wrap: Wrap::REPEAT }));
        let hidden = AlphaMask::from_opacity(1, 1, &[255], 0.4);
        assert!(hidden.is_some_and(|mask| !mask.opaque_at(Vec2::splat(0.3))));
    }

    #[test]
    fn transparent_texels_do_not_bleed() {
        let texels = vec![255, 0, 0, 255, 0, 255, 0, 0];
        let texture = Texture::from_rgba8("leaf", 2, 1, texels);
        assert_eq!(texture.levels[1].2, [255, 0, 0, 128]);
    }
}
