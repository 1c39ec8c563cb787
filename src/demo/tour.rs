//! The tour: six stops of ten seconds, each of which shows one idea, with a caption.

use std::f32::consts::TAU;
use std::path::PathBuf;

use glam::Quat;

use super::DemoError;
use super::action::Action;
use super::split::{Right, RightSide, Split};
use super::stage::Stage;
use crate::estimators::vpls::PathStyle;
use crate::output::OutputFile;
use crate::scene::Camera;
use crate::settings::{Indirect, Settings, VplSettings};

/// Length of a stop, seconds.
const STOP: f64 = 10.0;
/// VPLs whose paths are shown.
const FEW: u32 = 128;
/// Pictures of the contact sheet beside each other.
const COLUMNS: usize = 3;

/// A stop.
struct Stop {
    caption: &'static str,
    /// What happens, and when, seconds after the stop begins.
    acts: &'static [(f64, Act)],
    /// How far the camera sways about its target, degrees, and how often.
    sway: [f32; 2],
}

/// What happens at a stop.
#[derive(Clone, Copy)]
enum Act {
    Sets(u32),
    /// Few VPLs, so that their paths can be told apart; or as many as before.
    Few(bool),
    Paths(bool),
    Pause(bool),
    /// Direct light alone right of the divider, which sways.
    Compare,
    Truth,
    /// One picture again.
    Join,
}

const STOPS: [Stop; 6] = [
    Stop {
        caption: "Temporal sets. T = 1: each frame draws the light of all virtual point lights. After five seconds T = 16: \
                  a sixteenth of them a frame, added up over sixteen frames.",
        acts: &[(0.0, Act::Sets(1)), (0.5 * STOP, Act::Sets(16))],
        sway: [4.0, 1.0],
    },
    Stop {
        caption: "Virtual point lights. Light paths start at the lamps; where they meet a surface they leave a point that \
                  shines for the light that bounces there.",
        acts: &[(0.0, Act::Few(true)), (0.0, Act::Pause(true)), (0.0, Act::Paths(true))],
        sway: [4.0, 1.0],
    },
    Stop {
        caption: "Invalidation. A lamp sways: points that its light reaches no more are invalidated, flash, and are \
                  replaced, a few in each frame.",
        acts: &[(0.0, Act::Pause(false))],
        sway: [0.0, 1.0],
    },
    Stop {
        caption: "Disocclusion. What comes into view was in no earlier frame; surfaces around it stand in until all sets \
                  have seen it.",
        acts: &[(0.0, Act::Paths(false)), (0.0, Act::Few(false))],
        sway: [14.0, 3.0],
    },
    Stop {
        caption: "Methods side by side. Left of the divider bounced light by virtual point lights, right of it direct \
                  light alone, of the same world at the same moment.",
        acts: &[(0.0, Act::Compare)],
        sway: [4.0, 1.0],
    },
    Stop {
        caption: "The truth. A path tracer goes on as long as nothing moves; the picture on the left is judged by it.",
        acts: &[(0.0, Act::Join), (0.0, Act::Pause(true)), (0.0, Act::Truth)],
        sway: [0.0, 1.0],
    },
];

/// The tour under way.
pub(super) struct Tour {
    stop: usize,
    /// Since the stop began, seconds.
    time: f64,
    /// Acts of the stop that are over.
    acts: usize,
    /// The settings to go back to.
    settings: Settings,
    /// Where to write the contact sheet, and its pictures so far.
    sheet: Option<(PathBuf, Vec<Tile>)>,
}

/// What was on screen at the end of a stop, RGBA.
struct Tile {
    size: [usize; 2],
    pixels: Vec<[u8; 4]>,
}

/// What a frame of the tour does.
pub(super) struct TourFrame {
    pub actions: Vec<Action>,
    pub camera: Camera,
    /// Whether a stop begins.
    pub begins: bool,
}

impl Tour {
    /// Begins at the first stop; `sheet`: file of the contact sheet.
    pub fn new(settings: &Settings, sheet: Option<PathBuf>) -> Self {
        let sheet = sheet.map(|path| (path, Vec::new()));
        Self { stop: 0, time: 0.0, acts: 0, settings: settings.clone(), sheet }
    }

    /// What is to be read.
    pub fn caption(&self) -> &'static str {
        STOPS.get(self.stop).map_or("", |stop| stop.caption)
    }

    /// Goes on by `seconds`. None when the tour is over.
    pub fn advance(
        &mut self,
        seconds: f64,
        own: &Camera,
        stage: &Stage,
        split: Option<&Split>,
    ) -> Result<Option<TourFrame>, DemoError> {
        // The first frame of all may come after a long load.
        let first = self.stop == 0 && self.acts == 0;
        self.time += if first { 0.0 } else { seconds };
        let ends = self.time >= STOP;
        if ends {
            self.take_tile(stage, split)?;
            (self.stop, self.time, self.acts) = (self.stop + 1, 0.0, 0);
        }
        let Some(stop) = STOPS.get(self.stop) else { return Ok(None) };
        let due = stop.acts.iter().filter(|(at, _)| *at <= self.time).count();
        let mut actions: Vec<Action> =
            stop.acts[self.acts..due].iter().map(|(_, act)| self.action(*act, stage)).collect();
        self.acts = due;
        let share = (self.time / STOP) as f32;
        if let Some(Right::Renderer(_)) = split.map(|split| &split.right) {
            actions.push(Action::MoveDivider(0.5 + 0.3 * (TAU * share).sin()));
        }
        let [degrees, times] = stop.sway;
        let angle = degrees.to_radians() * (TAU * times * share).sin();
        let mut camera = *own;
        camera.eye = own.target
            + Quat::from_axis_angle(own.up.normalize_or(glam::Vec3::Y), angle) * (own.eye - own.target);
        Ok(Some(TourFrame { actions, camera, begins: first || ends }))
    }

    /// The settings that were in use before, and whether the tour was only to draw its sheet.
    pub fn end(self) -> Result<(Settings, bool), DemoError> {
        let Some((path, tiles)) = &self.sheet else { return Ok((self.settings, false)) };
        let (size, pixels) = joined(tiles);
        OutputFile::new(path)?.save_png(size, &pixels)?;
        let captions: String = STOPS
            .iter()
            .enumerate()
            .map(|(number, stop)| format!("{}. {}\n", number + 1, stop.caption))
            .collect();
        OutputFile::new(path.with_extension("txt"))?.save_text(&captions)?;
        Ok((self.settings, true))
    }

    fn action(&self, act: Act, stage: &Stage) -> Action {
        match act {
            Act::Sets(sets) => {
                let vpl =
                    VplSettings { temporal_sets: sets.min(stage.settings.vpl.slots), ..stage.settings.vpl };
                Action::Set(Box::new(Settings { vpl, indirect: Indirect::Vpls, ..stage.settings.clone() }))
            }
            Act::Few(few) => {
                let pool = if few { FEW } else { self.settings.vpl.pool };
                let vpl = VplSettings { pool, ..stage.settings.vpl };
                Action::Set(Box::new(Settings { vpl, ..stage.settings.clone() }))
            }
            Act::Paths(shown) => {
                let mut view = stage.renderer.view().clone();
                view.vpl.vpl_paths = shown.then(PathStyle::default);
                Action::View(Box::new(view))
            }
            Act::Pause(paused) => Action::Pause(paused),
            Act::Compare => {
                let direct = Settings { indirect: Indirect::None, ..stage.settings.clone() };
                Action::Split(Some(RightSide::Settings(Box::new(direct))))
            }
            Act::Truth => Action::Split(Some(RightSide::Truth)),
            Act::Join => Action::Split(None),
        }
    }

    fn take_tile(&mut self, stage: &Stage, split: Option<&Split>) -> Result<(), DemoError> {
        let Some((_, tiles)) = &mut self.sheet else { return Ok(()) };
        let mut picture = stage.renderer.read_picture(false)?;
        let right = match split.map(|split| &split.right) {
            Some(Right::Renderer(other)) => Some(other.renderer.read_picture(false)?.display),
            Some(Right::Truth(truth)) => truth.picture().map(|picture| picture.display.clone()),
            None => None,
        };
        let divider = split.map_or(1.0, |split| split.at) * picture.width as f32;
        for (at, pixel) in right.iter().flatten().enumerate() {
            if (at % picture.width) as f32 >= divider {
                picture.display[at] = *pixel;
            }
        }
        tiles.push(Tile { size: [picture.width, picture.height], pixels: picture.display });
        Ok(())
    }
}

/// All tiles in rows; what is smaller than the largest has a black margin.
fn joined(tiles: &[Tile]) -> ([u32; 2], Vec<u8>) {
    let most = |axis: usize| tiles.iter().map(|tile| tile.size[axis]).max().unwrap_or(1);
    let [width, height] = [most(0), most(1)];
    let columns = COLUMNS.min(tiles.len().max(1));
    let rows = tiles.len().div_ceil(columns).max(1);
    let mut pixels = vec![0; columns * width * rows * height * 3];
    for (number, tile) in tiles.iter().enumerate() {
        let corner = [number % columns * width, number / columns * height];
        for (at, [r, g, b, _]) in tile.pixels.iter().enumerate() {
            let [x, y] = [corner[0] + at % tile.size[0], corner[1] + at / tile.size[0]];
            let to = 3 * (y * columns * width + x);
            pixels[to..to + 3].copy_from_slice(&[*r, *g, *b]);
        }
    }
    ([(columns * width) as u32, (rows * height) as u32], pixels)
}
