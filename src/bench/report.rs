//! The report of a benchmark, as in `bench.json`.

use serde::ser::SerializeStruct;
use serde::{Deserialize, Serialize, Serializer};

use super::equal_time::EqualTime;
use super::machine::Machine;
use super::method::Method;
use super::pictures::PictureEntry;
use super::plan::{Axis, Plan};
use super::quality::Quality;
use super::samples::Samples;
use super::summary::{Noise, Summary};
use crate::report::LoadTimes;
use crate::scene::Scene;
use crate::settings::Settings;

/// File format.
pub const FORMAT: &str = "glowworm bench 2";

/// A whole benchmark.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct Report {
    /// [`FORMAT`].
    pub format: String,
    /// Whether all planned runs are complete.
    pub complete: bool,
    /// The machine.
    pub machine: Machine,
    /// The plan.
    pub plan: Plan,
    /// The scenes, in order.
    pub scenes: Vec<SceneFacts>,
    /// Every setting of every scene, in order.
    pub runs: Vec<Run>,
    /// Pictures, in files beside this one.
    pub pictures: Vec<PictureEntry>,
    /// The methods at equal time, with `--quality`.
    pub equal_time: Vec<EqualTime>,
}

/// Size of a scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SceneFacts {
    /// Its name.
    pub name: String,
    /// Triangles of all instances.
    pub triangles: usize,
    /// Instances.
    pub instances: usize,
    /// Dynamic instances.
    pub moving_instances: usize,
    /// Lights.
    pub lights: usize,
    /// Load times; none if not measured.
    #[serde(flatten)]
    pub load: Option<LoadTimes>,
}

impl SceneFacts {
    /// The facts of `scene`.
    pub fn of(scene: &Scene) -> Self {
        Self {
            name: scene.name.clone(),
            triangles: scene.triangle_count(),
            instances: scene.instances.len(),
            moving_instances: scene.instances.iter().filter(|instance| instance.dynamic).count(),
            lights: scene.lights.len(),
            load: None,
        }
    }

    /// Whether it is the same scene, ignoring load times.
    pub fn is_same(&self, other: &Self) -> bool {
        Self { load: None, ..self.clone() } == Self { load: None, ..other.clone() }
    }
}

/// One method with one setting of one scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Run {
    /// Name of the scene.
    pub scene: String,
    /// What lights its pictures.
    pub method: Method,
    /// The settings.
    pub settings: Settings,
    /// Warm-up frames.
    pub warm_up: u32,
    /// Its measurements.
    pub rounds: Vec<Round>,
    /// Errors against the path tracer's pictures, with `--quality`.
    pub quality: Option<Quality>,
}

/// One measurement of a setting.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Round {
    /// Frame by frame.
    pub samples: Samples,
    /// Peak memory of the program, bytes; none if the system does not report it.
    pub cpu_peak: Option<u64>,
    /// Peak device memory, bytes.
    pub device_peak: u64,
}

impl Run {
    /// Whether it measures the same as `other`.
    pub fn is_same(&self, other: &Self) -> bool {
        self.scene == other.scene && self.method == other.method && self.settings == other.settings
    }

    /// The samples of all rounds together, in the order of [`Samples::quantities`].
    pub fn rounds(&self) -> impl Iterator<Item = &Samples> {
        self.rounds.iter().map(|round| &round.samples)
    }

    /// Peak memory of the program over all rounds, bytes.
    pub fn cpu_peak(&self) -> Option<u64> {
        self.rounds.iter().filter_map(|round| round.cpu_peak).max()
    }

    /// Peak device memory over all rounds, bytes.
    pub fn device_peak(&self) -> u64 {
        self.rounds.iter().map(|round| round.device_peak).max().unwrap_or(0)
    }
}

impl Report {
    /// A report without measurements.
    pub fn new(machine: Machine, plan: Plan, scenes: Vec<SceneFacts>, runs: Vec<Run>) -> Self {
        Self {
            format: FORMAT.to_owned(),
            complete: false,
            machine,
            plan,
            scenes,
            runs,
            pictures: Vec::new(),
            equal_time: Vec::new(),
        }
    }

    /// The runs of a scene.
    pub fn runs_of<'a>(&'a self, scene: &'a str) -> impl Iterator<Item = &'a Run> {
        self.runs.iter().filter(move |run| run.scene == scene)
    }

    /// What has several values: the method, and settings that differ between runs of one method.
    pub fn varied(&self) -> Vec<Axis> {
        let differ = |axis: Axis, a: &Run, b: &Run| {
            let is_alike = a.scene == b.scene && (axis == Axis::Method || a.method == b.method);
            is_alike && axis.text(a) != axis.text(b)
        };
        let several = |axis: &Axis| self.runs.iter().any(|a| self.runs.iter().any(|b| differ(*axis, a, b)));
        Axis::ALL.into_iter().filter(several).collect()
    }

    /// The representative number of temporal sets for charts and pictures: 16, or else the most.
    pub fn shown_sets(&self) -> u32 {
        let sets = || self.runs.iter().map(|run| run.settings.vpl.temporal_sets);
        if sets().any(|sets| sets == 16) { 16 } else { sets().max().unwrap_or(1) }
    }

    /// Whether the content is consistent; validates untrusted files.
    pub fn is_sound(&self) -> bool {
        let frames = self.plan.frames as usize;
        let whole = |run: &Run| {
            run.rounds.len() <= self.plan.rounds as usize
                && run.rounds().all(|samples| samples.is_whole(frames))
        };
        let known = |run: &Run| self.scenes.iter().any(|scene| scene.name == run.scene);
        let done = |run: &Run| !self.complete || run.rounds.len() == self.plan.rounds as usize;
        frames > 0
            && self.plan.rounds > 0
            && self
                .runs
                .iter()
                .all(|run| whole(run) && known(run) && done(run) && run.settings.check().is_ok())
    }
}

impl Serialize for Report {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        /// A run with its statistics.
        #[derive(Serialize)]
        struct Summarised<'a> {
            #[serde(flatten)]
            run: &'a Run,
            summary: Option<Summary>,
        }
        let noise = Noise::of(&self.runs);
        let summarised = |run| Summarised { run, summary: Summary::of(run, &noise) };
        let runs: Vec<_> = self.runs.iter().map(summarised).collect();
        let load = |get: fn(&LoadTimes) -> f64| -> f64 {
            self.scenes.iter().filter_map(|scene| scene.load.as_ref()).map(get).sum()
        };
        let mut fields = serializer.serialize_struct("Report", 11)?;
        fields.serialize_field("format", &self.format)?;
        fields.serialize_field("complete", &self.complete)?;
        fields.serialize_field("machine", &self.machine)?;
        fields.serialize_field("plan", &self.plan)?;
        fields.serialize_field("load_ms", &load(|times| times.load_ms))?;
        fields.serialize_field("bvh_ms", &load(|times| times.bvh_ms))?;
        fields.serialize_field("scenes", &self.scenes)?;
        fields.serialize_field("noise", &noise)?;
        fields.serialize_field("runs", &runs)?;
        fields.serialize_field("pictures", &self.pictures)?;
        fields.serialize_field("equal_time", &self.equal_time)?;
        fields.end()
    }
}
