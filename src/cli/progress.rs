//! Progress bars and interruption.

use std::io::IsTerminal;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use indicatif::{ProgressBar, ProgressStyle};

#[cfg(feature = "bench")]
use crate::bench::Control;

/// A bar of this length with an indicatif `template`, on a terminal; hidden otherwise.
pub(super) fn bar(length: u64, template: &str) -> ProgressBar {
    if !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new(length);
    match ProgressStyle::with_template(template) {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
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
        bar.set_message(task.to_owned());
        bar.inc(work);
    };
    let done = run(&mut Control::new(&stop, &mut advance));
    bar.finish_and_clear();
    done
}

/// A flag set by the first interruption (Ctrl-C). A second interruption ends the program at once.
pub(super) fn interruption() -> Arc<AtomicBool> {
    let stop = Arc::new(AtomicBool::new(false));
    let seen = Arc::clone(&stop);
    let on_interrupt = move || {
        if seen.swap(true, Ordering::Relaxed) {
            std::process::exit(130);
        }
    };
    // Installing a second handler in one process, as in tests, fails; the first one stays.
    let _ = ctrlc::set_handler(on_interrupt);
    stop
}
