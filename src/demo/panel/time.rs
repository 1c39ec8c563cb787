//! The animation's time.

use egui::{Slider, Ui};

use super::{Places, Shown, place};
use crate::demo::action::Action;
use crate::demo::clock::Pace;

/// Least length of the scrub bar, seconds.
const LEAST_SPAN: f64 = 10.0;
/// What the slider rounds to, seconds.
const ROUNDING: f64 = 0.01;

pub(super) fn show(ui: &mut Ui, shown: &mut Shown<'_>, places: &mut Places, wishes: &mut Vec<Action>) {
    let clock = &mut *shown.clock;
    ui.horizontal(|ui| {
        let label = if clock.paused { "Play" } else { "Pause" };
        if ui.button(label).on_hover_text("Space").clicked() {
            wishes.push(Action::TogglePause);
        }
        for (pace, label, what) in [
            (Pace::RealTime, "real time", "The animation keeps pace with the clock on the wall."),
            (Pace::Steps, "steps", "Each frame is one time_step after the last, as in render."),
        ] {
            ui.selectable_value(&mut clock.pace, pace, label).on_hover_text(what);
        }
    });
    let mut time = clock.time;
    // Grows in steps, so that the knob does not stand still at the end.
    let span = LEAST_SPAN * (time / LEAST_SPAN + 1e-9).ceil().max(1.0);
    ui.spacing_mut().slider_width = 150.0;
    let slider = ui.add(Slider::new(&mut time, 0.0..=span).suffix(" s").fixed_decimals(2));
    place(ui, places, "scrub", &slider);
    // The slider rounds what it shows; that is no wish.
    let moved = slider.changed() && (time - clock.time).abs() > ROUNDING;
    slider.on_hover_text("Drag to see any time of the animation.");
    if moved {
        wishes.push(Action::Scrub(time));
    }
}
