//! Writes the SPIR-V of all shaders to `shaders/spirv`, or to the folder that is given. See `scripts/compile-shaders`.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

fn main() -> ExitCode {
    let shaders = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/.."));
    let out = std::env::args_os().nth(1).map_or_else(|| shaders.join("spirv"), PathBuf::from);
    match shader_compiler::compile_all(shaders, &out) {
        Ok(()) => ExitCode::SUCCESS,
        Err(messages) => {
            messages.iter().for_each(|message| eprintln!("{message}"));
            ExitCode::FAILURE
        }
    }
}
