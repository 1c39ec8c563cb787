//! The list of keys.

use egui::style::ScrollStyle;
use egui::{Grid, ScrollArea, Ui, Window};

use super::shown::Shown;
use super::widgets::Output;
use crate::demo::action::AppAction;
use crate::demo::bindings::{BINDINGS, GESTURES};

pub(super) fn draw(ui: &mut Ui, shown: &Shown<'_>, out: &mut Output) {
    let corner = shown.picture_area(ui.ctx()).min;
    let mut is_open = true;
    let window = Window::new("Keys")
        .open(&mut is_open)
        .fixed_pos(corner + egui::vec2(8.0, 8.0))
        .collapsible(false)
        .resizable(false);
    let height = ui.available_height() - 100.0;
    window.show(ui.ctx(), |ui| {
        // A bar that is seen tells that there is more.
        ui.spacing_mut().scroll = ScrollStyle::thin();
        ScrollArea::vertical().max_height(height).show(ui, list);
    });
    if !is_open {
        out.push(AppAction::ToggleHelp);
    }
}

fn list(ui: &mut Ui) {
    Grid::new("keys").num_columns(2).striped(true).show(ui, |ui| {
        let bound = BINDINGS.iter().map(|(keys, what, ..)| (*keys, *what));
        for (keys, what) in GESTURES.iter().copied().chain(bound) {
            ui.strong(keys);
            ui.label(what);
            ui.end_row();
        }
    });
}
