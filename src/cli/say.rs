//! Output: results on standard output; errors, warnings and notes, one line each, on standard error. A closed
//! pipe is no error.

use std::backtrace::{Backtrace, BacktraceStatus};
use std::io::{self, Write};
use std::panic::PanicHookInfo;
use std::sync::atomic::{AtomicBool, Ordering};

use log::{Level, LevelFilter};

use super::CliError;
use crate::output::PictureTarget;
use crate::untrusted;

/// Whether notes and progress are left out.
static QUIET: AtomicBool = AtomicBool::new(false);

/// Leaves notes and progress out from now on.
pub(super) fn be_quiet() {
    QUIET.store(true, Ordering::Relaxed);
}

/// Whether notes and progress are left out.
pub(super) fn is_quiet() -> bool {
    QUIET.load(Ordering::Relaxed)
}

/// Prints why the run failed, in one line.
pub fn say_error(error: &CliError) {
    say("error", &error.to_string());
}

/// Prints a warning, in one line.
pub(super) fn warning(message: &str) {
    say("warning", message);
}

/// Advice for a picture that is black.
pub(super) const BLACK: &str = "the picture is black: the camera sees no surface that light reaches; change --eye and --target, or the lights";

/// Prints a note, in one line.
pub(super) fn note(message: &str) {
    if !is_quiet() {
        say("note", message);
    }
}

/// Prints that the program ends at once.
pub(super) fn interrupted() {
    say("error", "interrupted");
}

/// Prints the outcome of a run: as a note if standard output has the picture.
pub(super) fn outcome(target: &PictureTarget, text: &str) -> Result<(), CliError> {
    if target.is_standard_output() {
        note(text);
        return Ok(());
    }
    print(text)
}

fn say(kind: &str, message: &str) {
    // If standard error is closed there is nowhere to report that.
    let _ = writeln!(io::stderr(), "glowworm: {kind}: {}", untrusted::one_line(message));
}

/// Writes `text` to standard output.
pub(super) fn print(text: &str) -> Result<(), CliError> {
    let mut output = io::stdout().lock();
    match output.write_all(untrusted::printable(text).as_bytes()).and_then(|()| output.flush()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => Err(CliError::StandardOutput(error)),
        _ => Ok(()),
    }
}

/// Prints panics in one line too, but for those of decoders, which are errors of their files. With `RUST_BACKTRACE=1` the backtrace follows.
pub fn install_panic_hook() {
    static SAID: AtomicBool = AtomicBool::new(false);
    std::panic::set_hook(Box::new(|panic| {
        if untrusted::is_guarded() || SAID.swap(true, Ordering::Relaxed) {
            return;
        }
        say("error", &describe(panic));
        let backtrace = Backtrace::capture();
        if backtrace.status() == BacktraceStatus::Captured {
            let _ = writeln!(io::stderr(), "{backtrace}");
        }
    }));
}

fn describe(panic: &PanicHookInfo) -> String {
    let place = panic.location().map_or_else(|| "an unknown place".to_owned(), ToString::to_string);
    let payload = panic.payload();
    let text = payload.downcast_ref::<String>().map(String::as_str);
    let what = text.or(payload.downcast_ref().copied()).unwrap_or("no message");
    format!("internal error at {place}: {what} (a bug in glowworm; please report it)")
}

/// Prints the library's log to standard error: warnings; with `verbose` 1 notes, with 2 details.
pub(super) fn start_log(verbose: u8) {
    let level = match verbose {
        0 => LevelFilter::Warn,
        1 => LevelFilter::Info,
        _ => LevelFilter::Debug,
    };
    let mut builder = env_logger::Builder::new();
    builder.filter_level(LevelFilter::Error).filter_module("glowworm", level).parse_default_env();
    builder.format(|line, record| {
        let kind = match record.level() {
            Level::Error => "error",
            Level::Warn => "warning",
            Level::Info => "note",
            Level::Debug | Level::Trace => "detail",
        };
        writeln!(line, "glowworm: {kind}: {}", untrusted::one_line(&record.args().to_string()))
    });
    // A second call, as from tests, fails and keeps the first log.
    let _ = builder.try_init();
}
