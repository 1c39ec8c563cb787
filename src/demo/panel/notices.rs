//! Notices over the picture: errors, captions, that a scene is loaded.

use egui::{Align2, Area, Color32, Frame, Id, Pos2, Rect, RichText, Ui};

use super::shown::Shown;
use super::widgets::Output;
use crate::demo::action::AppAction;
use crate::demo::loader::Loader;

/// Widest text, points.
const WIDEST: f32 = 720.0;

fn area(name: &str, at: Pos2, pivot: Align2) -> Area {
    Area::new(Id::new(name)).fixed_pos(at).pivot(pivot).interactable(false)
}

/// Shows a caption of the tour, or a hint, at the lower edge of the picture.
pub(super) fn caption(ui: &Ui, viewport: Rect, caption: &str) {
    let at = viewport.center_bottom() - egui::vec2(0.0, 12.0);
    area("caption", at, Align2::CENTER_BOTTOM).show(ui.ctx(), |ui| {
        Frame::popup(ui.style()).fill(Color32::from_black_alpha(200)).show(ui, |ui| {
            ui.set_max_width((viewport.width() - 40.0).min(WIDEST));
            ui.label(RichText::new(caption).size(16.0).color(Color32::WHITE));
        });
    });
}

/// The last error, until it is dismissed.
pub(super) fn error(ui: &Ui, shown: &Shown<'_>, out: &mut Output) {
    let Some(error) = &shown.view.interface.error else { return };
    let viewport = shown.picture_area(ui.ctx());
    let at = viewport.center_top() + egui::vec2(0.0, 12.0);
    let dismiss = area("error", at, Align2::CENTER_TOP).interactable(true).show(ui.ctx(), |ui| {
        Frame::popup(ui.style()).show(ui, |ui| {
            ui.set_max_width((viewport.width() - 40.0).min(WIDEST));
            ui.label(RichText::new(error).color(ui.visuals().error_fg_color));
            ui.button("Dismiss")
        })
    });
    out.click(ui, "dismiss", &dismiss.inner.inner, AppAction::DismissError);
}

/// Names what the next frames wait for, in the middle.
pub(super) fn preparing(ui: &Ui, viewport: Rect, subject: &str) {
    area("preparing", viewport.center(), Align2::CENTER_CENTER).show(ui.ctx(), |ui| {
        Frame::popup(ui.style()).show(ui, |ui| ui.label(format!("preparing {subject} …")));
    });
}

/// The first scene's progress, in the middle.
pub(super) fn loading(ui: &Ui, viewport: Rect, loader: &Loader) {
    let Some((name, step, elapsed)) = loader.progress() else { return };
    area("loading", viewport.center(), Align2::CENTER_CENTER).show(ui.ctx(), |ui| {
        ui.set_min_width((viewport.width() - 40.0).min(WIDEST));
        ui.vertical_centered(|ui| {
            ui.label(format!("{name}: {} ({:.0} s)", step.label(), elapsed.as_secs_f32()));
        });
    });
}
