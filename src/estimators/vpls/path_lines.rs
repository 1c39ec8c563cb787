//! VPLs as points, their paths as lines from their lights, and those that just became invalid.
//!
//! In: the slots. Out: lines to draw over the picture. Points are as large as their flux; colours tell what
//! was asked for.

use std::collections::HashSet;

use glam::Vec3;

use super::manager::{InvalidationReason, SlotState, SlotView, VplManager};
use super::view::PathStyle;
use crate::passes::overlay::Line;
use crate::scene::luminance;

/// Frames during which an invalid VPL is still seen.
const FLASH_FRAMES: u32 = 30;
/// Hidden parts keep this share of their opacity.
const HIDDEN: f32 = 0.2;
/// Opacity of the lines of all paths together; a single path is opaque.
const LINE_OPACITY: f32 = 0.35;
/// Smallest and largest diameter of a point in a picture of [`USUAL_HEIGHT`].
const DIAMETERS: [f32; 2] = [2.5, 11.0];
/// Height of a picture, in pixels, above which lines and points grow with it.
const USUAL_HEIGHT: f32 = 720.0;
/// Colours of VPLs that light something seen, and of others.
const USEFUL: Vec3 = Vec3::new(0.25, 0.65, 1.0);
const USELESS: Vec3 = Vec3::new(1.0, 0.55, 0.1);
/// Golden ratio: numbers times this are spread over the circle of hues.
const GOLDEN: f32 = 0.618_034;

/// Selects the paths to draw.
pub(super) struct PathView {
    pub style: PathStyle,
    /// Draw the path of this slot only.
    pub single: Option<u32>,
    /// Draw at most so many paths; none: all.
    pub sample: Option<u32>,
    /// Height of the picture, pixels.
    pub height: u32,
}

impl PathView {
    /// All lines, then all points, so that points lie on top, and those that flash on top of all.
    pub fn lines(&self, vpls: &VplManager) -> Vec<Line> {
        let chosen = self.single.map(|slot| vpls.path_to(slot));
        // The first VPL of a path stands for it.
        let first = |slot: &SlotView| vpls.path_to(slot.slot).first().copied().unwrap_or(slot.slot);
        let mut paths: Vec<u32> = vpls.slots().map(|slot| first(&slot)).collect();
        paths.dedup();
        let step = self.sample.map_or(1, |most| paths.len().div_ceil(most.max(1) as usize));
        let sampled: HashSet<u32> = paths.into_iter().step_by(step).collect();
        let shown = |slot: &SlotView| match &chosen {
            Some(path) => path.contains(&slot.slot),
            None => step == 1 || sampled.contains(&first(slot)),
        };
        let slots: Vec<SlotView> = vpls.slots().filter(shown).collect();
        let valid = || slots.iter().filter(|slot| slot.state == SlotState::Valid);
        let brightest = vpls.slots().map(|slot| luminance(slot.flux)).fold(f32::MIN_POSITIVE, f32::max);
        let scale = (self.height as f32 / USUAL_HEIGHT).max(1.0);
        let mut lines: Vec<Line> = valid()
            .filter(|slot| slot.origin != slot.position && self.style != PathStyle::Usefulness)
            .map(|slot| {
                let colour = self.colour(vpls, slot, brightest).extend(self.line_opacity());
                line(slot.origin, slot.position, colour.to_array(), 1.5 * scale)
            })
            .collect();
        let flashes = slots.iter().filter_map(|slot| flash(vpls, slot.slot, scale));
        let (flashing_lines, flashing_points): (Vec<Line>, Vec<Line>) = flashes.unzip();
        lines.extend(flashing_lines);
        lines.extend(valid().map(|slot| {
            let share = (luminance(slot.flux) / brightest).sqrt();
            let diameter = scale * (DIAMETERS[0] + (DIAMETERS[1] - DIAMETERS[0]) * share);
            let colour = self.colour(vpls, slot, brightest).extend(1.0);
            Line::point(slot.position, colour.to_array(), diameter, HIDDEN)
        }));
        lines.extend(flashing_points);
        lines
    }

    fn line_opacity(&self) -> f32 {
        if self.single.is_some() { 1.0 } else { LINE_OPACITY }
    }

    fn colour(&self, vpls: &VplManager, slot: &SlotView, brightest: f32) -> Vec3 {
        match self.style {
            PathStyle::Bounce => bounce_colour(slot.bounce),
            // Six stops from the faintest to the brightest.
            PathStyle::Flux => heat(1.0 + (luminance(slot.flux) / brightest).log2() / 6.0),
            // A thousand frames are old.
            PathStyle::Age => {
                let age = vpls.history(slot.slot).map_or(0, |history| history.age);
                heat(1.0 - (age as f32 + 1.0).log2() / 10.0)
            }
            PathStyle::Usefulness if slot.useful => USEFUL,
            PathStyle::Usefulness => USELESS,
            PathStyle::Set => hue(slot.set as f32 * GOLDEN),
        }
    }
}

/// How its light came to a VPL that became invalid a short while ago, and where it was.
fn flash(vpls: &VplManager, slot: u32, scale: f32) -> Option<(Line, Line)> {
    let last = vpls.history(slot)?.invalidation?;
    let age = vpls.frame().saturating_sub(last.frame);
    if age >= FLASH_FRAMES {
        return None;
    }
    let fade = 1.0 - age as f32 / FLASH_FRAMES as f32;
    let colour = |opacity: f32| Vec3::from(reason_colour(last.reason)).extend(opacity * fade).to_array();
    let point = Line::point(last.position, colour(1.0), (4.0 + 10.0 * fade) * scale, 2.0 * HIDDEN);
    Some((line(last.origin, last.position, colour(0.6), 2.0 * scale), point))
}

fn line(from: Vec3, to: Vec3, colour: [f32; 4], width: f32) -> Line {
    Line { from, to, colour, width, hidden: HIDDEN }
}

/// The colour, as display values, in which VPLs flash that became invalid for this reason.
pub fn reason_colour(reason: InvalidationReason) -> [f32; 3] {
    match reason {
        InvalidationReason::LightTurnedAway => [1.0, 1.0, 1.0],
        InvalidationReason::FacesAway => [0.2, 0.9, 1.0],
        InvalidationReason::Occluded => [1.0, 0.1, 0.1],
        InvalidationReason::ParentInvalid => [1.0, 0.3, 0.9],
        InvalidationReason::LightChanged => [1.0, 1.0, 0.2],
        InvalidationReason::NoSlot => [0.7, 0.7, 0.7],
    }
}

/// The meaning of the colours of a style, as display values; none where each number has its own colour.
pub fn path_legend(style: PathStyle) -> Vec<(&'static str, [f32; 3])> {
    let entries = match style {
        PathStyle::Bounce => vec![
            ("0", bounce_colour(0)),
            ("1", bounce_colour(1)),
            ("2", bounce_colour(2)),
            ("3", bounce_colour(3)),
        ],
        PathStyle::Flux => vec![("1/64 of the most", heat(0.0)), ("1/8", heat(0.5)), ("the most", heat(1.0))],
        PathStyle::Age => vec![("new", heat(1.0)), ("30 frames", heat(0.5)), ("1000", heat(0.0))],
        PathStyle::Usefulness => vec![("lights something seen", USEFUL), ("nothing", USELESS)],
        PathStyle::Set => Vec::new(),
    };
    entries.into_iter().map(|(name, colour)| (name, colour.to_array())).collect()
}

/// Colours apart for the first bounces, then hues that go on.
fn bounce_colour(bounce: u32) -> Vec3 {
    match bounce {
        0 => Vec3::new(1.0, 0.95, 0.6),
        1 => Vec3::new(1.0, 0.55, 0.1),
        2 => Vec3::new(0.25, 0.65, 1.0),
        3 => Vec3::new(0.4, 0.9, 0.4),
        _ => hue(bounce as f32 * GOLDEN),
    }
}

/// From dark blue (0) over red to pale yellow (1).
fn heat(value: f32) -> Vec3 {
    let stops = [
        Vec3::new(0.1, 0.15, 0.6),
        Vec3::new(0.65, 0.1, 0.5),
        Vec3::new(1.0, 0.45, 0.1),
        Vec3::new(1.0, 1.0, 0.7),
    ];
    let place = value.clamp(0.0, 1.0) * 3.0;
    let first = (place as usize).min(2);
    stops[first].lerp(stops[first + 1], place - first as f32)
}

fn hue(turns: f32) -> Vec3 {
    let channel = |shift: f32| 0.55 + 0.45 * (std::f32::consts::TAU * (turns + shift)).cos();
    Vec3::new(channel(0.0), channel(1.0 / 3.0), channel(2.0 / 3.0))
}
