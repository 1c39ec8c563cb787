//! VPLs in the panel: options of their views, the legend of their paths, those that light a point.

use egui::{Align2, ComboBox, DragValue, Grid, Rect, Slider, Ui, Window};

use super::shown::Shown;
use super::widgets::Output;
use crate::demo::action::ViewAction;
use crate::demo::inspector::Found;
use crate::demo::session::Session;
use crate::estimators::vpls::{
    InvalidationReason, PathStyle, SHARE_COLOURS, STALENESS, VPL_VISIBILITY, VplDebugView, Vpls, path_legend,
    reason_colour, shows_a_set,
};
use crate::renderer::DebugView;
use crate::scene::luminance;
use crate::settings::VplSettings;

/// The options of the views, where VPLs are the method.
pub(super) fn view_options(ui: &mut Ui, view: &mut DebugView, session: &Session, out: &mut Output) {
    if session.renderer.estimator::<Vpls>().is_none() {
        return;
    }
    let shows_a_set = shows_a_set(&view.buffer);
    view.change_options(|options| {
        if shows_a_set {
            set(ui, options, session.settings.vpl.temporal_sets);
        }
        paths(ui, options, session.settings.vpl.pool_size().max(1), out);
        single(ui, options, out);
    });
}

/// A title, and what each colour means.
type Legend = (String, Vec<(String, [f32; 3])>);

/// Explains the colours of a view: those of paths, and those of the age of the light in frames.
pub(super) fn legends(view: &DebugView, settings: &VplSettings) -> Vec<Legend> {
    let mut legends = Vec::new();
    if view.buffer == STALENESS {
        let age = |third| format!("{:.0}", f64::from(settings.temporal_sets * third) / 3.0);
        let entries = (0..).zip(SHARE_COLOURS).map(|(third, colour)| (age(third), colour));
        legends.push(("frames old:".to_owned(), entries.collect()));
    }
    if let Some(style) = view.options::<VplDebugView>().vpl_paths {
        let entries = path_legend(style).into_iter().map(|(name, colour)| (name.to_owned(), colour));
        legends.push((format!("paths by {}:", style.label().to_lowercase()), entries.collect()));
        let reasons =
            InvalidationReason::ALL.map(|reason| (reason.label().to_owned(), reason_colour(reason)));
        legends.push(("flashing, since invalidated:".to_owned(), reasons.into()));
    }
    legends
}

/// Names the VPL that is shown alone.
pub(super) fn isolated(view: &DebugView) -> Option<String> {
    let slot = view.options::<VplDebugView>().single_vpl?;
    Some(format!("VPL {slot} alone (. and , step, / shows all)"))
}

/// A hint after the name of a view that needs more.
pub(super) fn hint(view: &DebugView) -> &'static str {
    let lacks_vpl = view.options::<VplDebugView>().single_vpl.is_none();
    if view.buffer == VPL_VISIBILITY && lacks_vpl { " (choose one with , and .)" } else { "" }
}

fn set(ui: &mut Ui, view: &mut VplDebugView, sets: u32) {
    ui.horizontal(|ui| {
        ui.label("temporal set");
        ui.add(DragValue::new(&mut view.set).range(0..=sets.saturating_sub(1)).speed(0.05));
    });
}

fn paths(ui: &mut Ui, view: &mut VplDebugView, most: u32, out: &mut Output) {
    ui.horizontal(|ui| {
        let mut on = view.vpl_paths.is_some();
        if ui
            .checkbox(&mut on, "paths by")
            .on_hover_text("VPLs as points, their paths as lines (P)")
            .changed()
        {
            out.push(ViewAction::TogglePaths);
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
        let mut sample = view.path_sample.unwrap_or(most);
        let slider = Slider::new(&mut sample, 1..=most).logarithmic(true).text("paths");
        if ui.add(slider).on_hover_text("As many of all, evenly chosen").changed() {
            view.path_sample = (sample < most).then_some(sample);
        }
    }
}

fn single(ui: &mut Ui, view: &VplDebugView, out: &mut Output) {
    ui.horizontal(|ui| {
        ui.label("VPL");
        out.on_click(&ui.small_button("<").on_hover_text("previous VPL (,)"), ViewAction::StepVpl(-1));
        ui.label(view.single_vpl.map_or_else(|| "all".to_owned(), |slot| slot.to_string()));
        out.on_click(&ui.small_button(">").on_hover_text("next VPL (.)"), ViewAction::StepVpl(1));
        if ui.add_enabled(view.single_vpl.is_some(), egui::Button::new("all").small()).clicked() {
            out.push(ViewAction::AllVpls);
        }
    });
}

/// The list of VPLs that light a point.
pub(super) fn inspector(ui: &Ui, viewport: Rect, shown: &Shown<'_>, out: &mut Output) {
    let window = Window::new("Inspector")
        .anchor(Align2::LEFT_BOTTOM, [8.0, -8.0])
        .max_width((viewport.width() - 30.0).max(200.0))
        .max_height(viewport.height() * 0.45)
        .resizable(false)
        .vscroll(true);
    window.show(ui.ctx(), |ui| {
        if let Some((pixel, _)) = &shown.view.inspector.pixel {
            ui.label(pixel);
            ui.separator();
        }
        if shown.view.inspector.point.is_none() {
            ui.label("Click a surface.");
            return;
        }
        if shown.view.inspector.found.is_empty() {
            ui.label("No VPL faces this point.");
            return;
        }
        let all: f32 = shown.view.inspector.found.iter().map(brought).sum();
        Grid::new("found").num_columns(6).striped(true).show(ui, |ui| {
            for head in ["slot", "share", "bounce", "age", "path", "ray"] {
                ui.strong(head);
            }
            ui.end_row();
            for found in &shown.view.inspector.found {
                let slot = found.slot.slot;
                if ui.link(slot.to_string()).on_hover_text("Isolate this VPL.").clicked()
                    && let Some(session) = shown.session()
                {
                    let mut view = session.renderer.view().clone();
                    view.change_options(|options: &mut VplDebugView| options.single_vpl = Some(slot));
                    out.push(ViewAction::View(Box::new(view)));
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
fn brought(found: &Found) -> f32 {
    let seen = found.contribution.visible;
    if seen { luminance(found.contribution.irradiance) } else { 0.0 }
}
