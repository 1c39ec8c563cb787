//! Runs: the measurements of one method with one setting of one scene.

use serde::{Deserialize, Serialize};

use super::method::Method;
use super::samples::{OTHER, Samples};
use crate::estimators;
use crate::metrics::Comparison;
use crate::settings::Settings;
use crate::statistics::mean;

/// One method with one setting of one scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Run {
    /// Name of the scene.
    pub scene: String,
    /// It lights the pictures.
    pub method: Method,
    /// The settings.
    pub settings: Settings,
    /// Warm-up frames.
    pub warm_up: u32,
    /// Measurements.
    pub rounds: Vec<Round>,
    /// Errors against the path tracer's pictures, with `--quality`.
    pub quality: Option<Quality>,
}

/// One measurement of a setting.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Round {
    /// Frame by frame.
    pub samples: Samples,
    /// Peak memory of the program, bytes; none if the system does not report it.
    pub cpu_peak: Option<u64>,
    /// Peak device memory, bytes.
    pub device_peak: u64,
}

impl Run {
    /// Whether it measures the same as `other`.
    pub fn is_same(&self, other: &Self) -> bool {
        self.scene == other.scene && self.method == other.method && self.settings == other.settings
    }

    /// Frames after which the picture of a still scene is complete.
    pub fn completes_in(&self) -> u32 {
        (estimators::method(&self.settings).warm_up)(&self.settings)
    }

    /// The samples of all rounds together, in the order of [`Samples::quantities`].
    pub fn rounds(&self) -> impl Iterator<Item = &Samples> {
        self.rounds.iter().map(|round| &round.samples)
    }

    /// Peak memory of the program over all rounds, bytes.
    pub fn cpu_peak(&self) -> Option<u64> {
        self.rounds.iter().filter_map(|round| round.cpu_peak).max()
    }

    /// Peak device memory over all rounds, bytes.
    pub fn device_peak(&self) -> u64 {
        self.rounds.iter().map(|round| round.device_peak).max().unwrap_or(0)
    }
}

/// The stages of the frames of `runs`: their passes, those of several parts as one, and the time between them.
pub fn stages<'a>(runs: impl IntoIterator<Item = &'a Run>) -> Vec<&'static str> {
    let mut stages: Vec<&'static str> = Vec::new();
    for samples in runs.into_iter().filter_map(|run| run.rounds().next()) {
        let whole = samples.passes.0.keys().filter(|name| !estimators::is_part(name));
        let missing: Vec<_> = whole.filter(|name| !stages.contains(name)).collect();
        stages.extend(missing);
    }
    stages.push(OTHER);
    stages
}

/// Quality of the pictures of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Quality {
    /// The selected frames.
    pub frames: Vec<FrameQuality>,
    /// Frames until the picture is stationary after all motion stops.
    pub settling_frames: u32,
    /// Mean absolute change of luminance from frame to frame after that (Schied et al. 2017), W/m^2/sr.
    pub temporal_error: f64,
    /// Quality at the last moment.
    pub still: Still,
}

/// A picture of one moment, from a fresh start until it is frozen.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Still {
    /// Frames until it is frozen.
    pub frames: u32,
    /// Time of these frames, ms.
    pub ms: f64,
    /// Error of the last one.
    pub error: FrameQuality,
}

/// Error of one picture against the path tracer's.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FrameQuality {
    /// Number of the frame.
    pub frame: u32,
    /// Mean HDR-FLIP error, 0 to 1.
    pub flip: f64,
    /// Structural similarity of display values at the exposure of the path tracer's picture.
    pub ssim: f64,
    /// Mean relative error of luminance; none where the path tracer's picture is black.
    pub relative_error: Option<f64>,
}

impl Quality {
    /// Mean of a figure over the selected frames.
    pub fn mean(&self, figure: fn(&FrameQuality) -> f64) -> f64 {
        mean(&self.frames.iter().map(figure).collect::<Vec<_>>())
    }

    /// Mean relative error over those frames that have one.
    pub fn relative_error(&self) -> Option<f64> {
        let errors: Vec<f64> = self.frames.iter().filter_map(|frame| frame.relative_error).collect();
        (!errors.is_empty()).then(|| mean(&errors))
    }
}

impl FrameQuality {
    pub(super) fn of(frame: u32, comparison: &Comparison) -> Self {
        let metrics = comparison.metrics;
        let relative_error = Some(metrics.mean_relative_error).filter(|error| error.is_finite());
        Self { frame, flip: metrics.flip, ssim: metrics.ssim, relative_error }
    }
}
