//! Per-pixel errors: mean errors, and relative errors of luminance.

use rayon::prelude::*;
use serde::Serialize;

use super::image::Image;
use crate::statistics::{mean, percentile};

/// Keeps the relative squared error of black pixels finite (Rousselle et al. 2011).
const RELMSE_EPSILON: f64 = 0.01;

/// Lower bound of the denominator of relative errors, as a fraction of the reference's mean luminance, so that errors
/// in black regions are relative to a visible luminance.
const MIN_DENOMINATOR: f64 = 0.01;

/// The relative errors of the mean luminance of square blocks of pixels, against max(b, 1 % of the mean of b)
/// as for pixels. Blocks at the right and lower border may be smaller.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Blocks {
    /// Side of a block in pixels.
    pub side: usize,
    /// Number of blocks.
    pub count: usize,
    /// Mean relative error.
    pub mean_relative_error: f64,
    /// 95th percentile of the relative errors.
    pub p95_relative_error: f64,
    /// The fraction of blocks with an error of at most 0.03.
    pub within_3_percent: f64,
    /// The fraction of blocks with an error of at most 0.05.
    pub within_5_percent: f64,
}

/// Mean errors over all channels and pixels.
pub(super) struct MeanErrors {
    pub mae: f64,
    pub mse: f64,
    pub relmse: f64,
}

impl MeanErrors {
    /// The order of summation is independent of the number of cores.
    pub(super) fn of(image: &[[f32; 3]], reference: &[[f32; 3]]) -> Self {
        const CHUNK: usize = 4096;
        let add = |a: [f64; 3], b: [f64; 3]| [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
        let chunks = image.par_chunks(CHUNK).zip(reference.par_chunks(CHUNK));
        let chunk_sums: Vec<[f64; 3]> = chunks
            .map(|(image, reference)| {
                let pairs = image.as_flattened().iter().zip(reference.as_flattened());
                pairs.fold([0.0; 3], |sums, (&a, &b)| {
                    let (difference, b) = (f64::from(a) - f64::from(b), f64::from(b));
                    let square = difference * difference;
                    add(sums, [difference.abs(), square, square / (b * b + RELMSE_EPSILON)])
                })
            })
            .collect();
        let sums = chunk_sums.into_iter().fold([0.0; 3], add);
        let [mae, mse, relmse] = sums.map(|sum| sum / (3 * image.len()) as f64);
        Self { mae, mse, relmse }
    }
}

/// The luminances of a picture and its reference, and metrics of them.
pub(super) struct Luminances {
    image: Vec<f64>,
    reference: Vec<f64>,
    size: [usize; 2],
    /// The reference's mean.
    mean: f64,
}

impl Luminances {
    pub(super) fn of(image: &Image, reference: &Image) -> Self {
        let (image, reference, size) = (image.luminances(), reference.luminances(), image.size());
        Self { mean: mean(&reference), image, reference, size }
    }

    /// The image's mean over the reference's; 1 if both are black, infinite if only the reference is.
    pub(super) fn mean_ratio(&self) -> f64 {
        let image = mean(&self.image);
        if image == self.mean { 1.0 } else { image / self.mean }
    }

    /// The relative error of each pixel.
    pub(super) fn relative_errors(&self) -> Vec<f64> {
        self.relative(&self.image, &self.reference)
    }

    /// The relative errors of means over blocks of `side` x `side` pixels; smaller at the right and lower border.
    pub(super) fn blocks(&self, side: usize) -> Blocks {
        let [image, reference] =
            [&self.image, &self.reference].map(|luminances| self.block_means(luminances, side));
        let errors = self.relative(&image, &reference);
        let within =
            |limit: f64| errors.iter().filter(|&&error| error <= limit).count() as f64 / errors.len() as f64;
        Blocks {
            side,
            count: errors.len(),
            mean_relative_error: mean(&errors),
            p95_relative_error: p95(&errors),
            within_3_percent: within(0.03),
            within_5_percent: within(0.05),
        }
    }

    /// |a - b| / |b|, with a denominator of at least [`MIN_DENOMINATOR`] times the reference's mean. If the whole
    /// reference is black, any error is infinite.
    fn relative(&self, image: &[f64], reference: &[f64]) -> Vec<f64> {
        let min = MIN_DENOMINATOR * self.mean.abs();
        let relative = |(a, b): (&f64, &f64)| if a == b { 0.0 } else { (a - b).abs() / b.abs().max(min) };
        image.iter().zip(reference).map(relative).collect()
    }

    fn block_means(&self, luminances: &[f64], side: usize) -> Vec<f64> {
        let [width, height] = self.size;
        let block_mean = |(left, top): (usize, usize)| {
            let (right, bottom) = ((left + side).min(width), (top + side).min(height));
            let rows =
                (top..bottom).map(|y| luminances[y * width + left..y * width + right].iter().sum::<f64>());
            rows.sum::<f64>() / ((right - left) * (bottom - top)) as f64
        };
        let corners = (0..height).step_by(side).flat_map(|y| (0..width).step_by(side).map(move |x| (x, y)));
        corners.map(block_mean).collect()
    }
}

/// The mean absolute change of luminance between two pictures (Schied et al. 2017).
pub(super) fn mean_change(before: &[f64], after: &[f64]) -> f64 {
    before.iter().zip(after).map(|(before, after)| (after - before).abs()).sum::<f64>() / after.len() as f64
}

pub(super) fn p95(values: &[f64]) -> f64 {
    percentile(values.iter().copied(), 0.95).unwrap_or_default()
}
