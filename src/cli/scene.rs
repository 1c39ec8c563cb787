//! The scene of a command and its settings: command line over scene file over defaults.

use std::time::Instant;

use super::options::FileOptions;
use super::progress::preparing;
use super::{CliError, say};
use crate::formats::{LoadOptions, load_scene_with};
use crate::scene::{CameraOverride, Scene};
use crate::settings::{GivenSettings, Settings, parser_of};

/// Scene and common settings of the commands that path trace or export.
#[derive(Clone, Debug, clap::Args)]
pub(super) struct SceneOptions {
    /// A built-in scene, a scene file (.toml) or a model (.obj, .gltf, .glb).
    #[arg(value_name = "SCENE")]
    pub name: String,
    /// Bounces of light before the visible surface, 0 to 1,000, or inf. Otherwise the scene's, or 2.
    #[arg(long, value_name = "N|inf", value_parser = parse_bounces, allow_negative_numbers = true)]
    bounces: Option<Bounces>,
    /// Width and height of the picture in pixels. Otherwise the scene's, or 1280x720.
    #[arg(long, value_name = "WxH", value_parser = parser_of("size"), allow_negative_numbers = true)]
    size: Option<String>,
    /// Seconds of animation from one frame to the next, such as 1/60. Otherwise the scene's, or 1/60.
    #[arg(long, value_name = "SECONDS", value_parser = parser_of("time_step"), allow_negative_numbers = true)]
    time_step: Option<String>,
    #[command(flatten)]
    pub animation: AnimationOption,
}

/// Which animation of a model is shown.
#[derive(Clone, Debug, Default, clap::Args)]
pub(super) struct AnimationOption {
    /// The animation of a .gltf or .glb, by name or by index from 0. Otherwise the first.
    #[arg(long, value_name = "NAME|INDEX")]
    pub animation: Option<String>,
}

impl AnimationOption {
    /// Options to load a file that is seen by the scene's camera, but for the parts that `camera` overrides.
    pub fn seen_by(&self, camera: CameraOverride) -> LoadOptions {
        LoadOptions { animation: self.animation.clone(), seen_by: camera }
    }
}

/// `--bounces`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Bounces {
    Limited(u32),
    Unlimited,
}

fn parse_bounces(text: &str) -> Result<Bounces, String> {
    match text {
        "inf" => Ok(Bounces::Unlimited),
        number => match number.parse() {
            Ok(limit @ 0..=1000) => Ok(Bounces::Limited(limit)),
            _ => Err("must be a whole number from 0 to 1000, or inf".to_owned()),
        },
    }
}

impl SceneOptions {
    /// The given settings, with those of `more` that have a value.
    pub fn given(&self, more: &[(&str, &Option<String>)]) -> GivenSettings {
        let mut given = GivenSettings::default();
        let own = [("size", &self.size), ("time_step", &self.time_step)];
        for (key, text) in own.iter().chain(more) {
            if let Some(text) = text {
                given.insert(key, text.as_str());
            }
        }
        given
    }

    /// The bounce limit, if any.
    pub fn bounces(&self, settings: &Settings) -> Option<u32> {
        match self.bounces {
            None => Some(settings.bounces),
            Some(Bounces::Limited(limit)) => Some(limit),
            Some(Bounces::Unlimited) => None,
        }
    }
}

/// A scene with its settings.
pub(super) struct LoadedScene {
    pub scene: Scene,
    pub settings: Settings,
    /// How long loading took.
    pub load_ms: f64,
}

/// Loads the scene `name`, prints its warnings, and resolves its settings with those `given`.
pub(super) fn load(
    name: &str,
    given: &GivenSettings,
    files: &FileOptions,
    options: &LoadOptions,
) -> Result<LoadedScene, CliError> {
    let begun = Instant::now();
    let scene = preparing(|| load_scene_with(name, files.assets_folder().as_deref(), options))?;
    let load_ms = begun.elapsed().as_secs_f64() * 1e3;
    scene.warnings.iter().for_each(|warning| say::warning(warning));
    let settings = Settings::resolve(&scene.settings, given)
        .map_err(|error| CliError::Settings { scene: name.to_owned(), error })?;
    Ok(LoadedScene { scene, settings, load_ms })
}
