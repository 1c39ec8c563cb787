//! Shaders that are compiled again while the program runs, for work on them: feature `shader-reload`.
//!
//! In: the sources in the repository. Out: SPIR-V that pipelines are made of from then on, in place of the program's.

use std::path::Path;
use std::process::Command;
use std::sync::{Mutex, MutexGuard, PoisonError};

use super::shaders;

/// Compiles all shaders of the repository into a folder.
const COMPILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scripts/compile-shaders");

/// Shaders that have changed: SPIR-V of the program, and of the sources. Never freed, since pipelines remember it.
static CHANGED: Mutex<Vec<(&[u8], &[u8])>> = Mutex::new(Vec::new());

fn changed() -> MutexGuard<'static, Vec<(&'static [u8], &'static [u8])>> {
    CHANGED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A shader of the program as it was compiled last.
pub(super) fn newest(built: &'static [u8]) -> &'static [u8] {
    changed().iter().find(|(known, _)| *known == built).map_or(built, |(_, newest)| newest)
}

/// Compiles the shaders of the repository; pipelines that are made from now on are of them.
///
/// # Errors
/// One line: the first error of the compiler. Nothing has changed then.
pub fn compile_shaders() -> Result<(), String> {
    compile_with(Path::new(COMPILE))
}

fn compile_with(command: &Path) -> Result<(), String> {
    let failed = |error: std::io::Error| format!("{}: {error}", command.display());
    let folder = tempfile::tempdir().map_err(failed)?;
    let output = Command::new(command).arg(folder.path()).output().map_err(failed)?;
    if !output.status.success() {
        let said = String::from_utf8_lossy(&output.stderr);
        let line = said.lines().find_map(|line| line.strip_prefix("ERROR: ")).or(said.lines().next());
        return Err(line.unwrap_or("the shaders do not compile").to_owned());
    }
    let mut compiled = Vec::new();
    for &(file, built) in shaders::FILES {
        let bytes = std::fs::read(folder.path().join(file)).map_err(failed)?;
        let last = newest(built);
        compiled.push((built, if bytes == last { last } else { Box::leak(bytes.into_boxed_slice()) }));
    }
    *changed() = compiled;
    Ok(())
}

#[cfg(test)]
#[cfg(unix)]
mod tests {
    use std::os::unix::fs::PermissionsExt;

    use super::*;

    #[test]
    fn what_does_not_compile_changes_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let command = folder.path().join("compile");
        let compile = |script: &str| {
            let copy = concat!("cp ", env!("CARGO_MANIFEST_DIR"), "/shaders/spirv/* \"$1\"");
            std::fs::write(&command, format!("#!/bin/sh\n{copy}\n{script}\n")).unwrap();
            std::fs::set_permissions(&command, PermissionsExt::from_mode(0o755)).unwrap();
            compile_with(&command)
        };
        let built = shaders::TAA_COMP;
        assert_eq!(compile(""), Ok(()));
        assert_eq!(newest(built), built);
        compile("printf 1234 >> \"$1/taa.comp.spv\"").unwrap();
        let changed = newest(built);
        assert!(changed.starts_with(built) && changed.ends_with(b"1234"));
        let refused = compile("echo 'parse error: Log:' >&2; echo 'ERROR: taa.comp:7: no' >&2; exit 1");
        assert_eq!(refused, Err("taa.comp:7: no".to_owned()));
        assert_eq!(newest(built), changed);
    }
}
