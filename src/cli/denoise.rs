//! `glowworm denoise`: runs a denoiser over a data set.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::Serialize;

use super::options::{DeviceOptions, ReportOptions};
use super::progress::frames_bar;
use super::{CliError, device, say};
use crate::dataset::{DatasetDenoiser, DatasetError, DatasetFrames, DenoisedFrame, Layout};
use crate::metrics::{CompareOptions, Image, Sequence, SequenceMetrics};
use crate::output::{OutputError, OutputFile, Picture, PictureTarget};
use crate::report::COMMIT;
use crate::settings::{GivenDenoising, Settings};
use crate::statistics::percentile;

/// Help after the options.
const HELP: &str = "\
It runs the passes of the renderer: reprojection, the denoiser of indirect light, and what joins the light. Of a data set of \
render --dataset the pictures are those of the run that wrote it, bit for bit, given the same settings. Of dataset, indirect \
light is denoised, and direct and reflected light are added as they are. Of the layout of BMFR (Koskela et al. 2019), all light \
is denoised; motion is that of the camera alone.
With a reference{f}.exr of each frame the pictures are compared with it, by the metrics of compare.";

/// Options of `denoise`.
#[derive(Clone, Debug, clap::Args)]
#[command(args_override_self = true, after_help = HELP)]
pub(super) struct DenoiseOptions {
    /// The folder of the data set.
    #[arg(value_name = "DIR")]
    pub folder: PathBuf,
    /// Which of its files to read. Otherwise the first of these whose files are there.
    #[arg(long, value_name = "NAME", value_enum)]
    pub layout: Option<Layout>,
    /// Pictures to write, .exr (linear, 32 bits) or .png (tone-mapped, 8 bits): every frame if the name has a {frame} or {frame:04},
    /// else the last; or a folder for denoised{frame}.exr; -: a PNG to standard output.
    #[arg(short, long, value_name = "FILE|DIR", help_heading = "Files")]
    pub out: PathBuf,
    #[command(flatten)]
    pub report: ReportOptions,
    #[command(flatten)]
    pub device: DeviceOptions,
    #[command(flatten)]
    pub settings: GivenDenoising,
}

/// Report of a run, for `--json`.
#[derive(Debug, Serialize)]
struct DenoiseReport {
    dataset: String,
    layout: Layout,
    size: [u32; 2],
    /// How many.
    frames: u32,
    device: String,
    driver: String,
    /// Settings that are not at their defaults.
    settings: toml::Table,
    commit: &'static str,
    /// Median over the frames of the milliseconds of each pass on the device.
    passes: BTreeMap<&'static str, f64>,
    /// Against the references, if there are any.
    #[serde(skip_serializing_if = "Option::is_none")]
    metrics: Option<SequenceMetrics>,
}

/// Denoises the data set.
pub(super) fn denoise(options: &DenoiseOptions) -> Result<(), CliError> {
    let settings = Settings::resolve(&toml::Table::new(), &options.settings.0)
        .map_err(|error| CliError::Settings { scene: options.folder.display().to_string(), error })?;
    let dataset = DatasetFrames::open(&options.folder, options.layout)?;
    let target = target(&options.out)?;
    let json = options.report.check(target.pictures(dataset.frames().into()))?;
    check_apart(options, &target, json.as_ref(), dataset.frames())?;
    let device = device::open(&options.device)?;
    let mut denoiser = None;
    let mut sequence = Sequence::new(CompareOptions { luminance: true, ..CompareOptions::default() }, false);
    let mut passes: BTreeMap<&'static str, Vec<f64>> = BTreeMap::new();
    let progress = frames_bar(dataset.frames().into());
    for frame in 0..dataset.frames() {
        let given = dataset.frame(frame)?;
        let denoiser = match &mut denoiser {
            None => denoiser.insert(DatasetDenoiser::new(&device, &settings, &given)?),
            Some(denoiser) => denoiser,
        };
        if let Some(misfit) = denoiser.misfit(&given) {
            let reason = format!("frame {frame} {misfit}; write the data set anew");
            return Err(DatasetError::Folder { path: options.folder.clone(), reason }.into());
        }
        let DenoisedFrame { picture, passes: times } = denoiser.denoise(&given)?;
        for (name, ms) in summed(times) {
            passes.entry(name).or_default().push(ms);
        }
        compare(&mut sequence, &dataset, frame, &target, &picture)?;
        if target.wants(frame.into(), dataset.frames().into()) {
            target.write(&picture, frame.into())?;
        }
        progress.inc(1);
    }
    progress.finish_and_clear();
    drop(denoiser);
    device::check_validation(&device.validation_messages())?;
    let report = DenoiseReport {
        dataset: options.folder.display().to_string(),
        layout: dataset.layout(),
        size: dataset.size(),
        frames: dataset.frames(),
        device: device.info().name.clone(),
        driver: device.info().driver.clone(),
        settings: settings.differing(),
        commit: COMMIT,
        passes: passes.into_iter().filter_map(|(name, ms)| Some((name, percentile(ms, 0.5)?))).collect(),
        metrics: sequence.finish(),
    };
    if let Some(json) = json {
        json.save_json(&report)?;
    }
    say::outcome(&target, &format!("{}: {}\n", target.name().display(), headline(&report)))
}

/// The pictures of `--out`: a file or a sequence, or those of a folder, which is made.
fn target(out: &Path) -> Result<PictureTarget, CliError> {
    let is_picture = out == "-" || out.extension().is_some() && !out.is_dir();
    if is_picture {
        return Ok(PictureTarget::new(out, false)?);
    }
    if !out.is_dir() {
        std::fs::create_dir(out).map_err(|source| OutputError::Write { path: out.to_owned(), source })?;
    }
    Ok(PictureTarget::new(&out.join("denoised{frame}.exr"), false)?)
}

/// Fails if an output would overwrite another one or a file of the data set.
fn check_apart(
    options: &DenoiseOptions,
    target: &PictureTarget,
    json: Option<&OutputFile>,
    frames: u32,
) -> Result<(), CliError> {
    let wrong = |option: &str, path: &Path, what: &str| {
        Err(CliError::Usage(format!(
            "{option} {}: would overwrite {what}; give it another name",
            path.display()
        )))
    };
    if let Some(json) = json.filter(|json| target.writes_to(json, frames.into())) {
        return wrong("--json", json.path(), "a picture of --out");
    }
    // Pictures of an earlier run may stand in the folder, and are replaced.
    let is_of_dataset = |path: &Path| {
        let folder = |path: &Path| path.canonicalize().ok();
        let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
        let within = path.parent().and_then(|parent| folder(&Path::new(".").join(parent)));
        path.exists() && !name.starts_with("denoised") && within == folder(&options.folder)
    };
    if let Some(json) = json.filter(|json| is_of_dataset(json.path())) {
        return wrong("--json", json.path(), "a file of the data set");
    }
    if let Some(path) = target.pictures(frames.into()).find(|path| is_of_dataset(path)) {
        return wrong("--out", &path, "a file of the data set");
    }
    Ok(())
}

/// Milliseconds of each pass, summed over those of one name.
fn summed(times: Vec<(&'static str, f64)>) -> BTreeMap<&'static str, f64> {
    let mut sums = BTreeMap::new();
    for (name, ms) in times {
        *sums.entry(name).or_default() += ms;
    }
    sums
}

/// Adds the errors of a frame that has a reference.
fn compare(
    sequence: &mut Sequence,
    dataset: &DatasetFrames,
    frame: u32,
    target: &PictureTarget,
    picture: &Picture,
) -> Result<(), CliError> {
    let Some(reference) = dataset.reference(frame) else { return Ok(()) };
    let name = target.path_of(frame.into()).display().to_string();
    let size = [picture.width, picture.height];
    let image = Image::from_linear(name, size, picture.colour.clone())?;
    let reference = Image::read(&reference, None)?;
    sequence.push(frame.into(), &image, &reference)?;
    Ok(())
}

fn headline(report: &DenoiseReport) -> String {
    let frames = format!("{} frames of {}", report.frames, report.dataset);
    match &report.metrics {
        None => frames,
        Some(metrics) => {
            let means = &metrics.means;
            format!("{frames}: RMSE {:.4}, SSIM {:.4}, FLIP {:.4}", means.rmse, means.ssim, means.flip)
        }
    }
}
