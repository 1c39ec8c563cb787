//! `glowworm render`: a scene to a picture or a sequence of pictures, and a report of the frames.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::options::RunOptions;
use super::progress::frames_bar;
use super::scene::GivenSettings;
use super::{CliError, device, say};
use crate::output::{OutputFile, PictureTarget};
use crate::renderer::{BufferView, DebugView, PathStyle, Renderer, Replay};
use crate::report::{FrameReport, RenderReport};
use crate::settings::Settings;
use crate::vpl::SlotState;

/// Options of `render`.
#[derive(Clone, Debug, clap::Args)]
#[command(args_override_self = true)]
pub(super) struct RenderOptions {
    /// A built-in scene, a scene file (.toml) or a model (.obj).
    pub scene: String,
    /// Frames to render. Otherwise as many as were recorded, or as there are temporal sets: then a still picture
    /// is complete.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    pub frames: Option<u64>,
    /// Picture to write: .png (tone-mapped, 8 bits) or .exr (linear, 32 bits); the last frame, or every
    /// frame where the name has a {frame} or {frame:04}.
    #[arg(long, value_name = "FILE", help_heading = "Files")]
    pub out: PathBuf,
    /// Add the G-buffer, direct and indirect light to an .exr as layers.
    #[arg(long, help_heading = "Files")]
    pub layers: bool,
    #[command(flatten)]
    pub view: ViewOptions,
    #[command(flatten)]
    pub settings: Settings,
    #[command(flatten)]
    pub run: RunOptions,
}

/// What to look at other than the picture.
#[derive(Clone, Debug, Default, clap::Args)]
#[command(next_help_heading = "Looking inside (.png only)")]
pub(super) struct ViewOptions {
    /// Show one of the images that a frame goes through in place of the picture.
    #[arg(long, value_name = "NAME", value_enum, default_value = "combined")]
    view: BufferView,
    /// The temporal set that set-buffer and set-reprojected show.
    #[arg(long, value_name = "K", default_value = "0")]
    view_set: u32,
    /// Draw VPLs as points and their paths as lines; colours tell this.
    #[arg(long, value_name = "COLOURS", value_enum)]
    vpl_paths: Option<PathStyle>,
    /// Show the light and path of the VPL in this slot alone, as bright as if all VPLs were like it.
    #[arg(long, value_name = "SLOT")]
    single_vpl: Option<u32>,
}

impl ViewOptions {
    /// Fails where there is nothing of the kind to look at.
    fn check(&self, settings: &Settings, target: &PictureTarget) -> Result<(), CliError> {
        let wrong = |what: String| Err(CliError::Usage(what));
        if self.debug_view() != DebugView::default() && target.is_linear() {
            return wrong("--view, --vpl-paths and --single-vpl: only a .png shows them".to_owned());
        }
        if self.view_set >= settings.temporal_sets {
            let (set, sets) = (self.view_set, settings.temporal_sets);
            return wrong(format!("--view-set {set}: must be below --temporal-sets, which is {sets}"));
        }
        match self.single_vpl {
            Some(slot) if slot >= settings.vpls => {
                wrong(format!("--single-vpl {slot}: must be below --vpls, which is {}", settings.vpls))
            }
            None if self.view == BufferView::VplVisibility => {
                wrong("--view vpl-visibility: say of which VPL with --single-vpl SLOT".to_owned())
            }
            _ => Ok(()),
        }
    }

    /// Says so where the single VPL is not there in the last frame.
    fn note_missing(&self, renderer: &Renderer) {
        let Some(slot) = self.single_vpl else { return };
        let held = renderer.vpls().slots().nth(slot as usize);
        if held.is_none_or(|held| held.state != SlotState::Valid) {
            say::warning(&format!("--single-vpl {slot}: the slot holds no VPL, so there is no light of it"));
        }
    }

    fn debug_view(&self) -> DebugView {
        DebugView {
            buffer: self.view,
            set: self.view_set,
            vpl_paths: self.vpl_paths,
            single_vpl: self.single_vpl,
            lines: Vec::new(),
        }
    }
}

/// Renders the scene. `given` are the settings given on the command line.
pub(super) fn render(options: &RenderOptions, given: &[&str]) -> Result<(), CliError> {
    let given = GivenSettings::new(&options.scene, &options.settings, given);
    given.check()?;
    let target = PictureTarget::new(&options.out, options.layers)?;
    let json = options.run.files.json.as_ref().map(OutputFile::new).transpose()?;
    let device = device::open(&options.run.device)?;
    let (scene, settings) = given.load(&options.run.files)?;
    let scene = Arc::new(scene);
    options.view.check(&settings, &target)?;
    let recorded = scene.recording.last().map(|last| last.frame + 1);
    let frames = options.frames.or(recorded).unwrap_or_else(|| u64::from(settings.temporal_sets));
    if let Some(json) = &json {
        check_apart(json, &target, frames, options)?;
    }
    device::note_slow(&device);
    let mut replay = Replay::new(&device, &scene, &settings, options.run.files.assets_folder())?;
    replay.renderer().set_view(&options.view.debug_view())?;
    let reports = render_frames(&mut replay, frames, &target)?;
    options.view.note_missing(replay.renderer());
    let tracer = replay.renderer().tracer();
    drop(replay);
    device::check_validation(&device.validation_messages())?;
    let info = device.info();
    let report = RenderReport::new(&scene.name, info, tracer, &settings, reports);
    if let Some(json) = json {
        json.save_json(&report)?;
    }
    say::print(&format!("{}: {}\n", options.out.display(), report.headline()))
}

/// Fails where the report would be written over a picture of this run or over the scene.
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
        "--json {}: would be written over {what}; give it another name",
        json.path().display()
    )))
}

/// Renders frames 0 to `frames` - 1 and writes the pictures that `target` wants. Shows progress on a
/// terminal. Gives the report of each frame.
fn render_frames(
    replay: &mut Replay,
    frames: u64,
    target: &PictureTarget,
) -> Result<Vec<FrameReport>, CliError> {
    let progress = frames_bar(frames);
    for frame in 0..frames {
        replay.next_frame()?;
        if target.wants(frame, frames) {
            target.write(&replay.renderer().read_picture(target.layers())?, frame)?;
        }
        progress.inc(1);
    }
    progress.finish_and_clear();
    Ok(replay.renderer().finish()?)
}
