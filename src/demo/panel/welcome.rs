//! The first lines that a new user reads.

use egui::{Align2, Ui, Window};

use super::shown::Shown;
use super::widgets::Output;
use crate::demo::action::AppAction;

const LINES: [&str; 5] = [
    "All light in this room is computed as you watch: click a lamp or a ball and drag it by its arrows.",
    "Fly with W A S D, Q and E; look around with the right mouse button; Home brings you back.",
    "The bar at the top chooses the scene, the method, temporal sets (T) and quality.",
    "C compares two methods side by side, G shows the path traced reference, X the error.",
    "F1 lists all keys; F2 begins a tour; F3 measures what temporal sets gain.",
];

pub(super) fn draw(ui: &Ui, shown: &Shown<'_>, out: &mut Output) {
    let at = shown.picture_area(ui.ctx()).left_bottom() + egui::vec2(12.0, -36.0);
    let window = Window::new("Welcome to glowworm").fixed_pos(at).pivot(Align2::LEFT_BOTTOM);
    let width = (shown.picture_area(ui.ctx()).width() - 40.0).clamp(100.0, 640.0);
    let shown = window.collapsible(false).resizable(false).show(ui.ctx(), |ui| {
        ui.set_max_width(width);
        for line in LINES {
            ui.label(line);
        }
        ui.button("Got it")
    });
    if let Some(button) = shown.and_then(|shown| shown.inner) {
        out.click(ui, "Got it", &button, AppAction::DismissWelcome);
    }
}
