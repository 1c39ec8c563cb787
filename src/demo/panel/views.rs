//! Ways to look into the method: buffers, paths, single VPLs.

use clap::ValueEnum;
use egui::{Color32, ComboBox, DragValue, RichText, Ui};

use super::Shown;
use crate::demo::action::Action;
use crate::renderer::{BufferView, DebugView, PathStyle, reason_colour};
use crate::vpl::InvalidationReason;

pub(super) fn show(ui: &mut Ui, shown: &Shown<'_>, wishes: &mut Vec<Action>) {
    let Some(stage) = shown.stage else { return };
    let mut view = stage.renderer.view().clone();
    buffers(ui, &mut view, stage.settings.temporal_sets);
    paths(ui, &mut view);
    single(ui, &view, wishes);
    let mut inspecting = shown.inspector.is_on();
    if ui
        .checkbox(&mut inspecting, "inspector")
        .on_hover_text("Click a surface to list the VPLs that light it (I).")
        .changed()
    {
        wishes.push(Action::ToggleInspector);
    }
    if view != *stage.renderer.view() {
        wishes.push(Action::View(Box::new(view)));
    }
}

fn buffers(ui: &mut Ui, view: &mut DebugView, sets: u32) {
    ui.horizontal(|ui| {
        ui.label("buffer");
        let chosen =
            ComboBox::from_id_salt("buffer").selected_text(view.buffer.label()).width(150.0).height(300.0);
        chosen.show_ui(ui, |ui| {
            for buffer in BufferView::ALL {
                let label = ui.selectable_value(&mut view.buffer, buffer, buffer.label());
                label.on_hover_text(doc(buffer));
            }
        });
    });
    if matches!(view.buffer, BufferView::SetBuffer | BufferView::SetReprojected) {
        ui.horizontal(|ui| {
            ui.label("temporal set");
            ui.add(DragValue::new(&mut view.set).range(0..=sets.saturating_sub(1)).speed(0.05));
        });
    }
    ui.small(doc(view.buffer));
}

/// The documentation of a buffer, written once, for the command line.
fn doc(buffer: BufferView) -> String {
    let value = buffer.to_possible_value();
    value.and_then(|value| value.get_help().map(ToString::to_string)).unwrap_or_default()
}

fn paths(ui: &mut Ui, view: &mut DebugView) {
    ui.horizontal(|ui| {
        let mut on = view.vpl_paths.is_some();
        if ui
            .checkbox(&mut on, "paths by")
            .on_hover_text("VPLs as points, their paths as lines (P)")
            .changed()
        {
            view.vpl_paths = on.then(PathStyle::default);
        }
        let mut style = view.vpl_paths.unwrap_or_default();
        ComboBox::from_id_salt("paths").selected_text(style.label()).show_ui(ui, |ui| {
            for choice in PathStyle::ALL {
                if ui.selectable_value(&mut style, choice, choice.label()).clicked() {
                    view.vpl_paths = Some(choice);
                }
            }
        });
    });
    if view.vpl_paths.is_some() {
        ui.horizontal_wrapped(|ui| {
            ui.small("invalidated:");
            for reason in InvalidationReason::ALL {
                let [r, g, b] = reason_colour(reason).map(|channel| (channel * 255.0) as u8);
                ui.label(RichText::new(reason.label()).small().color(Color32::from_rgb(r, g, b)));
            }
        });
    }
}

fn single(ui: &mut Ui, view: &DebugView, wishes: &mut Vec<Action>) {
    ui.horizontal(|ui| {
        ui.label("VPL");
        if ui.small_button("<").on_hover_text("VPL before (,)").clicked() {
            wishes.push(Action::StepVpl(-1));
        }
        ui.label(view.single_vpl.map_or_else(|| "all".to_owned(), |slot| slot.to_string()));
        if ui.small_button(">").on_hover_text("next VPL (.)").clicked() {
            wishes.push(Action::StepVpl(1));
        }
        if ui.add_enabled(view.single_vpl.is_some(), egui::Button::new("all").small()).clicked() {
            wishes.push(Action::AllVpls);
        }
    });
}
