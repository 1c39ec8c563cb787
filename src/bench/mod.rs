//! The benchmark: how fast each scene is with each setting, and what speed costs in quality.
//!
//! In: a [`Plan`] and a device. Out: a [`Report`] of samples, and from it alone every table, plot and page, so that
//! they cannot disagree (Tonna 2019, figures 23 to 27 and 30).
//!
//! - `plan`: what is measured; `run`: one measurement; `samples`: what it gives; `quality`, `pictures`: the rest.
//! - `report`: all of it; `summary`: what the samples amount to; `against`: what has changed since another report.
//! - [`micro`]: tracers, the BVH and passes by themselves, with a report of its own.
//! - `tables`, `charts`: the report for people; `csv`, `markdown`, `html`, `folder`: as files.

mod against;
mod charts;
mod control;
mod csv;
mod folder;
mod html;
mod machine;
mod markdown;
pub mod micro;
mod pictures;
mod plan;
mod quality;
mod report;
mod run;
mod samples;
mod summary;
mod tables;

pub use against::{Change, Comparison, compare_reports};
pub use control::Control;
pub use folder::{Folder, MICRO_FILE, REPORT_FILE, read_report};
pub use machine::Machine;
pub use pictures::{PictureEntry, PictureKind};
pub use plan::{Axis, Plan, Sweep};
pub use quality::{FrameQuality, Quality};
pub use report::{FORMAT, Report, Round, Run, SceneFacts};
pub use samples::{OTHER, Samples, TOTAL, Unit, VplColumns, stages};
pub use summary::{Figure, Noise, QuantityNoise, Summary};
pub use tables::{Table, milliseconds, tables};

use std::path::PathBuf;
use std::sync::Arc;

use crate::metrics::MetricsError;
use crate::output::{OutputError, Picture};
use crate::plot::PlotError;
use crate::renderer::{RenderError, Renderer, tracer_rates};
use crate::scene::{SceneError, load_scene};
use crate::settings::{Settings, SettingsError};
use crate::vulkan::Device;
use control::work_of_frame;
use quality::Converged;
use run::{Stage, warm_up};

/// Why there is no report.
#[derive(Debug, thiserror::Error)]
pub enum BenchError {
    /// A scene cannot be loaded.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A combination of settings cannot be used.
    #[error("{scene}: {error}")]
    Settings {
        /// The scene whose settings took part.
        scene: String,
        /// What is wrong with them.
        error: SettingsError,
    },
    /// Two scenes have one name, under which their figures would be joined.
    #[error("{0}: another scene of that name is measured too; leave one of them out")]
    SceneTwice(String),
    /// A scene cannot be rendered.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// Something cannot be written or read.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// A plot cannot be drawn.
    #[error(transparent)]
    Plot(#[from] PlotError),
    /// Pictures cannot be compared.
    #[error(transparent)]
    Metrics(#[from] MetricsError),
    /// A file is no report, or cannot be gone on with.
    #[error("{path}: {reason}")]
    Report {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// Somebody interrupted the benchmark of small things, of which nothing is kept.
    #[error("interrupted after {done} of {planned} measurements")]
    Stopped {
        /// Measurements that were done.
        done: usize,
        /// Measurements in all.
        planned: usize,
    },
    /// Somebody interrupted it.
    #[error("interrupted after {done} of {planned} runs{}", if *.done > 0 { "; --resume goes on" } else { "" })]
    Interrupted {
        /// Runs that are kept.
        done: usize,
        /// Runs in all.
        planned: usize,
    },
}

/// A benchmark on its way.
pub struct Bench {
    device: Arc<Device>,
    assets: Option<PathBuf>,
    folder: Folder,
    report: Report,
}

impl Bench {
    /// Looks at all scenes and settings, so that what is wrong is found before anything is measured.
    ///
    /// # Errors
    /// Where a scene cannot be loaded or a setting cannot be used.
    pub fn new(
        device: &Arc<Device>,
        plan: Plan,
        folder: Folder,
        assets: Option<PathBuf>,
    ) -> Result<Self, BenchError> {
        let (mut scenes, mut runs) = (Vec::<SceneFacts>::new(), Vec::new());
        for name in &plan.scenes {
            let scene = load_scene(name, assets.as_deref())?;
            if scenes.iter().any(|known| known.name == scene.name) {
                return Err(BenchError::SceneTwice(scene.name));
            }
            let combinations = plan
                .combinations(&scene.settings)
                .map_err(|error| BenchError::Settings { scene: name.clone(), error })?;
            scenes.push(SceneFacts::of(&scene));
            runs.extend(combinations.into_iter().map(|settings| Run {
                scene: scene.name.clone(),
                warm_up: warm_up(&settings),
                settings,
                rounds: Vec::new(),
                quality: None,
            }));
        }
        let report = Report::new(Machine::new(device.info(), tracer_rates(device)), plan, scenes, runs);
        Ok(Self { device: Arc::clone(device), assets, folder, report })
    }

    /// Takes over what an earlier run of the same plan has left in the folder; false if there is nothing.
    ///
    /// # Errors
    /// Where it is of another plan, or unfinished and of another machine or version.
    pub fn resume(&mut self) -> Result<bool, BenchError> {
        let Some((path, earlier)) = self.folder.earlier()? else { return Ok(false) };
        let cannot = |reason: String| Err(BenchError::Report { path: path.clone(), reason });
        let anew = "leave --resume out to begin anew";
        if let Some(option) = earlier.plan.difference(&self.report.plan) {
            return cannot(format!("was begun with another {option}; give the same one, or {anew}"));
        }
        if earlier.complete {
            self.report = earlier;
            return Ok(true);
        }
        if let Some(what) = earlier.machine.difference(&self.report.machine) {
            return cannot(format!("was measured on another {what}; {anew}"));
        }
        if earlier.machine.commit != self.report.machine.commit {
            return cannot(format!("was measured by another version of glowworm; {anew}"));
        }
        let same_runs = earlier.runs.len() == self.report.runs.len()
            && earlier
                .runs
                .iter()
                .zip(&self.report.runs)
                .all(|(a, b)| a.settings == b.settings && a.scene == b.scene);
        if !same_runs || earlier.scenes != self.report.scenes {
            return cannot(format!("is of scenes that have changed since; {anew}"));
        }
        self.report = earlier;
        Ok(true)
    }

    /// How much is left to do, in the units of [`Control`].
    pub fn work_left(&self) -> u64 {
        let plan = &self.report.plan;
        let mut work = 0;
        for scene in &self.report.scenes {
            let mut converged = None;
            for run in self.report.runs_of(&scene.name) {
                let frame = work_of_frame(&run.settings);
                let rounds_left = plan.rounds.saturating_sub(run.rounds.len() as u32);
                work += u64::from(rounds_left * (run.warm_up + plan.frames)) * frame;
                if plan.quality && run.quality.is_none() {
                    work += u64::from(quality::longest_settling(&run.settings)) * frame;
                    let many = quality::converged_settings(&run.settings);
                    if converged.as_ref() != Some(&many) {
                        work += quality::chosen_frames(plan.frames).len() as u64 * work_of_frame(&many);
                        converged = Some(many);
                    }
                }
            }
            if let Some(settings) = self.missing_artefacts(&scene.name) {
                let kinds = PictureKind::ARTEFACTS.len() as u64;
                work += kinds * u64::from(pictures::artefact_frames(settings)) * work_of_frame(settings);
            }
        }
        work
    }

    /// Runs to be done and those that are.
    pub fn runs(&self) -> (usize, usize) {
        let done = self.report.runs.iter().map(|run| run.rounds.len()).sum();
        (self.report.runs.len() * self.report.plan.rounds as usize, done)
    }

    /// Measures what is left. What has been measured is kept after every run, so that another call goes on.
    ///
    /// # Errors
    /// Where something fails or somebody interrupts.
    pub fn run(&mut self, control: &mut Control<'_>) -> Result<(), BenchError> {
        for index in 0..self.report.scenes.len() {
            let name = self.report.scenes[index].name.clone();
            let rounds = self.report.plan.rounds as usize;
            let measured = self.report.runs_of(&name).all(|run| run.rounds.len() >= rounds);
            if measured && self.missing_artefacts(&name).is_none() {
                continue;
            }
            control.begin(format!("loading {name}"));
            let scene = load_scene(&self.report.plan.scenes[index], self.assets.as_deref())?;
            let stage = Stage::new(&self.device, scene);
            self.measure_scene(index, &stage, control)?;
            self.take_artefacts(index, &stage, control)?;
        }
        self.report.complete = true;
        Ok(())
    }

    /// All rounds of all settings of a scene: round by round, so that the rounds of one setting lie apart.
    fn measure_scene(
        &mut self,
        index: usize,
        stage: &Stage,
        control: &mut Control<'_>,
    ) -> Result<(), BenchError> {
        let name = &stage.scene.name;
        let mut converged = None;
        for round in 0..self.report.plan.rounds as usize {
            for at in 0..self.report.runs.len() {
                let run = &self.report.runs[at];
                if run.scene != *name || run.rounds.len() > round {
                    continue;
                }
                let (planned, done) = self.runs();
                control.runs = [done, planned];
                let sets = Axis::TemporalSets.phrase(&run.settings);
                control.begin(format!("run {} of {planned}: {name}, {sets}", done + 1));
                self.measure(at, index, stage, &mut converged, control)?;
                self.folder.keep(&self.report)?;
            }
        }
        Ok(())
    }

    /// One round of run number `at`, of scene number `scene`.
    fn measure(
        &mut self,
        at: usize,
        scene: usize,
        stage: &Stage,
        converged: &mut Option<Converged>,
        control: &mut Control<'_>,
    ) -> Result<(), BenchError> {
        let run = &self.report.runs[at];
        let frames = self.report.plan.frames;
        let settings = run.settings.clone();
        let judged = self.report.plan.quality && run.quality.is_none();
        let chosen = if judged { quality::chosen_frames(frames) } else { Vec::new() };
        if judged && !converged.as_ref().is_some_and(|converged| converged.serves(&settings)) {
            *converged = Some(Converged::render(stage, &settings, frames, control)?);
        }
        let ends = self.wants_ends(at).then(|| [0, frames - 1]);
        let mut taken: Vec<(u32, Picture)> = Vec::new();
        let mut stop = (0, 0.0);
        let mut look = |frame: u32, renderer: &mut Renderer, control: &mut Control<'_>| {
            if chosen.contains(&frame) || ends.is_some_and(|ends| ends.contains(&frame)) {
                taken.push((frame, renderer.read_picture(false)?));
            }
            if judged && frame + 1 == frames {
                stop = quality::stop(stage, renderer, &settings, frames, control)?;
            }
            Ok(())
        };
        let round = stage.measure(&settings, frames, control, &mut look)?;
        if let Some([first, last]) = ends {
            for (kind, frame) in [(PictureKind::Beginning, first), (PictureKind::End, last)] {
                if let Some((_, picture)) = taken.iter().find(|(number, _)| *number == frame) {
                    self.keep_picture(scene, kind, settings.temporal_sets, picture)?;
                }
            }
        }
        if let Some(converged) = converged.as_ref().filter(|_| judged) {
            let (frames, (settling_frames, temporal_error)) = (converged.compare(&taken)?, stop);
            self.report.runs[at].quality = Some(Quality { frames, settling_frames, temporal_error });
        }
        self.report.runs[at].rounds.push(round);
        Ok(())
    }

    /// Whether the scene's beginning and end are pictures of this run: of the first with the sets that are shown.
    fn wants_ends(&self, at: usize) -> bool {
        let run = &self.report.runs[at];
        let shown = self.report.shown_sets();
        let first = self.report.runs_of(&run.scene).find(|run| run.settings.temporal_sets == shown);
        run.rounds.is_empty() && first.is_some_and(|first| first.settings == run.settings)
    }

    /// The settings for the pictures of a moving camera, with the most sets, unless there are such pictures.
    fn missing_artefacts<'a>(&'a self, scene: &'a str) -> Option<&'a Settings> {
        let taken = |kind: PictureKind| {
            self.report.pictures.iter().any(|picture| picture.scene == scene && picture.kind == kind)
        };
        if PictureKind::ARTEFACTS.into_iter().all(taken) {
            return None;
        }
        let runs = || self.report.runs_of(scene).map(|run| &run.settings);
        let most = runs().map(|settings| settings.temporal_sets).max()?;
        runs().find(|settings| settings.temporal_sets == most)
    }

    fn take_artefacts(
        &mut self,
        index: usize,
        stage: &Stage,
        control: &mut Control<'_>,
    ) -> Result<(), BenchError> {
        let Some(settings) = self.missing_artefacts(&stage.scene.name).cloned() else { return Ok(()) };
        let (planned, done) = self.runs();
        control.runs = [done, planned];
        for kind in PictureKind::ARTEFACTS {
            control.begin(format!("{}: the camera {}", stage.scene.name, kind.caption()));
            let picture = pictures::artefact(stage, &settings, kind, control)?;
            self.keep_picture(index, kind, settings.temporal_sets, &picture)?;
        }
        self.folder.keep(&self.report)
    }

    fn keep_picture(
        &mut self,
        scene: usize,
        kind: PictureKind,
        temporal_sets: u32,
        picture: &Picture,
    ) -> Result<(), BenchError> {
        let entry = PictureEntry::new(scene, &self.report.scenes[scene].name, kind, temporal_sets);
        self.folder.keep_picture(&entry, picture)?;
        self.report.pictures.retain(|known| known.file != entry.file);
        self.report.pictures.push(entry);
        Ok(())
    }

    /// Writes the report in all its forms.
    ///
    /// # Errors
    /// Where something cannot be written.
    pub fn write(&self) -> Result<(), BenchError> {
        self.folder.write(&self.report)
    }

    /// What has been measured so far.
    pub fn report(&self) -> &Report {
        &self.report
    }
}

/// Whether a scene is one whose models are not shipped and are not there.
///
/// # Errors
/// Whatever else is wrong with it.
pub fn lacks_models(scene: &str, assets: Option<&std::path::Path>) -> Result<bool, SceneError> {
    match load_scene(scene, assets) {
        Ok(_) => Ok(false),
        Err(SceneError::MissingModel { .. }) => Ok(true),
        Err(error) => Err(error),
    }
}
