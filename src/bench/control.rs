//! Progress and interruption.

use std::sync::atomic::{AtomicBool, Ordering};

use super::BenchError;
use crate::estimators;
use crate::settings::Settings;

/// Progress and cancellation of a benchmark.
pub struct Control<'a> {
    /// Set to cancel.
    pub stop: &'a AtomicBool,
    /// Receives the current task and the work done since the last call.
    pub progress: &'a mut dyn FnMut(&str, u64),
    /// The current task.
    task: String,
    /// Completed runs and total runs.
    pub(super) runs: [usize; 2],
}

impl<'a> Control<'a> {
    /// Reports to `progress` until `stop` is set.
    pub fn new(stop: &'a AtomicBool, progress: &'a mut dyn FnMut(&str, u64)) -> Self {
        Self { stop, progress, task: String::new(), runs: [0; 2] }
    }

    pub(super) fn begin(&mut self, task: String) {
        self.task = task;
        (self.progress)(&self.task, 0);
    }

    /// Counts a turn of a micro-benchmark; an error once cancelled.
    pub(super) fn turn_done(&mut self) -> Result<(), BenchError> {
        (self.progress)(&self.task, 1);
        self.runs[0] += 1;
        if self.stop.load(Ordering::Relaxed) {
            return Err(BenchError::Stopped { done: self.runs[0], planned: self.runs[1] });
        }
        Ok(())
    }

    /// Counts work; an error once cancelled.
    pub(super) fn done(&mut self, work: u64) -> Result<(), BenchError> {
        (self.progress)(&self.task, work);
        if self.stop.load(Ordering::Relaxed) {
            return Err(BenchError::Interrupted { done: self.runs[0], planned: self.runs[1] });
        }
        Ok(())
    }
}

/// Work of a path, in shadow rays: it has several rays, which are incoherent, and shading.
const WORK_OF_PATH: u64 = 40;

/// Estimated work of a frame, for the remaining time: pixels * (rays of the method for a pixel + a constant), or that of the path
/// tracer's samples.
pub(super) fn work_of_frame(settings: &Settings, samples: Option<u32>) -> u64 {
    if let Some(samples) = samples {
        return u64::from(samples) * work_of_sample(settings.size);
    }
    let rays = (estimators::method(settings).rays)(settings);
    pixels(settings.size) * u64::from(rays + 4)
}

/// Estimated work of one of the path tracer's samples of each pixel.
pub(super) fn work_of_sample(size: [u32; 2]) -> u64 {
    pixels(size) * WORK_OF_PATH
}

fn pixels([width, height]: [u32; 2]) -> u64 {
    u64::from(width) * u64::from(height)
}
