//! Exposure and tone mapping on the CPU: twin of shaders/passes/exposure.comp and shaders/include/tone_map.glsl.
//!
//! In: linear radiance. Out: sRGB display values, by automatic exposure and a tone curve.

use glam::{Mat3, Vec3};

use super::picture::Picture;
use crate::settings::{Settings, ToneMap};

/// Exposed luminance of the picture's median.
const MIDDLE_GREY: f32 = 0.18;

/// The percentile that is kept below white, and by how many stops at most the picture gets darker for it.
const BRIGHT: f32 = 0.985;
const MOST_DIMMED: f32 = 2.0;

/// Stride of the histogram's pixels, in x and y.
const HISTOGRAM_STEP: usize = 4;

/// How radiance is shown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tones {
    /// Stops; none: automatic.
    pub exposure: Option<f32>,
    /// The curve.
    pub curve: ToneMap,
}

impl From<&Settings> for Tones {
    fn from(settings: &Settings) -> Self {
        Self { exposure: settings.exposure, curve: settings.tone_map }
    }
}

/// Computes `picture.display` from its colour. `weights`: how much each pixel counts for automatic exposure.
pub fn tone_map(picture: &mut Picture, tones: Tones, weights: impl Iterator<Item = f32>) {
    let automatic = || automatic_exposure(picture, tones.curve, weights);
    let factor = tones.exposure.map_or_else(automatic, f32::exp2);
    picture.display = picture
        .colour
        .iter()
        .map(|&colour| {
            // Bounded first: squares overflow on very bright lights.
            let exposed = (Vec3::from(colour) * factor).min(Vec3::splat(1e4));
            let shown = curve(tones.curve, exposed).clamp(Vec3::ZERO, Vec3::ONE);
            (shown.map(encode) * 255.0).round().extend(255.0).as_u8vec4().to_array()
        })
        .collect();
}

/// The exposure factor that maps the median of the pixels' brightest channels to middle grey, less where more than 2 % of the
/// pixels would be white.
pub fn automatic_exposure(picture: &Picture, curve: ToneMap, weights: impl Iterator<Item = f32>) -> f32 {
    // Eight bins a stop over 2^-16 .. 2^16; black does not count.
    let mut bins = [0.0f32; 256];
    for ((index, colour), weight) in picture.colour.iter().enumerate().zip(weights) {
        let (x, y) = (index % picture.width, index / picture.width);
        let brightest = Vec3::from(*colour).max_element();
        if x % HISTOGRAM_STEP == 0 && y % HISTOGRAM_STEP == 0 && brightest > 0.0 {
            bins[(brightest.log2() * 8.0 + 128.0).clamp(0.0, 255.0) as usize] += (16.0 * weight).round();
        }
    }
    let total: f32 = bins.iter().sum();
    let stops_at = |share: f32| {
        let (wanted, mut before) = (share * total, 0.0);
        let mut bins = (0u8..).zip(bins);
        let place = bins.find_map(|(bin, count)| {
            before += count;
            (before >= wanted).then(|| f32::from(bin) + (wanted - before + count) / count)
        });
        (place.unwrap_or(0.0) - 128.0) / 8.0
    };
    if total == 0.0 {
        return 1.0;
    }
    let middle = MIDDLE_GREY.log2() - stops_at(0.5);
    let bright = white(curve).log2() - stops_at(BRIGHT);
    middle.min(bright.max(middle - MOST_DIMMED)).exp2()
}

/// The exposed radiance from which a grey surface is nearly white.
fn white(curve: ToneMap) -> f32 {
    match curve {
        ToneMap::Aces => 8.0,
        ToneMap::Agx => 10.0,
        ToneMap::None => 0.9,
    }
}

/// Exposed radiance to the share of white.
fn curve(curve: ToneMap, exposed: Vec3) -> Vec3 {
    match curve {
        ToneMap::Aces => aces(exposed),
        ToneMap::Agx => agx(exposed),
        ToneMap::None => exposed,
    }
}

/// The reference rendering and output transforms of ACES, as Hill fitted them; middle grey stays what it is.
fn aces(exposed: Vec3) -> Vec3 {
    const TO_RRT: Mat3 = Mat3::from_cols_array(&[
        0.59719, 0.07600, 0.02840, 0.35458, 0.90834, 0.13383, 0.04823, 0.01566, 0.83777,
    ]);
    const FROM_ODT: Mat3 = Mat3::from_cols_array(&[
        1.60475, -0.10208, -0.00327, -0.53108, 1.10813, -0.07276, -0.07367, -0.00605, 1.07602,
    ]);
    let x = TO_RRT * (1.45 * exposed);
    FROM_ODT * ((x * (x + 0.024_578_6) - 0.000_090_537) / (x * (0.983_729 * x + 0.432_951) + 0.238_081))
}

/// Sobotka's AgX, its curve by the polynomial of Wrensch: highlights lose their colour rather than change it.
fn agx(exposed: Vec3) -> Vec3 {
    const INSET: Mat3 = Mat3::from_cols_array(&[
        0.842_479_1,
        0.042_328_242,
        0.042_375_655,
        0.078_433_6,
        0.878_468_64,
        0.078_433_6,
        0.079_223_745,
        0.079_166_13,
        0.879_143,
    ]);
    const OUTSET: Mat3 = Mat3::from_cols_array(&[
        1.196_879,
        -0.052_896_85,
        -0.052_971_635,
        -0.098_020_88,
        1.151_903_1,
        -0.098_043_45,
        -0.099_029_74,
        -0.098_961_18,
        1.151_073_7,
    ]);
    const LEAST: f32 = -12.473_93;
    const MOST: f32 = 4.026_069;
    let stops = (INSET * exposed).max(Vec3::splat(1e-10)).map(f32::log2);
    let x = ((stops - LEAST) / (MOST - LEAST)).clamp(Vec3::ZERO, Vec3::ONE);
    let x2 = x * x;
    let x4 = x2 * x2;
    let y =
        15.5 * x4 * x2 - 40.14 * x4 * x + 31.96 * x4 - 6.868 * x2 * x + 0.4298 * x2 + 0.1191 * x - 0.00232;
    (OUTSET * y).max(Vec3::ZERO).map(|y| y.powf(2.2))
}

fn encode(x: f32) -> f32 {
    if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CURVES: [ToneMap; 3] = [ToneMap::Aces, ToneMap::Agx, ToneMap::None];

    #[test]
    fn curves_keep_middle_grey_rise_and_reach_white() {
        for kind in CURVES {
            let grey = |x: f32| curve(kind, Vec3::splat(x));
            assert!((grey(MIDDLE_GREY).y - 0.19).abs() < 0.03, "{kind:?}: {}", grey(MIDDLE_GREY));
            let rising: Vec<f32> =
                (0..=130).map(|i| grey(2f32.powf(f32::from(i as u8) / 10.0 - 9.0)).y).collect();
            assert!(rising.windows(2).all(|pair| pair[0] <= pair[1]), "{kind:?}: {rising:?}");
            assert!(rising[0] < 0.003 && rising[130] > 0.99, "{kind:?}: {} {}", rising[0], rising[130]);
            // Just below white.
            let nearly = encode(grey(white(kind)).max_element()) * 255.0;
            assert!((235.0..254.5).contains(&nearly), "{kind:?}: {nearly}");
        }
    }

    fn exposure_of(colours: &[[f32; 3]], curve: ToneMap, weights: Vec<f32>) -> f32 {
        let colour = colours.iter().flat_map(|&colour| [colour; 4]).collect();
        let picture = Picture { width: 4 * colours.len(), height: 1, colour, ..Picture::default() };
        automatic_exposure(&picture, curve, weights.into_iter().flat_map(|weight| [weight; 4])).log2()
    }

    #[test]
    fn the_median_is_metered_and_highlights_are_kept() {
        let of = |bright: usize, radiance: f32, weight: f32| {
            let colours: Vec<_> = (0..100).map(|i| [if i < bright { radiance } else { 0.18 }; 3]).collect();
            let weights = (0..100).map(|i| if i < bright { weight } else { 1.0 }).collect();
            exposure_of(&colours, ToneMap::Aces, weights)
        };
        // Within half a bin.
        assert!(of(0, 1.0, 1.0).abs() < 0.07);
        assert!(of(1, 1e4, 1.0).abs() < 0.07, "one of a hundred pixels may be white");
        assert!((of(5, 16.0, 1.0) + 1.0).abs() < 0.13, "{}", of(5, 20.0, 1.0));
        assert!((of(5, 1e4, 1.0) + MOST_DIMMED).abs() < 0.07, "no more darker than that");
        assert!(of(5, 1e4, 1.0 / 16.0).abs() < 0.07, "lights that are seen count little");
        assert_eq!(exposure_of(&[[0.0; 3]; 8], ToneMap::Aces, vec![1.0; 8]), 0.0);
    }
}
