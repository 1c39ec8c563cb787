//! The last seconds in numbers, for the plots.

use std::collections::VecDeque;

use crate::report::FrameReport;
use crate::statistics::percentile;

/// Frames that are kept.
const KEPT: usize = 240;

/// What one frame of the window was.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sample {
    /// Real time since the frame before, milliseconds.
    pub interval_ms: f64,
    /// Laying out the user interface, milliseconds of CPU.
    pub ui_cpu_ms: f64,
    /// Drawing it, milliseconds of the device.
    pub ui_device_ms: f64,
    /// What the renderer measured.
    pub report: FrameReport,
}

/// The last frames, oldest first.
#[derive(Default)]
pub(super) struct History {
    samples: VecDeque<Sample>,
}

impl History {
    pub fn push(&mut self, sample: Sample) {
        if self.samples.len() == KEPT {
            self.samples.pop_front();
        }
        self.samples.push_back(sample);
    }

    pub fn clear(&mut self) {
        self.samples.clear();
    }

    pub fn samples(&self) -> impl ExactSizeIterator<Item = &Sample> + Clone {
        self.samples.iter()
    }

    /// Median and 95th percentile of a figure.
    pub fn median_and_p95(&self, figure: impl Fn(&Sample) -> f64) -> Option<[f64; 2]> {
        let at = |quantile| percentile(self.samples.iter().map(&figure), quantile);
        Some([at(0.5)?, at(0.95)?])
    }
}
