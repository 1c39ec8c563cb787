//! Measurements of the last frames, for the plots.

use std::collections::VecDeque;

use crate::report::FrameReport;
use crate::statistics::percentile;

/// Frames to keep.
const LENGTH: usize = 240;
/// The frame rate is that of so many ms: few, so that the effect of a setting is seen at once.
const RECENT_MS: f64 = 500.0;

/// Measurements of one frame of the window.
#[derive(Clone, Debug, Default)]
pub(super) struct Sample {
    /// Time since the previous frame, ms.
    pub interval_ms: f64,
    /// CPU time of laying out the user interface, ms.
    pub ui_cpu_ms: f64,
    /// Device time of drawing it, ms.
    pub ui_device_ms: f64,
    /// The renderer's report.
    pub report: FrameReport,
}

/// The last frames, oldest first.
#[derive(Default)]
pub(super) struct History {
    pub samples: VecDeque<Sample>,
}

impl History {
    pub fn push(&mut self, sample: Sample) {
        if self.samples.len() == LENGTH {
            self.samples.pop_front();
        }
        self.samples.push_back(sample);
    }

    /// Mean interval of the frames of the last half second, ms; 0 before the first.
    pub fn recent_ms(&self) -> f64 {
        let (mut sum, mut count) = (0.0, 0.0);
        for sample in self.samples.iter().rev() {
            sum += sample.interval_ms;
            count += 1.0;
            if sum >= RECENT_MS {
                break;
            }
        }
        if count > 0.0 { sum / count } else { 0.0 }
    }

    /// Median and 95th percentile of a figure.
    pub fn median_and_p95(&self, figure: impl Fn(&Sample) -> f64) -> Option<[f64; 2]> {
        let at = |quantile| percentile(self.samples.iter().map(&figure), quantile);
        Some([at(0.5)?, at(0.95)?])
    }
}
