//! `glowworm export`: a scene at one frame for another renderer.

use std::path::{Path, PathBuf};

use super::options::{CameraOptions, FileOptions, count, folder};
use super::scene::{LoadedScene, SceneOptions, load};
use super::{CliError, say};
use crate::export::{ExportFolder, ExportReport, ExportSettings, SCENE_FILE, export_mitsuba};
use crate::scene::Scene;
use crate::settings::Settings;

/// Target renderer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum Format {
    /// Mitsuba 3: scene.xml, meshes as PLY, textures as PNG.
    Mitsuba,
}

/// Options of `export`.
#[derive(Clone, Debug, clap::Args)]
#[command(args_override_self = true)]
pub(super) struct ExportOptions {
    #[command(flatten)]
    pub scene: SceneOptions,
    /// Renderer to export for.
    #[arg(long, value_enum, default_value = "mitsuba")]
    pub format: Format,
    /// Frame of the scene's animation, from 0.
    #[arg(long, value_name = "K", value_parser = count::<u64>(0..=1_000_000_000), default_value = "0")]
    pub frame: u64,
    /// Samples per pixel, overridden by `mitsuba -D spp=N`.
    #[arg(long, value_name = "N", value_parser = count::<u32>(1..=1_000_000_000), default_value = "256")]
    pub spp: u32,
    #[command(flatten)]
    pub camera: CameraOptions,
    /// Folder to write to: new, empty, or an earlier export, which is replaced.
    #[arg(short, long, value_name = "DIR", value_parser = folder(), help_heading = "Files")]
    pub out: PathBuf,
    #[command(flatten)]
    pub files: FileOptions,
}

/// Exports the scene.
pub(super) fn export(options: &ExportOptions) -> Result<(), CliError> {
    let Format::Mitsuba = options.format;
    options.camera.check()?;
    let folder = ExportFolder::new(&options.out)?;
    let json = options.files.report.check([folder.path().join(SCENE_FILE)])?;
    if let Some(json) = &json
        && (folder.may_write(json) || json.is_same(Path::new(&options.scene.name)))
    {
        let path = json.path().display();
        return Err(CliError::Usage(format!(
            "--json {path}: would overwrite the export or the scene; give it another name"
        )));
    }
    let given = options.scene.given(&[]);
    let LoadedScene { mut scene, settings, .. } = load(
        &options.scene.name,
        &given,
        &options.files,
        &options.scene.animation.seen_by(options.camera.parts()),
    )?;
    options.camera.place(&mut scene)?;
    let report = options.run(&scene, &settings, &folder)?;
    if let Some(json) = json {
        json.save_json(&report)?;
    }
    say::print(&headline(&folder.path().join(SCENE_FILE), &report))
}

impl ExportOptions {
    fn run(
        &self,
        scene: &Scene,
        settings: &Settings,
        folder: &ExportFolder,
    ) -> Result<ExportReport, CliError> {
        let settings = ExportSettings {
            frame: self.frame,
            time: self.frame as f64 * settings.time_step,
            size: settings.size,
            bounces: self.scene.bounces(settings),
            spp: self.spp,
        };
        Ok(export_mitsuba(scene, &settings, folder)?)
    }
}

/// Summary of the export, with what is not exact.
fn headline(scene: &Path, report: &ExportReport) -> String {
    let mut text = format!(
        "{}: {} shapes, {} triangles, {} materials, {} textures, {} lights; render it with mitsuba {0}\n",
        scene.display(),
        report.shapes,
        report.triangles,
        report.materials,
        report.textures,
        report.lights.total(),
    );
    for difference in &report.inexact {
        text += &format!("not exact: {difference}\n");
    }
    text
}
