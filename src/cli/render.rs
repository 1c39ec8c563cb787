//! `glowworm render`: renders a picture or a sequence of pictures, with a report of the frames.

use clap::builder::{PossibleValue, PossibleValuesParser};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Instant;

use super::options::{CameraOptions, RunOptions, count};
use super::progress::{frames_bar, interruption, preparing};
use super::scene::{AnimationOption, LoadedScene, load};
use super::{CliError, device, say};
use crate::dataset::LiveDataset;
use crate::estimators;
use crate::estimators::paths;
use crate::estimators::vpls::{PathStyle, SlotState, VPL_VISIBILITY, VplDebugView, Vpls};
use crate::output::{OutputFile, PictureTarget};
use crate::passes::buffer_view::COMBINED;
use crate::renderer::{DebugView, Renderer, Replay};
use crate::report::{FrameReport, LoadTimes, RenderReport, Resolved};
use crate::scene::{Scene, luminance};
use crate::settings::{GivenSettings, Settings, read_seconds};
use crate::statistics::percentile;

/// Options of `render`.
#[derive(Clone, Debug, clap::Args)]
#[command(args_override_self = true)]
pub(super) struct RenderOptions {
    /// A built-in scene, a scene file (.toml) or a model (.obj, .gltf, .glb).
    pub scene: String,
    /// Frames to render. Otherwise those of the recording, or one per temporal set, which completes a stationary
    /// picture.
    #[arg(long, value_name = "N", value_parser = count::<u64>(1..=1_000_000))]
    pub frames: Option<u64>,
    /// Animation time of the last frame, seconds; those before it lead up to it by --time-step. Otherwise frame 0 is at 0.
    #[arg(long, value_name = "SECONDS", value_parser = parse_time)]
    pub time: Option<f64>,
    /// Picture to write: .png (tone-mapped, 8 bits) or .exr (linear, 32 bits); the last frame, or every
    /// frame if the name has a {frame} or {frame:04}; -: a PNG to standard output.
    #[arg(short, long, value_name = "FILE", help_heading = "Files")]
    pub out: PathBuf,
    /// Add the G-buffer, direct and indirect light to an .exr as layers.
    #[arg(long, help_heading = "Files")]
    pub layers: bool,
    /// Also write what the denoiser of indirect light is given in each frame to a folder, new or empty, for `denoise`; see
    /// `dataset` for its files. Needs --indirect paths --antialiasing none --still-frames 0.
    #[arg(long, value_name = "DIR", help_heading = "Files")]
    pub dataset: Option<PathBuf>,
    #[command(flatten)]
    pub animation: AnimationOption,
    #[command(flatten)]
    pub camera: CameraOptions,
    #[command(flatten)]
    pub view: ViewOptions,
    #[command(flatten)]
    pub settings: GivenSettings,
    #[command(flatten)]
    pub run: RunOptions,
}

/// Debug views.
#[derive(Clone, Debug, Default, clap::Args)]
#[command(next_help_heading = "Debug views (.png only)")]
pub(super) struct ViewOptions {
    /// Show an intermediate image of the frame instead of the picture.
    #[arg(long, value_name = "NAME", value_parser = view_names(), default_value = COMBINED)]
    view: String,
    /// The temporal set that set-buffer and set-reprojected show.
    #[arg(long, value_name = "K", default_value = "0")]
    view_set: u32,
    /// Draw VPLs as points and their paths as lines, coloured by this; hidden parts are dimmed, and invalidated ones flash in the
    /// colour of their reason: light turned away white, surfaces face away cyan, occluded red, parent invalid pink, light changed
    /// yellow.
    #[arg(long, value_name = "COLOURS", value_enum)]
    vpl_paths: Option<PathStyle>,
    /// Show the light and path of the VPL in this slot only, scaled up by the number of VPLs.
    #[arg(long, value_name = "SLOT")]
    single_vpl: Option<u32>,
}

/// The views with their descriptions.
fn view_names() -> PossibleValuesParser {
    estimators::views().map(|view| PossibleValue::new(view.name).help(view.about)).collect::<Vec<_>>().into()
}

impl ViewOptions {
    /// Fails if the views do not fit the settings or the output.
    fn check(&self, settings: &Settings, target: &PictureTarget) -> Result<(), CliError> {
        let wrong = |what: String| Err(CliError::Usage(what));
        if self.debug_view() != DebugView::default() && target.is_linear() {
            return wrong("--view, --vpl-paths and --single-vpl: need a .png as --out".to_owned());
        }
        if self.view_set >= settings.vpl.temporal_sets {
            let (set, sets) = (self.view_set, settings.vpl.temporal_sets);
            return wrong(format!("--view-set {set}: must be below --temporal-sets, which is {sets}"));
        }
        if paths::shows_cells(&self.view) && !settings.paths.filter.has_cells() {
            return wrong(format!(
                "--view {}: there are no cells; choose --indirect paths and --filter hpsf, nhpsf, a-nhpsf or cache",
                self.view
            ));
        }
        match self.single_vpl {
            Some(slot) if slot >= settings.vpl.slots => {
                wrong(format!("--single-vpl {slot}: must be below --vpls, which is {}", settings.vpl.slots))
            }
            None if self.view == VPL_VISIBILITY => {
                wrong("--view vpl-visibility: needs --single-vpl SLOT".to_owned())
            }
            _ => Ok(()),
        }
    }

    /// Warns if the single VPL does not exist in the last frame.
    fn note_missing(&self, renderer: &Renderer) {
        let Some(slot) = self.single_vpl else { return };
        let held = renderer.estimator::<Vpls>().and_then(|vpls| vpls.manager().slots().nth(slot as usize));
        if held.is_none_or(|held| held.state != SlotState::Valid) {
            say::warning(&format!("--single-vpl {slot}: the slot holds no VPL; choose another one"));
        }
    }

    fn debug_view(&self) -> DebugView {
        let view = DebugView { buffer: self.view.clone().into(), ..DebugView::default() };
        view.with_options(&VplDebugView {
            set: self.view_set,
            vpl_paths: self.vpl_paths,
            single_vpl: self.single_vpl,
            ..VplDebugView::default()
        })
    }
}

/// Seconds from 0 to 1,000,000.
fn parse_time(text: &str) -> Result<f64, String> {
    let seconds = read_seconds(text).filter(|seconds| (0.0..=1e6).contains(seconds));
    seconds.ok_or_else(|| "must be seconds from 0 to 1,000,000, such as 2.5".to_owned())
}

/// Renders the scene.
pub(super) fn render(options: &RenderOptions) -> Result<(), CliError> {
    options.camera.check()?;
    let target = PictureTarget::new(&options.out, options.layers)?;
    let report_options = &options.run.files.report;
    let json = report_options.check(target.pictures(1))?;
    let device = device::open(&options.run.device)?;
    let LoadedScene { mut scene, settings, load_ms } = load(
        &options.scene,
        &options.settings,
        &options.run.files,
        &options.animation.seen_by(options.camera.parts()),
    )?;
    options.camera.place(&mut scene)?;
    let scene = Arc::new(scene);
    options.view.check(&settings, &target)?;
    let recorded = scene.recording.last().map(|last| last.frame + 1);
    let frames = options
        .frames
        .or(recorded)
        .unwrap_or_else(|| (estimators::method(&settings).warm_up)(&settings).into());
    if let Some(json) = &json {
        check_apart(json, &target, frames, options)?;
    }
    report_options.check_new(target.pictures(frames))?;
    device::note_slow(&device);
    let mut dataset =
        options.dataset.as_ref().map(|folder| dataset(folder, &scene, &settings)).transpose()?;
    let assets = options.run.files.assets_folder();
    if options.time.is_some() && recorded.is_some() {
        return Err(CliError::Usage("--time: a recording has a time of its own; leave it out".to_owned()));
    }
    let lead = frames.saturating_sub(1) as f64 * settings.time_step;
    let start = options.time.map_or(0.0, |time| time - lead);
    let mut replay = preparing(|| Replay::new(&device, &scene, &settings, assets, start))?;
    let load = LoadTimes { load_ms, bvh_ms: replay.renderer().bvh_ms() };
    replay.renderer().set_view(&options.view.debug_view())?;
    let Rendered { reports, interval_ms, extreme } =
        render_frames(&mut replay, frames, &target, settings.exposure, dataset.as_mut())?;
    if let Some(dataset) = dataset {
        dataset.finish(scene.bounding_sphere(&scene.pose(0.0)).radius)?;
    }
    if let Some(extreme) = extreme {
        say::warning(&format!("{}: {extreme}", scene.name));
    }
    options.view.note_missing(replay.renderer());
    for warning in replay.renderer().warnings() {
        say::warning(&format!("{}: {warning}", scene.name));
    }
    let renderer = replay.renderer();
    let resolved = Resolved { tracer: renderer.tracer(), direct: renderer.direct() };
    drop(replay);
    device::check_validation(&device.validation_messages())?;
    let info = device.info();
    let report = RenderReport::new(&scene.name, info, resolved, &settings, load, reports)
        .with_device_memory(device.memory_peak())
        .with_interval(interval_ms);
    if let Some(json) = json {
        json.save_json(&report)?;
    }
    say::outcome(&target, &format!("{}: {}\n", target.name().display(), report.headline()))
}

/// Fails if the report would overwrite a picture of this run or the scene.
fn check_apart(
    json: &OutputFile,
    target: &PictureTarget,
    frames: u64,
    options: &RenderOptions,
) -> Result<(), CliError> {
    let what = if target.writes_to(json, frames) {
        format!("a picture of --out {}", options.out.display())
    } else if json.is_same(Path::new(&options.scene)) {
        "the scene".to_owned()
    } else {
        return Ok(());
    };
    Err(CliError::Usage(format!(
        "--json {}: would overwrite {what}; give it another name",
        json.path().display()
    )))
}

/// Stops on either side of middle grey within which automatic exposure adapts; twin: shaders/passes/exposure.comp.
const EXPOSURE_STOPS: f32 = 16.0;

/// A warning about the picture: it is black, or too bright or dark for automatic exposure.
fn extreme_of(colour: &[[f32; 3]], exposure: Option<f32>) -> Option<&'static str> {
    let luminances = colour.iter().map(|&colour| luminance(colour.into())).filter(|&l| l > 0.0);
    let stops: Vec<f32> = luminances.map(f32::log2).collect();
    if stops.is_empty() {
        return Some(say::BLACK);
    }
    let mean = stops.iter().sum::<f32>() / stops.len() as f32;
    let is_beyond = exposure.is_none() && mean.abs() >= EXPOSURE_STOPS;
    is_beyond.then_some("automatic exposure is at its bound; give --exposure, or scale the lights")
}

/// Starts the data set of `--dataset`.
fn dataset(folder: &Path, scene: &Scene, settings: &Settings) -> Result<LiveDataset, CliError> {
    match LiveDataset::lacking(scene, settings) {
        None => Ok(LiveDataset::new(folder, &scene.name)?),
        Some(needs) => Err(CliError::Usage(format!("--dataset {}: needs {needs}", folder.display()))),
    }
}

/// Frames that wait for no earlier one.
const IN_FLIGHT: usize = 2;

/// The results of a run.
struct Rendered {
    reports: Vec<FrameReport>,
    /// Time from one frame to the next, median: that of the loop without writing pictures.
    interval_ms: Option<f64>,
    /// The warning about the last picture.
    extreme: Option<&'static str>,
}

/// Renders frames 0 to `frames` - 1 and writes the pictures of `target` and `dataset`. Shows progress on a terminal.
fn render_frames(
    replay: &mut Replay,
    frames: u64,
    target: &PictureTarget,
    exposure: Option<f32>,
    mut dataset: Option<&mut LiveDataset>,
) -> Result<Rendered, CliError> {
    let stop = interruption();
    let progress = frames_bar(frames);
    let (mut intervals, mut extreme) = (Vec::new(), None);
    for frame in 0..frames {
        if stop.load(Ordering::Relaxed) {
            progress.finish_and_clear();
            return Err(CliError::Stopped {
                done: frame,
                frames,
                kept: frame > 0 && target.wants(0, frames),
            });
        }
        let begun = Instant::now();
        replay.next_frame()?;
        intervals.push(begun.elapsed().as_secs_f64() * 1e3);
        if let Some(dataset) = &mut dataset {
            let pose = replay.pose().clone();
            dataset.write(replay.renderer(), &pose)?;
        }
        if target.wants(frame, frames) {
            let picture = replay.renderer().read_picture(target.layers())?;
            extreme = extreme_of(&picture.colour, exposure);
            target.write(&picture, frame)?;
        }
        progress.inc(1);
    }
    progress.finish_and_clear();
    let interval_ms = percentile(intervals.into_iter().skip(IN_FLIGHT), 0.5);
    Ok(Rendered { reports: replay.renderer().finish()?, interval_ms, extreme })
}
