//! Metrics of what is left of the divider against what is right of it, in the background, a few times a second while either changes.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::time::{Duration, Instant};

use serde::Serialize;

use crate::metrics::{CompareOptions, Image, Metrics, MetricsError, compare, temporal_error};

/// Time between comparisons.
const INTERVAL: Duration = Duration::from_millis(300);

/// The display values of a picture, for comparisons.
#[derive(Clone)]
pub(super) struct Shot {
    /// Width and height.
    pub size: [u32; 2],
    /// sRGB, in rows from the top left.
    pub pixels: Vec<[u8; 4]>,
}

/// The left picture against the right one.
pub(super) struct Compared {
    /// Errors of display values.
    pub metrics: Metrics,
    /// Mean change of luminance between the last two pictures of the left side; none for the first.
    pub temporal_error: Option<f64>,
    pub size: [usize; 2],
    /// FLIP error of each pixel, 0 to 1, in rows from the top left.
    pub flip: Vec<f32>,
    left: Image,
}

/// The log's entry for a comparison.
#[derive(Serialize)]
pub(super) struct Logged {
    #[serde(flatten)]
    metrics: Metrics,
    temporal_error: Option<f64>,
    /// Samples of the reference, a pixel.
    samples: Option<u64>,
}

/// Compares one pair of pictures at a time.
#[derive(Default)]
pub(super) struct LiveMetrics {
    running: Option<Receiver<Result<Compared, MetricsError>>>,
    begun: Option<Instant>,
    /// The last pair that was compared, see [`Self::is_due`].
    pair: Option<[u64; 2]>,
    /// The last comparison.
    pub last: Option<Compared>,
    /// Counts comparisons.
    pub version: u64,
    logged: u64,
}

impl LiveMetrics {
    /// The last comparison for the log, once. `samples`: of the reference.
    pub fn take_log(&mut self, samples: Option<u64>) -> Option<Logged> {
        let is_new = std::mem::replace(&mut self.logged, self.version) != self.version;
        let Compared { metrics, temporal_error, .. } = self.last.as_ref().filter(|_| is_new)?;
        Some(Logged { metrics: *metrics, temporal_error: *temporal_error, samples })
    }

    /// Forgets the last comparison, and the one in flight.
    pub fn forget(&mut self) {
        (self.running, self.pair, self.last) = (None, None, None);
    }

    /// Takes a comparison that is done; whether it is time for another. `pair` tells the pictures of both sides from those before: a pair
    /// that stays is compared once.
    pub fn is_due(&mut self, pair: [u64; 2]) -> bool {
        match self.running.as_ref().map(Receiver::try_recv) {
            Some(Err(TryRecvError::Empty)) => return false,
            Some(Ok(compared)) => {
                (self.last, self.running) = (compared.ok(), None);
                self.version += 1;
            }
            Some(Err(TryRecvError::Disconnected)) => self.running = None,
            None => {}
        }
        self.pair != Some(pair) && self.begun.is_none_or(|begun| begun.elapsed() >= INTERVAL)
    }

    /// Compares two pictures of one moment, which are this pair.
    pub fn compare(&mut self, left: Shot, right: Arc<Shot>, pair: [u64; 2]) {
        let (sender, receiver) = channel();
        let before = self.last.as_ref().map(|compared| compared.left.clone());
        std::thread::spawn(move || {
            // The receiver is gone where the pair is of no interest any more.
            let _ = sender.send(compared(&left, &right, before));
        });
        self.running = Some(receiver);
        (self.begun, self.pair) = (Some(Instant::now()), Some(pair));
    }
}

fn compared(left: &Shot, right: &Shot, before: Option<Image>) -> Result<Compared, MetricsError> {
    let (left, right) = (left.image("left")?, right.image("right")?);
    let compared = compare(&left, &right, &CompareOptions::default())?;
    let temporal_error = match before.filter(|before| before.size() == left.size()) {
        Some(before) => temporal_error(&[before, left.clone()])?,
        None => None,
    };
    let (metrics, size, flip) = (compared.metrics, compared.size, compared.flip_errors);
    Ok(Compared { metrics, temporal_error, size, flip, left })
}

impl Shot {
    /// For comparisons; `name` appears in errors.
    pub fn image(&self, name: &str) -> Result<Image, MetricsError> {
        let channel = |value: u8| f32::from(value) / 255.0;
        let pixels = self.pixels.iter().map(|&[r, g, b, _]| [r, g, b].map(channel)).collect();
        Image::from_display(name, self.size.map(|side| side as usize), pixels)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Waits until a comparison of this pair is due, or the one in flight is done and some time has passed.
    fn is_due_in_time(metrics: &mut LiveMetrics, pair: [u64; 2]) -> bool {
        let enough = Instant::now() + 2 * INTERVAL;
        loop {
            if metrics.is_due(pair) {
                return true;
            }
            if metrics.running.is_none() && Instant::now() > enough {
                return false;
            }
            std::thread::sleep(INTERVAL / 10);
        }
    }

    #[test]
    fn a_pair_that_stays_is_compared_once() {
        let shot = Shot { size: [16, 16], pixels: vec![[90, 120, 40, 255]; 256] };
        let mut metrics = LiveMetrics::default();
        assert!(metrics.is_due([3, 1]));
        metrics.compare(shot.clone(), Arc::new(shot), [3, 1]);
        assert!(!is_due_in_time(&mut metrics, [3, 1]));
        assert!(metrics.last.as_ref().is_some_and(|compared| compared.metrics.flip == 0.0));
        assert!(is_due_in_time(&mut metrics, [4, 1]) && is_due_in_time(&mut metrics, [3, 2]));
        metrics.forget();
        assert!(metrics.is_due([3, 1]));
    }
}
