//! How many window pixels a picture pixel covers, chosen by the intervals and costs of frames.

use crate::statistics::percentile;

/// Largest coarseness.
pub(super) const COARSEST: u32 = 8;
/// The largest that is chosen automatically: nothing can be made out in a coarser picture.
const COARSEST_AUTOMATIC: u32 = 4;

/// Intervals longer than the aim by this factor ask for fewer pixels.
const SLOW: f64 = 1.25;
/// Share of the aim that more pixels must be expected to stay within.
const HEADROOM: f64 = 0.8;
/// Longest frame of a picture at rest, ms: it needs no rate, but the panel must still answer.
const LONGEST_AT_REST: f64 = 500.0;
/// The resolution is judged by the median over at least so many frames and so many ms.
const JUDGED: (usize, f64) = (3, 1e3);

/// Window pixels per picture pixel.
pub(super) struct Resolution {
    /// The number in each direction, 1 to [`COARSEST`].
    pub coarseness: u32,
    /// Whether it follows the frame rate.
    pub automatic: bool,
    /// The coarseness in motion, while the picture is at rest.
    in_motion: Option<u32>,
    /// Median cost of a frame as last judged, if it had all pixels, ms.
    full_ms: Option<f64>,
    /// Interval and cost of each frame since the last judgement, ms.
    frames: Vec<[f64; 2]>,
    /// The largest coarseness that was too fine; 0 if none was.
    too_fine: u32,
}

impl Resolution {
    /// Window pixels are picture pixels, unless it is `automatic` and frames turn out to take too long.
    pub fn full(automatic: bool) -> Self {
        Self { coarseness: 1, automatic, in_motion: None, full_ms: None, frames: Vec::new(), too_fine: 0 }
    }

    /// Whether the picture would get more pixels at rest.
    pub fn awaits_rest(&self) -> bool {
        self.automatic && self.in_motion.is_none() && self.coarseness > 1
    }

    /// The picture is at rest: it gets all pixels that its frames have time for. Whether the coarseness has changed.
    pub fn rest(&mut self) -> bool {
        if !self.automatic || self.in_motion.is_some() {
            return false;
        }
        let now = self.coarseness;
        self.in_motion = Some(now);
        self.frames.clear();
        let Some(ms) = self.full_ms else { return false };
        self.coarseness = (1..now).find(|&finer| ms <= LONGEST_AT_REST * pixels(finer)).unwrap_or(now);
        self.coarseness != now
    }

    /// The picture is at rest no longer. Whether the coarseness has changed.
    pub fn move_on(&mut self) -> bool {
        let Some(in_motion) = self.in_motion.take() else { return false };
        self.frames.clear();
        // A size that was too fine at rest is so in motion.
        let wanted = in_motion.max(self.coarseness);
        std::mem::replace(&mut self.coarseness, wanted) != wanted
    }

    /// The coarseness of motion stays, whatever the rate. Whether it was another.
    pub fn hold(&mut self) -> bool {
        self.automatic = false;
        self.move_on()
    }

    /// Forgets what was measured, since another picture is drawn.
    pub fn forget(&mut self) {
        self.frames.clear();
        self.too_fine = 0;
        self.full_ms = None;
    }

    /// Restarts the measurement of the current picture.
    pub fn restart(&mut self) {
        self.frames.clear();
    }

    /// Counts a frame that came after `interval` ms, of which its passes took `cost`, where `aim` ms are wanted in motion; whether
    /// the coarseness has changed.
    pub fn judge(&mut self, interval: f64, cost: f64, aim: f64) -> bool {
        let is_at_rest = self.in_motion.is_some();
        let aim = if is_at_rest { aim.max(LONGEST_AT_REST) } else { aim };
        // A frame that waits for the display costs less than its interval.
        self.frames.push([interval, cost.min(interval)]);
        if self.frames.len() < JUDGED.0 || self.frames.iter().map(|[ms, _]| ms).sum::<f64>() < JUDGED.1 {
            return false;
        }
        let median = |which: usize| percentile(self.frames.iter().map(|frame| frame[which]), 0.5);
        let [interval, cost] = [0, 1].map(|which| median(which).unwrap_or(aim));
        self.frames.clear();
        let now = self.coarseness;
        // A frame costs as much as it has pixels.
        let expected = |ms: f64, coarseness: u32| ms * pixels(now) / pixels(coarseness);
        self.full_ms = Some(expected(cost, 1));
        let wanted = if interval > SLOW * aim {
            self.too_fine = self.too_fine.max(now);
            let most = now.max(COARSEST_AUTOMATIC);
            (now..most).find(|&coarser| expected(interval, coarser) <= aim).unwrap_or(most)
        } else if is_at_rest {
            // Its frames add up to the mean, which other pixels would begin again.
            now
        } else {
            let mut finer = self.too_fine + 1..now;
            finer.find(|&finer| expected(cost, finer) <= HEADROOM * aim).unwrap_or(now)
        };
        std::mem::replace(&mut self.coarseness, wanted) != wanted
    }
}

/// Window pixels per picture pixel.
fn pixels(coarseness: u32) -> f64 {
    f64::from(coarseness).powi(2)
}

#[cfg(test)]
mod tests {
    use super::*;

    const AIM: f64 = 1e3 / 15.0;

    /// The coarseness after a second of frames that take `ms` at full resolution.
    fn judged(resolution: &mut Resolution, ms: f64) -> u32 {
        let cost = ms / f64::from(resolution.coarseness).powi(2);
        let _ = (0..1000).any(|_| resolution.judge(cost, cost, AIM));
        resolution.coarseness
    }

    #[test]
    fn the_resolution_follows_the_cost_of_a_frame() {
        let mut resolution = Resolution::full(true);
        assert_eq!(judged(&mut resolution, 40.0), 1, "25 frames a second at full resolution");
        assert_eq!(judged(&mut resolution, 500.0), 3, "7.5 times too slow, so a ninth of the pixels");
        assert_eq!(judged(&mut resolution, 500.0), 3);
        assert_eq!(judged(&mut resolution, 1e9), COARSEST_AUTOMATIC);
        resolution.forget();
        assert_eq!(judged(&mut resolution, 40.0), 1);
    }

    #[test]
    fn a_picture_at_rest_gets_the_pixels_that_it_has_time_for() {
        let mut resolution = Resolution::full(true);
        assert_eq!(judged(&mut resolution, 600.0), 3);
        assert_eq!(judged(&mut resolution, 600.0), 3);
        assert!(resolution.awaits_rest() && resolution.rest());
        assert_eq!(resolution.coarseness, 2, "all pixels would take 600 ms");
        assert!(!resolution.rest() && !resolution.awaits_rest());
        assert_eq!(judged(&mut resolution, 100.0), 2, "the mean is not begun again");
        assert!(resolution.move_on() && !resolution.move_on());
        assert_eq!(resolution.coarseness, 3);
    }

    #[test]
    fn what_is_too_slow_at_rest_is_so_in_motion() {
        let mut resolution = Resolution::full(true);
        assert!(!resolution.rest(), "it has all pixels already");
        assert_eq!(judged(&mut resolution, 4000.0), 3);
        assert!(!resolution.move_on());
        assert_eq!(resolution.coarseness, 3);
    }

    #[test]
    fn a_held_picture_keeps_the_pixels_of_motion() {
        let mut resolution = Resolution::full(true);
        assert_eq!(judged(&mut resolution, 500.0), 3);
        assert_eq!(judged(&mut resolution, 500.0), 3);
        assert!(resolution.rest() && resolution.hold());
        assert_eq!(resolution.coarseness, 3);
        assert!(!resolution.rest() && !resolution.awaits_rest());
    }

    #[test]
    fn the_pace_of_the_display_is_no_cost() {
        let mut resolution = Resolution { coarseness: 2, ..Resolution::full(true) };
        let _ = (0..1000).any(|_| resolution.judge(AIM, 3.0, AIM));
        assert_eq!(resolution.coarseness, 1);
    }

    #[test]
    fn a_single_slow_frame_changes_nothing() {
        let mut resolution = Resolution::full(true);
        assert!([20.0, 20.0, 2e3].iter().all(|ms| !resolution.judge(*ms, *ms, AIM)));
        assert_eq!(resolution.coarseness, 1);
    }

    #[test]
    fn what_was_too_fine_is_not_tried_again() {
        let mut resolution = Resolution::full(true);
        assert_eq!(judged(&mut resolution, 500.0), 3);
        assert_eq!(judged(&mut resolution, 250.0), 3);
        assert_eq!(judged(&mut resolution, 100.0), 2, "1 has been too slow before");
        resolution.forget();
        assert_eq!(judged(&mut resolution, 40.0), 1);
    }
}
