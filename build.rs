//! Makes a constant of each shader's SPIR-V and sets `GLOWWORM_COMMIT`.
//!
//! The SPIR-V is committed in `shaders/spirv`, so that a build needs no C++ compiler. Where the sources differ from those it
//! was compiled from, the build stops.

#[path = "shaders/sources.rs"]
mod sources;

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

fn main() {
    let root = PathBuf::from(std::env::var_os("CARGO_MANIFEST_DIR").expect("set by cargo"));
    let out = PathBuf::from(std::env::var_os("OUT_DIR").expect("set by cargo"));
    let shaders = root.join("shaders");
    println!("cargo::rerun-if-changed={}", shaders.display());
    match spirv_folder(&shaders) {
        Ok(spirv) => write_constants(&shaders, &spirv, &out),
        Err(messages) => messages.iter().for_each(|message| println!("cargo::error={message}")),
    }
    set_commit(&root);
}

/// The folder of the committed SPIR-V, if it was compiled from the sources as they are.
fn spirv_folder(shaders: &Path) -> Result<PathBuf, Vec<String>> {
    let spirv = shaders.join("spirv");
    // A published package has no compiler, and its sources never change.
    if !shaders.join("compiler").exists() {
        return Ok(spirv);
    }
    let compiled = std::fs::read_to_string(spirv.join(sources::MANIFEST)).unwrap_or_default();
    let now = sources::manifest(shaders).expect("the shaders can be read");
    if now == compiled {
        return Ok(spirv);
    }
    let differs = |of: &str, other: &str| of.lines().find(|line| !other.contains(line)).map(str::to_owned);
    let line = differs(&now, &compiled).or_else(|| differs(&compiled, &now)).unwrap_or_default();
    let file = line.split_whitespace().last().unwrap_or("shaders");
    Err(vec![format!("{file} is not what shaders/spirv was compiled from; run scripts/compile-shaders")])
}

/// Writes `shaders.rs`: a constant for each shader, whose name follows from that of its file.
fn write_constants(shaders: &Path, spirv: &Path, out: &Path) {
    let (mut rust, mut embedded) = (String::new(), String::new());
    for shader in sources::shaders(shaders).expect("the shaders can be read") {
        let files: Vec<_> = shader.spirv_files().iter().map(|file| spirv.join(file)).collect();
        for (name, file) in shader.spirv_files().iter().zip(&files) {
            writeln!(embedded, "({name:?}, include_bytes!({file:?})),").expect("writing to a string");
        }
        let value = match files.as_slice() {
            [software, hardware] => format!(
                "PerTracer = PerTracer {{ software: include_bytes!({software:?}), hardware: include_bytes!({hardware:?}) }}"
            ),
            files => format!("&[u8] = include_bytes!({:?})", files[0]),
        };
        let (name, constant) = (&shader.name, shader.name.replace('.', "_").to_uppercase());
        writeln!(rust, "/// `{name}`, compiled.\npub const {constant}: {value};")
            .expect("writing to a string");
    }
    if std::env::var_os("CARGO_FEATURE_SHADER_RELOAD").is_some() {
        rust += "/// All of them by the names of their files.\n";
        writeln!(rust, "pub const FILES: &[(&str, &[u8])] = &[{embedded}];").expect("writing to a string");
    }
    std::fs::write(out.join("shaders.rs"), rust).expect("OUT_DIR is writable");
}

fn set_commit(root: &Path) {
    let git = |arguments: &[&str]| {
        let output = Command::new("git").arg("-C").arg(root).args(arguments).output().ok()?;
        output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim().to_owned())
    };
    if let Some(log) = git(&["rev-parse", "--git-path", "logs/HEAD"]) {
        println!("cargo::rerun-if-changed={}", root.join(log).display());
    }
    let commit = git(&["rev-parse", "--short=12", "HEAD"]).unwrap_or_else(|| "unknown".to_owned());
    println!("cargo::rustc-env=GLOWWORM_COMMIT={commit}");
}
