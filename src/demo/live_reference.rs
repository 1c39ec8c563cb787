//! The path tracer's picture of a stationary scene, which gets better in the background.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use super::live_metrics::Shot;
use super::loader::in_own_pool;
use super::session::Session;
use crate::output::tone_map;
use crate::reference::{Reference, ReferenceSettings};
use crate::scene::{Pose, Scene};
use crate::settings::Settings;

/// Samples a pixel after which it is good enough.
pub(super) const ENOUGH: u64 = 4096;
/// Time between pictures.
const INTERVAL: Duration = Duration::from_millis(250);

/// A picture as far as it is.
pub(super) struct Progress {
    pub shot: Arc<Shot>,
    /// Samples a pixel.
    pub samples: u64,
    /// Standard error over the mean luminance.
    pub error: Option<f64>,
    /// Time since the first sample.
    pub elapsed: Duration,
}

/// The path tracer of the world as it stood in the last frame.
#[derive(Default)]
pub(super) struct LiveReference {
    /// The world of the last frame.
    last: Option<Key>,
    run: Option<Run>,
    /// The picture so far; none before the first sample.
    pub progress: Option<Progress>,
    /// Counts pictures.
    pub version: u64,
}

/// The picture depends on these.
#[derive(Clone)]
struct Key {
    scene: Arc<Scene>,
    pose: Pose,
    settings: Settings,
}

struct Run {
    stop: Arc<AtomicBool>,
    progress: Receiver<Progress>,
    thread: Option<JoinHandle<()>>,
}

impl LiveReference {
    /// Starts again where anything has changed; the path tracer waits until nothing does.
    pub fn follow(&mut self, session: &Session) {
        let same = self.last.as_ref().is_some_and(|last| last.is_of(session));
        if !same {
            (self.run, self.progress) = (None, None);
            self.last = Some(Key {
                scene: Arc::clone(session.renderer.scene()),
                pose: session.pose.clone(),
                settings: session.settings.clone(),
            });
        } else if let (None, Some(key)) = (&self.run, &self.last) {
            self.run = Some(Run::start(key.clone()));
        }
        if let Some(newest) = self.run.as_ref().and_then(|run| run.progress.try_iter().last()) {
            self.progress = Some(newest);
            self.version += 1;
        }
    }
}

impl Progress {
    /// Estimates the time until it is good enough.
    pub fn left(&self) -> Duration {
        let still = ENOUGH.saturating_sub(self.samples) as f64 / self.samples.max(1) as f64;
        self.elapsed.mul_f64(still)
    }
}

impl Key {
    fn is_of(&self, session: &Session) -> bool {
        Arc::ptr_eq(&self.scene, session.renderer.scene())
            && self.pose == session.pose
            && self.settings == session.settings
    }
}

impl Run {
    fn start(key: Key) -> Self {
        let (sender, progress) = channel();
        let stop = Arc::new(AtomicBool::new(false));
        let stopped = Arc::clone(&stop);
        let thread = std::thread::spawn(move || {
            in_own_pool("path tracer", || trace(&key, &stopped, &sender));
        });
        Self { stop, progress, thread: Some(thread) }
    }
}

impl Drop for Run {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

fn trace(key: &Key, stop: &AtomicBool, sender: &Sender<Progress>) {
    let settings = ReferenceSettings::like(&key.settings);
    let reference = Reference::new(&key.scene, &key.pose, &settings);
    let Ok(mut film) = reference.film() else { return };
    let begun = Instant::now();
    let mut sent: Option<Instant> = None;
    while film.samples() < ENOUGH && reference.add_sample(&mut film, stop) {
        if film.samples() < ENOUGH && sent.is_some_and(|sent| sent.elapsed() < INTERVAL) {
            continue;
        }
        let mut picture = film.picture();
        tone_map(&mut picture, (&key.settings).into(), film.metered());
        let error = film.standard_error().map(|error| error / film.mean_luminance());
        let shot = Arc::new(Shot { size: key.settings.size, pixels: picture.display });
        let progress = Progress { shot, samples: film.samples(), error, elapsed: begun.elapsed() };
        if sender.send(progress).is_err() {
            return;
        }
        sent = Some(Instant::now());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metrics::{CompareOptions, compare};

    /// Root mean square error of display values.
    fn rmse(ours: &Shot, reference: &Shot) -> f64 {
        let image = |shot: &Shot| shot.image("shot").unwrap();
        compare(&image(ours), &image(reference), &CompareOptions::default()).unwrap().metrics.rmse
    }

    #[test]
    fn the_picture_nears_the_reference_as_samples_grow() {
        let scene = Arc::new(crate::formats::load_scene("cornell-box", None).unwrap());
        let pose = scene.pose(0.0);
        let settings = Settings { size: [16, 12], seed: 5, exposure: Some(0.0), ..Settings::default() };
        let run =
            Run::start(Key { scene: Arc::clone(&scene), pose: pose.clone(), settings: settings.clone() });
        let other = ReferenceSettings { seed: 77, ..ReferenceSettings::like(&settings) };
        let reference = Reference::new(&scene, &pose, &other);
        let mut film = reference.film().unwrap();
        while film.samples() < 4 * ENOUGH {
            assert!(reference.add_sample(&mut film, &AtomicBool::new(false)));
        }
        let mut picture = film.picture();
        tone_map(&mut picture, (&settings).into(), film.metered());
        let reference = Shot { size: settings.size, pixels: picture.display };
        let progress: Vec<Progress> = run.progress.iter().collect();
        let (first, last) = (&progress[0], progress.last().unwrap());
        assert_eq!(last.samples, ENOUGH);
        // The noise of the reference counts, too.
        let expected = (last.samples as f64).recip() + (4.0 * ENOUGH as f64).recip();
        let ratio = rmse(&last.shot, &reference) / rmse(&first.shot, &reference);
        let wanted = (expected * first.samples as f64).sqrt();
        // Random samples would fall as this; those of a low-discrepancy sequence fall faster.
        assert!(ratio < 1.5 * wanted, "{ratio}, not {wanted}");
        assert_eq!(last.left(), Duration::ZERO);
    }
}
