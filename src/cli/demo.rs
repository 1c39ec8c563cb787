//! `glowworm [demo]`: the window; without a display, its scene rendered to a file.

use std::env::var_os;
use std::path::{Path, PathBuf};

use super::options::{CameraOptions, RunOptions};
use super::render::{RenderOptions, ViewOptions, render};
use super::scene::AnimationOption;
use super::{CliError, device, say};
use crate::demo::{self, DemoError, Launch};
use crate::settings::GivenSettings;

/// Options of `demo`.
#[derive(Clone, Debug, clap::Args)]
#[command(args_override_self = true)]
pub(super) struct DemoOptions {
    /// A built-in scene, a scene file (.toml) or a model (.obj, .gltf, .glb).
    #[arg(default_value = "playroom")]
    pub scene: String,
    /// Begin with a tour: eleven stops of 10 s, each of which shows one idea. Esc ends it.
    #[arg(long)]
    pub tour: bool,
    /// Write a .png of all stops of the tour, and their captions beside it as .txt, then close.
    #[arg(long, value_name = "FILE", requires = "tour", help_heading = "Files")]
    pub contact_sheet: Option<PathBuf>,
    #[command(flatten)]
    pub settings: GivenSettings,
    #[command(flatten)]
    pub run: RunOptions,
}

/// Shows the scene in a window. Without a display it warns and renders the scene to a file in the current folder.
pub(super) fn demo(options: DemoOptions) -> Result<(), CliError> {
    let report = &options.run.files.report;
    report.check_new(options.contact_sheet.iter().chain(&report.json).cloned())?;
    let launch = Launch {
        scene: options.scene.clone(),
        given: options.settings.clone(),
        assets: options.run.files.assets_folder(),
        json: report.json.clone(),
        device: options.run.device.device.clone(),
        validate: options.run.device.validate,
        cache: cache_folder(),
        tour: options.tour,
        contact_sheet: options.contact_sheet.clone(),
    };
    match demo::run(launch) {
        Ok(messages) => device::check_validation(&messages),
        Err(DemoError::NoDisplay(reason)) => render_instead(options, &reason),
        Err(error) => Err(error.into()),
    }
}

/// `glowworm` in the user's cache folder: `XDG_CACHE_HOME`, or else `.cache` in the home folder; none where there is
/// neither.
fn cache_folder() -> Option<PathBuf> {
    let folder = |variable| var_os(variable).map(PathBuf::from).filter(|folder| folder.is_absolute());
    let caches = folder("XDG_CACHE_HOME").or_else(|| Some(folder("HOME")?.join(".cache")));
    caches.map(|caches| caches.join("glowworm"))
}

fn render_instead(options: DemoOptions, reason: &str) -> Result<(), CliError> {
    let name = Path::new(&options.scene).file_stem().unwrap_or_default().to_string_lossy();
    let out = format!("glowworm-{name}.png");
    say::warning(&format!("no display to open a window on ({reason}); rendering {} to {out}", options.scene));
    let DemoOptions { scene, settings, run, .. } = options;
    let (camera, view) = (CameraOptions::default(), ViewOptions::default());
    let out = out.into();
    render(&RenderOptions {
        scene,
        frames: None,
        time: None,
        out,
        layers: false,
        dataset: None,
        animation: AnimationOption::default(),
        camera,
        view,
        settings,
        run,
    })
}

impl From<DemoError> for CliError {
    fn from(error: DemoError) -> Self {
        match error {
            DemoError::Vulkan(error) => Self::Vulkan(error),
            DemoError::Render(error) => Self::Render(error),
            DemoError::Scene(error) => Self::Scene(error),
            DemoError::Settings { scene, error } => Self::Settings { scene, error },
            DemoError::Output(error) => Self::Output(error),
            other => Self::Window(other.to_string()),
        }
    }
}
