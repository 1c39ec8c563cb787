//! Animation time.

use egui::{Slider, Ui};

use super::{Places, Shown, place};
use crate::demo::action::Action;
use crate::demo::clock::Pace;

/// Minimum length of the scrub bar, seconds.
const LEAST_SPAN: f64 = 10.0;
/// Resolution of the slider, seconds.
const ROUNDING: f64 = 0.01;

pub(super) fn draw(ui: &mut Ui, shown: &mut Shown<'_>, places: &mut Places, actions: &mut Vec<Action>) {
    let clock = &mut *shown.clock;
    ui.horizontal(|ui| {
        let label = if clock.paused { "Play" } else { "Pause" };
        if ui.button(label).on_hover_text("Space").clicked() {
            actions.push(Action::TogglePause);
        }
        for (pace, label, what) in [
            (Pace::RealTime, "real time", "The animation follows real time."),
            (Pace::Steps, "steps", "Each frame advances by time_step, as in render."),
        ] {
            ui.selectable_value(&mut clock.pace, pace, label).on_hover_text(what);
        }
    });
    let mut time = clock.time;
    // Grow in steps, so that the knob keeps moving.
    let span = LEAST_SPAN * (time / LEAST_SPAN + 1e-9).ceil().max(1.0);
    ui.spacing_mut().slider_width = 150.0;
    let slider = ui.add(Slider::new(&mut time, 0.0..=span).suffix(" s").fixed_decimals(2));
    place(ui, places, "scrub", &slider);
    let value = slider.rect.with_min_x(slider.rect.min.x + ui.spacing().slider_width);
    place(ui, places, "scrub value", &slider.clone().with_new_rect(value));
    // Ignore changes from the slider's own rounding.
    let moved = slider.changed() && (time - clock.time).abs() > ROUNDING;
    slider.on_hover_text("Drag to set the animation time.");
    if moved {
        actions.push(Action::Scrub(time));
    }
}
