//! Size of the picture in the window.
//!
//! In: the viewport that the panel leaves, and the intervals between frames. Out: the picture's size.

use std::time::{Duration, Instant};

use super::resolution::{COARSEST, Resolution};
use super::session::Session;
use crate::scene::Pose;
use crate::vulkan::Viewport;

/// Delay from the last change of the viewport to that of the picture, which is scaled meanwhile.
const RESIZE_DELAY: Duration = Duration::from_millis(150);
/// Time without motion after which a picture is at rest.
const REST_DELAY: Duration = Duration::from_millis(500);
/// Frames at rest by which its resolution is judged: later ones have a mean that is not to be lost.
const JUDGED_AT_REST: u32 = 16;

/// Viewport and resolution of the picture.
pub(super) struct PictureSize {
    pub resolution: Resolution,
    /// The viewport of the last frame.
    viewport: Viewport,
    /// Time of the last change of the viewport or the resolution, until the picture follows.
    pub changed: Option<Instant>,
    rest: Option<RestState>,
}

/// The stationary pose, and since when.
struct RestState {
    pose: Pose,
    since: Instant,
}

impl PictureSize {
    /// Window pixels are picture pixels, unless the resolution is `automatic`.
    pub fn new(automatic: bool) -> Self {
        Self {
            resolution: Resolution::full(automatic),
            viewport: Viewport::default(),
            changed: None,
            rest: None,
        }
    }

    /// Size of the picture in a viewport, pixels.
    pub fn in_viewport(&self, viewport: Viewport) -> [u32; 2] {
        viewport.size.map(|side| side.div_ceil(self.resolution.coarseness).max(1))
    }

    /// Notes that the picture may need another size.
    pub fn change(&mut self) {
        self.changed = Some(Instant::now());
    }

    /// Notes the viewport of this frame.
    pub fn follow(&mut self, viewport: Viewport) {
        if std::mem::replace(&mut self.viewport, viewport) != viewport {
            self.change();
        }
    }

    /// The size that the picture is to have, once [`RESIZE_DELAY`] after a change.
    pub fn take_due(&mut self) -> Option<[u32; 2]> {
        self.changed.take_if(|when| when.elapsed() > RESIZE_DELAY)?;
        Some(self.in_viewport(self.viewport))
    }

    /// Keeps the coarseness of motion, whatever the rate.
    pub fn hold(&mut self) {
        if self.resolution.hold() {
            self.change();
        }
    }

    /// Window pixels per picture pixel in each direction; none: as the rate asks for.
    pub fn set_coarseness(&mut self, pixels: Option<u32>) {
        self.resolution.hold();
        self.resolution.automatic = pixels.is_none();
        if let Some(pixels) = pixels {
            self.resolution.coarseness = pixels.clamp(1, COARSEST);
        }
        self.change();
    }

    /// Gives the picture as many pixels as keep the target rate, or all of them where there is none; at rest, as many as it has time
    /// for. `interval`: between frames, ms; `refresh`: frames that the display shows, per second.
    pub fn follow_rate(&mut self, session: &Session, interval: f64, refresh: Option<f64>) {
        let rest = self.rest.take().filter(|rest| rest.pose == session.pose);
        let rest = rest.unwrap_or_else(|| RestState { pose: session.pose.clone(), since: Instant::now() });
        let is_at_rest = rest.since.elapsed() > REST_DELAY;
        self.rest = Some(rest);
        let (still, is_frozen) = (session.renderer.still_frames(), session.renderer.is_frozen());
        let cost = session.report.figures.total_ms;
        let changed = match aim_ms(session.settings.target_fps, refresh) {
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
            self.change();
        }
    }
}

/// The interval of frames at the `target` rate, ms, but no shorter than the display shows them; none where the target is 0.
fn aim_ms(target: u32, refresh: Option<f64>) -> Option<f64> {
    (target > 0).then(|| 1e3 / f64::from(target).min(refresh.unwrap_or(f64::INFINITY)))
}
