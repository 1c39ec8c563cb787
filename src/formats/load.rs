//! Loads a [`Scene`] by name or file.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::time::Instant;

use glam::Affine3A;

use super::error::SceneError;
use super::scene_file::schema::SceneFile;
use super::scene_file::{ReadFiles, load_toml};
use super::{default_view, gltf, obj};
use crate::activity;
use crate::builtin;
use crate::scene::{CameraOverride, Instance, Scene};
use crate::untrusted;

/// Loads a built-in scene by name, a scene file (`.toml`) or a bare model (`.obj`, `.gltf`, `.glb`). `assets` is the
/// folder of the downloadable models.
///
/// # Errors
/// One line that names the file, the line or key if known, and what to do.
pub fn load_scene(name: &str, assets: Option<&Path>) -> Result<Scene, SceneError> {
    load_scene_with(name, assets, &LoadOptions::default())
}

/// What is asked of a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LoadOptions {
    /// Name or index of the animation of a glTF file, otherwise the first one.
    pub animation: Option<String>,
    /// The camera that is going to be overridden: a bare model is lit for what that sees.
    pub seen_by: CameraOverride,
}

/// The same as [`load_scene`], as `options` ask.
///
/// # Errors
/// Likewise; the file has no such animation.
pub fn load_scene_with(
    name: &str,
    assets: Option<&Path>,
    options: &LoadOptions,
) -> Result<Scene, SceneError> {
    load_with(name, assets, options, &mut ReadFiles::default())
}

/// The same; `read` receives what was read for a scene file.
pub(crate) fn load_with(
    name: &str,
    assets: Option<&Path>,
    options: &LoadOptions,
    read: &mut ReadFiles,
) -> Result<Scene, SceneError> {
    let begun = Instant::now();
    activity::begin(format!("reading {name}"));
    let mut scene = match find(name)? {
        Source::Model(path) if gltf::is_gltf(&path) => {
            gltf::load(&path, options.animation.as_deref(), &options.seen_by)?
        }
        _ if options.animation.is_some() => {
            let problem = "only glTF files have animations to choose from; leave --animation out";
            return Err(SceneError::invalid(Path::new(name), None, problem));
        }
        Source::File(path, text) => load_toml(&path, &text, assets, read)?,
        Source::Model(path) => load_bare_obj(&path, &options.seen_by)?,
        Source::CornellBox => builtin::cornell_box(),
    };
    scene.warnings.iter_mut().for_each(|warning| *warning = untrusted::one_line(warning));
    let (meshes, textures) = (scene.meshes.len(), scene.textures.len());
    let load_ms = begun.elapsed().as_secs_f64() * 1e3;
    log::info!("{}: loaded {meshes} meshes and {textures} textures in {load_ms:.0} ms", scene.name);
    Ok(scene)
}

/// Source of a scene.
pub(crate) enum Source {
    /// A scene file, with its text.
    File(PathBuf, String),
    /// A bare model.
    Model(PathBuf),
    /// The procedural Cornell box.
    CornellBox,
}

/// Finds a scene by name or file.
pub(crate) fn find(name: &str) -> Result<Source, SceneError> {
    let path = Path::new(name);
    let extension = path.extension().map(|extension| extension.to_string_lossy().to_lowercase());
    match extension.as_deref() {
        Some("toml") if path.is_file() => {
            let read = std::fs::read(path);
            let bytes = read.map_err(|reason| SceneError::Unreadable { file: path.to_owned(), reason })?;
            let text = untrusted::unicode_of(&bytes).ok_or_else(|| {
                SceneError::invalid(path, None, "is not UTF-8 text; save the scene file as UTF-8 TOML")
            })?;
            match untrusted::wrong_format(&bytes) {
                Some(why) if !bytes.is_empty() => Err(SceneError::invalid(path, None, why)),
                _ => Ok(Source::File(path.to_owned(), text.into_owned())),
            }
        }
        Some("obj" | "gltf" | "glb") if path.is_file() => Ok(Source::Model(path.to_owned())),
        _ if name == "cornell-box" => Ok(Source::CornellBox),
        _ => match builtin::scene_file(name) {
            Some(text) => Ok(Source::File(format!("{name}.toml").into(), text.to_owned())),
            None => Err(match path.metadata() {
                Ok(_) => SceneError::UnknownKind(path.to_owned()),
                Err(reason) if reason.kind() == ErrorKind::PermissionDenied => {
                    SceneError::Unreadable { file: path.to_owned(), reason }
                }
                Err(_) => SceneError::NotFound(path.to_owned()),
            }),
        },
    }
}

/// The first file of a built-in scene that is not in the folder `assets` of the downloadable models; none if all are there, or
/// the scene needs none.
pub fn missing_asset(name: &str, assets: Option<&Path>) -> Option<PathBuf> {
    let file = SceneFile::parse(Path::new(name), builtin::scene_file(name)?).ok()?;
    let maps = file.environment.iter().filter_map(|environment| environment.asset.as_ref());
    let models = file.models.iter().filter_map(|model| model.asset.as_ref());
    let is_there = |asset: &Path| assets.is_some_and(|folder| folder.join(asset).is_file());
    models.chain(maps).find(|asset| !is_there(asset)).cloned()
}

/// Builds a scene from the text of a scene file, whose paths must be absolute.
///
/// # Errors
/// Those of a scene file.
pub fn scene_of_text(text: &str, assets: Option<&Path>) -> Result<Scene, SceneError> {
    ReadFiles::default().scene_of_text(text, assets)
}

fn load_bare_obj(path: &Path, seen_by: &CameraOverride) -> Result<Scene, SceneError> {
    let mut scene = Scene::new(&obj::stem(path));
    let mesh = obj::add_obj(path, &mut scene)?;
    scene.anchor_meshes();
    let name = scene.name.clone();
    scene.instances.push(Instance::fixed(&name, mesh, Affine3A::IDENTITY));
    scene.add_area_light(0);
    default_view::add_default_camera_and_light(&mut scene, None, seen_by)
        .map_err(|why| SceneError::invalid(path, None, why))?;
    Ok(scene)
}
