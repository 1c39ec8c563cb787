//! Progress bars and interruption.

use std::io::IsTerminal;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressState, ProgressStyle};

use crate::activity;
#[cfg(feature = "bench")]
use crate::bench::Control;
use crate::untrusted::one_line;

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

/// Shows on a terminal what is being prepared while `prepare` runs.
pub(super) fn preparing<T>(prepare: impl FnOnce() -> T) -> T {
    let bar = bar(0, "{spinner} {activity} ({elapsed})");
    let activity = |_: &ProgressState, text: &mut dyn std::fmt::Write| {
        let _ = text.write_str(&one_line(&activity::now()));
    };
    bar.set_style(bar.style().with_key("activity", activity));
    bar.enable_steady_tick(Duration::from_millis(100));
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
