//! The program `glowworm`: arguments in, one call of the library, an exit code out.

use std::process::ExitCode;

use glowworm::cli;

fn main() -> ExitCode {
    cli::install_panic_hook();
    match std::panic::catch_unwind(|| cli::run(std::env::args_os())) {
        Ok(Ok(())) => ExitCode::SUCCESS,
        Ok(Err(error)) => {
            cli::say_error(&error);
            ExitCode::from(error.exit_code())
        }
        // The hook has said what happened.
        Err(_) => ExitCode::FAILURE,
    }
}
