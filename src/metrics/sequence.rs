//! Metrics of a sequence of pictures: by frame, their means, and the temporal error.

use serde::Serialize;

use super::compare::{CompareOptions, Comparison, LuminanceMetrics, Metrics, compare};
use super::differences::{Blocks, mean_change};
use super::error::MetricsError;
use super::image::Image;
use crate::statistics::mean;

/// One frame of a sequence.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FrameMetrics {
    /// Frame number.
    pub frame: u64,
    /// Metrics against the reference.
    #[serde(flatten)]
    pub metrics: Metrics,
    /// Mean absolute change of luminance since the frame before; none for the first.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub temporal_error: Option<f64>,
    /// Mean absolute change of the reference's luminance, if it is a sequence.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reference_temporal_error: Option<f64>,
    /// Mean absolute change of display luminance since the frame before, if errors of it are wanted.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub luminance_temporal_error: Option<f64>,
}

/// A whole sequence.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SequenceMetrics {
    /// The mean of each metric over the frames.
    #[serde(flatten)]
    pub means: Metrics,
    /// The mean of all changes from frame to frame (Schied et al. 2017); none for a single frame.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub temporal_error: Option<f64>,
    /// The mean of all changes of the reference, if it is a sequence.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reference_temporal_error: Option<f64>,
    /// The mean of all changes of display luminance, if errors of it are wanted.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub luminance_temporal_error: Option<f64>,
    /// Every frame, in order.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub frames: Vec<FrameMetrics>,
}

/// Compares a sequence frame by frame; keeps only the luminance of the last frame.
#[derive(Clone, Debug, Default)]
pub struct Sequence {
    options: CompareOptions,
    still_reference: bool,
    frames: Vec<FrameMetrics>,
    /// The last picture and its reference: name, size, luminances.
    last: Option<[LuminanceImage; 2]>,
    /// The display luminances of the last picture.
    last_display: Option<Vec<f64>>,
}

/// Name, width and height, luminance of each pixel.
type LuminanceImage = (String, [usize; 2], Vec<f64>);

impl Sequence {
    /// An empty sequence. With a `still_reference` every frame is compared with the same picture.
    pub fn new(options: CompareOptions, still_reference: bool) -> Self {
        Self { options, still_reference, ..Self::default() }
    }

    /// Compares the next frame, number `frame`.
    ///
    /// # Errors
    /// If size or encoding differ, or the size is not that of the previous frame.
    pub fn push(&mut self, frame: u64, image: &Image, reference: &Image) -> Result<Comparison, MetricsError> {
        let comparison = compare(image, reference, &self.options)?;
        let now = [image, reference]
            .map(|picture| (picture.name().to_owned(), picture.size(), picture.luminances()));
        let change = |index: usize| {
            let Some(before) = &self.last else { return Ok(None) };
            let ((image, size, after), (reference, reference_size, before)) = (&now[index], &before[index]);
            let (size, reference_size) = (*size, *reference_size);
            if size != reference_size {
                let (image, reference) = (image.clone(), reference.clone());
                return Err(MetricsError::Size { image, size, reference, reference_size });
            }
            Ok(Some(mean_change(before, after)))
        };
        let (temporal_error, reference_change) = (change(0)?, change(1)?);
        let display = self.options.luminance.then(|| image.display_luminances(self.options.exposure));
        let luminance_temporal_error = self
            .last_display
            .as_ref()
            .zip(display.as_ref())
            .map(|(before, after)| mean_change(before, after));
        self.frames.push(FrameMetrics {
            frame,
            metrics: comparison.metrics,
            temporal_error,
            reference_temporal_error: reference_change.filter(|_| !self.still_reference),
            luminance_temporal_error,
        });
        self.last = Some(now);
        self.last_display = display;
        Ok(comparison)
    }

    /// The metrics of all frames; none without frames.
    pub fn finish(self) -> Option<SequenceMetrics> {
        let mean_change = |change: fn(&FrameMetrics) -> Option<f64>| {
            let changes: Vec<f64> = self.frames.iter().filter_map(change).collect();
            (!changes.is_empty()).then(|| mean(&changes))
        };
        Some(SequenceMetrics {
            means: mean_metrics(&self.frames)?,
            temporal_error: mean_change(|frame| frame.temporal_error),
            reference_temporal_error: mean_change(|frame| frame.reference_temporal_error),
            luminance_temporal_error: mean_change(|frame| frame.luminance_temporal_error),
            frames: self.frames,
        })
    }
}

/// The temporal error of frames of a static scene: the mean over pixels and pairs of frames of the absolute
/// change of luminance (Schied et al., *Spatiotemporal Variance-Guided Filtering*, 2017). None for fewer than
/// two frames.
///
/// # Errors
/// If size or encoding differ.
pub fn temporal_error(frames: &[Image]) -> Result<Option<f64>, MetricsError> {
    let luminances: Vec<_> = frames.iter().map(Image::luminances).collect();
    let mut changes = Vec::new();
    for (pair, luminances) in frames.windows(2).zip(luminances.windows(2)) {
        pair[1].check_comparable(&pair[0])?;
        changes.push(mean_change(&luminances[0], &luminances[1]));
    }
    Ok((!changes.is_empty()).then(|| mean(&changes)))
}

/// The mean of each metric; none without frames.
fn mean_metrics(frames: &[FrameMetrics]) -> Option<Metrics> {
    let first = frames.first()?.metrics;
    let mean_of = |figure: fn(&Metrics) -> f64| {
        mean(&frames.iter().map(|frame| figure(&frame.metrics)).collect::<Vec<_>>())
    };
    Some(Metrics {
        mae: mean_of(|metrics| metrics.mae),
        rmse: mean_of(|metrics| metrics.rmse),
        relmse: mean_of(|metrics| metrics.relmse),
        psnr: mean_of(|metrics| metrics.psnr),
        ssim: mean_of(|metrics| metrics.ssim),
        flip: mean_of(|metrics| metrics.flip),
        mean_ratio: mean_of(|metrics| metrics.mean_ratio),
        mean_relative_error: mean_of(|metrics| metrics.mean_relative_error),
        p95_relative_error: mean_of(|metrics| metrics.p95_relative_error),
        blocks: Blocks {
            side: first.blocks.side,
            count: first.blocks.count,
            mean_relative_error: mean_of(|metrics| metrics.blocks.mean_relative_error),
            p95_relative_error: mean_of(|metrics| metrics.blocks.p95_relative_error),
            within_3_percent: mean_of(|metrics| metrics.blocks.within_3_percent),
            within_5_percent: mean_of(|metrics| metrics.blocks.within_5_percent),
        },
        luminance: first.luminance.map(|_| LuminanceMetrics {
            rmse: mean_of(|metrics| metrics.luminance.map_or(0.0, |luminance| luminance.rmse)),
            ssim: mean_of(|metrics| metrics.luminance.map_or(0.0, |luminance| luminance.ssim)),
        }),
    })
}
