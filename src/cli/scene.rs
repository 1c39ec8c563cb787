//! The scene of a command and its settings: command line over scene file over defaults.

use std::time::Instant;

use super::options::FileOptions;
use super::{CliError, say};
use crate::formats::load_scene;
use crate::scene::Scene;
use crate::settings::{Settings, text};

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
    #[arg(long, value_name = "WxH", value_parser = text::parse_size, allow_negative_numbers = true)]
    size: Option<[u32; 2]>,
    /// Seconds of animation from one frame to the next, such as 1/60. Otherwise the scene's, or 1/60.
    #[arg(long, value_name = "SECONDS", value_parser = text::parse_seconds, allow_negative_numbers = true)]
    time_step: Option<f64>,
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
    /// The scene and the given settings.
    pub fn given(&self) -> GivenSettings<'_> {
        GivenSettings { scene: &self.name, settings: Settings::default(), names: Vec::new() }
            .with("size", self.size, |settings, size| settings.size = size)
            .with("time_step", self.time_step, |settings, seconds| settings.time_step = seconds)
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

/// A scene and the settings that the command line gives for it.
#[derive(Clone, Debug)]
pub(super) struct GivenSettings<'a> {
    scene: &'a str,
    settings: Settings,
    /// Which of the settings were given.
    names: Vec<&'a str>,
}

impl<'a> GivenSettings<'a> {
    /// All `settings` of a command; `names` are those given.
    pub fn new(scene: &'a str, settings: &Settings, names: &[&'a str]) -> Self {
        Self { scene, settings: settings.clone(), names: names.to_vec() }
    }

    /// Adds a setting, if it has a value.
    pub fn with<T>(
        mut self,
        name: &'static str,
        value: Option<T>,
        set: impl FnOnce(&mut Settings, T),
    ) -> Self {
        if let Some(value) = value {
            set(&mut self.settings, value);
            self.names.push(name);
        }
        self
    }

    /// Fails if a setting is out of range. To be called before any slow work or output.
    pub fn check(&self) -> Result<(), CliError> {
        self.settings.check_options(&self.names).map_err(|error| self.error(error))
    }

    /// Loads the scene, prints its warnings, and resolves the settings.
    pub fn load(&self, files: &FileOptions) -> Result<(Scene, Settings), CliError> {
        self.load_timed(files).map(|(scene, settings, _)| (scene, settings))
    }

    /// [`Self::load`], and the load time, ms.
    pub fn load_timed(&self, files: &FileOptions) -> Result<(Scene, Settings, f64), CliError> {
        let begun = Instant::now();
        let scene = load_scene(self.scene, files.assets_folder().as_deref())?;
        let load_ms = begun.elapsed().as_secs_f64() * 1e3;
        scene.warnings.iter().for_each(|warning| say::warning(warning));
        let settings = Settings::resolve(&scene.settings, &self.settings, &self.names);
        Ok((scene, settings.map_err(|error| self.error(error))?, load_ms))
    }

    fn error(&self, error: crate::settings::SettingsError) -> CliError {
        CliError::Settings { scene: self.scene.to_owned(), error }
    }
}
