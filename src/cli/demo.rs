//! `glowworm [demo]`: without a window, renders its scene to a file instead.

use std::path::Path;

use super::options::RunOptions;
use super::render::{RenderOptions, ViewOptions, render};
use super::{CliError, say};
use crate::settings::Settings;

/// Options of `demo`.
#[derive(Clone, Debug, clap::Args)]
#[command(args_override_self = true)]
pub(super) struct DemoOptions {
    /// A built-in scene, a scene file (.toml) or a model (.obj).
    #[arg(default_value = "cornell-box")]
    pub scene: String,
    #[command(flatten)]
    pub settings: Settings,
    #[command(flatten)]
    pub run: RunOptions,
}

/// Renders the scene to a file in the current folder and says so. `given` are the settings given on
/// the command line.
pub(super) fn demo(options: DemoOptions, given: &[&str]) -> Result<(), CliError> {
    let name = Path::new(&options.scene).file_stem().unwrap_or_default().to_string_lossy();
    let out = format!("glowworm-{name}.png");
    say::warning(&format!("there is no window yet; rendering {} to {out} instead", options.scene));
    let DemoOptions { scene, settings, run } = options;
    let view = ViewOptions::default();
    render(&RenderOptions { scene, frames: None, out: out.into(), layers: false, view, settings, run }, given)
}
