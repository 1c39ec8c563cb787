//! Exposure and tone mapping on the CPU: twin of shaders/passes/exposure.comp and shaders/include/tone_map.glsl.
//!
//! In: linear radiance. Out: sRGB display values, by automatic exposure (Reinhard et al. 2002) and a filmic curve (the
//! ACES fit of Narkowicz 2015).

use glam::Vec3;

use super::picture::Picture;
use crate::scene::luminance;

/// Target of the log-average luminance.
const MIDDLE_GREY: f32 = 0.18;

/// Pre-exposure of the curve, which keeps middle grey fixed.
const CURVE_EXPOSURE: f32 = 0.6;

/// Stride of the histogram's pixels, in x and y.
const HISTOGRAM_STEP: usize = 4;

/// Computes `picture.display` from its colour, with `stops` of exposure, or automatic exposure over the pixels that
/// `covered` marks as showing a surface.
pub fn tone_map(picture: &mut Picture, stops: Option<f32>, covered: impl Iterator<Item = bool>) {
    let factor = stops.map_or_else(|| automatic_exposure(picture, covered), f32::exp2);
    picture.display = picture
        .colour
        .iter()
        .map(|&colour| {
            let exposed = (Vec3::from(colour) * factor).min(Vec3::splat(1e4));
            (filmic(exposed).map(encode) * 255.0).round().extend(255.0).as_u8vec4().to_array()
        })
        .collect();
}

/// The exposure factor that maps the log-average luminance, without the darkest and brightest tenth, to middle grey.
pub fn automatic_exposure(picture: &Picture, covered: impl Iterator<Item = bool>) -> f32 {
    // Eight bins a stop over 2^-16 .. 2^16; black and background pixels do not count.
    let mut bins = [0.0f32; 256];
    for ((index, colour), covered) in picture.colour.iter().enumerate().zip(covered) {
        let (x, y) = (index % picture.width, index / picture.width);
        let l = luminance(Vec3::from(*colour));
        if covered && x % HISTOGRAM_STEP == 0 && y % HISTOGRAM_STEP == 0 && l > 0.0 {
            bins[(l.log2() * 8.0 + 128.0).clamp(0.0, 255.0) as usize] += 1.0;
        }
    }
    let total: f32 = bins.iter().sum();
    let (low, high) = (0.1 * total, 0.9 * total);
    let (mut seen, mut sum, mut weight) = (0.0f32, 0.0, 0.0);
    for (bin, count) in bins.into_iter().enumerate() {
        let kept = ((seen + count).min(high) - seen.max(low)).max(0.0);
        sum += kept * (bin as f32 + 0.5 - 128.0) / 8.0;
        weight += kept;
        seen += count;
    }
    if weight > 0.0 { MIDDLE_GREY / (sum / weight).exp2() } else { 1.0 }
}

fn filmic(x: Vec3) -> Vec3 {
    let x = x * CURVE_EXPOSURE;
    ((x * (2.51 * x + 0.03)) / (x * (2.43 * x + 0.59) + 0.14)).clamp(Vec3::ZERO, Vec3::ONE)
}

fn encode(x: f32) -> f32 {
    if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 }
}
