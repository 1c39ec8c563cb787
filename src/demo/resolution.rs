//! Where the window shows the picture, and of how many pixels it is.
//!
//! In: the layout of the panel and the intervals between frames. Out: the viewport and the picture's size.

use std::time::{Duration, Instant};

use super::action::Action;
use super::app::Open;
use super::recorder::Recording;
use super::split::Right;
use crate::settings::Settings;
use crate::statistics::percentile;
use crate::vulkan::Viewport;

/// Delay from the last change of the viewport to that of the picture, which is scaled meanwhile.
const RESIZE_DELAY: Duration = Duration::from_millis(150);
/// Default logical pixels per picture pixel in each direction, on a CPU driver.
const CPU_COARSENESS: f64 = 2.0;
/// Largest coarseness.
pub(super) const COARSEST: u32 = 8;
/// The largest that is chosen automatically: nothing can be made out in a coarser picture.
const COARSEST_AUTOMATIC: u32 = 4;

/// Interval that an automatic resolution aims at, ms.
const AIM_MS: f64 = 1e3 / 15.0;
/// Intervals above this ask for fewer pixels, ms.
const SLOW_MS: f64 = 1e3 / 12.0;
/// Share of the aim that more pixels must be expected to stay within.
const HEADROOM: f64 = 0.8;
/// The resolution is judged by the median over at least so many frames and so many ms.
const JUDGED: (usize, f64) = (6, 1e3);

/// Window pixels per picture pixel.
pub(super) struct Resolution {
    /// In each direction, 1 to [`COARSEST`].
    pub coarseness: u32,
    /// Whether it follows the frame rate.
    pub automatic: bool,
    intervals: Vec<f64>,
    /// The largest coarseness that was too fine; 0 if none was.
    too_fine: u32,
}

impl Resolution {
    /// Window pixels are picture pixels.
    pub fn full() -> Self {
        Self { coarseness: 1, automatic: false, intervals: Vec::new(), too_fine: 0 }
    }

    /// One that follows the frame rate of a CPU driver, for this scale factor of the display.
    pub fn automatic(scale: f64) -> Self {
        let coarseness = (CPU_COARSENESS * scale).round().clamp(1.0, f64::from(COARSEST)) as u32;
        Self { coarseness, automatic: true, ..Self::full() }
    }

    /// Forgets what was measured, since another picture is drawn.
    pub fn forget(&mut self) {
        self.intervals.clear();
        self.too_fine = 0;
    }

    /// Counts a frame that took `ms`; whether the coarseness has changed.
    fn judge(&mut self, ms: f64) -> bool {
        self.intervals.push(ms);
        if self.intervals.len() < JUDGED.0 || self.intervals.iter().sum::<f64>() < JUDGED.1 {
            return false;
        }
        let median = percentile(self.intervals.drain(..), 0.5).unwrap_or(AIM_MS);
        // A frame costs as much as it has pixels.
        let expected = |coarseness: u32| {
            let ratio = f64::from(self.coarseness) / f64::from(coarseness);
            median * ratio * ratio
        };
        let now = self.coarseness;
        let wanted = if median > SLOW_MS {
            self.too_fine = self.too_fine.max(now);
            let most = now.max(COARSEST_AUTOMATIC);
            (now..most).find(|&coarser| expected(coarser) <= AIM_MS).unwrap_or(most)
        } else {
            let mut finer = self.too_fine + 1..now;
            finer.find(|&finer| expected(finer) <= HEADROOM * AIM_MS).unwrap_or(now)
        };
        std::mem::replace(&mut self.coarseness, wanted) != wanted
    }
}

impl Open {
    /// The part of the window that is left of the panel and below the bar, pixels.
    pub fn viewport(&self) -> Viewport {
        let context = self.egui.egui_ctx();
        let (area, scale) = (self.panel.viewport(context), context.pixels_per_point());
        let pixels = |points: egui::Pos2| [points.x, points.y].map(|at| (at * scale).round().max(0.0) as u32);
        let (corner, end) = (pixels(area.min), pixels(area.max));
        Viewport { corner, size: [0, 1].map(|axis| end[axis].saturating_sub(corner[axis])) }
    }

    /// Size of the picture for the viewport, pixels.
    pub fn picture_size(&self) -> [u32; 2] {
        self.viewport().size.map(|side| side.div_ceil(self.resolution.coarseness).max(1))
    }

    /// Resizes the presenter at once, and the renderer after [`RESIZE_DELAY`].
    pub fn follow_size(&mut self) {
        let window = self.window.inner_size();
        self.gpu.presenter.resize([window.width, window.height]);
        let viewport = self.viewport();
        if std::mem::replace(&mut self.last_viewport, viewport) != viewport {
            self.resized = Some(Instant::now());
        }
        if self.resized.is_none_or(|when| when.elapsed() <= RESIZE_DELAY) {
            return;
        }
        self.resized = None;
        let size = self.picture_size();
        if let Some(session) = self.session.as_ref().filter(|session| session.settings.size != size) {
            let settings = Settings { size, ..session.settings.clone() };
            self.actions.push(Action::Set(Box::new(settings)));
        }
    }

    /// Gives the picture as many pixels as keep the frame rate. Not while something else needs the machine, or a picture
    /// must keep its size.
    pub fn follow_rate(&mut self) {
        let is_reference =
            self.split.as_ref().is_some_and(|split| matches!(split.right, Right::Reference(_)));
        let is_busy = self.loader.progress().is_some() || self.resized.is_some();
        let is_fixed = is_reference || !matches!(self.recording, Recording::Off);
        if !self.resolution.automatic || is_busy || is_fixed || self.session.is_none() {
            self.resolution.intervals.clear();
        } else if self.resolution.judge(self.clock.interval_ms()) {
            self.resized = Some(Instant::now());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The coarseness after a second of frames that take `ms` at full resolution.
    fn judged(resolution: &mut Resolution, ms: f64) -> u32 {
        let cost = ms / f64::from(resolution.coarseness).powi(2);
        let _ = (0..1000).any(|_| resolution.judge(cost));
        resolution.coarseness
    }

    #[test]
    fn the_resolution_follows_the_cost_of_a_frame() {
        let mut resolution = Resolution::automatic(1.0);
        assert_eq!(resolution.coarseness, 2);
        assert_eq!(judged(&mut resolution, 40.0), 1, "15 frames a second at full resolution");
        assert_eq!(judged(&mut resolution, 500.0), 3, "7.5 times too slow, so a ninth of the pixels");
        assert_eq!(judged(&mut resolution, 500.0), 3);
        assert_eq!(judged(&mut resolution, 1e9), COARSEST_AUTOMATIC);
    }

    #[test]
    fn what_was_too_fine_is_not_tried_again() {
        let mut resolution = Resolution::automatic(1.0);
        assert_eq!(judged(&mut resolution, 500.0), 3);
        assert_eq!(judged(&mut resolution, 100.0), 3, "2 has been too slow before");
        resolution.forget();
        assert_eq!(judged(&mut resolution, 100.0), 2);
    }
}
