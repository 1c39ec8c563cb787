//! The benchmark: frame times of scenes across settings, and the quality at each.
//!
//! In: a [`Plan`] and a device. Out: a [`Report`] of samples. All tables, plots and pages derive from it (Tonna 2019,
//! figures 23 to 27 and 30).
//!
//! - `plan`: scenes, methods, settings, frames; `axis`: differences between runs; `method`: the method that lights the pictures; `run`,
//!   `samples`: measurements; `source`: takes them; `quality`, `equal_time`, `pictures`.
//! - `report`: the report; `summary`: statistics; `against`: changes since an earlier report.
//! - `background`: measures beside a program that goes on drawing.
//! - [`micro`]: micro-benchmarks of tracers, BVH and passes, with a report of their own.
//! - `tables`, `charts`: the report as tables and plots; `csv`, `markdown`, `html`, `folder`: as files.

mod against;
mod axis;
mod background;
mod charts;
mod control;
mod csv;
mod equal_time;
mod folder;
mod html;
mod machine;
mod markdown;
mod method;
pub mod micro;
mod pictures;
mod plan;
mod quality;
mod report;
mod run;
mod samples;
mod source;
mod summary;
mod tables;

pub use against::{Change, Comparison, compare_reports};
pub use axis::Axis;
pub use background::BackgroundBench;
pub use control::Control;
pub use folder::{Folder, MICRO_FILE, REPORT_FILE, read_report};
pub use machine::Machine;
pub use method::Method;
pub use plan::{Plan, Sweep};
pub use report::{EqualTime, FORMAT, PictureEntry, PictureKind, Report, SceneFacts};
pub use run::{FrameQuality, Quality, Round, Run, Still};
pub use samples::{Columns, OTHER, Samples, TOTAL, Unit};
pub use summary::{Figure, Noise, QuantityNoise, Summary};
pub use tables::{Table, milliseconds, tables};

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use crate::formats::{SceneError, load_scene};
use crate::metrics::MetricsError;
use crate::output::{OutputError, Picture};
use crate::reference::ReferenceError;
use crate::renderer::RenderError;
use crate::report::LoadTimes;
use crate::scene::Scene;
use crate::settings::SettingsError;
use crate::vulkan::Device;
use control::{work_of_frame, work_of_sample};
use quality::ReferencePictures;
use source::{BenchScene, FrameSource, measure, warm_up};

/// Errors of the benchmark.
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
        /// The error of the settings.
        error: SettingsError,
    },
    /// Two scenes have the same name.
    #[error("{0}: another scene of that name is measured too; omit one of them")]
    SceneTwice(String),
    /// A scene cannot be rendered.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// Something cannot be written or read.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// Pictures cannot be compared.
    #[error(transparent)]
    Metrics(#[from] MetricsError),
    /// A picture cannot be path traced.
    #[error(transparent)]
    Reference(#[from] ReferenceError),
    /// A file is no report, or cannot be resumed.
    #[error("{path}: {reason}")]
    Report {
        /// The file.
        path: PathBuf,
        /// The reason.
        reason: String,
    },
    /// The micro-benchmarks were interrupted; nothing is kept.
    #[error("interrupted after {done} of {planned} measurements")]
    Stopped {
        /// Completed measurements.
        done: usize,
        /// Planned measurements.
        planned: usize,
    },
    /// The benchmark was interrupted.
    #[error("interrupted after {done} of {planned} runs{}", if *.done > 0 { "; --resume continues" } else { "" })]
    Interrupted {
        /// Completed runs.
        done: usize,
        /// Planned runs.
        planned: usize,
    },
}

/// A benchmark in progress.
pub struct Bench {
    device: Arc<Device>,
    source: SceneSource,
    /// None: nothing is kept on disk, and no pictures are taken for it.
    folder: Option<Folder>,
    report: Report,
}

/// Where the scenes of a benchmark come from.
enum SceneSource {
    /// By name or file, with the folder of the downloaded models.
    Named(Option<PathBuf>),
    /// The only scene.
    Open(Box<Scene>),
}

impl SceneSource {
    fn load(&self, name: &str) -> Result<Scene, SceneError> {
        match self {
            Self::Named(assets) => load_scene(name, assets.as_deref()),
            Self::Open(scene) => Ok(Scene::clone(scene)),
        }
    }
}

impl Bench {
    /// Checks all scenes and settings before anything is measured.
    ///
    /// # Errors
    /// If a scene cannot be loaded or a setting is invalid.
    pub fn new(
        device: &Arc<Device>,
        plan: Plan,
        folder: Folder,
        assets: Option<PathBuf>,
    ) -> Result<Self, BenchError> {
        Self::planned(device, plan, SceneSource::Named(assets), Some(folder))
    }

    /// Measures `scene`, the only one of the plan, and keeps nothing on disk.
    ///
    /// # Errors
    /// If a setting is invalid.
    pub fn of_scene(device: &Arc<Device>, plan: Plan, scene: Scene) -> Result<Self, BenchError> {
        Self::planned(device, plan, SceneSource::Open(Box::new(scene)), None)
    }

    fn planned(
        device: &Arc<Device>,
        plan: Plan,
        source: SceneSource,
        folder: Option<Folder>,
    ) -> Result<Self, BenchError> {
        let (mut scenes, mut runs) = (Vec::<SceneFacts>::new(), Vec::new());
        for name in &plan.scenes {
            let scene = source.load(name)?;
            if scenes.iter().any(|known| known.name == scene.name) {
                return Err(BenchError::SceneTwice(scene.name));
            }
            let combinations = plan
                .combinations(&scene.settings)
                .map_err(|error| BenchError::Settings { scene: name.clone(), error })?;
            scenes.push(SceneFacts::of(&scene));
            runs.extend(combinations.into_iter().map(|(method, settings)| Run {
                scene: scene.name.clone(),
                method,
                warm_up: warm_up(&settings),
                settings,
                rounds: Vec::new(),
                quality: None,
            }));
        }
        let report = Report::new(Machine::new(device.info()), plan, scenes, runs);
        Ok(Self { device: Arc::clone(device), source, folder, report })
    }

    /// Resumes an earlier run of the same plan in the folder; false if there is none.
    ///
    /// # Errors
    /// If its plan differs, or if it is unfinished and from another machine or version.
    pub fn resume(&mut self) -> Result<bool, BenchError> {
        let Some(folder) = &self.folder else { return Ok(false) };
        let Some((path, earlier)) = folder.earlier()? else { return Ok(false) };
        let cannot = |reason: String| Err(BenchError::Report { path: path.clone(), reason });
        let anew = "omit --resume to start over";
        if let Some(option) = earlier.plan.difference(&self.report.plan) {
            return cannot(format!("was started with another {option}; give the same one, or {anew}"));
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
            && earlier.runs.iter().zip(&self.report.runs).all(|(a, b)| a.is_same(b));
        let scenes = (&earlier.scenes, &self.report.scenes);
        let same_scenes =
            scenes.0.len() == scenes.1.len() && scenes.0.iter().zip(scenes.1).all(|(a, b)| a.is_same(b));
        if !same_runs || !same_scenes {
            return cannot(format!("has scenes that changed since; {anew}"));
        }
        self.report = earlier;
        Ok(true)
    }

    /// Remaining work, in the units of [`Control`].
    pub fn work_left(&self) -> u64 {
        let plan = &self.report.plan;
        let mut work = 0;
        for scene in &self.report.scenes {
            let mut references = Vec::new();
            for run in self.report.runs_of(&scene.name) {
                let frame = work_of_frame(&run.settings, run.method.samples());
                let rounds_left = plan.rounds.saturating_sub(run.rounds.len() as u32);
                work += u64::from(rounds_left * (run.warm_up + plan.frames)) * frame;
                if plan.quality && run.quality.is_none() {
                    // After motion stops, and from a fresh start.
                    work += u64::from(2 * quality::LIKELY_SETTLING) * frame;
                    let settings = quality::reference_settings(&run.settings);
                    if !references.contains(&settings) {
                        let samples = quality::chosen_frames(plan.frames).len() as u64 * u64::from(plan.spp);
                        work += samples * work_of_sample(settings.size);
                        references.push(settings);
                    }
                }
            }
            if let Some(run) = self.missing_artefacts(&scene.name) {
                let kinds = PictureKind::ARTEFACTS.len() as u64;
                let frames = u64::from(pictures::artefact_frames(&run.settings));
                work += kinds * frames * work_of_frame(&run.settings, None);
            }
        }
        work
    }

    /// Planned and completed runs.
    pub fn runs(&self) -> (usize, usize) {
        let done = self.report.runs.iter().map(|run| run.rounds.len()).sum();
        (self.report.runs.len() * self.report.plan.rounds as usize, done)
    }

    /// Measures the remaining runs. Each run is saved, so that a later call can resume.
    ///
    /// # Errors
    /// If something fails or the benchmark is interrupted.
    pub fn run(&mut self, control: &mut Control<'_>) -> Result<(), BenchError> {
        for index in 0..self.report.scenes.len() {
            let name = self.report.scenes[index].name.clone();
            let rounds = self.report.plan.rounds as usize;
            let measured = self.report.runs_of(&name).all(|run| run.rounds.len() >= rounds);
            if measured && self.missing_artefacts(&name).is_none() && !self.wants_equal_time(&name) {
                continue;
            }
            control.begin(format!("loading {name}"));
            let begun = Instant::now();
            let loaded = self.source.load(&self.report.plan.scenes[index])?;
            let load_ms = begun.elapsed().as_secs_f64() * 1e3;
            let scene = BenchScene::new(&self.device, loaded);
            self.report.scenes[index].load = Some(LoadTimes { load_ms, bvh_ms: scene.prepared.bvh_ms() });
            let mut references = Vec::new();
            self.measure_scene(index, &scene, &mut references, control)?;
            self.compare_at_equal_time(index, &scene, &mut references, control)?;
            self.take_artefacts(index, &scene, control)?;
        }
        self.report.complete = true;
        Ok(())
    }

    /// Measures all runs of a scene, round by round, so that drift affects all alike.
    fn measure_scene(
        &mut self,
        index: usize,
        scene: &BenchScene,
        references: &mut Vec<ReferencePictures>,
        control: &mut Control<'_>,
    ) -> Result<(), BenchError> {
        let name = &scene.scene.name;
        for round in 0..self.report.plan.rounds as usize {
            for at in 0..self.report.runs.len() {
                let run = &self.report.runs[at];
                if run.scene != *name || run.rounds.len() > round {
                    continue;
                }
                let (planned, done) = self.runs();
                control.runs = [done, planned];
                let axes = [Some(Axis::Method), Axis::main(run)].into_iter().flatten();
                let what = axes.map(|axis| axis.phrase(run)).collect::<Vec<_>>().join(", ");
                control.begin(format!("run {} of {planned}: {name}, {what}", done + 1));
                self.measure(at, index, scene, references, control)?;
                self.keep()?;
            }
        }
        Ok(())
    }

    /// Measures one round of run `at` of scene `index`.
    fn measure(
        &mut self,
        at: usize,
        index: usize,
        scene: &BenchScene,
        references: &mut Vec<ReferencePictures>,
        control: &mut Control<'_>,
    ) -> Result<(), BenchError> {
        let run = &self.report.runs[at];
        let frames = self.report.plan.frames;
        let (method, settings) = (run.method.clone(), run.settings.clone());
        let judged = self.report.plan.quality && run.quality.is_none();
        let chosen = if judged { quality::chosen_frames(frames) } else { Vec::new() };
        let ends = self.wants_ends(at).then(|| [0, frames - 1]);
        let mut taken: Vec<(u32, Picture)> = Vec::new();
        let mut stop = (0, 0.0);
        let mut look = |frame: u32, source: &mut FrameSource, control: &mut Control<'_>| {
            if chosen.contains(&frame) || ends.is_some_and(|ends| ends.contains(&frame)) {
                taken.push((frame, source.picture()?));
            }
            if judged && frame + 1 == frames {
                stop = quality::stop(scene, source, &settings, frames, control)?;
            }
            Ok(())
        };
        let round = measure(scene, (&method, &settings), frames, control, &mut look)?;
        if let Some([first, last]) = ends {
            for (kind, frame) in [(PictureKind::Beginning, first), (PictureKind::End, last)] {
                if let Some((_, picture)) = taken.iter().find(|(number, _)| *number == frame) {
                    self.keep_picture(self.entry(index, kind, &settings), picture)?;
                }
            }
        }
        if judged {
            if self.report.plan.spp == 0 && !references.iter().any(|known| known.serves(&settings)) {
                references.push(ReferencePictures::of_run(&settings, taken.clone()));
            }
            let reference = ReferencePictures::of(references, scene, &settings, &self.report.plan, control)?;
            let (frames, (settling_frames, temporal_error)) = (reference.errors(&taken)?, stop);
            let still = quality::still(scene, &method, &settings, reference, control)?;
            self.report.runs[at].quality = Some(Quality { frames, settling_frames, temporal_error, still });
        }
        self.report.runs[at].rounds.push(round);
        Ok(())
    }

    /// Writes the report in all formats.
    ///
    /// # Errors
    /// If something cannot be written.
    pub fn write(&self) -> Result<(), BenchError> {
        self.folder.as_ref().map_or(Ok(()), |folder| folder.write(&self.report))
    }

    /// Saves the unfinished report.
    fn keep(&self) -> Result<(), BenchError> {
        self.folder.as_ref().map_or(Ok(()), |folder| folder.keep(&self.report))
    }

    /// The report so far.
    pub fn report(&self) -> &Report {
        &self.report
    }
}

/// Whether a scene needs downloadable models that are missing.
///
/// # Errors
/// Any other error of loading it.
pub fn lacks_models(scene: &str, assets: Option<&std::path::Path>) -> Result<bool, SceneError> {
    match load_scene(scene, assets) {
        Ok(_) => Ok(false),
        Err(SceneError::MissingAsset { .. }) => Ok(true),
        Err(error) => Err(error),
    }
}
