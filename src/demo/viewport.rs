//! Where the window shows the picture, and the size of the picture.
//!
//! In: the layout of the panel and the intervals between frames. Out: the viewport and the picture's size.

use std::time::{Duration, Instant};

use super::action::Action;
use super::app::Open;
use super::recorder::Recording;
use super::split::{Right, Split};
use crate::settings::Settings;
use crate::vulkan::Viewport;

/// Delay from the last change of the viewport to that of the picture, which is scaled meanwhile.
const RESIZE_DELAY: Duration = Duration::from_millis(150);

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
        if self.is_measuring() || self.resized.is_none_or(|when| when.elapsed() <= RESIZE_DELAY) {
            return;
        }
        self.resized = None;
        let size = self.picture_size();
        if let Some(session) = self.session.as_ref().filter(|session| session.settings.size != size) {
            let settings = Settings { size, ..session.settings.clone() };
            self.actions.push(Action::Set(Box::new(settings)));
        }
    }

    /// Whether no frame would differ from the last one: a scene is loaded, or the picture is frozen.
    pub fn is_calm(&self) -> bool {
        let is_frozen = self.session.as_ref().is_none_or(|session| session.renderer.is_frozen())
            && self.split.as_ref().is_none_or(Split::is_frozen);
        let waits = self.actions.is_empty() && self.saving.is_empty() && self.resized.is_none();
        is_frozen && waits && self.tour.is_none() && !self.egui.egui_ctx().has_requested_repaint()
    }

    /// Gives the picture as many pixels as keep the target rate, or all of them where there is none. Not while something else
    /// needs the machine, or a picture must keep its size.
    pub fn follow_rate(&mut self) {
        let is_still = self.split.as_ref().is_some_and(|split| !matches!(split.right, Right::Renderer(_)));
        let is_busy = self.loader.progress().is_some() || self.resized.is_some() || self.is_measuring();
        let is_fixed = is_still || !matches!(self.recording, Recording::Off);
        let session = self.session.as_ref().filter(|_| self.resolution.automatic && !is_busy && !is_fixed);
        // Motion asks for a rate; what stands still, for every pixel.
        let session = session.filter(|session| session.renderer.still_frames() == 0);
        let Some(session) = session else {
            self.resolution.restart();
            return;
        };
        let (aim, cost) = (self.aim_ms(session.settings.target_fps), session.report.figures.total_ms);
        let changed = match aim {
            Some(aim) => self.resolution.judge(self.clock.interval_ms(), cost, aim),
            None => std::mem::replace(&mut self.resolution.coarseness, 1) != 1,
        };
        if changed {
            self.resized = Some(Instant::now());
        }
    }

    /// The interval of frames at the `target` rate, ms, but no shorter than the display shows them; none where the target is 0.
    fn aim_ms(&self, target: u32) -> Option<f64> {
        let display = self.window.current_monitor().and_then(|monitor| monitor.refresh_rate_millihertz());
        let most = display.map_or(f64::INFINITY, |millihertz| f64::from(millihertz) / 1e3);
        (target > 0).then(|| 1e3 / f64::from(target).min(most))
    }
}
