//! Everything that a benchmark found, as it is written to `bench.json` and read back from it.

use serde::ser::SerializeStruct;
use serde::{Deserialize, Serialize, Serializer};

use super::machine::Machine;
use super::pictures::PictureEntry;
use super::plan::{Axis, Plan};
use super::quality::Quality;
use super::samples::Samples;
use super::summary::{Noise, Summary};
use crate::scene::Scene;
use crate::settings::Settings;

/// What kind of file it is.
pub const FORMAT: &str = "glowworm bench 1";

/// A whole benchmark.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct Report {
    /// [`FORMAT`].
    pub format: String,
    /// Whether everything that was planned has been measured.
    pub complete: bool,
    /// What it was measured on.
    pub machine: Machine,
    /// What was asked for.
    pub plan: Plan,
    /// The scenes, in order.
    pub scenes: Vec<SceneFacts>,
    /// Every setting of every scene, in order.
    pub runs: Vec<Run>,
    /// Pictures, in files beside this one.
    pub pictures: Vec<PictureEntry>,
}

/// What a scene consists of.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SceneFacts {
    /// Its name.
    pub name: String,
    /// Triangles of all instances.
    pub triangles: usize,
    /// Placed meshes.
    pub instances: usize,
    /// Those that may move.
    pub moving_instances: usize,
    /// Lights.
    pub lights: usize,
}

impl SceneFacts {
    /// Of `scene`.
    pub fn of(scene: &Scene) -> Self {
        Self {
            name: scene.name.clone(),
            triangles: scene.triangle_count(),
            instances: scene.instances.len(),
            moving_instances: scene.instances.iter().filter(|instance| instance.dynamic).count(),
            lights: scene.lights.len(),
        }
    }
}

/// One setting of one scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Run {
    /// Name of the scene.
    pub scene: String,
    /// The settings.
    pub settings: Settings,
    /// Frames before the measured ones.
    pub warm_up: u32,
    /// What was measured each time.
    pub rounds: Vec<Round>,
    /// How far the pictures are from converged ones, if that was asked for.
    pub quality: Option<Quality>,
}

/// One measurement of a setting.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Round {
    /// Frame by frame.
    pub samples: Samples,
    /// The most memory that the program held at once, bytes; none where the system does not tell.
    pub cpu_peak: Option<u64>,
    /// The most memory of the device in use at once, bytes.
    pub device_peak: u64,
}

impl Run {
    /// The samples of all rounds together, in the order of [`Samples::quantities`].
    pub fn rounds(&self) -> impl Iterator<Item = &Samples> {
        self.rounds.iter().map(|round| &round.samples)
    }

    /// The most memory of the program in any round, bytes.
    pub fn cpu_peak(&self) -> Option<u64> {
        self.rounds.iter().filter_map(|round| round.cpu_peak).max()
    }

    /// The most memory of the device in any round, bytes.
    pub fn device_peak(&self) -> u64 {
        self.rounds.iter().map(|round| round.device_peak).max().unwrap_or(0)
    }
}

impl Report {
    /// A report of nothing yet.
    pub fn new(machine: Machine, plan: Plan, scenes: Vec<SceneFacts>, runs: Vec<Run>) -> Self {
        Self { format: FORMAT.to_owned(), complete: false, machine, plan, scenes, runs, pictures: Vec::new() }
    }

    /// The runs of a scene.
    pub fn runs_of<'a>(&'a self, scene: &'a str) -> impl Iterator<Item = &'a Run> {
        self.runs.iter().filter(move |run| run.scene == scene)
    }

    /// The settings of which there are several values.
    pub fn varied(&self) -> Vec<Axis> {
        let several = |axis: &Axis| {
            let text = |run: &Run| axis.text(&run.settings);
            self.scenes.iter().any(|scene| {
                let mut runs = self.runs_of(&scene.name).map(text);
                let first = runs.next();
                runs.any(|other| Some(other) != first)
            })
        };
        Axis::ALL.into_iter().filter(several).collect()
    }

    /// The number of temporal sets that is shown where one must stand for all: 16, or else the most.
    pub fn shown_sets(&self) -> u32 {
        let sets = || self.runs.iter().map(|run| run.settings.temporal_sets);
        if sets().any(|sets| sets == 16) { 16 } else { sets().max().unwrap_or(1) }
    }

    /// Whether the content fits together: what was read may be anybody's.
    pub fn is_sound(&self) -> bool {
        let frames = self.plan.frames as usize;
        let whole = |run: &Run| {
            run.rounds.len() <= self.plan.rounds as usize
                && run.rounds().all(|samples| samples.is_whole(frames))
        };
        let known = |run: &Run| self.scenes.iter().any(|scene| scene.name == run.scene);
        let done = |run: &Run| !self.complete || run.rounds.len() == self.plan.rounds as usize;
        self.runs.iter().all(|run| whole(run) && known(run) && done(run) && run.settings.check().is_ok())
    }
}

impl Serialize for Report {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        /// A run with what follows from it.
        #[derive(Serialize)]
        struct Summarised<'a> {
            #[serde(flatten)]
            run: &'a Run,
            summary: Option<Summary>,
        }
        let noise = Noise::of(&self.runs);
        let summarised = |run| Summarised { run, summary: Summary::of(run, &noise) };
        let runs: Vec<_> = self.runs.iter().map(summarised).collect();
        let mut fields = serializer.serialize_struct("Report", 8)?;
        fields.serialize_field("format", &self.format)?;
        fields.serialize_field("complete", &self.complete)?;
        fields.serialize_field("machine", &self.machine)?;
        fields.serialize_field("plan", &self.plan)?;
        fields.serialize_field("scenes", &self.scenes)?;
        fields.serialize_field("noise", &noise)?;
        fields.serialize_field("runs", &runs)?;
        fields.serialize_field("pictures", &self.pictures)?;
        fields.end()
    }
}
