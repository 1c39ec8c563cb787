//! Options that subcommands share, apart from the settings.

use std::ops::RangeInclusive;
use std::path::PathBuf;

use clap::builder::{PathBufValueParser, TypedValueParser};
use glam::Vec3;

use super::CliError;
use crate::output::OutputFile;
use crate::scene::{CameraOverride, MAX_COORDINATE, Scene};
use crate::settings::read_whole;

/// Parser of a whole number in a range, such as 1000 or 1e3.
pub(super) fn count<Number: TryFrom<u64>>(
    range: RangeInclusive<u64>,
) -> impl Fn(&str) -> Result<Number, String> + Clone {
    move |text| {
        let number = read_whole(text).filter(|number| range.contains(number));
        let wrong = || format!("must be a whole number, {} to {}", range.start(), range.end());
        number.and_then(|number| Number::try_from(number).ok()).ok_or_else(wrong)
    }
}

/// Parser of the name of a folder to write.
pub(super) fn folder() -> impl TypedValueParser<Value = PathBuf> {
    PathBufValueParser::new().try_map(|folder| match folder.as_os_str() == "-" {
        true => Err("must be a folder; only a single picture goes to standard output"),
        false => Ok(folder),
    })
}

/// Overrides of the scene's camera.
#[derive(Clone, Copy, Debug, Default, clap::Args)]
#[command(next_help_heading = "Camera")]
pub(super) struct CameraOptions {
    /// Eye point, in scene units. Otherwise the scene's. With --eye or --target the camera does not move, and
    /// its near and far planes do not count.
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_point, allow_hyphen_values = true)]
    eye: Option<Vec3>,
    /// The point at the centre of the picture, in scene units. Otherwise the scene's. Looking straight up or down, -z is up in the
    /// picture.
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_point, allow_hyphen_values = true)]
    target: Option<Vec3>,
    /// Vertical field of view in degrees, 0.01 to 170. Otherwise the scene's.
    #[arg(long, value_name = "DEG", value_parser = parse_vfov, allow_negative_numbers = true)]
    vfov: Option<f32>,
}

impl CameraOptions {
    /// The given parts.
    pub fn parts(&self) -> CameraOverride {
        let vertical_fov = self.vfov.map(f32::to_radians);
        CameraOverride { eye: self.eye, target: self.target, vertical_fov }
    }

    /// Fails if they are invalid for any scene. To be called before any slow work or output.
    pub fn check(&self) -> Result<(), CliError> {
        match (self.eye, self.target) {
            (Some(eye), Some(target)) if eye == target => Err(unusable("eye and target must differ")),
            _ => Ok(()),
        }
    }

    /// Applies the overrides to the scene's camera.
    pub fn place(&self, scene: &mut Scene) -> Result<(), CliError> {
        scene.override_camera(&self.parts()).map_err(unusable)
    }
}

fn unusable(problem: &str) -> CliError {
    CliError::Usage(format!("--eye, --target: {problem}"))
}

fn parse_point(text: &str) -> Result<Vec3, String> {
    let numbers: Result<Vec<f32>, _> = text.split(',').map(|number| number.trim().parse()).collect();
    let point = numbers.ok().and_then(|numbers| <[f32; 3]>::try_from(numbers).ok()).map(Vec3::from_array);
    point
        .filter(|point| point.abs().cmple(Vec3::splat(MAX_COORDINATE)).all())
        .ok_or_else(|| format!("must be three numbers such as 1,2.5,-3, each within +-{MAX_COORDINATE:e}"))
}

fn parse_vfov(text: &str) -> Result<f32, String> {
    let degrees = text.parse().ok().filter(|degrees| (0.01..=170.0).contains(degrees));
    degrees.ok_or_else(|| "must be degrees from 0.01 to 170".to_owned())
}

/// Device options.
#[derive(Clone, Debug, Default, clap::Args)]
#[command(next_help_heading = "Device")]
pub(super) struct DeviceOptions {
    /// Vulkan device: its index in `glowworm info` or a part of its name. Otherwise the best one.
    #[arg(long, value_name = "NAME|INDEX")]
    pub device: Option<String>,
    /// Enable the Vulkan validation layer; slow, and any message fails the run.
    #[arg(long)]
    pub validate: bool,
}

/// Options of commands that render on a device.
#[derive(Clone, Debug, Default, clap::Args)]
pub(super) struct RunOptions {
    #[command(flatten)]
    pub device: DeviceOptions,
    #[command(flatten)]
    pub files: FileOptions,
}

/// Files of commands that read a scene.
#[derive(Clone, Debug, Default, clap::Args)]
pub(super) struct FileOptions {
    /// Folder with the downloaded models of scenes whose models are not shipped. Otherwise the
    /// environment variable `GLOWWORM_ASSETS`.
    #[arg(long, value_name = "DIR", help_heading = "Files")]
    assets: Option<PathBuf>,
    #[command(flatten)]
    pub report: ReportOptions,
}

/// The report of a run, and whether its files may replace others.
#[derive(Clone, Debug, Default, clap::Args)]
pub(super) struct ReportOptions {
    /// Write what was measured or listed to FILE, as JSON.
    #[arg(long, value_name = "FILE", help_heading = "Files")]
    pub json: Option<PathBuf>,
    /// Fail before the work begins if a file to be written is there already.
    #[arg(long, help_heading = "Files")]
    no_overwrite: bool,
}

impl ReportOptions {
    /// The file of --json, checked. Fails with --no-overwrite if it or another one of the `outputs` is there.
    pub fn check(&self, outputs: impl IntoIterator<Item = PathBuf>) -> Result<Option<OutputFile>, CliError> {
        self.check_new(outputs.into_iter().chain(self.json.clone()))?;
        Ok(self.json.as_ref().map(OutputFile::new).transpose()?)
    }

    /// Fails with --no-overwrite if one of the `outputs` is there.
    pub fn check_new(&self, outputs: impl IntoIterator<Item = PathBuf>) -> Result<(), CliError> {
        let is_there = |path: &PathBuf| self.no_overwrite && path.symlink_metadata().is_ok();
        outputs.into_iter().find(is_there).map_or(Ok(()), |path| Err(CliError::Exists(path)))
    }
}

impl FileOptions {
    /// `--assets`, or else `GLOWWORM_ASSETS`, or none.
    pub fn assets_folder(&self) -> Option<PathBuf> {
        let from_environment =
            || std::env::var_os("GLOWWORM_ASSETS").filter(|folder| !folder.is_empty()).map(PathBuf::from);
        self.assets.clone().or_else(from_environment)
    }
}
