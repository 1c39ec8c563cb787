//! What a still scene does: it runs through one cycle of jitter and noise that is averaged, then it stands still.
//!
//! In: whether anything has changed since the last frame. Out: the number of the frame in that cycle. It begins at the same
//! temporal set whatever came before, so that what it makes does not depend on the past.

use glam::Vec2;

use crate::denoise::RestFrame;
use crate::scene::Pose;

/// Positions in a pixel that antialiasing goes through.
const JITTERS: u32 = 16;
/// Frames of noise that are averaged before those of the last positions are.
const NOISE_FRAMES: u32 = 48;

/// What the frames of a renderer take to come to rest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Cycle {
    /// Of the estimator: see [`crate::estimators::Estimator::cycle`].
    pub estimator: u32,
    /// Frames after which its light is that of a fresh start.
    pub settled: u32,
    /// Whether rays are random.
    pub is_noisy: bool,
    /// Whether pixels are sampled at several positions.
    pub is_jittered: bool,
}

impl Cycle {
    /// Frames before those whose pictures are averaged.
    fn settling(&self) -> u32 {
        self.settled.max(if self.is_noisy { NOISE_FRAMES } else { 0 })
    }
}

/// Counts frames, and those at rest.
#[derive(Default)]
pub(super) struct RestClock {
    frame: u64,
    last: Option<Pose>,
    /// The frame in which the cycle began.
    begun: Option<u64>,
}

/// Where a frame stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct FrameClock {
    /// Number of the frame.
    pub frame: u64,
    /// The same in a still scene; none while anything changes.
    rest: Option<u32>,
    cycle: Cycle,
}

impl RestClock {
    /// A clock that goes on at a frame.
    pub fn starting_at(frame: u64) -> Self {
        Self { frame, ..Self::default() }
    }

    /// Number of the next frame.
    pub fn frame(&self) -> u64 {
        self.frame
    }

    /// Something else than the pose has changed.
    pub fn disturb(&mut self) {
        self.last = None;
        self.begun = None;
    }

    /// The next frame, with everything standing as in `pose`.
    pub fn next(&mut self, pose: &Pose, cycle: Cycle) -> FrameClock {
        let frame = self.frame;
        self.frame += 1;
        let moves = self.last.as_ref().is_some_and(|last| last != pose);
        if moves {
            self.begun = None;
        }
        if self.last.is_none() || moves {
            self.last = Some(pose.clone());
        }
        if !moves && self.begun.is_none() && frame.is_multiple_of(u64::from(cycle.estimator)) {
            self.begun = Some(frame);
        }
        let rest = self.begun.map(|begun| u32::try_from(frame - begun).unwrap_or(u32::MAX));
        FrameClock { frame, rest, cycle }
    }
}

impl FrameClock {
    /// The place among the frames whose pictures are averaged, 0 to 15.
    pub fn averaged(&self) -> Option<u32> {
        let place = self.rest?.checked_sub(self.cycle.settling())?;
        (place < JITTERS).then_some(place)
    }

    /// Whether the cycle is over, and nothing is drawn any more that is random.
    pub fn is_frozen(&self) -> bool {
        self.rest.is_some_and(|rest| rest >= self.cycle.settling() + JITTERS)
    }

    /// What denoisers are told; none while anything changes.
    pub fn rest(&self) -> Option<RestFrame> {
        let rest = self.rest.filter(|_| self.cycle.is_noisy)?;
        Some(RestFrame { index: rest, shown: rest >= self.cycle.settling() })
    }

    /// Number of the frame in the sequence of random numbers.
    pub fn noise_frame(&self) -> u32 {
        self.rest.unwrap_or(self.frame as u32)
    }

    /// From the middle of a pixel to where it is sampled, pixels: 16 points of the Halton sequence to the bases 2 and 3, shifted
    /// so that the first is the middle. What stands still is sampled there, too.
    pub fn jitter(&self) -> Vec2 {
        if !self.cycle.is_jittered || self.is_frozen() {
            return Vec2::ZERO;
        }
        let index = self.rest.map_or((self.frame % u64::from(JITTERS)) as u32, |rest| rest % JITTERS);
        let first = halton(1);
        let shifted = halton(index + 1) - first + 0.5;
        shifted - shifted.floor() - 0.5
    }
}

fn halton(index: u32) -> Vec2 {
    Vec2::new(radical_inverse(index, 2), radical_inverse(index, 3))
}

fn radical_inverse(mut index: u32, base: u32) -> f32 {
    let (mut value, mut digit) = (0.0, 1.0);
    while index > 0 {
        digit /= base as f32;
        value += (index % base) as f32 * digit;
        index /= base;
    }
    value
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Scene;

    const CYCLE: Cycle = Cycle { estimator: 4, settled: 10, is_noisy: false, is_jittered: true };

    fn poses() -> [Pose; 2] {
        let pose = Scene::new("empty").pose(0.0);
        let mut moved = pose.clone();
        moved.camera.eye.x += 1.0;
        [pose, moved]
    }

    #[test]
    fn the_cycle_begins_with_the_first_set_and_ends() {
        let [pose, moved] = poses();
        let mut clock = RestClock::default();
        let fresh: Vec<FrameClock> = (0..30).map(|_| clock.next(&pose, CYCLE)).collect();
        let mut clock = RestClock::default();
        clock.next(&pose, CYCLE);
        let moving = clock.next(&moved, CYCLE);
        assert_eq!((moving.rest, moving.averaged()), (None, None));
        // Frames 2 and 3 wait for the first set.
        assert_eq!(clock.next(&moved, CYCLE).rest, None);
        clock.next(&moved, CYCLE);
        for expected in &fresh {
            let found = clock.next(&moved, CYCLE);
            assert_eq!(found.rest, expected.rest);
            assert_eq!(found.jitter(), expected.jitter());
        }
        let averaged: Vec<u32> = fresh.iter().filter_map(FrameClock::averaged).collect();
        assert_eq!(averaged, Vec::from_iter(0..16));
        assert!(!fresh[25].is_frozen() && fresh[26].is_frozen());
    }

    #[test]
    fn jitter_covers_the_pixel_from_its_middle_on() {
        let [pose, _] = poses();
        let mut clock = RestClock::default();
        let cycle = Cycle { settled: 16, ..CYCLE };
        let jitters: Vec<Vec2> = (0..16).map(|_| clock.next(&pose, cycle).jitter()).collect();
        assert_eq!(jitters[0], Vec2::ZERO);
        let mean = jitters.iter().sum::<Vec2>() / 16.0;
        assert!(mean.abs().max_element() < 0.06, "{mean}");
        for quarter in 0..4 {
            let inside = |jitter: &&Vec2| {
                (jitter.x >= 0.0) == (quarter & 1 == 1) && (jitter.y >= 0.0) == (quarter & 2 == 2)
            };
            assert!((3..=5).contains(&jitters.iter().filter(inside).count()), "{jitters:?}");
        }
    }
}
