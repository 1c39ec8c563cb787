//! Progress and interruption.

use std::sync::atomic::{AtomicBool, Ordering};

use super::BenchError;
use crate::settings::Settings;

/// What goes on outside while frames are drawn.
pub struct Control<'a> {
    /// Set once somebody wants it to end.
    pub stop: &'a AtomicBool,
    /// Gets what is being done now and how much work has been done since the last call.
    pub progress: &'a mut dyn FnMut(&str, u64),
    /// What is being done now.
    task: String,
    /// Runs that are kept, and runs in all.
    pub(super) runs: [usize; 2],
}

impl<'a> Control<'a> {
    /// Somebody who watches.
    pub fn new(stop: &'a AtomicBool, progress: &'a mut dyn FnMut(&str, u64)) -> Self {
        Self { stop, progress, task: String::new(), runs: [0; 2] }
    }

    pub(super) fn begin(&mut self, task: String) {
        self.task = task;
        (self.progress)(&self.task, 0);
    }

    /// Counts a turn of what is measured by itself; an error once it is to end.
    pub(super) fn turn_done(&mut self) -> Result<(), BenchError> {
        (self.progress)(&self.task, 1);
        self.runs[0] += 1;
        if self.stop.load(Ordering::Relaxed) {
            return Err(BenchError::Stopped { done: self.runs[0], planned: self.runs[1] });
        }
        Ok(())
    }

    /// Counts a frame drawn with `settings`; an error once it is to end.
    pub(super) fn frame_done(&mut self, settings: &Settings) -> Result<(), BenchError> {
        (self.progress)(&self.task, work_of_frame(settings));
        if self.stop.load(Ordering::Relaxed) {
            return Err(BenchError::Interrupted { done: self.runs[0], planned: self.runs[1] });
        }
        Ok(())
    }
}

/// About how much work a frame is, to tell the time left: pixels times (shadow rays of a pixel, and all else).
pub(super) fn work_of_frame(settings: &Settings) -> u64 {
    let rays = settings.vpls.div_ceil(settings.temporal_sets * settings.interleave.pow(2));
    u64::from(settings.size[0]) * u64::from(settings.size[1]) * u64::from(rays + 4)
}
