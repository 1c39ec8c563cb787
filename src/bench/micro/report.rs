//! The report of the micro-benchmarks, and its tables.

use std::collections::BTreeMap;

use serde::Serialize;

use super::super::machine::Machine;
use super::super::report::SceneFacts;
use super::super::tables::{Table, milliseconds};
use super::contender::Query;
use super::rays::RayKind;
use crate::settings::Settings;
use crate::statistics::{Spread, percentile};

/// File format.
pub const MICRO_FORMAT: &str = "glowworm bench micro 1";

/// The whole report.
#[derive(Clone, Debug, Serialize)]
pub struct MicroReport {
    /// [`MICRO_FORMAT`].
    pub format: String,
    /// The machine.
    pub machine: Machine,
    /// Measurements of each quantity.
    pub turns: u32,
    /// Scene by scene.
    pub scenes: Vec<SceneMicro>,
}

/// Results of one scene.
#[derive(Clone, Debug, Serialize)]
pub struct SceneMicro {
    /// The scene.
    pub scene: SceneFacts,
    /// The settings of its frames.
    pub settings: Settings,
    /// Each set of rays with each query.
    pub rays: Vec<RayRun>,
    /// Building, updating and uploading the BVH, then each pass.
    pub times: Vec<TimeRun>,
    /// Measurements that were omitted, and why.
    pub notes: Vec<String>,
}

/// A ray set, cast by all tracers.
#[derive(Clone, Debug, Serialize)]
pub struct RayRun {
    /// Kind of rays.
    pub kind: RayKind,
    /// Query.
    pub query: Query,
    /// Number of rays.
    pub rays: usize,
    /// Fraction of hits.
    pub hit_share: f64,
    /// Results of each tracer.
    pub tracers: Vec<TracerRun>,
}

/// Result of one tracer for a ray set.
#[derive(Clone, Debug, Serialize)]
pub struct TracerRun {
    /// Name.
    pub tracer: String,
    /// Million rays per second, by turn.
    pub rates: Vec<f64>,
    /// Spread of the rates.
    pub spread: Spread,
    /// Speed relative to each other tracer: median over the turns.
    pub over: BTreeMap<String, f64>,
    /// Results that differ from those of the first tracer.
    pub differing: usize,
}

/// Times of one operation.
#[derive(Clone, Debug, Serialize)]
pub struct TimeRun {
    /// The operation.
    pub what: String,
    /// Times in ms, by turn.
    pub ms: Vec<f64>,
    /// Spread of the times.
    pub spread: Spread,
}

impl TimeRun {
    /// From at least one measurement.
    pub(super) fn new(what: impl Into<String>, ms: Vec<f64>) -> Self {
        let spread = Spread::of(&ms, false).unwrap_or_default();
        Self { what: what.into(), ms, spread }
    }
}

impl RayRun {
    /// Summarises the tracers `names`: their rates by turn, and the number of differing results.
    pub(super) fn tracers(names: &[String], rates: &[Vec<f64>], differing: &[usize]) -> Vec<TracerRun> {
        let over = |mine: &[f64]| {
            let ratio = |others: &Vec<f64>| {
                let ratios = mine.iter().zip(others).map(|(mine, others)| mine / others);
                percentile(ratios, 0.5).unwrap_or_default()
            };
            names.iter().cloned().zip(rates.iter().map(ratio)).collect::<BTreeMap<_, _>>()
        };
        let tracer = |index: usize| TracerRun {
            tracer: names[index].clone(),
            rates: rates[index].clone(),
            spread: Spread::of(&rates[index], true).unwrap_or_default(),
            over: over(&rates[index]),
            differing: differing[index],
        };
        (0..names.len()).map(tracer).collect()
    }
}

/// All tables, in order.
pub fn micro_tables(report: &MicroReport) -> Vec<Table> {
    let of_scene = |scene| [rays(scene, report.turns), times(scene, report.turns)];
    report.scenes.iter().flat_map(of_scene).filter(|table| !table.rows.is_empty()).collect()
}

/// Formats a rate or ratio.
pub fn short(value: f64) -> String {
    format!("{value:.2}")
}

fn rays(scene: &SceneMicro, turns: u32) -> Table {
    let mut names: Vec<&str> = Vec::new();
    for tracer in scene.rays.iter().flat_map(|run| &run.tracers) {
        if !names.contains(&tracer.tracer.as_str()) {
            names.push(&tracer.tracer);
        }
    }
    let fixed = ["rays", "query", "tracer", "million rays/s", "5 %", "95 %", "differing"];
    let over = names.iter().map(|name| format!("over {name}"));
    let row = |run: &RayRun, tracer: &TracerRun| {
        let Spread { median, p5, p95, .. } = tracer.spread;
        let over = names.iter().map(|name| tracer.over.get(*name).map_or_else(String::new, |&x| short(x)));
        [
            format!("{} ({})", run.kind.name(), run.rays),
            run.query.name().to_owned(),
            tracer.tracer.clone(),
            short(median),
            short(p5),
            short(p95),
            tracer.differing.to_string(),
        ]
        .into_iter()
        .chain(over)
        .collect()
    };
    let note = format!(
        "Median of {turns} turns; `over`: relative speed, median over the turns. `differing`: results that differ from \
         those of the first tracer."
    );
    let rows = scene.rays.iter().flat_map(|run| run.tracers.iter().map(move |tracer| row(run, tracer)));
    let columns = fixed.map(str::to_owned).into_iter().chain(over);
    Table::new(format!("Rays of {}", scene.scene.name), note, columns, rows)
}

fn times(scene: &SceneMicro, turns: u32) -> Table {
    let row = |run: &TimeRun| {
        let Spread { median, p5, p95, .. } = run.spread;
        vec![run.what.clone(), milliseconds(median), milliseconds(p5), milliseconds(p95)]
    };
    let [width, height] = scene.settings.size;
    let note = format!("Median of {turns} turns; passes at {width}x{height}, in frames that do not overlap.");
    let title = format!("Times of {} in ms", scene.scene.name);
    Table::new(title, note, ["what", "ms", "5 %", "95 %"], scene.times.iter().map(row))
}
