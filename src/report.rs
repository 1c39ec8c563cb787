//! The measurements of frames, and the JSON report of `render`.

use indexmap::IndexMap;
use serde::{Deserialize, Serialize, Serializer};

use crate::settings::{Direct, Settings};
use crate::statistics::percentile;
use crate::vulkan::DeviceInfo;

/// A row among the times of a frame: a pass, whose name is that of its timer, label and shader, or a stage of several passes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PassInfo {
    /// Name.
    pub name: &'static str,
    /// Colour in plots, sRGB.
    pub colour: [u8; 3],
    /// The stage that it is a part of, whose time is the sum of its parts and which stands before them.
    pub stage: Option<&'static str>,
}

impl PassInfo {
    /// A pass by itself, or a stage.
    pub const fn new(name: &'static str, colour: [u8; 3]) -> Self {
        Self { name, colour, stage: None }
    }

    /// A pass that is a part of a stage.
    pub const fn part(stage: &'static str, name: &'static str, colour: [u8; 3]) -> Self {
        Self { name, colour, stage: Some(stage) }
    }
}

/// The commit that the program was built from, or `unknown` outside a git checkout.
pub const COMMIT: &str = match option_env!("GLOWWORM_COMMIT") {
    Some(commit) => commit,
    None => "unknown",
};

/// Milliseconds of each pass and stage, in the order of the frame.
pub type PassTimes = IndexMap<&'static str, f64>;

/// The counts of a method in a frame, by name. Dots nest: `vpls.valid` is the key `valid` of the object `vpls` in JSON.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Counters(pub IndexMap<&'static str, u64>);

impl Counters {
    /// Sets a counter.
    pub fn insert(&mut self, name: &'static str, count: u64) {
        self.0.insert(name, count);
    }

    /// A counter; 0 where there is none of that name.
    pub fn get(&self, name: &str) -> u64 {
        self.0.get(name).copied().unwrap_or(0)
    }
}

impl Serialize for Counters {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        nested(self.0.iter().map(|(name, count)| (*name, *count))).serialize(serializer)
    }
}

/// Values under their names, where dots nest.
pub(crate) fn nested<Value: Into<serde_json::Value>>(
    values: impl IntoIterator<Item = (&'static str, Value)>,
) -> serde_json::Map<String, serde_json::Value> {
    let mut root = serde_json::Map::new();
    for (name, value) in values {
        let (folders, last) = name.rsplit_once('.').unwrap_or(("", name));
        let mut place = &mut root;
        for folder in folders.split('.').filter(|folder| !folder.is_empty()) {
            let object = place.entry(folder).or_insert_with(|| serde_json::Map::new().into());
            let serde_json::Value::Object(object) = object else { unreachable!("{name} lies in a number") };
            place = object;
        }
        place.insert(last.to_owned(), value.into());
    }
    root
}

/// The measurements of one frame.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct FrameFigures {
    /// The sum of all passes, CPU and GPU, milliseconds. Frames overlap, so they may follow one another faster.
    pub total_ms: f64,
    /// Each pass.
    pub passes: PassTimes,
    /// The counts of the method.
    #[serde(flatten)]
    pub counters: Counters,
}

/// One frame with its figures.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct FrameReport {
    /// Number of the frame, from 0.
    pub frame: u64,
    /// Frames in which nothing has changed whose mean the picture goes over to, with this one; 0 while anything changes.
    pub still: u32,
    /// Measurements.
    #[serde(flatten)]
    pub figures: FrameFigures,
}

/// The figures of a run, each taken over all frames by itself.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Summary {
    /// Half of the frames stayed at or below.
    pub median: FrameFigures,
    /// 95 % of the frames stayed at or below.
    pub p95: FrameFigures,
}

impl Summary {
    /// Sums up `frames`; none if there are none.
    pub fn of(frames: &[FrameReport]) -> Option<Self> {
        Some(Self { median: figures_at(frames, 0.5)?, p95: figures_at(frames, 0.95)? })
    }
}

/// The tracer of the shaders' rays.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum RayTracer {
    /// The two-level BVH in storage buffers: every device.
    Software,
    /// Ray queries: devices that offer them.
    Hardware,
}

/// Values chosen for the settings that leave a choice. Flat in reports.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Resolved {
    /// The ray tracer.
    pub tracer: RayTracer,
    /// The shadows of direct light.
    pub direct: Direct,
}

/// How long a scene took until it was ready to be rendered. Flat in reports.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LoadTimes {
    /// Loading it, milliseconds: files, models, textures.
    pub load_ms: f64,
    /// Building its BVH, milliseconds.
    pub bvh_ms: f64,
}

/// The report of a run of `render`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RenderReport {
    /// Name of the scene.
    pub scene: String,
    /// Name of the device.
    pub device: String,
    /// Name and version of its driver.
    pub driver: String,
    /// The values in use.
    #[serde(flatten)]
    pub resolved: Resolved,
    /// The settings as they were given.
    pub settings: Settings,
    /// See [`COMMIT`].
    pub commit: &'static str,
    /// Times before the first frame.
    #[serde(flatten)]
    pub load: LoadTimes,
    /// Most device memory in use at once, bytes.
    pub device_memory: u64,
    /// Time from one frame to the next, median over those after the first two, milliseconds; none if there are none.
    pub interval_ms: Option<f64>,
    /// Every frame, in order.
    pub frames: Vec<FrameReport>,
    /// Median and 95th percentile; none if there are no frames.
    pub summary: Option<Summary>,
}

impl RenderReport {
    /// The report of `frames`, rendered on `device`.
    pub fn new(
        scene: &str,
        device: &DeviceInfo,
        resolved: Resolved,
        settings: &Settings,
        load: LoadTimes,
        frames: Vec<FrameReport>,
    ) -> Self {
        Self {
            scene: scene.to_owned(),
            device: device.name.clone(),
            driver: device.driver.clone(),
            resolved,
            settings: settings.clone(),
            commit: COMMIT,
            load,
            device_memory: 0,
            interval_ms: None,
            summary: Summary::of(&frames),
            frames,
        }
    }

    /// This report with the most device memory in use at once, bytes.
    #[must_use]
    pub fn with_device_memory(self, device_memory: u64) -> Self {
        Self { device_memory, ..self }
    }

    /// This report with the time from one frame to the next.
    #[must_use]
    pub fn with_interval(self, interval_ms: Option<f64>) -> Self {
        Self { interval_ms, ..self }
    }

    /// The run in one line.
    pub fn headline(&self) -> String {
        let median_ms = self.summary.as_ref().map_or(0.0, |summary| summary.median.total_ms);
        let frames = self.frames.len();
        format!("{frames} frames of {} on {}, {median_ms:.1} ms a frame (median)", self.scene, self.device)
    }
}

fn figures_at(frames: &[FrameReport], quantile: f64) -> Option<FrameFigures> {
    let first = &frames.first()?.figures;
    let figures = || frames.iter().map(|frame| &frame.figures);
    let pass = |name: &&'static str| {
        let times = figures().filter_map(|figures| figures.passes.get(name).copied());
        Some((*name, percentile(times, quantile)?))
    };
    let counter = |name: &&'static str| {
        Some((*name, percentile(figures().map(|figures| figures.counters.get(name)), quantile)?))
    };
    Some(FrameFigures {
        total_ms: percentile(figures().map(|figures| figures.total_ms), quantile)?,
        passes: first.passes.keys().filter_map(pass).collect(),
        counters: Counters(first.counters.0.keys().filter_map(counter).collect()),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(number: u64) -> FrameReport {
        let names = ["gbuffer", "combine"];
        let passes = names.into_iter().zip(0..).map(|(name, pass)| (name, (number * 10 + pass) as f64));
        let counters = [("vpls.slots", 512), ("vpls.shot", number), ("shadow_rays", 1000 - number)];
        FrameReport {
            frame: number,
            still: 0,
            figures: FrameFigures {
                total_ms: number as f64 + 0.5,
                passes: passes.collect(),
                counters: Counters(counters.into_iter().collect()),
            },
        }
    }

    #[test]
    fn a_summary_takes_every_figure_by_itself() {
        let frames: Vec<_> = (0..3).map(frame).collect();
        let Summary { median, p95 } = Summary::of(&frames).unwrap();
        assert_eq!(median.total_ms, 1.5);
        assert_eq!(median.passes["combine"], 11.0);
        assert_eq!((median.counters.get("shadow_rays"), p95.counters.get("shadow_rays")), (999, 1000));
        assert_eq!((p95.counters.get("vpls.shot"), p95.counters.get("vpls.slots")), (2, 512));
        assert_eq!(Summary::of(&[]), None);
    }

    #[test]
    fn the_report_has_the_keys_of_the_design() {
        let frames: Vec<_> = (0..2).map(frame).collect();
        let device = DeviceInfo { name: "some device".to_owned(), ..DeviceInfo::default() };
        let load = LoadTimes { load_ms: 12.0, bvh_ms: 3.0 };
        let resolved = Resolved { tracer: RayTracer::Software, direct: Direct::Soft };
        let report = RenderReport::new("cornell-box", &device, resolved, &Settings::default(), load, frames);
        assert_eq!(report.headline(), "2 frames of cornell-box on some device, 0.5 ms a frame (median)");
        let json = serde_json::to_value(&report).unwrap();
        let keys = |value: &serde_json::Value| -> Vec<String> {
            value.as_object().unwrap().keys().cloned().collect()
        };
        let sorted = |mut names: Vec<&str>| {
            names.sort_unstable();
            names.into_iter().map(str::to_owned).collect::<Vec<_>>()
        };
        let top =
            vec!["scene", "device", "driver", "tracer", "direct", "settings", "commit", "frames", "summary"];
        assert_eq!(
            keys(&json),
            sorted([top, vec!["load_ms", "bvh_ms", "device_memory", "interval_ms"]].concat())
        );
        assert_eq!((&json["load_ms"], &json["bvh_ms"]), (&12.0.into(), &3.0.into()));
        let figures = vec!["total_ms", "passes", "vpls", "shadow_rays"];
        let first = &json["frames"][0];
        assert_eq!(keys(first), sorted([figures.clone(), vec!["frame", "still"]].concat()));
        for part in [first, &json["summary"]["median"], &json["summary"]["p95"]] {
            assert_eq!(keys(&part["passes"]), sorted(vec!["gbuffer", "combine"]));
            assert_eq!(keys(&part["vpls"]), sorted(vec!["slots", "shot"]));
        }
        assert_eq!(keys(&json["summary"]["p95"]), sorted(figures));
        assert_eq!(json["settings"]["exposure"], "auto");
        assert_eq!(json["tracer"], "software");
        assert_eq!((&json["direct"], &json["settings"]["direct"]), (&"soft".into(), &"auto".into()));
    }
}
