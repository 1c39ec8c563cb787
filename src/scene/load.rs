//! From a name or file to a [`Scene`].

use std::path::{Path, PathBuf};

use super::Scene;

/// Why a scene could not be loaded; each names the file and, where there is one, the line or key.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// Neither a built-in scene nor a file.
    #[error("no such scene: {0}")]
    NotFound(PathBuf),
}

/// Loads a built-in scene by name, a scene file (`.toml`) or a bare `.obj`. `assets` is where the
/// downloadable models lie.
pub fn load_scene(_name: &str, _assets: Option<&Path>) -> Result<Scene, SceneError> {
    todo!()
}
