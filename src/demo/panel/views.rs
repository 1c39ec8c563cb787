//! Debug views: buffers, VPL paths, single VPLs.

use egui::{Color32, ComboBox, DragValue, RichText, Ui};

use super::Shown;
use crate::demo::action::Action;
use crate::estimators::vpls::{InvalidationReason, PathStyle, reason_colour, shows_a_set};
use crate::estimators::{self, vpls::VplLook};
use crate::renderer::DebugView;

pub(super) fn show(ui: &mut Ui, shown: &Shown<'_>, actions: &mut Vec<Action>) {
    let Some(stage) = shown.stage else { return };
    let mut view = stage.renderer.view().clone();
    buffers(ui, &mut view, stage.settings.vpl.temporal_sets);
    if stage.renderer.vpls().is_some() {
        paths(ui, &mut view.vpl);
        single(ui, &view.vpl, actions);
    }
    let mut inspecting = shown.inspector.is_on();
    if ui
        .checkbox(&mut inspecting, "inspector")
        .on_hover_text("Click a surface to edit its material and to list the VPLs that light it (I).")
        .changed()
    {
        actions.push(Action::ToggleInspector);
    }
    if view != *stage.renderer.view() {
        actions.push(Action::View(Box::new(view)));
    }
}

fn buffers(ui: &mut Ui, view: &mut DebugView, sets: u32) {
    ui.horizontal(|ui| {
        ui.label("buffer");
        let shown = estimators::views().find(|known| known.name == view.buffer);
        let label = shown.map_or("", |shown| shown.label);
        let chosen = ComboBox::from_id_salt("buffer").selected_text(label).width(150.0).height(300.0);
        chosen.show_ui(ui, |ui| {
            for known in estimators::views() {
                let label = ui.selectable_value(&mut view.buffer, known.name.into(), known.label);
                label.on_hover_text(known.about);
            }
        });
    });
    if shows_a_set(&view.buffer) {
        ui.horizontal(|ui| {
            ui.label("temporal set");
            ui.add(DragValue::new(&mut view.vpl.set).range(0..=sets.saturating_sub(1)).speed(0.05));
        });
    }
    let shown = estimators::views().find(|known| known.name == view.buffer);
    ui.small(shown.map_or("", |shown| shown.about));
}

fn paths(ui: &mut Ui, view: &mut VplLook) {
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

fn single(ui: &mut Ui, view: &VplLook, actions: &mut Vec<Action>) {
    ui.horizontal(|ui| {
        ui.label("VPL");
        if ui.small_button("<").on_hover_text("previous VPL (,)").clicked() {
            actions.push(Action::StepVpl(-1));
        }
        ui.label(view.single_vpl.map_or_else(|| "all".to_owned(), |slot| slot.to_string()));
        if ui.small_button(">").on_hover_text("next VPL (.)").clicked() {
            actions.push(Action::StepVpl(1));
        }
        if ui.add_enabled(view.single_vpl.is_some(), egui::Button::new("all").small()).clicked() {
            actions.push(Action::AllVpls);
        }
    });
}
