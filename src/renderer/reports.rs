//! What was measured of frames, once the device has finished them.

use std::collections::VecDeque;

use super::{RenderError, Renderer};
use crate::estimators::{self, Estimator, Method};
use crate::report::{Counters, FrameFigures, FrameReport, PassInfo, PassTimes};
use crate::vulkan::FrameTimes;

/// A frame in flight.
pub(super) struct Pending {
    pub frame: u64,
    /// Of [`FrameReport::still`].
    pub still: u32,
    pub method: &'static Method,
    pub cpu_ms: Vec<f64>,
    pub counters: Counters,
}

impl Renderer {
    /// The reports of finished frames that were not given yet, in order. Does not wait.
    pub fn take_reports(&mut self) -> Vec<FrameReport> {
        std::mem::take(&mut self.reports)
    }

    /// Waits for all frames and gives the reports that were not given yet, in order.
    pub fn finish(&mut self) -> Result<Vec<FrameReport>, RenderError> {
        for times in self.frames.finish()? {
            self.reports.extend(report(&mut self.pending, &*self.estimator, &times));
        }
        Ok(std::mem::take(&mut self.reports))
    }
}

/// The passes of a frame, in order.
fn frame_passes(method: &'static Method) -> impl Iterator<Item = &'static PassInfo> {
    estimators::passes_with(std::slice::from_ref(method)).map(|(_, pass)| pass)
}

/// Joins what the CPU knows of a frame with the device's times.
pub(super) fn report(
    pending: &mut VecDeque<Pending>,
    estimator: &dyn Estimator,
    times: &FrameTimes,
) -> Option<FrameReport> {
    let Pending { frame, still, method, cpu_ms, mut counters } = pending.pop_front()?;
    let mut passes: PassTimes = frame_passes(method).map(|pass| (pass.name, 0.0)).collect();
    passes.values_mut().zip(cpu_ms).for_each(|(pass, ms)| *pass = ms);
    // Passes of views are not part of the frame.
    for (name, ms) in &times.passes {
        if let Some(pass) = passes.get_mut(name) {
            *pass += ms;
        }
    }
    for (stage, part) in frame_passes(method).filter_map(|pass| Some((pass.stage?, pass.name))) {
        passes[stage] += passes[part];
    }
    estimator.add_device_counters(&mut counters, &times.readback);
    let whole = frame_passes(method).filter(|pass| pass.stage.is_none());
    let total_ms = whole.map(|pass| passes[pass.name]).sum();
    Some(FrameReport { frame, still, figures: FrameFigures { total_ms, passes, counters } })
}
