//! From a name or file to a [`Scene`].

use std::path::{Path, PathBuf};

use glam::Affine3A;

use super::error::SceneError;
use super::scene_file::SceneFile;
use super::{Instance, Scene, bare_obj, builtin, obj, scene_build};

/// Loads a built-in scene by name, a scene file (`.toml`) or a bare `.obj`. `assets` is where the
/// downloadable models lie.
///
/// # Errors
/// One line that names the file, the line or key where there is one, and what to do.
pub fn load_scene(name: &str, assets: Option<&Path>) -> Result<Scene, SceneError> {
    match find(name)? {
        Source::File(path, text) => load_toml(&path, &text, assets),
        Source::Model(path) => load_bare_obj(&path),
        Source::CornellBox => Ok(builtin::cornell_box()),
    }
}

/// What a scene is made of.
pub(super) enum Source {
    /// A scene file, with its text.
    File(PathBuf, String),
    /// A model that comes alone.
    Model(PathBuf),
    /// The one that is made by code.
    CornellBox,
}

/// Finds a scene by name or file.
pub(super) fn find(name: &str) -> Result<Source, SceneError> {
    let path = Path::new(name);
    let extension = path.extension().map(|extension| extension.to_string_lossy().to_lowercase());
    match extension.as_deref() {
        Some("toml") if path.is_file() => {
            let read = std::fs::read(path);
            let bytes = read.map_err(|reason| SceneError::Unreadable { file: path.to_owned(), reason })?;
            let text = String::from_utf8(bytes).map_err(|_| {
                SceneError::invalid(path, None, "is not UTF-8 text; save the scene file as UTF-8 TOML")
            })?;
            Ok(Source::File(path.to_owned(), text))
        }
        Some("obj") if path.is_file() => Ok(Source::Model(path.to_owned())),
        _ if name == "cornell-box" => Ok(Source::CornellBox),
        _ => match builtin::scene_file(name) {
            Some(text) => Ok(Source::File(format!("{name}.toml").into(), text.to_owned())),
            None if path.exists() => Err(SceneError::UnknownKind(path.to_owned())),
            None => Err(SceneError::NotFound(path.to_owned())),
        },
    }
}

/// Builds the scene of a scene file's text; paths in it are absolute.
///
/// # Errors
/// Those of a scene file.
pub fn scene_of_text(text: &str, assets: Option<&Path>) -> Result<Scene, SceneError> {
    load_toml(Path::new("recorded scene"), text, assets)
}

pub(super) fn load_toml(path: &Path, text: &str, assets: Option<&Path>) -> Result<Scene, SceneError> {
    let file = SceneFile::parse(path, text)?;
    scene_build::build(path, text, file, assets)
}

fn load_bare_obj(path: &Path) -> Result<Scene, SceneError> {
    let mut scene = Scene::new(&obj::stem(path));
    let mesh = obj::add_obj(path, &mut scene)?;
    let name = scene.name.clone();
    scene.instances.push(Instance::fixed(&name, mesh, Affine3A::IDENTITY));
    scene.add_area_light(0);
    bare_obj::frame(&mut scene);
    bare_obj::light(&mut scene);
    Ok(scene)
}
