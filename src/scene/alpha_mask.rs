//! Alpha masks, which cut out parts of surfaces.
//!
//! In: the alpha of an image's texels and of vertices. Out: whether a surface is there.

use std::sync::Arc;

use glam::Vec2;

use super::texture::Footprint;
use super::texture_use::Wrap;

/// Relative error of alpha at the cutoff of a mask: vertices have half floats.
const TOLERANCE: f32 = 1.0 / 2048.0;

/// The alpha by which a surface is cut out: the same for raster, CPU rays and shader rays.
#[derive(Clone, Debug, PartialEq)]
pub struct AlphaMask {
    /// Width in texels.
    pub width: u32,
    /// Height in texels.
    pub height: u32,
    /// Alpha by rows from the top, linear: a byte a texel, or two, little-endian.
    pub texels: Arc<[u8]>,
    /// Whether it is two.
    pub wide: bool,
    /// Along u and v. It is read where the texture of the base colour is.
    pub wrap: [Wrap; 2],
    /// As [`TextureUse::nearest`](super::TextureUse::nearest).
    pub nearest: bool,
    /// The surface is there where alpha, interpolated, times that of its vertices is at least this.
    pub threshold: f32,
}

impl AlphaMask {
    /// The mask of `opacity` (0 to 255 for each texel) times `dissolve`, cut at a half; none if all texels are opaque.
    pub fn from_opacity(width: u32, height: u32, opacity: &[u8], dissolve: f32) -> Option<Self> {
        let mask = Self::new([width, height], opacity.to_vec()).cut_at(0.5, dissolve);
        mask.cuts().then_some(mask)
    }

    /// The mask of `opacity` (0 to 255 for each texel), cut at a half.
    pub fn new([width, height]: [u32; 2], opacity: Vec<u8>) -> Self {
        let (wrap, nearest) = (Wrap::REPEAT, false);
        Self { width, height, texels: opacity.into(), wide: false, wrap, nearest, threshold: 0.0 }
            .cut_at(0.5, 1.0)
    }

    /// The mask of a surface that is there as far as its vertices are.
    pub fn whole() -> Self {
        Self::new([1, 1], vec![255])
    }

    /// This mask, cut where alpha times `factor` is below `cutoff`.
    pub fn cut_at(self, cutoff: f32, factor: f32) -> Self {
        let threshold = cutoff / factor.max(f32::MIN_POSITIVE) * (1.0 - TOLERANCE);
        Self { threshold: threshold.min(f32::MAX), ..self }
    }

    /// Whether any texel is cut out.
    pub fn cuts(&self) -> bool {
        (0..self.width * self.height).any(|place| self.texel(place) < self.threshold)
    }

    /// Whether no texel is opaque.
    pub fn is_empty(&self) -> bool {
        (0..self.width * self.height).all(|place| self.texel(place) < self.threshold)
    }

    fn texel(&self, place: u32) -> f32 {
        let place = place as usize;
        if self.wide {
            let at = 2 * place;
            return f32::from(u16::from_le_bytes([self.texels[at], self.texels[at + 1]])) / 65_535.0;
        }
        f32::from(self.texels[place]) / 255.0
    }

    /// The alpha where an image of another size has the texel `place`, by rows.
    pub(crate) fn texel_of(&self, [width, height]: [u32; 2], place: usize) -> f32 {
        let (x, y) = (place as u64 % u64::from(width), place as u64 / u64::from(width));
        let scaled = |at: u64, of: u32, size: u32| (at * u64::from(of) / u64::from(size)) as u32;
        self.texel(scaled(y, self.height, height) * self.width + scaled(x, self.width, width))
    }

    /// Whether the surface is opaque at `uv` (origin top left), where the alpha of its vertices is `alpha`.
    pub fn opaque_at(&self, uv: Vec2, alpha: f32) -> bool {
        let footprint = Footprint::new([self.width, self.height], uv, self.wrap, self.nearest);
        footprint.interpolate(|place| self.texel(place)) * alpha >= self.threshold
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn masks_hold_alpha_times_dissolve() {
        assert_eq!(AlphaMask::from_opacity(2, 1, &[255, 128], 1.0), None);
        let mask = AlphaMask::from_opacity(2, 1, &[255, 0], 0.9).unwrap();
        // Halfway between the middles of the texels alpha is .45; a half is at 4/9 of the way.
        let at = |u: f32| mask.opaque_at(Vec2::new(u, 0.5), 1.0);
        assert!(at(0.25) && at(0.25 + 0.5 * 0.44) && !at(0.25 + 0.5 * 0.45) && !at(0.75));
        assert!(!mask.opaque_at(Vec2::new(0.25, 0.5), 0.5) && mask.opaque_at(Vec2::new(0.25, 0.5), 0.6));
        let nearest = AlphaMask { nearest: true, ..mask };
        assert!(
            nearest.opaque_at(Vec2::new(0.49, 0.5), 1.0) && !nearest.opaque_at(Vec2::new(0.51, 0.5), 1.0)
        );
        let hidden = AlphaMask::from_opacity(1, 1, &[255], 0.4);
        assert!(hidden.is_some_and(|mask| !mask.opaque_at(Vec2::splat(0.3), 1.0)));
    }

    #[test]
    fn the_limits_of_the_cutoff() {
        let texels = |cutoff| AlphaMask::new([2, 1], vec![255, 254]).cut_at(cutoff, 1.0);
        let shown = |cutoff: f32| [0.25, 0.75].map(|u| texels(cutoff).opaque_at(Vec2::new(u, 0.5), 1.0));
        assert_eq!([0.0, 0.996, 1.0, 1.1].map(shown), [[true; 2], [true; 2], [true, false], [false; 2]]);
        assert!(!AlphaMask::new([1, 1], vec![255]).cut_at(0.5, 0.0).opaque_at(Vec2::ZERO, 1.0));
    }
}
