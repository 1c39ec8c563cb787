//! Debug views: buffers, and the options of the method's views.

use egui::{ComboBox, Ui};

use super::shown::Shown;
use super::vpls;
use super::widgets::Output;
use crate::demo::action::ViewAction;
use crate::estimators;
use crate::renderer::DebugView;

pub(super) fn draw(ui: &mut Ui, shown: &Shown<'_>, out: &mut Output) {
    let Some(session) = shown.session() else { return };
    let mut view = session.renderer.view().clone();
    buffers(ui, &mut view);
    vpls::view_options(ui, &mut view, session, out);
    let mut inspecting = shown.view.inspector.is_on;
    if ui
        .checkbox(&mut inspecting, "inspector")
        .on_hover_text("Click a surface to edit its material and to list the VPLs that light it (I).")
        .changed()
    {
        out.push(ViewAction::ToggleInspector);
    }
    if view != *session.renderer.view() {
        out.push(ViewAction::View(Box::new(view)));
    }
}

fn buffers(ui: &mut Ui, view: &mut DebugView) {
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
    let shown = estimators::views().find(|known| known.name == view.buffer);
    ui.small(shown.map_or("", |shown| shown.about));
}
