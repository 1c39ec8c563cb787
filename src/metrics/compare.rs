//! All metrics of a picture against its reference.

use std::sync::LazyLock;

use serde::Serialize;

use super::colour::luminance;
use super::differences::{Blocks, Luminances, MeanErrors, p95};
use super::error::MetricsError;
use super::flip::Flip;
use super::flip_hdr::Exposures;
use super::image::{Encoding, Image};
use super::ssim::ssim;
use crate::statistics::mean;

/// Options of a comparison.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CompareOptions {
    /// Exposure of linear pictures for PSNR and SSIM, stops.
    pub exposure: f32,
    /// Side of the blocks in pixels, at least 1.
    pub block_side: usize,
    /// Whether errors of display luminance are measured too.
    pub luminance: bool,
}

impl Default for CompareOptions {
    fn default() -> Self {
        Self { exposure: 0.0, block_side: 16, luminance: false }
    }
}

/// Metrics of a picture against its reference. In JSON an infinite value is null.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Metrics {
    /// Mean absolute error over all channels.
    pub mae: f64,
    /// Root of the mean squared error.
    pub rmse: f64,
    /// Mean of (a - b)² / (b² + 0.01), b being the reference.
    pub relmse: f64,
    /// Peak signal-to-noise ratio of display values, dB, for a peak of 1; infinite for equal pictures.
    pub psnr: f64,
    /// Structural similarity of display values, -1 to 1.
    pub ssim: f64,
    /// Mean FLIP error, 0 to 1; HDR-FLIP of linear pictures.
    pub flip: f64,
    /// Mean luminance over that of the reference; infinite if only the reference is black.
    pub mean_ratio: f64,
    /// Mean over the pixels of the relative error of luminance, |a - b| / max(b, 1 % of the mean of b);
    /// infinite if the whole reference is black and the picture is not.
    pub mean_relative_error: f64,
    /// 95th percentile of the relative error over the pixels (nearest rank).
    pub p95_relative_error: f64,
    /// The relative error of the means over blocks of pixels.
    pub blocks: Blocks,
    /// Errors of display luminance, if wanted.
    #[serde(flatten)]
    pub luminance: Option<LuminanceMetrics>,
}

/// Errors of display luminance (Flatval, *Denoising Algorithms for Ray Tracing in Real-Time Applications*, 2020).
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LuminanceMetrics {
    /// Root of the mean squared error.
    #[serde(rename = "luminance_rmse")]
    pub rmse: f64,
    /// Structural similarity, -1 to 1.
    #[serde(rename = "luminance_ssim")]
    pub ssim: f64,
}

impl LuminanceMetrics {
    fn of(display: &[[f32; 3]], reference: &[[f32; 3]], size: [usize; 2]) -> Self {
        let [image, reference] = [display, reference]
            .map(|pixels| pixels.iter().map(|&pixel| [luminance(pixel) as f32; 3]).collect::<Vec<_>>());
        Self { rmse: MeanErrors::of(&image, &reference).mse.sqrt(), ssim: ssim(&image, &reference, size) }
    }
}

/// A comparison of two pictures.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// Width and height of the pictures.
    pub size: [usize; 2],
    /// The encoding of their values.
    pub encoding: Encoding,
    /// The metrics.
    pub metrics: Metrics,
    /// The FLIP error of each pixel, 0 to 1, in rows from the top left.
    pub flip_errors: Vec<f32>,
    /// The exposures of HDR-FLIP; none for display values.
    pub exposures: Option<Exposures>,
}

/// Per-pixel errors besides FLIP.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PixelError {
    /// The mean over the channels of the absolute error; its mean is [`Metrics::mae`].
    Absolute,
    /// The relative error of luminance; its mean is [`Metrics::mean_relative_error`].
    Relative,
}

/// Compares `image` with `reference`.
///
/// # Errors
/// If size or encoding differ.
pub fn compare(
    image: &Image,
    reference: &Image,
    options: &CompareOptions,
) -> Result<Comparison, MetricsError> {
    image.check_comparable(reference)?;
    let errors = MeanErrors::of(image.pixels(), reference.pixels());
    let (display, display_reference) = (image.display(options.exposure), reference.display(options.exposure));
    let display_mse = MeanErrors::of(&display, &display_reference).mse;
    let luminances = Luminances::of(image, reference);
    let relative_errors = luminances.relative_errors();
    let (flip_errors, exposures) = flip_errors(image, reference);
    let metrics = Metrics {
        mae: errors.mae,
        rmse: errors.mse.sqrt(),
        relmse: errors.relmse,
        psnr: -10.0 * display_mse.log10(),
        ssim: ssim(&display, &display_reference, image.size()),
        flip: flip_errors.iter().map(|&error| f64::from(error)).sum::<f64>() / flip_errors.len() as f64,
        mean_ratio: luminances.mean_ratio(),
        mean_relative_error: mean(&relative_errors),
        p95_relative_error: p95(&relative_errors),
        blocks: luminances.blocks(options.block_side.max(1)),
        luminance: options
            .luminance
            .then(|| LuminanceMetrics::of(&display, &display_reference, image.size())),
    };
    Ok(Comparison { size: image.size(), encoding: image.encoding(), metrics, flip_errors, exposures })
}

/// The errors of each pixel, in rows from the top left.
///
/// # Errors
/// If size or encoding differ.
pub fn pixel_errors(image: &Image, reference: &Image, kind: PixelError) -> Result<Vec<f32>, MetricsError> {
    image.check_comparable(reference)?;
    let pairs = || image.pixels().iter().zip(reference.pixels());
    let absolute = |(a, b): (&[f32; 3], &[f32; 3])| (0..3).map(|i| (a[i] - b[i]).abs()).sum::<f32>() / 3.0;
    Ok(match kind {
        PixelError::Absolute => pairs().map(absolute).collect(),
        PixelError::Relative => {
            let errors = Luminances::of(image, reference).relative_errors();
            errors.into_iter().map(|error| error as f32).collect()
        }
    })
}

fn flip_errors(image: &Image, reference: &Image) -> (Vec<f32>, Option<Exposures>) {
    static FLIP: LazyLock<Flip> = LazyLock::new(Flip::new);
    match image.encoding() {
        Encoding::Display => (FLIP.errors(&image.linear(), &reference.linear(), image.size()), None),
        Encoding::Linear => {
            let exposures = Exposures::of(reference.pixels());
            let errors = FLIP.hdr_errors(image.pixels(), reference.pixels(), image.size(), exposures);
            (errors, Some(exposures))
        }
    }
}
