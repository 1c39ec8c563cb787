//! A benchmark in a thread of its own, beside a program that goes on drawing.
//!
//! The thread lets others use the device a few times a second, between two frames: drivers on the CPU do not bear two threads at
//! once, and what others draw would take time from the frames that are measured.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, MutexGuard, TryLockError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use super::{Bench, BenchError, Control, Report};

/// Time between turns of others, and how long they have to begin.
const INTERVAL: Duration = Duration::from_millis(250);
const TURN: Duration = Duration::from_millis(30);

/// A benchmark in progress, or done. Dropping it ends it.
pub struct BackgroundBench {
    stop: Arc<AtomicBool>,
    turn: Arc<Mutex<()>>,
    messages: Receiver<Message>,
    thread: Option<JoinHandle<()>>,
    begun: Instant,
    /// Work done and planned.
    work: [u64; 2],
    task: String,
}

enum Message {
    Planned(u64),
    Progress(String, u64),
    Done(Box<Result<Report, BenchError>>),
}

impl BackgroundBench {
    /// Starts the benchmark that `make` makes.
    pub fn start(make: impl FnOnce() -> Result<Bench, BenchError> + Send + 'static) -> Self {
        let (sender, messages) = channel();
        let (stop, turn) = (Arc::new(AtomicBool::new(false)), Arc::new(Mutex::new(())));
        let shared = (Arc::clone(&stop), Arc::clone(&turn));
        let thread = std::thread::spawn(move || {
            let measured = make().and_then(|bench| measure(bench, (&shared.0, &shared.1), &sender));
            // The receiver is gone if the benchmark was dropped.
            let _ = sender.send(Message::Done(Box::new(measured)));
        });
        let task = "starting".to_owned();
        Self { stop, turn, messages, thread: Some(thread), begun: Instant::now(), work: [0; 2], task }
    }

    /// Whoever holds it may use the device while the benchmark runs.
    pub fn turn(&self) -> &Arc<Mutex<()>> {
        &self.turn
    }

    /// Whether it goes on.
    pub fn is_running(&self) -> bool {
        self.thread.is_some()
    }

    /// Name of the measurement that runs.
    pub fn task(&self) -> &str {
        &self.task
    }

    /// Takes in what was measured meanwhile; the report, once, when it is done.
    ///
    /// # Errors
    /// The results of [`Bench::run`], once.
    pub fn follow(&mut self) -> Result<Option<Report>, BenchError> {
        while let Ok(message) = self.messages.try_recv() {
            match message {
                Message::Planned(work) => self.work[1] = work,
                Message::Progress(task, work) => {
                    self.task = task;
                    self.work[0] += work;
                }
                Message::Done(measured) => {
                    self.thread = None;
                    return (*measured).map(Some);
                }
            }
        }
        Ok(None)
    }

    /// The share that is done, and the time left.
    pub fn progress(&self) -> (f32, Duration) {
        let [done, planned] = self.work.map(|work| work as f64);
        let share = (done / planned.max(1.0)).min(1.0);
        let left = self.begun.elapsed().as_secs_f64() * (1.0 - share) / share.max(0.01);
        (share as f32, Duration::from_secs_f64(left))
    }
}

impl Drop for BackgroundBench {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

fn measure(
    mut bench: Bench,
    (stop, turn): (&AtomicBool, &Mutex<()>),
    sender: &Sender<Message>,
) -> Result<Report, BenchError> {
    let _ = sender.send(Message::Planned(bench.work_left()));
    let (mut held, mut since) = (take_turn(turn, stop), Instant::now());
    let mut progress = |task: &str, work: u64| {
        let _ = sender.send(Message::Progress(task.to_owned(), work));
        if since.elapsed() >= INTERVAL {
            held = None;
            std::thread::sleep(TURN);
            (held, since) = (take_turn(turn, stop), Instant::now());
        }
    };
    bench.run(&mut Control::new(stop, &mut progress))?;
    Ok(bench.report().clone())
}

/// Waits for the turn of the measurement; none once it is to stop, since others then wait for its end.
fn take_turn<'a>(turn: &'a Mutex<()>, stop: &AtomicBool) -> Option<MutexGuard<'a, ()>> {
    while !stop.load(Ordering::Relaxed) {
        match turn.try_lock() {
            Ok(guard) => return Some(guard),
            Err(TryLockError::Poisoned(poisoned)) => return Some(poisoned.into_inner()),
            Err(TryLockError::WouldBlock) => std::thread::sleep(Duration::from_millis(1)),
        }
    }
    None
}
