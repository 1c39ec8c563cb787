//! Compare T: the frame rates of temporal sets, and of other methods, on the scene and camera path on screen.
//!
//! In: the session. Out: the report that `glowworm bench --quality --spp 0` makes of the same scene. The window draws a few frames a
//! second meanwhile.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use serde::Serialize;

use super::app::Open;
use super::screenshot::{Saving, free_name};
use super::session::Session;
use crate::bench::{BackgroundBench, Bench, BenchError, Folder, Method, Noise, Plan, Report, Summary, Sweep};
use crate::estimators;
use crate::formats::SceneDocument;
use crate::settings::Settings;
use crate::vulkan::Device;

/// Time after which the window asks again whether it is its turn.
pub(super) const POLL: Duration = Duration::from_millis(10);
/// At least so many measured frames of each, twice.
const FRAMES: u32 = 20;
/// Animation time of a frame on a CPU device, as in `bench`, seconds.
const STEP_ON_CPU: f64 = 1.0 / 20.0;
/// Still frames until a picture is frozen: it has settled soon.
const STILL_FRAMES: u32 = 8;

/// What to measure.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Wanted {
    /// Numbers of temporal sets, for the methods that have any.
    pub sets: Vec<u32>,
    /// Methods by their short names; the first one with the first number is what all pictures are compared with.
    pub methods: Vec<Method>,
}

/// A comparison, in progress or done.
pub(super) struct Comparison {
    document: SceneDocument,
    pub bench: BackgroundBench,
    report: Option<Report>,
    /// A row for each run, once it is done.
    pub rows: Vec<Row>,
}

/// What was measured of a run.
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
        wanted: Wanted,
    ) -> Self {
        let plan = plan(session, device.is_cpu(), wanted);
        let (device, built, mut read) = (Arc::clone(device), document.clone(), session.read.clone());
        let bench = BackgroundBench::start(move || {
            Bench::of_scene(&device, plan, built.build(assets.as_deref(), &mut read)?)
        });
        Self { document, bench, report: None, rows: Vec::new() }
    }

    pub fn is_running(&self) -> bool {
        self.bench.is_running()
    }

    /// Takes in what was measured meanwhile; an error ends the comparison.
    pub fn follow(&mut self) -> Result<(), BenchError> {
        if let Some(report) = self.bench.follow()? {
            self.rows = rows(&report);
            self.report = Some(report);
        }
        Ok(())
    }

    /// Writes the report to a new folder, as `bench` does, with the scene beside it.
    fn save(&self, name: &str) -> Option<Saving> {
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

impl Open {
    /// Begins a comparison of what is on screen, or ends it.
    pub(super) fn compare(&mut self, wanted: Option<Wanted>, assets: Option<PathBuf>) {
        self.comparison = None;
        let (Some(session), Some(wanted)) = (&self.session, wanted) else { return };
        let camera = self.flight.has_moved().then_some(&session.pose.camera);
        let document = session.document_to_save(camera);
        self.comparison = Some(Comparison::start(&self.gpu.device, session, document, assets, wanted));
    }

    /// Begins a comparison of what the panel says, or ends it.
    pub(super) fn toggle_compare(&mut self, assets: Option<PathBuf>) {
        let Some(session) = self.session.as_ref().filter(|_| self.comparison.is_none()) else {
            self.comparison = None;
            return;
        };
        match self.panel.compare.wanted(&session.settings) {
            Ok(wanted) => self.compare(Some(wanted), assets),
            Err(error) => self.panel.error = Some(error),
        }
    }

    /// Whether frames are being measured, so that the window is to leave the machine alone.
    pub(super) fn is_measuring(&self) -> bool {
        self.comparison.as_ref().is_some_and(Comparison::is_running)
    }

    /// Takes in what was measured meanwhile; the rows of a comparison that is done, once.
    pub(super) fn follow_comparison(&mut self) -> Option<Vec<Row>> {
        let comparison = self.comparison.as_mut().filter(|comparison| comparison.is_running())?;
        if let Err(error) = comparison.follow() {
            self.panel.error = Some(error.to_string());
            self.comparison = None;
            return None;
        }
        (!comparison.is_running()).then(|| comparison.rows.clone())
    }

    /// Writes the report of the comparison to a new folder.
    pub(super) fn save_comparison(&mut self) {
        if let (Some(comparison), Some(session)) = (&self.comparison, &self.session) {
            self.saving.extend(comparison.save(&session.live_scene.name));
        }
    }
}

/// The plan of `bench` for it.
fn plan(session: &Session, on_cpu: bool, wanted: Wanted) -> Plan {
    let size = session.settings.size.map(i64::from).to_vec();
    let step = if on_cpu { STEP_ON_CPU } else { session.settings.time_step };
    let settings = toml::Table::from_iter([
        ("size".to_owned(), size.into()),
        ("time_step".to_owned(), step.into()),
        ("still_frames".to_owned(), i64::from(STILL_FRAMES).into()),
    ]);
    let sets = wanted.sets.iter().map(|sets| i64::from(*sets).into()).collect();
    Plan {
        scenes: vec![session.live_scene.name.clone()],
        frames: wanted.sets.iter().copied().fold(FRAMES, u32::max),
        rounds: 2,
        quality: true,
        spp: 0,
        sweep: Sweep {
            methods: wanted.methods,
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
