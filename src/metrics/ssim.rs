//! Structural similarity (Wang, Bovik, Sheikh, Simoncelli, *Image Quality Assessment: From Error Visibility
//! to Structural Similarity*, 2004).
//!
//! In: two pictures of display values in [0, 1]. Out: the mean of the index over pixels and channels, with a
//! Gaussian window of 11 x 11 pixels and sigma 1.5. The border is mirrored, and the outer 5 pixels, whose
//! windows cross the border, do not count, except along a side shorter than the window.
//! The convention is that of scikit-image's `structural_similarity(channel_axis=-1, data_range=1,
//! gaussian_weights=True, sigma=1.5, use_sample_covariance=False)`.

use std::ops::Range;

use rayon::prelude::*;

use super::convolve::{Border, Separable};

const SIGMA: f64 = 1.5;
const RADIUS: usize = 5;
const C1: f64 = 0.01 * 0.01;
const C2: f64 = 0.03 * 0.03;

/// The mean index of two `size` (width, height) pictures: 1 for equal pictures, at least -1.
pub(super) fn ssim(image: &[[f32; 3]], reference: &[[f32; 3]], size: [usize; 2]) -> f64 {
    let filter = Separable { along_columns: window(), along_rows: window(), border: Border::Mirror };
    let [columns, rows] = size.map(inner);
    let pixels = 3 * columns.len() * rows.len();
    let row_sums: Vec<f64> = rows
        .into_par_iter()
        .map(|y| {
            let channel_sums = (0..3).map(|channel| {
                let moments = filter.row(y, size, |x, y| {
                    let at = y * size[0] + x;
                    let (a, b) = (f64::from(image[at][channel]), f64::from(reference[at][channel]));
                    [a, b, a * a, b * b, a * b]
                });
                moments[columns.clone()].iter().map(index).sum::<f64>()
            });
            channel_sums.sum()
        })
        .collect();
    row_sums.iter().sum::<f64>() / pixels as f64
}

/// The pixels along one side whose windows lie within the picture; all if the side is shorter than a window.
fn inner(length: usize) -> Range<usize> {
    if length > 2 * RADIUS { RADIUS..length - RADIUS } else { 0..length }
}

/// The index from the means of a, b, a², b² and ab under one window (equation 13).
fn index(&[a, b, aa, bb, ab]: &[f64; 5]) -> f64 {
    let (variance_a, variance_b, covariance) = (aa - a * a, bb - b * b, ab - a * b);
    (2.0 * a * b + C1) * (2.0 * covariance + C2) / ((a * a + b * b + C1) * (variance_a + variance_b + C2))
}

fn window() -> Vec<[f64; 5]> {
    let weight = |tap: usize| (-0.5 * ((tap as f64 - RADIUS as f64) / SIGMA).powi(2)).exp();
    let sum: f64 = (0..=2 * RADIUS).map(weight).sum();
    (0..=2 * RADIUS).map(|tap| [weight(tap) / sum; 5]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn constant_pictures_have_the_index_of_their_means() {
        let (a, b) = (0.25_f32, 0.75_f32);
        let expected = (2.0 * 0.25 * 0.75 + C1) / (0.25 * 0.25 + 0.75 * 0.75 + C1);
        for size in [[1, 1], [3, 20], [16, 12]] {
            let picture = |value: f32| vec![[value; 3]; size[0] * size[1]];
            let index = ssim(&picture(a), &picture(b), size);
            assert!((index - expected).abs() < 1e-9, "{size:?}: {index}");
            assert_eq!(ssim(&picture(a), &picture(a), size), 1.0);
        }
    }

    #[test]
    fn a_negative_has_negative_similarity() {
        let size = [24, 24];
        let picture: Vec<_> = (0..24 * 24).map(|i| [((i % 24 + i / 24) % 2) as f32; 3]).collect();
        let negative: Vec<_> = picture.iter().map(|pixel| pixel.map(|value| 1.0 - value)).collect();
        let index = ssim(&picture, &negative, size);
        assert!(index < -0.9 && index == ssim(&negative, &picture, size), "{index}");
    }
}
