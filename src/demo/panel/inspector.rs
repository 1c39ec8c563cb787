//! The list of VPLs that light a point.

use egui::{Align2, Grid, Rect, Ui, Window};

use super::Shown;
use crate::demo::action::Action;
use crate::scene::luminance;

pub(super) fn show(ui: &Ui, viewport: Rect, shown: &Shown<'_>, actions: &mut Vec<Action>) {
    let window = Window::new("VPL inspector")
        .anchor(Align2::LEFT_BOTTOM, [8.0, -8.0])
        .max_width((viewport.width() - 30.0).max(200.0))
        .max_height(viewport.height() * 0.45)
        .resizable(false)
        .vscroll(true);
    window.show(ui.ctx(), |ui| {
        if !shown.inspector.has_point() {
            ui.label("Click a surface.");
            return;
        }
        if shown.inspector.found.is_empty() {
            ui.label("No VPL faces this point.");
            return;
        }
        let all: f32 = shown.inspector.found.iter().map(brought).sum();
        Grid::new("found").num_columns(6).striped(true).show(ui, |ui| {
            for head in ["slot", "share", "bounce", "age", "path", "ray"] {
                ui.strong(head);
            }
            ui.end_row();
            for found in &shown.inspector.found {
                let slot = found.slot.slot;
                if ui.link(slot.to_string()).on_hover_text("Isolate this VPL.").clicked()
                    && let Some(stage) = shown.stage
                {
                    let mut view = stage.renderer.view().clone();
                    view.vpl.single_vpl = Some(slot);
                    actions.push(Action::View(Box::new(view)));
                }
                let share = if all > 0.0 { 100.0 * brought(found) / all } else { 0.0 };
                ui.label(format!("{share:.1} %"))
                    .on_hover_text(format!("{} W/m²", found.contribution.irradiance));
                ui.label(found.slot.bounce.to_string());
                let age = found.history.map_or(0, |history| history.age);
                ui.label(age.to_string()).on_hover_text("frames since it was shot");
                let path: Vec<String> = found.path.iter().map(ToString::to_string).collect();
                let last = found
                    .history
                    .and_then(|history| history.invalidation)
                    .map_or("never invalidated", |last| last.reason.label());
                ui.label(path.join(" > "))
                    .on_hover_text(format!("slots of its path; last invalidation: {last}"));
                ui.label(if found.contribution.visible { "visible" } else { "occluded" });
                ui.end_row();
            }
        });
    });
}

/// Luminance of its contribution; 0 if occluded.
fn brought(found: &crate::demo::inspector::Found) -> f32 {
    let seen = found.contribution.visible;
    if seen { luminance(found.contribution.irradiance) } else { 0.0 }
}
