//! Errors of loading a scene: one line each, with file, line and what to do.

use std::fmt;
use std::path::{Path, PathBuf};

use crate::builtin;
use crate::untrusted::{nearest, one_line};

/// A file and, if known, a line. Displays as `file` or `file:line`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// The file at fault.
    pub file: PathBuf,
    /// Line number, from 1.
    pub line: Option<usize>,
}

impl Place {
    /// A place in `file`.
    pub fn new(file: &Path, line: Option<usize>) -> Self {
        Self { file: file.to_owned(), line }
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.line {
            Some(line) => write!(f, "{}:{line}", self.file.display()),
            None => write!(f, "{}", self.file.display()),
        }
    }
}

/// Why a scene could not be loaded; each names the file and, if known, the line or key.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// Neither a built-in scene nor a file.
    #[error("no such scene: {}{}; give a .toml, .obj, .gltf or .glb file, or a built-in scene: {}", .0.display(), did_you_mean(.0), builtin::NAMES.join(", "))]
    NotFound(PathBuf),
    /// A file of an unsupported type.
    #[error("{}: not a scene; give a .toml scene file, an .obj, .gltf or .glb model or one of: {}", .0.display(), builtin::NAMES.join(", "))]
    UnknownKind(PathBuf),
    /// An existing file could not be read.
    #[error("cannot read {}: {reason}; check that the file exists and may be read", file.display())]
    Unreadable {
        /// The file.
        file: PathBuf,
        /// The system's error.
        reason: std::io::Error,
    },
    /// A model or map that is not shipped was not found.
    #[error("scene \"{}\" needs the file {}, which {found}; set --assets or GLOWWORM_ASSETS to the folder that holds it; download: {}", one_line(scene), one_line(&asset.to_string_lossy()), one_line(source_url))]
    MissingAsset {
        /// The scene that uses it.
        scene: String,
        /// Path below the assets folder.
        asset: PathBuf,
        /// Where it was searched for.
        found: String,
        /// Download address.
        source_url: String,
    },
    /// The content of a file is wrong.
    #[error("{place}: {problem}")]
    Invalid {
        /// File and line.
        place: Place,
        /// What is wrong and what to do.
        problem: String,
    },
}

/// The built-in scene whose name is like this one, for an error.
fn did_you_mean(name: &Path) -> String {
    let like = nearest(&name.to_string_lossy(), builtin::NAMES);
    like.map_or_else(String::new, |like| format!(" (did you mean {like}?)"))
}

impl SceneError {
    /// Invalid content at `line` of `file`; joins the lines of `problem`.
    pub(crate) fn invalid(file: &Path, line: Option<usize>, problem: impl Into<String>) -> Self {
        Self::Invalid { place: Place::new(file, line), problem: one_line(&problem.into()) }
    }
}
