//! The report of a benchmark, as in `bench.json`.

use serde::ser::SerializeStruct;
use serde::{Deserialize, Serialize, Serializer};

use super::axis::Axis;
use super::machine::Machine;
use super::method::Method;
use super::plan::Plan;
use super::run::{FrameQuality, Run};
use super::summary::{Noise, Summary};
use crate::estimators;
use crate::report::LoadTimes;
use crate::scene::Scene;
use crate::settings::Settings;

/// File format.
pub const FORMAT: &str = "glowworm bench 3";

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
    /// Name.
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
    pub fn runs_of<'a>(&'a self, scene: &'a str) -> impl DoubleEndedIterator<Item = &'a Run> {
        self.runs.iter().filter(move |run| run.scene == scene)
    }

    /// The axes with several values: the method, and settings that differ between runs of one method.
    pub fn varied(&self) -> Vec<Axis> {
        let differ = |axis: Axis, a: &Run, b: &Run| {
            let is_alike = a.scene == b.scene && (axis == Axis::Method || a.method == b.method);
            is_alike && axis.text(a) != axis.text(b)
        };
        let several = |axis: &Axis| self.runs.iter().any(|a| self.runs.iter().any(|b| differ(*axis, a, b)));
        Axis::all().into_iter().filter(several).collect()
    }

    /// The representative run of a scene for charts and pictures: the first with the default on the main axis of its method,
    /// or else the one whose pictures take the most frames.
    pub fn shown_run<'a>(&'a self, scene: &'a str) -> Option<&'a Run> {
        let defaults = Settings::default();
        let is_default = |run: &&Run| {
            let axis = estimators::method(&run.settings).axes.first();
            axis.is_none_or(|axis| (axis.get)(&run.settings) == (axis.get)(&defaults))
        };
        let longest = || self.runs_of(scene).rev().max_by_key(|run| run.completes_in());
        self.runs_of(scene).find(is_default).or_else(longest)
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

/// A method at the time of the first one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EqualTime {
    /// Name of the scene.
    pub scene: String,
    /// The method, with its samples chosen.
    pub method: Method,
    /// Name among the runs.
    pub run: Method,
    /// The setting that was chosen, with its value; none where the method has none.
    pub setting: Option<(String, u32)>,
    /// Median frame time, ms.
    pub ms: f64,
    /// Error of the picture.
    pub error: FrameQuality,
}

/// The subject of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum PictureKind {
    /// The first measured frame.
    Beginning,
    /// The last measured frame.
    End,
    /// Stationary camera.
    Static,
    /// Camera turning down.
    Turning,
    /// Camera moving to the right.
    Strafing,
    /// The path tracer's picture of the last measured frame.
    Reference,
    /// A method at equal time, at the last measured frame.
    EqualTime,
    /// FLIP error.
    FlipMap,
}

impl PictureKind {
    /// Pictures of a moving camera, and of the stationary one to compare with.
    pub const ARTEFACTS: [Self; 3] = [Self::Static, Self::Turning, Self::Strafing];

    /// Caption.
    pub fn caption(self) -> &'static str {
        match self {
            Self::Beginning => "beginning",
            Self::End => "end",
            Self::Static => "stationary",
            Self::Turning => "turning down",
            Self::Strafing => "strafing right",
            Self::Reference => "path tracer",
            Self::EqualTime => "at equal time",
            Self::FlipMap => "FLIP error",
        }
    }
}

/// A picture of the report.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PictureEntry {
    /// Name of the scene.
    pub scene: String,
    /// Subject.
    pub kind: PictureKind,
    /// The method among the runs; none where it does not matter.
    pub method: Option<Method>,
    /// The short name of what rendered it, such as `vpls@T=16`.
    pub rendered_by: String,
    /// Name in the folder of pictures.
    pub file: String,
}

impl PictureEntry {
    /// The entry for number `index` of the scenes, whose name may not suit a file.
    pub fn new(index: usize, scene: &str, kind: PictureKind, settings: &Settings) -> Self {
        let rendered_by = estimators::method(settings).short_name(settings);
        let file = format!("{}-{}-{}.png", index + 1, plain(scene), plain(kind.caption()));
        Self { scene: scene.to_owned(), kind, method: None, rendered_by, file }
    }

    /// The entry for a method among several.
    pub fn of(self, method: &Method) -> Self {
        let file = format!("{}-{}.png", self.file.trim_end_matches(".png"), plain(method.name()));
        Self { method: Some(method.clone()), file, ..self }
    }

    /// Whether [`Self::new`] could have named its file; validates untrusted reports.
    pub fn is_sound(&self) -> bool {
        let plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.');
        self.file.chars().all(plain) && self.file.ends_with(".png") && !self.file.starts_with('.')
    }
}

/// With a `_` for what may not suit a file.
fn plain(name: &str) -> String {
    name.chars().map(|c| if c.is_ascii_alphanumeric() || c == '-' { c } else { '_' }).collect()
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
