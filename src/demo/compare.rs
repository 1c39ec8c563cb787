//! Compare T: the frame rates of temporal sets, and of other methods, on the scene and camera path on screen.
//!
//! In: the session. Out: the report that `glowworm bench --quality --spp 0` makes of the same scene. The window draws a few frames a
//! second meanwhile.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

use serde::Serialize;

use super::action::RequestedSettings;
use super::saving::{Saving, free_name};
use super::session::Session;
use crate::bench::{BackgroundBench, Bench, BenchError, Folder, Noise, Plan, Report, Summary, Sweep};
use crate::estimators;
use crate::formats::SceneDocument;
use crate::settings::Settings;
use crate::vulkan::Device;

/// At least so many measured frames of each, twice.
const FRAMES: u32 = 20;
/// Animation time of a frame on a CPU device, as in `bench`, seconds.
const STEP_ON_CPU: f64 = 1.0 / 20.0;
/// Still frames until a picture is frozen: it has settled soon.
const STILL_FRAMES: u32 = 8;

/// A comparison, in progress or done.
pub(super) struct Comparison {
    document: SceneDocument,
    pub bench: BackgroundBench,
    report: Option<Report>,
    /// A row for each run, once it is done.
    pub rows: Vec<Row>,
}

/// Measurements of a run.
#[derive(Clone, Serialize)]
pub(super) struct Row {
    pub name: String,
    pub settings: Settings,
    /// Median frames per second, and the interval of another run's.
    pub fps: f64,
    pub interval: [f64; 2],
    pub ms: f64,
    /// Mean FLIP error against the first row.
    pub flip: f64,
    /// Frames until the picture stands still after all motion has stopped.
    pub settles: u32,
}

impl Comparison {
    /// Starts to measure the session's scene, as `document` has it, at the size of its picture.
    pub fn start(
        device: &Arc<Device>,
        session: &Session,
        document: SceneDocument,
        assets: Option<PathBuf>,
        requested: RequestedSettings,
    ) -> Self {
        let plan = plan(session, device.is_cpu(), requested);
        let (device, built, mut read) = (Arc::clone(device), document.clone(), session.read.clone());
        let bench = BackgroundBench::start(move || {
            Bench::of_scene(&device, plan, built.build(assets.as_deref(), &mut read)?)
        });
        Self { document, bench, report: None, rows: Vec::new() }
    }

    /// Takes in the runs measured meanwhile; an error ends the comparison.
    pub fn follow(&mut self) -> Result<(), BenchError> {
        if let Some(report) = self.bench.follow()? {
            self.rows = rows(&report);
            self.report = Some(report);
        }
        Ok(())
    }

    /// Writes the report to a new folder, as `bench` does, with the scene beside it.
    pub fn save(&self, name: &str) -> Option<Saving> {
        let (report, document) = (self.report.clone()?, self.document.clone());
        let stem = format!("glowworm-compare-{}", name.replace(['/', '\\'], "-"));
        Some(Saving::of(move || {
            let path = free_name(&stem, "")?;
            let written = Folder::new(&path).and_then(|folder| folder.write(&report));
            written.map_err(|error| error.to_string())?;
            let scene = path.join("scene.toml");
            std::fs::write(&scene, document.text_to_save(&scene)).map_err(|error| error.to_string())?;
            Ok(path.join("report.html"))
        }))
    }
}

/// The plan of `bench` for it.
fn plan(session: &Session, on_cpu: bool, requested: RequestedSettings) -> Plan {
    let size = session.settings.size.map(i64::from).to_vec();
    let step = if on_cpu { STEP_ON_CPU } else { session.settings.time_step };
    let settings = toml::Table::from_iter([
        ("size".to_owned(), size.into()),
        ("time_step".to_owned(), step.into()),
        ("still_frames".to_owned(), i64::from(STILL_FRAMES).into()),
    ]);
    let sets = requested.sets.iter().map(|sets| i64::from(*sets).into()).collect();
    Plan {
        scenes: vec![session.live_scene.name.clone()],
        frames: requested.sets.iter().copied().fold(FRAMES, u32::max),
        rounds: 2,
        quality: true,
        spp: 0,
        sweep: Sweep {
            methods: requested.methods,
            settings: BTreeMap::from([("temporal_sets".to_owned(), sets)]),
        },
        settings,
    }
}

fn rows(report: &Report) -> Vec<Row> {
    let noise = Noise::of(&report.runs);
    let row = |run: &crate::bench::Run| {
        let (summary, quality) = (Summary::of(run, &noise)?, run.quality.as_ref()?);
        let fps = summary.median("fps");
        let states_more = run.method.samples().is_some() || run.method.settings().len() > 1;
        let name = if states_more {
            run.method.to_string()
        } else {
            estimators::method(&run.settings).short_name(&run.settings)
        };
        Some(Row {
            name,
            settings: run.settings.clone(),
            fps,
            interval: summary.figure("fps").and_then(|figure| figure.interval).unwrap_or([fps; 2]),
            ms: summary.median("total"),
            flip: quality.mean(|frame| frame.flip),
            settles: quality.settling_frames,
        })
    };
    report.runs.iter().filter_map(row).collect()
}
