//! The sources of `shaders/` and the SPIR-V files that they compile to. Shared by `build.rs`, the compiler and a test.
#![allow(dead_code, reason = "each user needs a part")]

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// The file beside the SPIR-V that holds the [`manifest`] of its sources.
pub const MANIFEST: &str = "sources.sha1";

/// The extensions of shaders; the stage follows from it.
const STAGES: [&str; 3] = ["comp", "frag", "vert"];

/// A file that compiles to SPIR-V.
pub struct Shader {
    /// The source.
    pub path: PathBuf,
    /// The source's file name, such as `taa.comp`.
    pub name: String,
    /// Whether it traces rays: such a shader is compiled for each tracer.
    pub traces_rays: bool,
}

impl Shader {
    /// The names of its SPIR-V files: one, or that of the software and that of the hardware tracer.
    pub fn spirv_files(&self) -> Vec<String> {
        let variants: &[&str] = if self.traces_rays { &["software.spv", "hardware.spv"] } else { &["spv"] };
        variants.iter().map(|variant| format!("{}.{variant}", self.name)).collect()
    }
}

/// All shaders below the folder `shaders`, by path.
///
/// # Errors
/// A file or folder cannot be read.
pub fn shaders(shaders: &Path) -> io::Result<Vec<Shader>> {
    let mut found = Vec::new();
    for path in sources(shaders)?.into_iter().filter(|path| has_extension(path, &STAGES)) {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let traces_rays = fs::read_to_string(&path)?.contains("#include \"tracer.glsl\"");
        found.push(Shader { path, name, traces_rays });
    }
    Ok(found)
}

/// One line for each file that SPIR-V depends on: its SHA-1 and its path, as `sha1sum` prints them. The shell scripts
/// compute the same.
///
/// # Errors
/// A file or folder cannot be read.
pub fn manifest(shaders: &Path) -> io::Result<String> {
    let mut lines = String::new();
    let compiler = shaders.join("compiler/lib.rs");
    let mut files = sources(shaders)?;
    files.push(compiler);
    files.sort_by_key(|file| slashed(shaders, file));
    for file in files {
        let hash = sha1_smol::Sha1::from(fs::read(&file)?).digest().to_string();
        lines += &format!("{hash}  {}\n", slashed(shaders, &file));
    }
    Ok(lines)
}

/// The path from the root of the repository, with slashes.
fn slashed(shaders: &Path, file: &Path) -> String {
    let inside = file.strip_prefix(shaders).unwrap_or(file);
    let parts = inside.components().map(|part| part.as_os_str().to_string_lossy());
    parts.fold("shaders".to_owned(), |path, part| path + "/" + &part)
}

/// All GLSL files below a folder, by path.
fn sources(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_dir() {
            found.extend(sources(&path)?);
        } else if has_extension(&path, &STAGES) || has_extension(&path, &["glsl"]) {
            found.push(path);
        }
    }
    found.sort();
    Ok(found)
}

fn has_extension(path: &Path, extensions: &[&str]) -> bool {
    path.extension().is_some_and(|extension| extensions.iter().any(|one| extension == *one))
}
