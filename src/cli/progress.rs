//! Progress bars and interruption.

use std::io::IsTerminal;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressState, ProgressStyle};

use super::error::INTERRUPTED;
use super::say;
use crate::activity;
#[cfg(feature = "bench")]
use crate::bench::Control;
use crate::output;
use crate::untrusted::one_line;

/// Time between redraws, so that a bar is there before its first step is done.
const TICK: Duration = Duration::from_millis(100);

/// A bar of this length with an indicatif `template`, on a terminal; hidden otherwise, and with --quiet.
pub(super) fn bar(length: u64, template: &str) -> ProgressBar {
    if say::is_quiet() || !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new(length);
    let bar = match ProgressStyle::with_template(template) {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    };
    bar.enable_steady_tick(TICK);
    bar
}

/// Shows on a terminal what is being prepared while `prepare` runs.
pub(super) fn preparing<T>(prepare: impl FnOnce() -> T) -> T {
    let bar = bar(0, "{spinner} {activity} ({elapsed})");
    let activity = |_: &ProgressState, text: &mut dyn std::fmt::Write| {
        let _ = text.write_str(&one_line(&activity::now()));
    };
    bar.set_style(bar.style().with_key("activity", activity));
    let prepared = prepare();
    bar.finish_and_clear();
    prepared
}

/// A bar over frames.
pub(super) fn frames_bar(frames: u64) -> ProgressBar {
    bar(frames, "{bar:40} frame {pos} of {len}, {eta} left")
}

#[cfg(feature = "bench")]
/// Runs a benchmark of total `work` with a progress bar, until it is done or interrupted.
pub(super) fn controlled<T>(work: u64, run: impl FnOnce(&mut Control<'_>) -> T) -> T {
    let stop = interruption();
    let bar = bar(work, "{bar:40} {msg}, {eta} left");
    let mut advance = |task: &str, work: u64| {
        bar.set_message(one_line(task));
        bar.inc(work);
    };
    let done = run(&mut Control::new(&stop, &mut advance));
    bar.finish_and_clear();
    done
}

/// The flag of work that stops by itself; none: an interruption ends the program at once.
static STOP: Mutex<Option<Arc<AtomicBool>>> = Mutex::new(None);

/// A flag set by the first interruption (Ctrl-C) from now on. A second interruption ends the program at once.
pub(super) fn interruption() -> Arc<AtomicBool> {
    let stop = Arc::new(AtomicBool::new(false));
    *STOP.lock().unwrap_or_else(PoisonError::into_inner) = Some(Arc::clone(&stop));
    stop
}

/// Makes interruptions set the flag of [`interruption`], or end the program without leaving temporary files behind.
pub(super) fn watch_interruptions() {
    let on_interrupt = || {
        let stop = STOP.lock().unwrap_or_else(PoisonError::into_inner).clone();
        if stop.is_none_or(|stop| stop.swap(true, Ordering::Relaxed)) {
            say::interrupted();
            output::exit(INTERRUPTED.into());
        }
    };
    // Installing a second handler in one process, as in tests, fails; the first one stays.
    let _ = ctrlc::set_handler(on_interrupt);
}
