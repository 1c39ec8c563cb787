//! HDR-FLIP (Andersson et al., *Visualizing Errors in Rendered High Dynamic Range Images*, 2021): the
//! maximum of FLIP over the reference's range of exposures.
//!
//! In: two pictures of linear RGB; negative values count as 0. Out: the error of each pixel, 0 to 1. Exposures, about
//! one stop apart, range from the one that tone-maps the reference's brightest pixel to 0.85 to the one that does so
//! for its median.

use rayon::prelude::*;
use serde::Serialize;

use super::colour::luminance;
use super::flip::Flip;

/// The ACES curve `(a c² + b c) / (d c² + e c + f)` (Narkowicz 2015, without its pre-exposure of 0.6).
const ACES: [f32; 5] = [0.36 * 2.51, 0.6 * 0.03, 0.36 * 2.43, 0.6 * 0.59, 0.14];
/// Tone-mapped value at the ends of the range.
const TARGET: f32 = 0.85;
/// Values from here on are white at every exposure; squares of larger ones would overflow f32.
const WHITE: f32 = 1.0e6;

/// The exposures at which pictures were compared, in stops.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Exposures {
    /// The lowest.
    pub start: f32,
    /// The highest.
    pub stop: f32,
    /// Number of equidistant exposures; at least 2.
    pub count: u32,
}

impl Exposures {
    /// The range of `reference` (section 3).
    pub(super) fn of(reference: &[[f32; 3]]) -> Self {
        // Lower bound of the median, as in the authors' program, and of the brightest pixel.
        const DARKEST: f32 = f32::EPSILON;
        let mut luminances: Vec<f32> =
            reference.iter().map(|&rgb| luminance(not_negative(rgb)) as f32).collect();
        let brightest = luminances.iter().fold(DARKEST, |brightest, &luminance| brightest.max(luminance));
        let middle = luminances.len() / 2;
        let median = luminances.select_nth_unstable_by(middle, f32::total_cmp).1.max(DARKEST);
        let [start, stop] = [brightest, median].map(|luminance| (target_value() / luminance).log2());
        Self { start, stop, count: (stop - start).ceil().max(2.0) as u32 }
    }

    fn factors(self) -> impl Iterator<Item = f32> {
        let step = (self.stop - self.start) / (self.count - 1) as f32;
        (0..self.count).map(move |i| (self.start + i as f32 * step).exp2())
    }
}

impl Flip {
    /// The largest error of each pixel of two `size` (width, height) pictures over `exposures`.
    pub(super) fn hdr_errors(
        &self,
        image: &[[f32; 3]],
        reference: &[[f32; 3]],
        size: [usize; 2],
        exposures: Exposures,
    ) -> Vec<f32> {
        let mut largest = vec![0.0_f32; image.len()];
        for factor in exposures.factors() {
            let [image, reference] = [image, reference].map(|picture| tone_mapped(picture, factor));
            let errors = self.errors(&image, &reference, size);
            largest.iter_mut().zip(errors).for_each(|(largest, error)| *largest = largest.max(error));
        }
        largest
    }
}

fn tone_mapped(picture: &[[f32; 3]], factor: f32) -> Vec<[f32; 3]> {
    let [a, b, d, e, f] = ACES;
    let curve = |value: f32| {
        let c = (value * factor).min(WHITE);
        ((a * c * c + b * c) / (d * c * c + e * c + f)).clamp(0.0, 1.0)
    };
    picture.par_iter().map(|&rgb| not_negative(rgb).map(curve)).collect()
}

/// The value that the tone mapper maps to [`TARGET`].
fn target_value() -> f32 {
    let [a, b, d, e, f] = ACES;
    // The greater root of (a - s d) c² + (b - s e) c - s f = 0.
    let (square, linear, constant) = (a - TARGET * d, b - TARGET * e, -TARGET * f);
    let half = -0.5 * linear / square;
    half + (half * half - constant / square).sqrt()
}

fn not_negative(rgb: [f32; 3]) -> [f32; 3] {
    rgb.map(|channel| channel.max(0.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grey(values: impl IntoIterator<Item = f32>) -> Vec<[f32; 3]> {
        values.into_iter().map(|value| [value; 3]).collect()
    }

    /// The parameters that flip-evaluator 1.7 reports for the same pictures.
    #[test]
    fn exposures_match_the_authors_program() {
        for (picture, start, stop, count) in [
            (grey((1..=64).map(|i| i as f32)), -4.916_702_7, -3.961_097, 2),
            (grey([1.0; 64]), 1.083_297_3, 1.083_297_3, 2),
            (grey((0..64).map(|i| if i == 0 { 1.0 } else { 0.0 })), 1.083_297_3, 24.083_298, 23),
            (grey((0..64).map(|i| if i < 40 { 0.0 } else { 1.0 + i as f32 })), -4.916_702_7, 24.083_298, 29),
            (grey((0..64).map(|i| i as f32 - 40.0)), -3.440_265, 24.083_298, 28),
        ] {
            let exposures = Exposures::of(&picture);
            assert!((exposures.start - start).abs() < 2e-6, "{exposures:?}");
            assert!((exposures.stop - stop).abs() < 2e-6, "{exposures:?}");
            assert_eq!(exposures.count, count);
        }
    }

    #[test]
    fn a_black_reference_differs_from_a_picture_that_is_not_black() {
        let (black, size) = (grey([0.0; 400]), [20, 20]);
        let exposures = Exposures::of(&black);
        assert_eq!((exposures.start, exposures.count), (exposures.stop, 2));
        let flip = Flip::new();
        assert!(flip.hdr_errors(&black, &black, size, exposures).iter().all(|&error| error == 0.0));
        let errors = flip.hdr_errors(&grey([1.0; 400]), &black, size, exposures);
        assert!(errors.iter().all(|&error| error > 0.9));
    }

    #[test]
    fn the_brightest_values_stay_finite() {
        let (bright, size) = (grey([f32::MAX; 400]), [20, 20]);
        let exposures = Exposures::of(&grey((0..400).map(|i| i as f32)));
        let errors = Flip::new().hdr_errors(&bright, &grey([1.0e30; 400]), size, exposures);
        assert!(errors.iter().all(|&error| error == 0.0));
    }
}
