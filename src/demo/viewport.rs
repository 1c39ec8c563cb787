//! Where the window shows the picture, and the size of the picture.
//!
//! In: the layout of the panel and the intervals between frames. Out: the viewport and the picture's size.

use std::time::{Duration, Instant};

use super::action::Action;
use super::app::Open;
use super::recorder::Recording;
use super::resolution::COARSEST;
use super::split::{Right, Split};
use crate::scene::Pose;
use crate::settings::Settings;
use crate::vulkan::Viewport;

/// Delay from the last change of the viewport to that of the picture, which is scaled meanwhile.
const RESIZE_DELAY: Duration = Duration::from_millis(150);
/// Time without motion after which a picture is at rest.
const REST_DELAY: Duration = Duration::from_millis(500);
/// Frames at rest by which its resolution is judged: later ones have a mean that is not to be lost.
const JUDGED_AT_REST: u32 = 16;

/// The pose that stands still, and since when.
pub(super) struct Standing {
    pose: Pose,
    since: Instant,
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
        if self.is_measuring()
            || self.has_waiting()
            || self.resized.is_none_or(|when| when.elapsed() <= RESIZE_DELAY)
        {
            return;
        }
        self.resized = None;
        let size = self.picture_size();
        if let Some(session) = self.session.as_ref().filter(|session| session.settings.size != size) {
            let settings = Settings { size, ..session.settings.clone() };
            self.actions.push(Action::Set(Box::new(settings)));
        }
    }

    /// Window pixels per picture pixel in each direction; none: as the rate asks for.
    pub fn set_coarseness(&mut self, pixels: Option<u32>) {
        self.resolution.hold();
        self.resolution.automatic = pixels.is_none();
        if let Some(pixels) = pixels {
            self.resolution.coarseness = pixels.clamp(1, COARSEST);
        }
        self.resized = Some(Instant::now());
    }

    /// Whether no frame would differ from the last one: a scene is loaded, or the picture is frozen.
    pub fn is_calm(&self) -> bool {
        let is_frozen = self.session.as_ref().is_none_or(|session| session.renderer.is_frozen())
            && self.split.as_ref().is_none_or(Split::is_frozen);
        let waits = self.actions.is_empty() && self.saving.is_empty() && self.resized.is_none();
        let waits = waits && !(self.follows_rate() && self.resolution.awaits_rest());
        is_frozen && waits && self.tour.is_none() && !self.egui.egui_ctx().has_requested_repaint()
    }

    /// Whether the resolution is to be judged. Not while something else needs the machine, or a picture must keep its size.
    fn follows_rate(&self) -> bool {
        let is_still = self.split.as_ref().is_some_and(|split| !matches!(split.right, Right::Renderer(_)));
        let is_busy = self.loader.progress().is_some() || self.resized.is_some() || self.is_measuring();
        let is_fixed = is_still || !matches!(self.recording, Recording::Off);
        self.resolution.automatic && !is_busy && !is_fixed
    }

    /// Gives the picture as many pixels as keep the target rate, or all of them where there is none; at rest, as many as it has time
    /// for.
    pub fn follow_rate(&mut self) {
        let Some(session) = self.session.as_ref().filter(|_| self.follows_rate()) else {
            self.resolution.restart();
            return;
        };
        let standing = self.standing.take().filter(|standing| standing.pose == session.pose);
        let standing =
            standing.unwrap_or_else(|| Standing { pose: session.pose.clone(), since: Instant::now() });
        let is_at_rest = standing.since.elapsed() > REST_DELAY;
        self.standing = Some(standing);
        let (still, is_frozen) = (session.renderer.still_frames(), session.renderer.is_frozen());
        let (interval, cost) = (self.clock.interval_ms(), session.report.figures.total_ms);
        let changed = match self.aim_ms(session.settings.target_fps) {
            None => std::mem::replace(&mut self.resolution.coarseness, 1) != 1,
            Some(_) if is_at_rest && self.resolution.rest() => true,
            Some(_) if !is_at_rest && self.resolution.move_on() => true,
            // Frames of a frozen picture cost nothing.
            Some(aim) if still <= JUDGED_AT_REST && !is_frozen => self.resolution.judge(interval, cost, aim),
            Some(_) => {
                self.resolution.restart();
                false
            }
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
