//! `glowworm reference`: the ground truth of a scene, by path tracing on the CPU.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use serde::Serialize;

use super::options::{CameraOptions, FileOptions, count};
use super::progress::interruption;
use super::scene::{LoadedScene, SceneOptions, load};
use super::{CliError, progress, say};
use crate::output::{Picture, PictureTarget, Tones, tone_map};
use crate::reference::{Film, Identity, PixelFilter, Progress, Reference, ReferenceError, ReferenceSettings};
use crate::report::{COMMIT, LoadTimes};
use crate::scene::Scene;
use crate::settings::{Settings, parser_of};

/// The attribute of an .exr with its identity and progress.
const NOTE: &str = "glowworm reference";

/// Minimum time between saves of an unfinished picture.
const SAVING_INTERVAL: Duration = Duration::from_secs(10);

/// Minimum time between saves, in units of the duration of the last save.
const SAVING_SHARE: u32 = 20;

/// Minimum time between updates of the error.
const ERROR_INTERVAL: Duration = Duration::from_millis(500);

/// Options of `reference`.
#[derive(Clone, Debug, clap::Args)]
#[command(args_override_self = true)]
pub(super) struct ReferenceOptions {
    #[command(flatten)]
    pub scene: SceneOptions,
    /// Total samples per pixel. More: less noise, about as 1 / sqrt(N).
    #[arg(long, value_name = "N", value_parser = count::<u64>(1..=1_000_000_000), default_value = "256")]
    pub spp: u64,
    /// Frame of the scene's animation, from 0.
    #[arg(long, value_name = "K", value_parser = count::<u64>(0..=1_000_000_000), default_value = "0")]
    pub frame: u64,
    /// Positions of paths in a pixel: all over it (box) for antialiased edges, or at its centre (center) for the edges
    /// of `render`.
    #[arg(long, value_enum, default_value = "box")]
    pub pixel_filter: PixelFilter,
    /// Seed of the samples. Otherwise the scene's, or 0.
    #[arg(long, value_name = "N", value_parser = parser_of("seed"), allow_negative_numbers = true)]
    pub seed: Option<String>,
    /// Exposure of a .png in stops, or auto. Otherwise the scene's, or auto.
    #[arg(long, value_name = "EV|auto", value_parser = parser_of("exposure"), allow_negative_numbers = true)]
    pub exposure: Option<String>,
    /// Tone curve of a .png. Otherwise the scene's, or aces.
    #[arg(long, value_name = "NAME", value_parser = parser_of("tone_map"))]
    pub tone_map: Option<String>,
    #[command(flatten)]
    pub camera: CameraOptions,
    /// Picture to write: .exr (linear, 32 bits) or .png (tone-mapped, 8 bits), saved periodically, so that an aborted run leaves
    /// one; -: a PNG to standard output, at the end.
    #[arg(short, long, value_name = "FILE", help_heading = "Files")]
    pub out: PathBuf,
    /// Add to an .exr: direct light (of point, spot and directional lights) and its shadows, indirect light (as irradiance),
    /// albedo, normal, position, depth, instance.
    #[arg(long, help_heading = "Files")]
    pub layers: bool,
    /// Resume the .exr of an earlier run with the same options, if it exists, up to --spp samples in total.
    #[arg(long, help_heading = "Files")]
    pub resume: bool,
    #[command(flatten)]
    pub files: FileOptions,
}

/// Report of a run, for `--json`.
#[derive(Debug, Serialize)]
struct ReferenceReport {
    #[serde(flatten)]
    progress: Progress,
    spp: u64,
    interrupted: bool,
    mean_luminance: f64,
    /// Standard error / mean luminance.
    relative_error: Option<f64>,
    /// Samples of this run over all pixels, and its time without loading and saving, seconds.
    new_samples: u64,
    seconds: f64,
    samples_per_second: f64,
    threads: usize,
    commit: &'static str,
    #[serde(flatten)]
    load: LoadTimes,
}

/// Renders the reference.
pub(super) fn reference(options: &ReferenceOptions) -> Result<(), CliError> {
    let given = options.scene.given(&[
        ("seed", &options.seed),
        ("exposure", &options.exposure),
        ("tone_map", &options.tone_map),
    ]);
    options.camera.check()?;
    let target = PictureTarget::new(&options.out, options.layers)?;
    if options.resume && !target.is_linear() {
        return Err(CliError::Usage("--resume: needs an .exr as --out".to_owned()));
    }
    let json = options.files.report.check(target.picture(options.frame))?;
    if let Some(json) = &json
        && (json.is_same(&target.path_of(options.frame)) || json.is_same(Path::new(&options.scene.name)))
    {
        let path = json.path().display();
        return Err(CliError::Usage(format!(
            "--json {path}: would overwrite the picture or the scene; give it another name"
        )));
    }
    let LoadedScene { mut scene, settings, load_ms } = load(
        &options.scene.name,
        &given,
        &options.files,
        &options.scene.animation.seen_by(options.camera.parts()),
    )?;
    options.camera.place(&mut scene)?;
    let pose = scene.pose(options.frame as f64 * settings.time_step);
    let mut run = Run::new(options, &scene, &settings, target);
    let reference = progress::preparing(|| Reference::new(&scene, &pose, &run.settings));
    let mut film = run.start(&reference)?;
    run.load = LoadTimes { load_ms, bvh_ms: reference.bvh_ms() };
    let report = run.finish(&reference, &mut film)?;
    if let Some(json) = json {
        json.save_json(&report)?;
    }
    run.say_outcome(&film, &report)
}

/// One run of the command.
struct Run<'a> {
    options: &'a ReferenceOptions,
    target: PictureTarget,
    identity: Identity,
    settings: ReferenceSettings,
    tones: Tones,
    /// Samples per pixel before this run.
    resumed: u64,
    load: LoadTimes,
}

impl<'a> Run<'a> {
    fn new(options: &'a ReferenceOptions, scene: &Scene, settings: &Settings, target: PictureTarget) -> Self {
        let bounces = options.scene.bounces(settings);
        let identity = Identity {
            scene: scene.name.clone(),
            frame: options.frame,
            time_step: settings.time_step,
            size: settings.size,
            bounces,
            seed: settings.seed,
            pixel_filter: options.pixel_filter,
            camera: options.camera.parts(),
            layers: options.layers,
        };
        let tones = settings.into();
        let settings = ReferenceSettings {
            size: settings.size,
            bounces,
            seed: settings.seed,
            filter: options.pixel_filter,
            layers: options.layers,
        };
        Self { options, target, identity, settings, tones, resumed: 0, load: LoadTimes::default() }
    }

    /// An empty film, or with --resume that of the file.
    fn start(&mut self, reference: &Reference<'_>) -> Result<Film, CliError> {
        let path = self.target.path_of(self.options.frame);
        if !(self.options.resume && path.exists()) {
            return Ok(reference.film()?);
        }
        let cannot = |reason: String| CliError::Resume { path: path.clone(), reason };
        let picture = Picture::read_exr(&path)?;
        let note = picture.notes.get(NOTE).ok_or_else(|| {
            cannot("was not written by glowworm reference; omit --resume to start over".to_owned())
        })?;
        let progress: Progress = serde_json::from_str(note).map_err(|error| {
            cannot(format!("has an invalid progress attribute ({error}); omit --resume to start over"))
        })?;
        if let Some(option) = progress.identity.difference(&self.identity) {
            return Err(cannot(format!(
                "was rendered with another {option}; give the same one, or omit --resume to start over"
            )));
        }
        self.resumed = progress.samples;
        reference.resumed_film(&picture, &progress).map_err(|error| match error {
            ReferenceError::CannotResume => cannot(error.to_string()),
            ReferenceError::OutOfMemory => error.into(),
        })
    }

    /// Samples until complete or interrupted; saves periodically and at the end.
    fn finish(&self, reference: &Reference<'_>, film: &mut Film) -> Result<ReferenceReport, CliError> {
        let stop = interruption();
        let progress =
            progress::bar(self.options.spp, "{bar:40} sample {pos} of {len}, {eta} left, error {msg}")
                .with_position(film.samples());
        progress.reset_eta();
        let mut sampling = Duration::ZERO;
        let (mut saved, mut saving_took) = (None::<Instant>, Duration::ZERO);
        let mut looked = None::<Instant>;
        while film.samples() < self.options.spp {
            let begun = Instant::now();
            if !reference.add_sample(film, &stop) {
                break;
            }
            sampling += begun.elapsed();
            progress.set_position(film.samples());
            if looked.is_none_or(|looked| looked.elapsed() >= ERROR_INTERVAL) {
                looked = Some(Instant::now());
                progress.set_message(percent(relative_error(film)));
            }
            let pause = SAVING_INTERVAL.max(saving_took * SAVING_SHARE);
            let is_wanted = film.samples() < self.options.spp && !self.target.is_standard_output();
            if is_wanted && saved.is_none_or(|saved| saved.elapsed() >= pause) {
                let begun = Instant::now();
                self.save(film)?;
                saving_took = begun.elapsed();
                saved = Some(Instant::now());
            }
        }
        progress.finish_and_clear();
        if film.samples() > 0 {
            self.save(film)?;
        }
        Ok(self.report(film, sampling.as_secs_f64()))
    }

    fn progress(&self, film: &Film) -> Progress {
        Progress {
            identity: self.identity.clone(),
            samples: film.samples(),
            standard_error: film.standard_error().unwrap_or(0.0),
        }
    }

    fn save(&self, film: &Film) -> Result<(), CliError> {
        let mut picture = film.picture();
        let note = serde_json::to_string(&self.progress(film)).unwrap_or_default();
        picture.notes.insert(NOTE.to_owned(), note);
        if !self.target.is_linear() {
            tone_map(&mut picture, self.tones, film.metered());
        }
        self.target.write(&picture, self.options.frame)?;
        Ok(())
    }

    fn report(&self, film: &Film, seconds: f64) -> ReferenceReport {
        let [width, height] = self.settings.size.map(u64::from);
        let new_samples = (film.samples() - self.resumed) * width * height;
        ReferenceReport {
            progress: self.progress(film),
            spp: self.options.spp,
            interrupted: film.samples() < self.options.spp,
            mean_luminance: film.mean_luminance(),
            relative_error: relative_error(film),
            new_samples,
            seconds,
            samples_per_second: if seconds > 0.0 { new_samples as f64 / seconds } else { 0.0 },
            threads: rayon::current_num_threads(),
            commit: COMMIT,
            load: self.load,
        }
    }

    fn say_outcome(&self, film: &Film, report: &ReferenceReport) -> Result<(), CliError> {
        let path = self.target.path_of(self.options.frame);
        if film.dropped() > 0 {
            say::warning(&format!("{} samples were not finite; they count as black", film.dropped()));
        }
        if film.samples() > 0 && film.mean_luminance() == 0.0 {
            say::warning(&format!("{}: {}", self.options.scene.name, say::BLACK));
        }
        let (samples, spp) = (report.progress.samples, report.spp);
        if report.interrupted {
            return Err(CliError::Interrupted { path, samples, spp, resumable: self.target.is_linear() });
        }
        say::outcome(
            &self.target,
            &format!(
                "{}: {samples} samples per pixel, error {} of the mean luminance, {:.1} s, {:.2} million samples/s\n",
                path.display(),
                percent(report.relative_error),
                report.seconds,
                report.samples_per_second * 1e-6,
            ),
        )
    }
}

/// Standard error / mean luminance.
fn relative_error(film: &Film) -> Option<f64> {
    let mean = film.mean_luminance();
    film.standard_error().map(|error| error / mean).filter(|error| error.is_finite())
}

fn percent(error: Option<f64>) -> String {
    error.map_or_else(|| "unknown".to_owned(), |error| format!("{:.2} %", error * 100.0))
}
