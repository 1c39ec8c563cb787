//! Animation time and frame intervals.

use std::time::{Duration, Instant};

use serde::Serialize;

/// Longest step of a flight, seconds, so that a slow frame does not carry the camera through a wall.
const LONGEST_STEP: f64 = 0.1;
/// Longest step of the animation, seconds: it follows real time at any frame rate, but stands still while the program does.
const LONGEST_PAUSE: f64 = 1.0;

/// Time constant of automatic exposure, seconds: changes of light are seen, then evened out.
const ADAPTATION: f64 = 0.15;

/// Pacing of animation time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum FramePacing {
    /// It follows real time.
    #[default]
    RealTime,
    /// Each frame adds the setting `time_step`.
    Steps,
}

/// Animation time.
pub(super) struct Clock {
    /// Seconds.
    pub time: f64,
    pub paused: bool,
    pub pacing: FramePacing,
    /// When the last frame started.
    pub last_frame: Instant,
    interval: Duration,
}

impl Clock {
    pub fn new(pacing: FramePacing) -> Self {
        Self { time: 0.0, paused: false, pacing, last_frame: Instant::now(), interval: Duration::ZERO }
    }

    /// Starts a frame in which nothing goes on.
    pub fn hold(&mut self) {
        (self.interval, self.last_frame) = (Duration::ZERO, Instant::now());
    }

    /// Starts a frame; `step` is the setting `time_step`.
    pub fn tick(&mut self, step: f64) {
        let now = Instant::now();
        self.interval = now - self.last_frame;
        self.last_frame = now;
        if !self.paused {
            self.time += match self.pacing {
                FramePacing::RealTime => self.interval.as_secs_f64().min(LONGEST_PAUSE),
                FramePacing::Steps => step,
            };
        }
    }

    /// Time since the last frame, seconds, limited for flights.
    pub fn seconds(&self) -> f64 {
        self.interval.as_secs_f64().min(LONGEST_STEP)
    }

    /// Share of its way that automatic exposure goes in this frame.
    pub fn exposure_pace(&self) -> f32 {
        1.0 - (-self.interval.as_secs_f64() / ADAPTATION).exp() as f32
    }

    /// Time since the last frame, ms.
    pub fn interval_ms(&self) -> f64 {
        self.interval.as_secs_f64() * 1e3
    }
}
