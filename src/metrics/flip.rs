//! FLIP (Andersson et al., *FLIP: A Difference Evaluator for Alternating Images*, 2020): the
//! perceived difference when alternating between two pictures.
//!
//! In: two pictures of linear RGB in [0, 1]. Out: for each pixel an error from 0, equal, to 1, the maximum. For a
//! viewing distance of 0.7 m and a display 0.7 m and 3,840 pixels wide, about 67 pixels per degree.
//!
//! Own code, since the crate `nv-flip` takes 8 bits a channel only, too coarse for the dark exposures of HDR-FLIP
//! (errors up to a tenth) and for 16-bit pictures.

use std::f32::consts::PI;

use rayon::prelude::*;

use super::convolve::{Border, Separable};

/// Pixels per degree of visual angle.
const PIXELS_PER_DEGREE: f32 = 0.7 * (3840.0 / 0.7) * (PI / 180.0);

/// Contrast sensitivity of the eye as sums of Gaussians `a sqrt(pi / b) exp(-pi² x² / b)` (table 1): a and b for
/// luminance, red-green, and the two of blue-yellow.
const SENSITIVITY: [[f32; 2]; 4] = [[1.0, 0.0047], [1.0, 0.0053], [34.1, 0.04], [13.5, 0.025]];

/// Width of the edge and point detectors, degrees (section 4.2).
const FEATURE_WIDTH: f32 = 0.082;
/// Exponents of colour and feature differences.
const COLOUR_EXPONENT: f32 = 0.7;
const FEATURE_EXPONENT: f32 = 0.5;
/// Colour differences up to this fraction of the largest map to errors up to [`KNEE_ERROR`].
const KNEE_DIFFERENCE: f32 = 0.4;
const KNEE_ERROR: f32 = 0.95;

/// XYZ of linear sRGB's primaries, by rows (D65), and its inverse.
const XYZ_FROM_RGB: [[f32; 3]; 3] = [
    [10_135_552.0 / 24_577_794.0, 8_788_810.0 / 24_577_794.0, 4_435_075.0 / 24_577_794.0],
    [2_613_072.0 / 12_288_897.0, 8_788_810.0 / 12_288_897.0, 887_015.0 / 12_288_897.0],
    [1_425_312.0 / 73_733_382.0, 8_788_810.0 / 73_733_382.0, 70_074_185.0 / 73_733_382.0],
];
const RGB_FROM_XYZ: [[f32; 3]; 3] = [
    [3.241_003_3, -1.537_398_9, -0.498_615_86],
    [-0.969_224_3, 1.875_930_1, 0.041_554_224],
    [0.055_639_42, -0.204_011_2, 1.057_148_9],
];
/// XYZ of white.
const WHITE: [f32; 3] = [0.950_428_55, 1.0, 1.088_900_4];

/// The filters of both halves of the metric, and the largest colour difference.
pub(super) struct Flip {
    sensitivity: Separable<f32, 4>,
    features: Separable<f32, 4>,
    largest_difference: f32,
}

/// Luminance, red-green and blue-yellow (YCxCz), the last one twice, since it is filtered with two kernels.
type Opponent = [f32; 4];

impl Flip {
    pub(super) fn new() -> Self {
        let [green, blue] = [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|rgb| hunt_adjusted_lab(xyz_of(rgb)));
        Self {
            sensitivity: sensitivity_filter(),
            features: feature_filter(),
            largest_difference: hyab(green, blue).powf(COLOUR_EXPONENT),
        }
    }

    /// The error of each pixel of two `size` (width, height) pictures of linear RGB in [0, 1].
    pub(super) fn errors(&self, image: &[[f32; 3]], reference: &[[f32; 3]], size: [usize; 2]) -> Vec<f32> {
        let [image, reference] = [image, reference].map(opponent_picture);
        let rows = (0..size[1]).into_par_iter().map(|y| self.error_row(&image, &reference, size, y));
        rows.flatten_iter().collect()
    }

    fn error_row(&self, image: &[Opponent], reference: &[Opponent], size: [usize; 2], y: usize) -> Vec<f32> {
        let seen = |picture: &[Opponent]| self.sensitivity.row(y, size, |x, y| picture[y * size[0] + x]);
        // Detect features in luminance, with black at 0 and white at 1.
        let features = |picture: &[Opponent]| {
            self.features.row(y, size, |x, y| [(picture[y * size[0] + x][0] + 16.0) / 116.0; 4])
        };
        let colours = seen(image).into_iter().zip(seen(reference));
        let details = features(image).into_iter().zip(features(reference));
        colours
            .zip(details)
            .map(|((a, b), (features_a, features_b))| {
                let colour = self.colour_difference(a, b);
                colour.powf(1.0 - feature_difference(features_a, features_b))
            })
            .collect()
    }

    /// The difference of two filtered colours, 0 to 1 (section 4.1).
    fn colour_difference(&self, a: Opponent, b: Opponent) -> f32 {
        let [a, b] = [a, b].map(|[y, cx, cz_1, cz_2]| {
            let rgb = times(&RGB_FROM_XYZ, xyz_from_opponent([y, cx, cz_1 + cz_2]));
            hunt_adjusted_lab(xyz_of(rgb.map(|channel| channel.clamp(0.0, 1.0))))
        });
        let difference = hyab(a, b).powf(COLOUR_EXPONENT);
        let knee = KNEE_DIFFERENCE * self.largest_difference;
        if difference < knee {
            difference * KNEE_ERROR / knee
        } else {
            KNEE_ERROR + (difference - knee) / (self.largest_difference - knee) * (1.0 - KNEE_ERROR)
        }
    }
}

/// The difference of edges and points, 0 to 1 (section 4.2), from the first derivatives in x and y and the second
/// derivatives.
fn feature_difference(a: [f32; 4], b: [f32; 4]) -> f32 {
    let edge = |[dx, dy, _, _]: [f32; 4]| dx.hypot(dy);
    let point = |[_, _, ddx, ddy]: [f32; 4]| ddx.hypot(ddy);
    let difference = (edge(a) - edge(b)).abs().max((point(a) - point(b)).abs());
    (difference / 2.0_f32.sqrt()).powf(FEATURE_EXPONENT)
}

/// The contrast sensitivity filter. The kernels of one channel sum to 1.
fn sensitivity_filter() -> Separable<f32, 4> {
    let widest = SENSITIVITY.iter().fold(0.0, |widest: f32, &[_, b]| widest.max(b));
    let radius = (3.0 * (widest / (2.0 * PI * PI)).sqrt() * PIXELS_PER_DEGREE).ceil() as i32;
    let tap = |tap: i32| {
        let x = tap as f32 / PIXELS_PER_DEGREE;
        // Each kernel is used twice, along columns and rows, so its height is the root of the Gaussian's.
        SENSITIVITY.map(|[a, b]| (a * (PI / b).sqrt()).sqrt() * (-PI * PI * x * x / b).exp())
    };
    let mut taps: Vec<_> = (-radius..=radius).map(tap).collect();
    let sum_of = |lane: usize| taps.iter().map(|weights| weights[lane]).sum::<f32>();
    let [luminance, red_green, wide, narrow] = [0, 1, 2, 3].map(sum_of);
    let blue_yellow = wide.hypot(narrow);
    let sums = [luminance, red_green, blue_yellow, blue_yellow];
    taps.iter_mut().for_each(|weights| (0..4).for_each(|lane| weights[lane] /= sums[lane]));
    Separable { along_columns: taps.clone(), along_rows: taps, border: Border::Clamp }
}

/// First derivatives in x and y, then second derivatives, of a Gaussian. The weights of each sign sum to 1 (of the
/// Gaussian itself: all weights).
fn feature_filter() -> Separable<f32, 4> {
    let deviation = 0.5 * FEATURE_WIDTH * PIXELS_PER_DEGREE;
    let radius = (3.0 * deviation).ceil() as i32;
    let kernel = |derivative: &dyn Fn(f32) -> f32| {
        let gaussian = |x: f32| (-x * x / (2.0 * deviation * deviation)).exp();
        let taps: Vec<_> =
            (-radius..=radius).map(|tap| derivative(tap as f32) * gaussian(tap as f32)).collect();
        let sum_of = |sign: f32| taps.iter().map(|tap| (sign * tap).max(0.0)).sum::<f32>();
        let sums = [sum_of(1.0), sum_of(-1.0)];
        taps.into_iter().map(|tap| tap / if tap > 0.0 { sums[0] } else { sums[1] }).collect::<Vec<f32>>()
    };
    let gaussian = kernel(&|_| 1.0);
    let first = kernel(&|x| -x);
    let second = kernel(&|x| x * x / (deviation * deviation) - 1.0);
    let taps = |kernels: [&[f32]; 4]| {
        (0..gaussian.len()).map(|tap| kernels.map(|kernel| kernel[tap])).collect::<Vec<_>>()
    };
    Separable {
        along_columns: taps([&gaussian, &first, &gaussian, &second]),
        along_rows: taps([&first, &gaussian, &second, &gaussian]),
        border: Border::Clamp,
    }
}

fn opponent_picture(rgb: &[[f32; 3]]) -> Vec<Opponent> {
    let opponent = |&rgb: &[f32; 3]| {
        let [x, y, z] = relative_to_white(xyz_of(rgb));
        let blue_yellow = 200.0 * (y - z);
        [116.0 * y - 16.0, 500.0 * (x - y), blue_yellow, blue_yellow]
    };
    rgb.par_iter().map(opponent).collect()
}

fn xyz_from_opponent([y, cx, cz]: [f32; 3]) -> [f32; 3] {
    let y = (y + 16.0) / 116.0;
    let relative = [y + cx / 500.0, y, y - cz / 200.0];
    [0, 1, 2].map(|i| relative[i] * WHITE[i])
}

/// CIELAB with chroma scaled by lightness, as colour differences are less visible in the dark (Hunt effect).
fn hunt_adjusted_lab(xyz: [f32; 3]) -> [f32; 3] {
    const DELTA: f32 = 6.0 / 29.0;
    let [x, y, z] = relative_to_white(xyz)
        .map(|t| if t > DELTA * DELTA * DELTA { t.cbrt() } else { t / (3.0 * DELTA * DELTA) + 4.0 / 29.0 });
    let lightness = 116.0 * y - 16.0;
    [lightness, 0.01 * lightness * 500.0 * (x - y), 0.01 * lightness * 200.0 * (y - z)]
}

/// HyAB, a distance for large colour differences (Abasi et al. 2020).
fn hyab(a: [f32; 3], b: [f32; 3]) -> f32 {
    (a[0] - b[0]).abs() + (a[1] - b[1]).hypot(a[2] - b[2])
}

fn xyz_of(rgb: [f32; 3]) -> [f32; 3] {
    times(&XYZ_FROM_RGB, rgb)
}

fn relative_to_white(xyz: [f32; 3]) -> [f32; 3] {
    [0, 1, 2].map(|i| xyz[i] / WHITE[i])
}

fn times(matrix: &[[f32; 3]; 3], v: [f32; 3]) -> [f32; 3] {
    matrix.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: [usize; 2] = [40, 30];

    fn constant(rgb: [f32; 3]) -> Vec<[f32; 3]> {
        vec![rgb; SIZE[0] * SIZE[1]]
    }

    /// Results of flip-evaluator 1.7. In HyAB the distance of black and white is 100, that of green and blue, the
    /// farthest pair, 203.3.
    #[test]
    fn constant_pictures_differ_as_their_colours() {
        let flip = Flip::new();
        let (black, white) = ([0.0; 3], [1.0; 3]);
        let (red, green, blue) = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
        for (a, b, expected) in [(black, white, 0.967_396_9), (green, blue, 1.0), (red, black, 0.970_502_4)] {
            let errors = flip.errors(&constant(a), &constant(b), SIZE);
            assert!(errors.iter().all(|error| (error - expected).abs() < 1e-5), "{} {expected}", errors[0]);
        }
    }

    #[test]
    fn equal_pictures_have_no_error_and_flip_is_symmetric() {
        let flip = Flip::new();
        let a: Vec<_> = (0..SIZE[0] * SIZE[1])
            .map(|i| [(i % 7) as f32 / 6.0, (i % 5) as f32 / 4.0, (i % 3) as f32 / 2.0])
            .collect();
        let b: Vec<_> = a.iter().map(|&[r, g, b]| [g, r * 0.5, b]).collect();
        assert!(flip.errors(&a, &a, SIZE).iter().all(|&error| error == 0.0));
        let errors = flip.errors(&a, &b, SIZE);
        assert_eq!(errors, flip.errors(&b, &a, SIZE));
        assert!(errors.iter().all(|error| (0.0..=1.0).contains(error)));
    }

    /// A ramp has a constant first derivative and no second derivative.
    #[test]
    fn features_are_derivatives() {
        let flip = Flip::new();
        let slope = 1.0 / 64.0;
        let row = flip.features.row(30, [64, 60], |x, _| [slope * x as f32; 4]);
        let [dx, dy, ddx, ddy] = row[32];
        assert!(dy.abs() < 1e-6 && ddx.abs() < 1e-6 && ddy.abs() < 1e-6, "{:?}", row[32]);
        // The weights' mean distance from the centre on one side, and on the other, is what a unit slope gives.
        let distance: f32 =
            (0..).zip(&flip.features.along_rows).map(|(i, w)| (i as f32 - 9.0).abs() * w[0].abs()).sum();
        assert!((dx.abs() - slope * distance).abs() < 1e-6);
    }
}
