//! Compares what is left of the divider with what is right of it, in the background, a few times a second.

use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

use serde::Serialize;

use crate::metrics::{CompareOptions, Image, MetricsError, compare, temporal_error};
use crate::output::Picture;

/// Time between verdicts.
const INTERVAL: Duration = Duration::from_millis(300);

/// The error of the left picture, of display values.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub(super) struct Verdict {
    /// Mean FLIP error, 0 to 1.
    pub flip: f64,
    pub ssim: f64,
    /// Mean relative error of luminance.
    pub relative_error: f64,
    /// Root of the mean squared error of linear radiance, over the mean of the right picture.
    pub rmse: f64,
    /// Between the last two pictures of the left side; none for the first.
    pub temporal_error: Option<f64>,
}

/// A verdict, with the error of each pixel, 0 to 1, in rows from the top left.
pub(super) struct Judged {
    pub verdict: Verdict,
    pub size: [usize; 2],
    pub flip: Vec<f32>,
    left: Image,
}

/// Judges one pair of pictures at a time.
#[derive(Default)]
pub(super) struct Judge {
    running: Option<Receiver<Result<Judged, MetricsError>>>,
    begun: Option<Instant>,
    judged: Option<Judged>,
    /// Counts verdicts.
    pub version: u64,
    /// That of the last one that was asked for as news.
    told: u64,
}

impl Judge {
    /// The last verdict.
    pub fn judged(&self) -> Option<&Judged> {
        self.judged.as_ref()
    }

    /// The last verdict, if it came since the last call.
    pub fn newest(&mut self) -> Option<Verdict> {
        let told = std::mem::replace(&mut self.told, self.version);
        self.judged.as_ref().filter(|_| told != self.version).map(|judged| judged.verdict)
    }

    /// Forgets the last verdict, and that on its way.
    pub fn forget(&mut self) {
        (self.running, self.judged) = (None, None);
    }

    /// Takes a verdict that is there; whether it is time for another pair.
    pub fn is_waiting(&mut self) -> bool {
        if let Some(running) = &self.running {
            match running.try_recv() {
                Ok(judged) => {
                    self.judged = judged.ok();
                    self.version += 1;
                    self.running = None;
                }
                Err(std::sync::mpsc::TryRecvError::Empty) => return false,
                Err(std::sync::mpsc::TryRecvError::Disconnected) => self.running = None,
            }
        }
        self.begun.is_none_or(|begun| begun.elapsed() >= INTERVAL)
    }

    /// Compares two pictures of one moment.
    pub fn judge(&mut self, left: Picture, right: Picture) {
        let (sender, receiver) = channel();
        let before = self.judged.as_ref().map(|judged| judged.left.clone());
        std::thread::spawn(move || {
            // The receiver is gone where the pair is of no interest any more.
            let _ = sender.send(judge(left, &right, before));
        });
        self.running = Some(receiver);
        self.begun = Some(Instant::now());
    }
}

fn judge(left: Picture, right: &Picture, before: Option<Image>) -> Result<Judged, MetricsError> {
    let size = [left.width, left.height];
    let (left, right, rmse) = (display("left", &left)?, display("right", right)?, rmse(&left, right));
    let compared = compare(&left, &right, &CompareOptions::default())?;
    let same_size = before.filter(|before| before.size() == left.size());
    let temporal_error = match same_size {
        Some(before) => temporal_error(&[before, left.clone()])?,
        None => None,
    };
    let verdict = Verdict {
        flip: compared.metrics.flip,
        ssim: compared.metrics.ssim,
        relative_error: compared.metrics.mean_relative_error,
        rmse,
        temporal_error,
    };
    Ok(Judged { verdict, size, flip: compared.flip_errors, left })
}

fn display(name: &str, picture: &Picture) -> Result<Image, MetricsError> {
    let pixels =
        picture.display.iter().map(|&[r, g, b, _]| [r, g, b].map(|channel| f32::from(channel) / 255.0));
    Image::from_display(name, [picture.width, picture.height], pixels.collect())
}

fn rmse(left: &Picture, right: &Picture) -> f64 {
    let (mut squares, mut sum) = (0.0, 0.0);
    for (a, b) in left.colour.iter().flatten().zip(right.colour.iter().flatten()) {
        squares += f64::from(a - b).powi(2);
        sum += f64::from(*b);
    }
    let count = left.colour.len().max(1) as f64 * 3.0;
    (squares / count).sqrt() / (sum / count).max(f64::MIN_POSITIVE)
}
