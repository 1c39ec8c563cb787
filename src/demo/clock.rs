//! The time of the animation, and how long frames take.

use std::time::{Duration, Instant};

use serde::Serialize;

/// Longest step of real time, seconds: after a longer pause the animation goes on where it was.
const LONGEST_STEP: f64 = 0.1;

/// How animation time passes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Pace {
    /// As on the wall.
    #[default]
    RealTime,
    /// By the setting `time_step` each frame.
    Steps,
}

/// Animation time.
pub(super) struct Clock {
    /// Seconds.
    pub time: f64,
    pub paused: bool,
    pub pace: Pace,
    last_frame: Instant,
    interval: Duration,
}

impl Clock {
    pub fn new(pace: Pace) -> Self {
        Self { time: 0.0, paused: false, pace, last_frame: Instant::now(), interval: Duration::ZERO }
    }

    /// A frame begins; `step` is the setting `time_step`.
    pub fn tick(&mut self, step: f64) {
        let now = Instant::now();
        self.interval = now - self.last_frame;
        self.last_frame = now;
        if !self.paused {
            self.time += match self.pace {
                Pace::RealTime => self.seconds(),
                Pace::Steps => step,
            };
        }
    }

    /// What passed since the last frame, seconds, for things that move with real time.
    pub fn seconds(&self) -> f64 {
        self.interval.as_secs_f64().min(LONGEST_STEP)
    }

    /// What really passed since the last frame, milliseconds.
    pub fn interval_ms(&self) -> f64 {
        self.interval.as_secs_f64() * 1e3
    }
}
