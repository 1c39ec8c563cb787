//! The clock: counts frames, and those in which nothing changes. Their raw radiance is averaged (still.rs) until the picture freezes.
//!
//! In: where everything stands, and whether the estimator equals a restart. Out: the number of the frame among the still
//! ones. The first begins a cycle of the estimator, and all that is random follows from that number, so that the mean of so many frames
//! does not depend on the past.

use glam::Vec2;

use crate::scene::Pose;

/// Positions in a pixel that antialiasing goes through while anything changes, and before it goes on to others in a still scene.
const JITTERS: u32 = 16;
/// Phases of a checkerboard of 2 x 2 pixels, of which a frame samples one.
const CHECKERBOARD_PHASES: u32 = 4;

/// When still frames begin and end.
#[derive(Clone, Copy, Debug)]
pub struct ClockInputs {
    /// Frames after which the estimator begins again, the first with frame 0.
    pub cycle_length: u32,
    /// Whether the estimator's light is that of a restart.
    pub equals_restart: bool,
    /// Frames that are averaged until the picture freezes; 0: none is.
    pub still_frames: u32,
    /// Whether pixels are sampled at several positions.
    pub is_jittered: bool,
}

/// Counts frames, and those of a still scene.
#[derive(Default)]
pub struct Clock {
    frame: u64,
    last: Option<Pose>,
    /// The frame that first showed the last change.
    changed: Option<u64>,
    /// The first still frame.
    begun: Option<u64>,
}

/// The place of a frame in time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrameClock {
    /// Number of the frame.
    pub frame: u64,
    /// Whether it shows something else than the frame before.
    is_moving: bool,
    camera_moves: bool,
    /// Its number among the still frames, at most that of the last which is averaged; none while anything changes.
    still: Option<u32>,
    is_frozen: bool,
    still_frames: u32,
    cycle_length: u32,
    is_jittered: bool,
}

impl Clock {
    /// The clock of a renderer that was made for this pose: a first frame that shows another one shows a change.
    pub fn new(pose: &Pose) -> Self {
        Self { last: Some(pose.clone()), ..Self::default() }
    }

    /// Number of the next frame.
    pub fn frame(&self) -> u64 {
        self.frame
    }

    /// Something else than the pose changes in the next frame.
    pub fn disturb(&mut self) {
        self.last = None;
        self.begun = None;
        self.changed = Some(self.frame);
    }

    /// The next frame, with everything standing as in `pose`.
    pub fn next(&mut self, pose: &Pose, inputs: &ClockInputs) -> FrameClock {
        let ClockInputs { cycle_length, equals_restart, still_frames, is_jittered } = *inputs;
        let frame = self.frame;
        self.frame += 1;
        let moves = self.last.as_ref().is_some_and(|last| last != pose);
        let camera_moves = self.last.as_ref().is_some_and(|last| last.camera != pose.camera);
        if moves {
            self.begun = None;
            self.changed = Some(frame);
        }
        if self.last.is_none() || moves {
            self.last = Some(pose.clone());
        }
        // In the first frame after a change the estimator learns that it has ended.
        let has_rested = self.changed.is_none_or(|changed| frame > changed + 1);
        if self.begun.is_none()
            && has_rested
            && equals_restart
            && frame.is_multiple_of(u64::from(cycle_length))
        {
            self.begun = Some(frame);
        }
        let still = self.begun.filter(|_| still_frames > 0).map(|begun| frame - begun);
        FrameClock {
            frame,
            is_moving: moves,
            camera_moves,
            still: still.map(|still| still.min(u64::from(still_frames) - 1) as u32),
            is_frozen: still.is_some_and(|still| still >= u64::from(still_frames)),
            still_frames,
            cycle_length,
            is_jittered,
        }
    }
}

impl FrameClock {
    /// The number of the frame among those that are averaged, from 0; none while anything changes, and once the picture is frozen.
    pub fn averaged(&self) -> Option<u32> {
        self.still.filter(|_| !self.is_frozen)
    }

    /// Whether anything has moved since the frame before.
    pub fn is_moving(&self) -> bool {
        self.is_moving
    }

    /// Whether the camera has moved since the frame before.
    pub fn camera_moves(&self) -> bool {
        self.camera_moves
    }

    /// Frames whose mean the picture goes over to, with this one; 0 while anything changes.
    pub fn still_frames(&self) -> u32 {
        self.still.map_or(0, |still| still + 1)
    }

    /// Share of the frames to be averaged that the mean holds.
    pub fn progress(&self) -> f32 {
        self.still_frames() as f32 / self.still_frames.max(1) as f32
    }

    /// Whether the mean is complete, and the picture stays.
    pub fn is_frozen(&self) -> bool {
        self.is_frozen
    }

    /// Number of the frame in the sequence of random numbers.
    pub fn noise_frame(&self) -> u32 {
        self.still.unwrap_or(self.frame as u32)
    }

    /// Number of the frame in the estimator's cycle, from 0.
    pub fn cycle_phase(&self) -> u32 {
        (self.frame % u64::from(self.cycle_length)) as u32
    }

    /// Number of the cycle in the sequence of random numbers.
    pub fn cycle(&self) -> u32 {
        self.noise_frame() / self.cycle_length
    }

    /// The pixel of 2 x 2 that an estimator of half the resolution samples, 0 to 3. In a still scene each four frames sample all, and so
    /// does in time each phase of the cycle.
    pub fn checkerboard_phase(&self) -> u32 {
        let Some(still) = self.still else { return self.cycle_phase() % CHECKERBOARD_PHASES };
        // The least number of frames after which a phase of the cycle meets the same pixel again.
        let period = self.cycle_length
            << (CHECKERBOARD_PHASES.trailing_zeros() - self.cycle_length.trailing_zeros().min(2));
        (still + still / period) % CHECKERBOARD_PHASES
    }

    /// Offset from the middle of a pixel to where it is sampled, pixels.
    pub fn jitter(&self) -> Vec2 {
        if !self.is_jittered {
            return Vec2::ZERO;
        }
        let Some(still) = self.still else { return jitter((self.frame % u64::from(JITTERS)) as u32) };
        // Each pixel of 2 x 2 goes through all positions when its frames come, and so do each 16 frames.
        let round = still / CHECKERBOARD_PHASES;
        jitter(
            round / JITTERS * JITTERS
                + (round + self.checkerboard_phase() * JITTERS / CHECKERBOARD_PHASES) % JITTERS,
        )
    }
}

/// A point of the pixel from -1/2 to 1/2, of the Sobol sequence, scrambled so that the first lies next to the middle. Each run of 4, 16,
/// 64 ... points has as many in all equal parts of the pixel. Closer to the integral over the pixel than the Halton sequence.
fn jitter(index: u32) -> Vec2 {
    let [mut x, mut y] = [0x8888u16; 2];
    // The generator matrices of the first two dimensions, column by column.
    let [mut column_x, mut column_y] = [1 << 15; 2];
    for bit in 0..16 {
        if index >> bit & 1 == 1 {
            (x, y) = (x ^ column_x, y ^ column_y);
        }
        (column_x, column_y) = (column_x >> 1, column_y ^ column_y >> 1);
    }
    Vec2::new(x.into(), y.into()) / 65536.0 - 0.5
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;
    use crate::scene::Scene;

    const INPUTS: ClockInputs =
        ClockInputs { cycle_length: 4, equals_restart: true, still_frames: 12, is_jittered: true };

    fn poses() -> [Pose; 2] {
        let pose = Scene::new("empty").pose(0.0);
        let mut moved = pose.clone();
        moved.camera.eye.x += 1.0;
        [pose, moved]
    }

    #[test]
    fn still_frames_begin_with_a_cycle_and_end() {
        let [pose, moved] = poses();
        let mut clock = Clock::default();
        let fresh: Vec<FrameClock> = (0..16).map(|_| clock.next(&pose, &INPUTS)).collect();
        let mut clock = Clock::default();
        clock.next(&pose, &INPUTS);
        let moving = clock.next(&moved, &INPUTS);
        assert_eq!((moving.averaged(), moving.still_frames()), (None, 0));
        assert_eq!([(); 2].map(|()| clock.next(&moved, &INPUTS).averaged()), [None; 2], "amid a cycle");
        let changing = ClockInputs { equals_restart: false, ..INPUTS };
        assert_eq!([(); 4].map(|()| clock.next(&moved, &changing).averaged()), [None; 4]);
        for expected in &fresh {
            let found = clock.next(&moved, &INPUTS);
            assert_eq!(found.averaged(), expected.averaged());
            assert_eq!((found.jitter(), found.noise_frame()), (expected.jitter(), expected.noise_frame()));
            assert_eq!((found.cycle_phase(), found.cycle()), (expected.cycle_phase(), expected.cycle()));
        }
        let averaged: Vec<u32> = fresh.iter().filter_map(FrameClock::averaged).collect();
        assert_eq!(averaged, Vec::from_iter(0..12));
        assert!(!fresh[11].is_frozen() && fresh[12].is_frozen() && fresh[11].progress() == 1.0);
        let never = ClockInputs { still_frames: 0, ..INPUTS };
        assert_eq!(Clock::default().next(&pose, &never).averaged(), None);
    }

    #[test]
    fn a_change_is_over_in_its_second_frame() {
        let [pose, moved] = poses();
        let inputs = ClockInputs { cycle_length: 1, ..INPUTS };
        let mut clock = Clock::default();
        clock.next(&pose, &inputs);
        assert_eq!([(); 3].map(|()| clock.next(&moved, &inputs).averaged()), [None, None, Some(0)]);
        clock.disturb();
        assert_eq!([(); 3].map(|()| clock.next(&moved, &inputs).averaged()), [None, None, Some(0)]);
    }

    #[test]
    fn every_pixel_meets_every_phase_and_every_position() {
        let [pose, _] = poses();
        for cycle_length in [1, 2, 3, 4, 6, 8, 16, 32, 64] {
            let mut clock = Clock::default();
            let inputs = ClockInputs { cycle_length, still_frames: u32::MAX, ..INPUTS };
            let mut met = HashSet::new();
            for frames in 0..16 {
                // 64 frames sample each pixel of 2 x 2 at 16 positions, one in each strip.
                let mut strips = [(); 4].map(|()| [(); 2].map(|()| HashSet::new()));
                for _ in 0..64 {
                    let frame = clock.next(&pose, &inputs);
                    met.insert((frame.cycle_phase(), frame.checkerboard_phase()));
                    let place = (frame.jitter() + 0.5) * 16.0;
                    let [x, y] = &mut strips[frame.checkerboard_phase() as usize];
                    x.insert(place.x as u32);
                    y.insert(place.y as u32);
                }
                let seen = strips.map(|axes| axes.map(|strips| strips.len()));
                assert_eq!(seen, [[16; 2]; 4], "cycles of {cycle_length}, from frame {}", frames * 64);
            }
            assert_eq!(met.len(), 4 * cycle_length as usize, "cycles of {cycle_length}");
        }
    }

    #[test]
    fn jitter_covers_the_pixel_evenly() {
        let jitters: Vec<Vec2> = (0..256).map(jitter).collect();
        assert!(jitters[0].length() < 0.1, "{}", jitters[0]);
        for (runs, most) in [(4, 0.13), (16, 0.04), (64, 0.01), (256, 0.001)] {
            for run in jitters.chunks(runs) {
                let mean = run.iter().sum::<Vec2>() / runs as f32;
                assert!(mean.abs().max_element() < most, "{mean}, the mean of {runs}");
                for axis in 0..2 {
                    let strips: HashSet<u32> =
                        run.iter().map(|jitter| ((jitter[axis] + 0.5) * runs as f32) as u32).collect();
                    assert_eq!(strips.len(), runs);
                }
            }
        }
    }
}
