//! What was measured, frame by frame, and the JSON report of `render`.

use std::collections::BTreeMap;

use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::passes::tracer::RayTracer;
use crate::settings::Settings;
use crate::statistics::percentile;
use crate::vpl::{InvalidatedBy, InvalidationReason, VplCounters};
use crate::vulkan::DeviceInfo;

/// The passes of a frame, in order: the names of timers, labels and report keys, and of the GPU passes'
/// files and shaders.
pub const PASS_NAMES: [&str; 10] = [
    "bvh_update",
    "vpl_invalidation",
    "vpl_replacement",
    "gbuffer",
    "direct_shadows",
    "direct_shading",
    "indirect_shadows",
    "indirect_shading",
    "indirect_reprojection",
    "combine",
];

/// The colour of each pass in plots, sRGB: reds on the CPU, yellow to green for direct light, blues for indirect.
pub const PASS_COLOURS: [[u8; 3]; PASS_NAMES.len()] = [
    [140, 86, 75],
    [214, 95, 95],
    [242, 142, 43],
    [237, 201, 72],
    [182, 153, 45],
    [89, 161, 79],
    [31, 111, 180],
    [98, 182, 222],
    [148, 103, 189],
    [227, 119, 194],
];

/// The commit that the program was built from, or `unknown` outside a git checkout.
pub const COMMIT: &str = match option_env!("GLOWWORM_COMMIT") {
    Some(commit) => commit,
    None => "unknown",
};

/// One thing for each pass, in the order of [`PASS_NAMES`]; written as a map from name to thing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PerPass<Thing>(pub [Thing; PASS_NAMES.len()]);

/// Milliseconds of each pass.
pub type PassTimes = PerPass<f64>;

impl<Thing: Serialize> Serialize for PerPass<Thing> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(PASS_NAMES.iter().zip(&self.0))
    }
}

impl<'de, Thing: Deserialize<'de>> Deserialize<'de> for PerPass<Thing> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let mut map = BTreeMap::<String, Thing>::deserialize(deserializer)?;
        let take = |name| map.remove(name).ok_or_else(|| D::Error::missing_field(name));
        let things = PASS_NAMES.into_iter().map(take).collect::<Result<Vec<_>, _>>()?;
        things.try_into().map(Self).map_err(|_| D::Error::custom("not one for each pass"))
    }
}

/// What was measured of one frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct FrameFigures {
    /// The sum of all passes, CPU and GPU, milliseconds. Frames overlap, so they may follow one another faster.
    pub total_ms: f64,
    /// Each pass.
    pub passes: PassTimes,
    /// The VPLs.
    pub vpls: VplCounters,
    /// Occlusion rays cast by the shaders.
    pub shadow_rays: u64,
}

/// One frame with its figures.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct FrameReport {
    /// Number of the frame, from 0.
    pub frame: u64,
    /// What was measured.
    #[serde(flatten)]
    pub figures: FrameFigures,
}

/// The figures of a run, each taken over all frames by itself.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
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

/// Occlusion rays a second, of each tracer.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TracerRates {
    /// Of the software tracer.
    pub software: f64,
    /// Of the hardware tracer; 0 where its answers are wrong.
    pub hardware: f64,
}

impl TracerRates {
    /// The faster tracer.
    pub fn faster(&self) -> RayTracer {
        if self.hardware > self.software { RayTracer::Hardware } else { RayTracer::Software }
    }
}

impl std::fmt::Display for TracerRates {
    fn fmt(&self, text: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [software, hardware] = [self.software, self.hardware].map(|rate| rate * 1e-6);
        let auto = match self.faster() {
            RayTracer::Software => "software",
            RayTracer::Hardware => "hardware",
        };
        write!(text, "software {software:.2}, hardware {hardware:.2} million rays a second: auto is {auto}")
    }
}

/// The tracer in use.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct TracerChoice {
    /// The tracer.
    pub used: RayTracer,
    /// What was measured on the device, now or earlier, if that decided.
    pub rays_per_second: Option<TracerRates>,
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
    /// The ray tracer that was used.
    pub tracer: TracerChoice,
    /// The settings that were used.
    pub settings: Settings,
    /// See [`COMMIT`].
    pub commit: &'static str,
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
        tracer: TracerChoice,
        settings: &Settings,
        frames: Vec<FrameReport>,
    ) -> Self {
        Self {
            scene: scene.to_owned(),
            device: device.name.clone(),
            driver: device.driver.clone(),
            tracer,
            settings: settings.clone(),
            commit: COMMIT,
            summary: Summary::of(&frames),
            frames,
        }
    }

    /// The run in one line.
    pub fn headline(&self) -> String {
        let median_ms = self.summary.map_or(0.0, |summary| summary.median.total_ms);
        let frames = self.frames.len();
        format!("{frames} frames of {} on {}, {median_ms:.1} ms a frame (median)", self.scene, self.device)
    }
}

fn figures_at(frames: &[FrameReport], quantile: f64) -> Option<FrameFigures> {
    let figure =
        |get: fn(&FrameFigures) -> f64| percentile(frames.iter().map(|frame| get(&frame.figures)), quantile);
    let count =
        |get: fn(&FrameFigures) -> u32| percentile(frames.iter().map(|frame| get(&frame.figures)), quantile);
    let mut passes = PassTimes::default();
    for (pass, milliseconds) in passes.0.iter_mut().enumerate() {
        *milliseconds = percentile(frames.iter().map(|frame| frame.figures.passes.0[pass]), quantile)?;
    }
    Some(FrameFigures {
        total_ms: figure(|frame| frame.total_ms)?,
        passes,
        vpls: VplCounters {
            slots: count(|frame| frame.vpls.slots)?,
            valid: count(|frame| frame.vpls.valid)?,
            escaped: count(|frame| frame.vpls.escaped)?,
            stale: count(|frame| frame.vpls.stale)?,
            invalidated: count(|frame| frame.vpls.invalidated)?,
            invalidated_by: invalidated_by_at(frames, quantile)?,
            shot: count(|frame| frame.vpls.shot)?,
        },
        shadow_rays: percentile(frames.iter().map(|frame| frame.figures.shadow_rays), quantile)?,
    })
}

fn invalidated_by_at(frames: &[FrameReport], quantile: f64) -> Option<InvalidatedBy> {
    let mut counts = InvalidatedBy::default();
    for reason in InvalidationReason::ALL {
        let of_frames = frames.iter().map(|frame| frame.figures.vpls.invalidated_by.count(reason));
        *counts.count_mut(reason) = percentile(of_frames, quantile)?;
    }
    Some(counts)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(number: u64) -> FrameReport {
        let mut passes = PassTimes::default();
        for (pass, milliseconds) in passes.0.iter_mut().enumerate() {
            *milliseconds = (number * 10 + pass as u64) as f64;
        }
        FrameReport {
            frame: number,
            figures: FrameFigures {
                total_ms: number as f64 + 0.5,
                passes,
                vpls: VplCounters {
                    slots: 512,
                    valid: 500,
                    escaped: 12,
                    shot: number as u32,
                    ..VplCounters::default()
                },
                shadow_rays: 1000 - number,
            },
        }
    }

    #[test]
    fn a_summary_takes_every_figure_by_itself() {
        let frames: Vec<_> = (0..3).map(frame).collect();
        let summary = Summary::of(&frames).unwrap();
        assert_eq!(summary.median.total_ms, 1.5);
        assert_eq!(summary.median.passes.0[9], 19.0);
        assert_eq!((summary.median.shadow_rays, summary.p95.shadow_rays), (999, 1000));
        assert_eq!((summary.p95.vpls.shot, summary.p95.vpls.slots), (2, 512));
        assert_eq!(Summary::of(&[]), None);
    }

    #[test]
    fn the_faster_tracer_is_chosen() {
        let rates = |software, hardware| TracerRates { software, hardware };
        assert_eq!(rates(2.0, 1.0).faster(), RayTracer::Software);
        assert_eq!(rates(1.0, 2.0).faster(), RayTracer::Hardware);
    }

    #[test]
    fn the_report_has_the_keys_of_the_design() {
        let frames: Vec<_> = (0..2).map(frame).collect();
        let device = DeviceInfo { name: "some device".to_owned(), ..DeviceInfo::default() };
        let rates = TracerRates { software: 2.5, hardware: 1.0 };
        let tracer = TracerChoice { used: rates.faster(), rays_per_second: Some(rates) };
        let report = RenderReport::new("cornell-box", &device, tracer, &Settings::default(), frames);
        assert_eq!(report.headline(), "2 frames of cornell-box on some device, 0.5 ms a frame (median)");
        let json = serde_json::to_value(&report).unwrap();
        let keys = |value: &serde_json::Value| -> Vec<String> {
            value.as_object().unwrap().keys().cloned().collect()
        };
        let sorted = |mut names: Vec<&str>| {
            names.sort_unstable();
            names.into_iter().map(str::to_owned).collect::<Vec<_>>()
        };
        let top = vec!["scene", "device", "driver", "tracer", "settings", "commit", "frames", "summary"];
        assert_eq!(keys(&json), sorted(top));
        let figures = vec!["total_ms", "passes", "vpls", "shadow_rays"];
        let counts = vec!["slots", "valid", "escaped", "stale", "invalidated", "invalidated_by", "shot"];
        let first = &json["frames"][0];
        assert_eq!(keys(first), sorted([figures.clone(), vec!["frame"]].concat()));
        for part in [first, &json["summary"]["median"], &json["summary"]["p95"]] {
            assert_eq!(keys(&part["passes"]), sorted(PASS_NAMES.to_vec()));
            assert_eq!(keys(&part["vpls"]), sorted(counts.clone()));
        }
        assert_eq!(keys(&json["summary"]["p95"]), sorted(figures));
        assert_eq!(json["settings"]["exposure"], "auto");
        assert_eq!(json["tracer"]["used"], "software");
        assert_eq!(json["tracer"]["rays_per_second"]["hardware"], 1.0);
    }
}
