//! The tour: stops of ten seconds, each of which shows one idea, with a caption.

use std::f32::consts::TAU;
use std::path::PathBuf;

use glam::{Quat, Vec3};
use image::{Rgb, RgbImage};

use super::action::{Action, Actions, AppAction, EditAction, RequestedSettings, RightSide, ViewAction};
use super::compare::Comparison;
use super::error::DemoError;
use super::live_metrics::Shot;
use super::session::Session;
use super::split::{Right, Split};
use super::undo::Undo;
use crate::estimators::vpls::{PathStyle, VplDebugView};
use crate::output::OutputFile;
use crate::renderer::DebugView;
use crate::report::FrameReport;
use crate::scene::Camera;
use crate::settings::{Denoise, EffectSettings, Indirect, PathFilter, Settings, VplSettings};

/// Length of a stop, seconds.
const STOP: f64 = 10.0;
/// Longest step, seconds: what waits for the device misses no act.
const LONGEST_STEP: f64 = 1.0;
/// Numbers of temporal sets that are measured.
const FEW_SETS: [u32; 3] = [1, 4, 16];
/// VPLs whose paths are shown.
const FEW: u32 = 128;
/// Pictures of the contact sheet beside each other.
const COLUMNS: usize = 4;

/// A stop.
struct Stop {
    caption: &'static str,
    /// Acts, and when they happen, seconds after the stop begins.
    acts: &'static [(f64, Act)],
    /// How far the camera sways about its target, degrees, and how often.
    sway: [f32; 2],
}

/// Something that happens at a stop.
#[derive(Clone, Copy)]
enum Act {
    Sets(u32),
    /// Few VPLs, so that their paths can be told apart; or as many as before.
    FewVpls(bool),
    Paths(bool),
    Pause(bool),
    /// A method of indirect light and its denoiser on the left.
    Method(Indirect, Denoise),
    /// Others right of the divider, which sways.
    Beside(Indirect, Denoise),
    Reference,
    /// Paths without and, right of the divider, with light from a radiance cache.
    Cache,
    /// Measures frame rates of temporal sets, or closes what was measured.
    Compare(bool),
    /// One picture again.
    Join,
}

const STOPS: [Stop; 11] = [
    Stop {
        caption: "Temporal sets. T = 1: each frame draws the light of all virtual point lights. After five seconds T = 16: \
                  a sixteenth of them a frame, added up over sixteen frames.",
        acts: &[(0.0, Act::Sets(1)), (0.5 * STOP, Act::Sets(16))],
        sway: [4.0, 1.0],
    },
    Stop {
        caption: "What temporal sets gain, measured: frames per second of T = 1, 4 and 16 at this resolution, and how far their \
                  pictures are from those of T = 1. F3 does so for any view.",
        acts: &[(0.0, Act::Compare(true))],
        sway: [0.0, 1.0],
    },
    Stop {
        caption: "Virtual point lights. Light paths start at the lights; where they meet a surface they leave a point that \
                  shines for the light that bounces there.",
        acts: &[
            (0.0, Act::Compare(false)),
            (0.0, Act::FewVpls(true)),
            (0.0, Act::Pause(true)),
            (0.0, Act::Paths(true)),
        ],
        sway: [4.0, 1.0],
    },
    Stop {
        caption: "Invalidation. A light sways: points that its light reaches no more are invalidated, flash, and are \
                  replaced, a few in each frame.",
        acts: &[(0.0, Act::Pause(false))],
        sway: [0.0, 1.0],
    },
    Stop {
        caption: "Disocclusion. What comes into view was in no earlier frame; surfaces around it stand in until all sets \
                  have seen it.",
        acts: &[(0.0, Act::Paths(false)), (0.0, Act::FewVpls(false))],
        sway: [14.0, 3.0],
    },
    Stop {
        caption: "Methods side by side. Left of the divider bounced light by virtual point lights, right of it direct \
                  light alone, of the same world at the same moment.",
        acts: &[(0.0, Act::Beside(Indirect::NONE, Denoise::SVGF))],
        sway: [4.0, 1.0],
    },
    Stop {
        caption: "Path tracing. Right of the divider one light path a pixel and frame, cleaned by SVGF: averaged along motion, \
                  and blurred along surfaces as far as its variance says.",
        acts: &[(0.0, Act::Beside(Indirect::PATHS, Denoise::SVGF))],
        sway: [4.0, 1.0],
    },
    Stop {
        caption: "Two denoisers. The same light paths: on the left SVGF, on the right BMFR, which fits normals and positions to \
                  the noisy light in blocks of 32 pixels.",
        acts: &[
            (0.0, Act::Method(Indirect::PATHS, Denoise::SVGF)),
            (0.0, Act::Beside(Indirect::PATHS, Denoise::BMFR)),
        ],
        sway: [4.0, 1.0],
    },
    Stop {
        caption: "Path-space filtering. The same light paths: on the left each pixel has its own, on the right further bounces end in a \
                  radiance cache, cells in space whose light all paths share.",
        acts: &[(0.0, Act::Method(Indirect::PATHS, Denoise::SVGF)), (0.0, Act::Cache)],
        sway: [4.0, 1.0],
    },
    Stop {
        caption: "Standing still. While nothing moves, all frames are averaged: the picture becomes that of the path tracer, then it \
                  freezes and costs nothing. The number at the top counts them.",
        acts: &[(0.0, Act::Join), (0.0, Act::Method(Indirect::VPLS, Denoise::SVGF)), (0.0, Act::Pause(true))],
        sway: [0.0, 1.0],
    },
    Stop {
        caption: "The reference. A path tracer goes on as long as nothing moves; the picture on the left is compared with it.",
        acts: &[(0.0, Act::Reference)],
        sway: [0.0, 1.0],
    },
];

/// The tour under way.
pub(super) struct Tour {
    stop: usize,
    /// Time since the stop began, seconds.
    time: f64,
    /// Acts of the stop that are over.
    acts: usize,
    before: Before,
    /// Where to write the contact sheet, and its pictures so far.
    sheet: Option<(PathBuf, Vec<Shot>)>,
}

/// The state that the end of the tour restores.
pub(super) struct Before {
    pub settings: Settings,
    pub view: DebugView,
    /// Where the user had moved the camera.
    pub camera: Option<Camera>,
    pub paused: bool,
    /// Whether the resolution followed the rate.
    pub automatic: bool,
    /// The steps of undo before the tour.
    pub undo: Undo,
}

/// The work of a frame of the tour.
pub(super) struct TourFrame {
    pub actions: Actions,
    pub camera: Camera,
    /// Whether a stop begins.
    pub begins: bool,
}

impl Tour {
    /// Begins at the first stop; `sheet`: file of the contact sheet.
    pub fn new(before: Before, sheet: Option<PathBuf>) -> Self {
        let sheet = sheet.map(|path| (path, Vec::new()));
        Self { stop: 0, time: 0.0, acts: 0, before, sheet }
    }

    /// The text to be read.
    pub fn caption(&self) -> &'static str {
        STOPS.get(self.stop).map_or("", |stop| stop.caption)
    }

    /// The caption, and below it the rate, or what the tour waits for.
    pub fn said(&self, session: &Session, split: Option<&Split>, comparison: Option<&Comparison>) -> String {
        let [width, height] = session.settings.size;
        let rate = |report: &FrameReport| match report.figures.total_ms {
            0.0 => "stands still".to_owned(),
            ms => format!("{:.1} frames/s", 1e3 / ms),
        };
        let left = rate(&session.report);
        let below = match (
            comparison.filter(|comparison| comparison.bench.is_running()),
            split.map(|split| &split.right),
        ) {
            (Some(comparison), _) => {
                format!("waits: {:.0} % measured", 100.0 * comparison.bench.progress().0)
            }
            (_, Some(Right::Renderer(other))) => format!("left {left}, right {}", rate(&other.report)),
            (_, Some(Right::Reference(reference))) => match &reference.progress {
                Some(progress) => format!("{} samples a pixel", progress.samples),
                None => "waits for the first sample of each pixel".to_owned(),
            },
            (_, Some(Right::Picture(_)) | None) => {
                format!("{left}, {} still frames", session.renderer.still_frames())
            }
        };
        format!("{}\n{width}x{height}: {below}", self.caption())
    }

    /// Goes on by `seconds`. None when the tour is over.
    pub fn advance(
        &mut self,
        seconds: f64,
        own: &Camera,
        session: &Session,
        split: Option<&Split>,
    ) -> Result<Option<TourFrame>, DemoError> {
        // The first frame of all may come after a long load.
        let first = self.stop == 0 && self.acts == 0;
        self.time += if first { 0.0 } else { seconds.min(LONGEST_STEP) };
        let ends = self.time >= STOP;
        if ends {
            self.take_shot(session, split)?;
            (self.stop, self.time, self.acts) = (self.stop + 1, 0.0, 0);
        }
        let Some(stop) = STOPS.get(self.stop) else { return Ok(None) };
        let due = stop.acts.iter().filter(|(at, _)| *at <= self.time).count();
        let mut actions = Actions::default();
        actions.extend(stop.acts[self.acts..due].iter().map(|(_, act)| self.action(*act, session)));
        self.acts = due;
        let share = (self.time / STOP) as f32;
        if let Some(Right::Renderer(_)) = split.map(|split| &split.right) {
            actions.push(ViewAction::MoveDivider(0.5 + 0.3 * (TAU * share).sin()));
        }
        let [degrees, times] = stop.sway;
        let angle = degrees.to_radians() * (TAU * times * share).sin();
        let mut camera = *own;
        camera.eye =
            own.target + Quat::from_axis_angle(own.up.normalize_or(Vec3::Y), angle) * (own.eye - own.target);
        Ok(Some(TourFrame { actions, camera, begins: first || ends }))
    }

    /// Writes the sheet. Returns the state to go back to, and whether the tour was only to draw its sheet.
    pub fn end(self) -> Result<(Before, bool), DemoError> {
        let Some((path, shots)) = &self.sheet else { return Ok((self.before, false)) };
        let (size, pixels) = joined(shots);
        OutputFile::new(path)?.save_png(size, &pixels)?;
        let captions: String = STOPS
            .iter()
            .enumerate()
            .map(|(number, stop)| format!("{}. {}\n", number + 1, stop.caption))
            .collect();
        OutputFile::new(path.with_extension("txt"))?.save_text(&captions)?;
        Ok((self.before, true))
    }

    fn action(&self, act: Act, session: &Session) -> Action {
        let now = || session.settings.clone();
        let beside = |right: Settings| ViewAction::Split(Some(RightSide::Settings(Box::new(right)))).into();
        let set = |settings: Settings| EditAction::Set(Box::new(settings)).into();
        match act {
            Act::Sets(sets) => {
                let temporal_sets = sets.min(session.settings.vpl.slots);
                let vpl = VplSettings { temporal_sets, ..session.settings.vpl };
                set(Settings { vpl, indirect: Indirect::VPLS, ..now() })
            }
            Act::FewVpls(few) => {
                let pool = if few { FEW } else { self.before.settings.vpl.pool };
                set(Settings { vpl: VplSettings { pool, ..session.settings.vpl }, ..now() })
            }
            Act::Paths(shown) => {
                let mut view = session.renderer.view().clone();
                view.change_options(|options: &mut VplDebugView| {
                    options.vpl_paths = shown.then(PathStyle::default);
                    options.path_sample = Some(FEW);
                });
                ViewAction::View(Box::new(view)).into()
            }
            Act::Pause(paused) => ViewAction::Pause(paused).into(),
            Act::Method(indirect, denoise) => set(with_method(&session.settings, indirect, denoise)),
            Act::Beside(indirect, denoise) => beside(with_method(&session.settings, indirect, denoise)),
            Act::Reference => ViewAction::Split(Some(RightSide::Reference)).into(),
            Act::Cache => {
                let mut right = now();
                right.paths.filter = PathFilter::Cache;
                beside(right)
            }
            Act::Compare(begins) => {
                let vpls = "vpls".parse().ok().filter(|_| begins);
                let requested =
                    vpls.map(|vpls| RequestedSettings { sets: FEW_SETS.to_vec(), methods: vec![vpls] });
                AppAction::Compare(requested).into()
            }
            Act::Join => ViewAction::Split(None).into(),
        }
    }

    /// Keeps the picture on screen for the sheet.
    fn take_shot(&mut self, session: &Session, split: Option<&Split>) -> Result<(), DemoError> {
        let Some((_, shots)) = &mut self.sheet else { return Ok(()) };
        let mut shot = session.shot()?;
        if let Some(split) = split
            && let Some(right) = split.right_shot()?
        {
            let width = shot.size[0] as usize;
            let divider = (split.at * width as f32).round() as usize;
            let rows = shot.pixels.chunks_exact_mut(width).zip(right.pixels.chunks_exact(width));
            rows.for_each(|(row, right)| row[divider..].copy_from_slice(&right[divider..]));
        }
        shots.push(shot);
        Ok(())
    }
}

fn with_method(settings: &Settings, indirect: Indirect, denoise: Denoise) -> Settings {
    let effects = EffectSettings { denoise, ..settings.effects };
    Settings { indirect, effects, ..settings.clone() }
}

/// All shots in rows; what is smaller than the largest has a black margin.
fn joined(shots: &[Shot]) -> ([u32; 2], Vec<u8>) {
    let most = |axis: usize| shots.iter().map(|shot| shot.size[axis]).max().unwrap_or(1);
    let columns = COLUMNS.min(shots.len().max(1)) as u32;
    let rows = (shots.len() as u32).div_ceil(columns).max(1);
    let mut sheet = RgbImage::new(columns * most(0), rows * most(1));
    for (number, shot) in (0..).zip(shots) {
        let corner = [number % columns * most(0), number / columns * most(1)];
        for (at, [r, g, b, _]) in (0..).zip(&shot.pixels) {
            sheet.put_pixel(corner[0] + at % shot.size[0], corner[1] + at / shot.size[0], Rgb([*r, *g, *b]));
        }
    }
    (sheet.dimensions().into(), sheet.into_raw())
}
