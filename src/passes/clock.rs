//! The convergence of a static scene: it runs through one cycle of jitter and noise that is averaged, then it freezes.
//!
//! In: whether anything has changed since the last frame. Out: the number of the frame in that cycle. The cycle begins with the same
//! temporal set whatever came before, so that what it makes does not depend on the past.

use glam::Vec2;

use crate::scene::Pose;

/// Positions in a pixel that antialiasing goes through.
const JITTERS: u32 = 16;
/// Frames of noise that are averaged before those of the last positions are.
const NOISE_FRAMES: u32 = 48;

/// What the frames of a static scene go through until they freeze.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cycle {
    /// Frames in which the estimator renders everything once.
    pub estimator: u32,
    /// Frames after which its light is that of a fresh start.
    pub settled: u32,
    /// Whether denoisers accumulate noise.
    pub is_noisy: bool,
    /// Whether pixels are sampled at several positions.
    pub is_jittered: bool,
}

/// A frame of a static scene. A denoiser begins another history at the first, which depends on nothing before, and shows that in
/// the end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StaticFrame {
    /// Its number, from 0.
    pub index: u32,
    /// Whether that history is shown from now on.
    pub shown: bool,
}

impl Cycle {
    /// The length of the cycle, frames.
    pub fn frames(&self) -> u64 {
        u64::from(self.settling() + JITTERS)
    }

    /// Frames before those whose pictures are averaged.
    fn settling(&self) -> u32 {
        self.settled + if self.is_noisy { NOISE_FRAMES } else { 0 }
    }
}

/// Counts frames, and those of a static scene.
#[derive(Default)]
pub struct ConvergenceClock {
    frame: u64,
    last: Option<Pose>,
    /// The frame in which the cycle began.
    begun: Option<u64>,
}

/// The place of a frame in the cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrameClock {
    /// Number of the frame.
    pub frame: u64,
    /// The number of the frame in the cycle of a static scene; none while anything changes.
    rest: Option<u32>,
    cycle: Cycle,
}

impl ConvergenceClock {
    /// Number of the next frame.
    pub fn frame(&self) -> u64 {
        self.frame
    }

    /// Begins the cycle anew: something else than the pose has changed.
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

    /// Whether this is the last of the frames whose pictures are averaged.
    pub fn is_last_averaged(&self) -> bool {
        self.averaged() == Some(JITTERS - 1)
    }

    /// Whether the cycle is over, and nothing random is sampled any more.
    pub fn is_frozen(&self) -> bool {
        self.rest.is_some_and(|rest| rest >= self.cycle.settling() + JITTERS)
    }

    /// The frame's place in the static scene as denoisers count it; none while anything changes.
    pub fn static_frame(&self) -> Option<StaticFrame> {
        let rest = self.rest.filter(|_| self.cycle.is_noisy)?;
        // What rays see of the estimator's light may be of the past before.
        let index = rest.checked_sub(self.cycle.settled)?;
        Some(StaticFrame { index, shown: index >= NOISE_FRAMES })
    }

    /// Number of the frame in the sequence of random numbers.
    pub fn noise_frame(&self) -> u32 {
        self.rest.unwrap_or(self.frame as u32)
    }

    /// From the middle of a pixel to where it is sampled, pixels. What stands still in the end is sampled in the middle.
    pub fn jitter(&self) -> Vec2 {
        if !self.cycle.is_jittered || self.is_frozen() {
            return Vec2::ZERO;
        }
        jitter(self.rest.unwrap_or((self.frame % u64::from(JITTERS)) as u32) % JITTERS)
    }
}

/// One of 16 points of the pixel from -1/2 to 1/2, of which each sixteenth of its width and height has one, and each run of four is
/// spread over it: the start of the Sobol sequence, scrambled so that the first lies next to the middle. Closer to the integral over
/// the pixel than so many of the Halton sequence.
fn jitter(index: u32) -> Vec2 {
    // Generator matrices of the first two dimensions, for four bits.
    const X: [u32; 4] = [8, 4, 2, 1];
    const Y: [u32; 4] = [8, 12, 10, 15];
    let point = |matrix: [u32; 4]| {
        let bits = (0..4).filter(|bit| index >> bit & 1 == 1).fold(8, |point, bit| point ^ matrix[bit]);
        (bits as f32 + 0.5) / 16.0 - 0.5
    };
    Vec2::new(point(X), point(Y))
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
        let mut clock = ConvergenceClock::default();
        let fresh: Vec<FrameClock> = (0..30).map(|_| clock.next(&pose, CYCLE)).collect();
        let mut clock = ConvergenceClock::default();
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
    fn jitter_covers_the_pixel_evenly() {
        let [pose, _] = poses();
        let mut clock = ConvergenceClock::default();
        let cycle = Cycle { settled: 16, ..CYCLE };
        let jitters: Vec<Vec2> = (0..16).map(|_| clock.next(&pose, cycle).jitter()).collect();
        assert!(jitters[0].length() < 0.05, "{}", jitters[0]);
        assert_eq!(jitters.iter().sum::<Vec2>(), Vec2::ZERO);
        let mut strips = [Vec::new(), Vec::new()];
        for jitter in &jitters {
            (0..2).for_each(|axis| strips[axis].push(((jitter[axis] + 0.5) * 16.0) as u32));
        }
        for mut strip in strips {
            strip.sort_unstable();
            assert_eq!(strip, Vec::from_iter(0..16));
        }
        for run in jitters.chunks(4) {
            let mut quarters: Vec<bool> =
                run.iter().flat_map(|jitter| [jitter.x > 0.0, jitter.y > 0.0]).collect();
            quarters.sort_unstable();
            assert_eq!(quarters, [[false; 4], [true; 4]].concat(), "{run:?}");
        }
    }
}
