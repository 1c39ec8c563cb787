//! What the program says: results on standard output; errors, warnings and notes, a line each, on
//! standard error. A reader that has gone away is no error.

use std::backtrace::{Backtrace, BacktraceStatus};
use std::io::{self, Write};
use std::panic::PanicHookInfo;
use std::sync::atomic::{AtomicBool, Ordering};

use log::{Level, LevelFilter};

use super::CliError;

/// Says in one line why the run failed.
pub fn say_error(error: &CliError) {
    say("error", &error.to_string());
}

/// Says in one line what is odd but could be helped.
pub(super) fn warning(message: &str) {
    say("warning", message);
}

/// Says in one line what a person should know.
pub(super) fn note(message: &str) {
    say("note", message);
}

fn say(kind: &str, message: &str) {
    let line = message.split_whitespace().collect::<Vec<_>>().join(" ");
    // Where standard error is gone there is nobody to tell.
    let _ = writeln!(io::stderr(), "glowworm: {kind}: {line}");
}

/// Writes `text` to standard output.
pub(super) fn print(text: &str) -> Result<(), CliError> {
    let mut output = io::stdout().lock();
    match output.write_all(text.as_bytes()).and_then(|()| output.flush()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => Err(CliError::StandardOutput(error)),
        _ => Ok(()),
    }
}

/// Makes a broken promise inside the program end in one line too. With `RUST_BACKTRACE=1` the
/// backtrace follows.
pub fn install_panic_hook() {
    static SAID: AtomicBool = AtomicBool::new(false);
    std::panic::set_hook(Box::new(|panic| {
        if SAID.swap(true, Ordering::Relaxed) {
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

/// Shows the library's log on standard error: warnings; with `verbose` 1 notes, with 2 details.
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
        writeln!(line, "glowworm: {kind}: {}", record.args())
    });
    // A second call, as from tests, keeps the first log.
    let _ = builder.try_init();
}
