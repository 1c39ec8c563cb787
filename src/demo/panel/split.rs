//! The divided window: divider, descriptions of both sides, the reference's picture, the error of the left side.

use std::sync::Arc;
use std::time::Duration;

use egui::{
    Align2, Area, Color32, ColorImage, CursorIcon, FontId, Frame, Id, Pos2, Rect, RichText, Sense, Stroke,
    TextureHandle, TextureOptions, Ui, pos2, vec2,
};

use super::settings::row;
use super::shown::Shown;
use super::widgets::{Output, name_of, short};
use crate::demo::action::{Action, AppAction, RightSide, ViewAction};
use crate::demo::live_metrics::Shot;
use crate::demo::live_reference::{ENOUGH, LiveReference};
use crate::demo::session::Session;
use crate::demo::split::{Right, Split};
use crate::estimators;
use crate::plot::magma;
use crate::report::FrameReport;
use crate::settings::{self, Settings};

/// Half the width of the divider's grip, points.
const GRIP: f32 = 6.0;
/// Distance of the descriptions of both sides from the bar, points.
const LABELS_AT: f32 = 8.0;
/// Settings of the right side that can be chosen.
const CHOICES: [&str; 7] =
    ["indirect", "temporal_sets", "bounces", "direct", "reflections", "antialiasing", "denoise"];

/// Pictures of the CPU, as textures.
#[derive(Default)]
pub(in crate::demo) struct SplitState {
    right: Option<(Arc<Shot>, TextureHandle)>,
    difference: Option<(u64, TextureHandle)>,
}

/// Paints the pictures of the CPU, below everything else.
pub(super) fn pictures(ui: &Ui, state: &mut SplitState, viewport: Rect, split: &Split) {
    if let Some(shot) = split.right_of_cpu() {
        let shown = state.right.take().filter(|(known, _)| Arc::ptr_eq(known, shot));
        let (known, texture) = shown.unwrap_or_else(|| {
            let size = shot.size.map(|side| side as usize);
            let image = ColorImage::from_rgba_unmultiplied(size, bytemuck::cast_slice(&shot.pixels));
            (Arc::clone(shot), ui.ctx().load_texture("right side", image, TextureOptions::NEAREST))
        });
        let right = viewport.with_min_x(divider_of(viewport, split.at));
        paint(ui, &texture, right, viewport);
        state.right = Some((known, texture));
    }
    if !split.shows_difference {
        state.difference = None;
        let divider = divider_of(viewport, split.at);
        ui.painter().vline(divider, viewport.y_range(), Stroke::new(2.0, Color32::WHITE));
        return;
    }
    let Some(compared) = &split.metrics.last else { return };
    let shown = state.difference.take().filter(|(version, _)| *version == split.metrics.version);
    let (version, texture) = shown.unwrap_or_else(|| {
        let colours = compared.flip.iter().map(|&error| magma(f64::from(error)));
        let pixels = colours.map(|[r, g, b]| Color32::from_rgb(r, g, b)).collect();
        let image = ColorImage::new(compared.size, pixels);
        (split.metrics.version, ui.ctx().load_texture("difference", image, TextureOptions::NEAREST))
    });
    paint(ui, &texture, viewport, viewport);
    scale(ui, viewport);
    state.difference = Some((version, texture));
}

fn divider_of(viewport: Rect, at: f32) -> f32 {
    (viewport.left() + at * viewport.width()).round()
}

/// The part of a picture of the whole viewport.
fn paint(ui: &Ui, texture: &TextureHandle, part: Rect, viewport: Rect) {
    let share = |at: Pos2| ((at - viewport.min) / viewport.size()).to_pos2();
    let uv = Rect::from_min_max(share(part.min), share(part.max));
    ui.painter().image(texture.id(), part, uv, Color32::WHITE);
}

/// The scale of the error.
fn scale(ui: &Ui, viewport: Rect) {
    let bar = Rect::from_min_size(pos2(viewport.left() + 12.0, viewport.bottom() - 34.0), vec2(160.0, 10.0));
    let steps = 32;
    for step in 0..steps {
        let share = |step: i32| step as f32 / steps as f32;
        let [r, g, b] = magma(f64::from(share(step) + 0.5 / steps as f32));
        let piece = Rect::from_x_y_ranges(
            bar.left() + share(step) * bar.width()..=bar.left() + share(step + 1) * bar.width(),
            bar.y_range(),
        );
        ui.painter().rect_filled(piece, 0.0, Color32::from_rgb(r, g, b));
    }
    let text = |at: Pos2, align, text: &str| {
        ui.painter().text(at, align, text, FontId::proportional(12.0), Color32::WHITE);
    };
    text(bar.left_bottom(), Align2::LEFT_TOP, "0");
    text(bar.center_bottom(), Align2::CENTER_TOP, "FLIP error");
    text(bar.right_bottom(), Align2::RIGHT_TOP, "1");
}

/// The divider, with a description of both sides.
pub(super) fn draw(ui: &mut Ui, shown: &Shown<'_>, out: &mut Output) {
    let (Some(session), Some(split)) = (shown.session(), &shown.view.split) else { return };
    let viewport = shown.picture_area(ui.ctx());
    let x = divider_of(viewport, split.at);
    let line = Rect::from_x_y_ranges(x - GRIP..=x + GRIP, viewport.y_range());
    let divider = Area::new(Id::new("divider")).fixed_pos(line.min).show(ui.ctx(), |ui| {
        ui.allocate_response(line.size(), Sense::drag()).on_hover_cursor(CursorIcon::ResizeHorizontal)
    });
    out.place(ui, "divider", &divider.inner);
    if divider.inner.dragged()
        && let Some(at) = divider.inner.interact_pointer_pos()
    {
        let share = (at.x - viewport.left()) / viewport.width();
        out.push(ViewAction::MoveDivider(share.clamp(0.02, 0.98)));
    }
    let label = |id: &str, at: Pos2, align: Align2, add: &mut dyn FnMut(&mut Ui)| {
        Area::new(Id::new(id)).fixed_pos(at).pivot(align).constrain_to(viewport).show(ui.ctx(), |ui| {
            Frame::popup(ui.style()).show(ui, |ui| {
                ui.set_max_width(190.0);
                add(ui);
            });
        });
    };
    let left = pos2(x - 10.0, viewport.top() + LABELS_AT);
    label("left side", left, Align2::RIGHT_TOP, &mut |ui| {
        ui.label(RichText::new(described(&session.settings)).strong());
        ui.label(milliseconds(&session.report));
        numbers(ui, split);
    });
    let right = pos2(x + 10.0, viewport.top() + LABELS_AT);
    label("right side", right, Align2::LEFT_TOP, &mut |ui| {
        right_side(ui, (session, split), out);
    });
}

fn right_side(ui: &mut Ui, (session, split): (&Session, &Split), out: &mut Output) {
    ui.horizontal_wrapped(|ui| {
        let (is_method, is_reference) =
            (matches!(split.right, Right::Renderer(_)), matches!(split.right, Right::Reference(_)));
        let mut choice = |name: &str, is_on: bool, what: &str, action: Option<Action>| {
            let choice = ui.selectable_label(is_on, name).on_hover_text(what);
            out.place(ui, name, &choice);
            if choice.clicked() {
                out.extend(action);
            }
        };
        let side = |is_on: bool, side: RightSide| (!is_on).then_some(ViewAction::Split(Some(side)).into());
        let what =
            "The same world by other settings; each side draws as many frames as it can in half of the time.";
        choice("method", is_method, what, side(is_method, RightSide::beside(&session.settings)));
        let what = "The path tracer, while nothing moves (G).";
        choice("reference", is_reference, what, side(is_reference, RightSide::Reference));
        let what = "The picture of an .exr, .hdr or .png, which can also be dropped on the window.";
        choice("file …", !is_method && !is_reference, what, Some(AppAction::AskPicture.into()));
        let what = "FLIP error of the left side (X).";
        choice("difference", split.shows_difference, what, Some(ViewAction::ToggleDifference.into()));
    });
    match &split.right {
        Right::Reference(reference) => progress(ui, reference),
        Right::Picture(picture) => {
            ui.label(RichText::new(short(&picture.path.to_string_lossy())).strong());
            ui.label(picture.described());
        }
        Right::Renderer(other) => {
            ui.label(RichText::new(described(&other.settings)).strong());
            ui.label(milliseconds(&other.report));
            let mut settings = other.settings.clone();
            let folded = egui::CollapsingHeader::new("change").default_open(false);
            let header = folded.show(ui, |ui| {
                for setting in CHOICES.into_iter().filter_map(settings::find) {
                    row(ui, setting, &mut settings, &session.settings);
                }
            });
            out.place(ui, "change", &header.header_response);
            if settings != other.settings {
                out.push(ViewAction::Split(Some(RightSide::Settings(Box::new(settings)))));
            }
        }
    }
}

fn progress(ui: &mut Ui, reference: &LiveReference) {
    let Some(progress) = &reference.progress else {
        ui.label("waits until nothing moves (Space pauses)");
        return;
    };
    let percent = progress.error.map_or(String::new(), |error| format!(", noise {:.1} %", 100.0 * error));
    ui.label(RichText::new(format!("path tracer: {} of {ENOUGH} samples", progress.samples)).strong());
    ui.label(format!("{} left{percent}", minutes(progress.left())));
}

fn minutes(time: Duration) -> String {
    let seconds = time.as_secs();
    if seconds >= 60 { format!("{} min {} s", seconds / 60, seconds % 60) } else { format!("{seconds} s") }
}

/// The error of the left side.
fn numbers(ui: &mut Ui, split: &Split) {
    let Some(compared) = &split.metrics.last else { return };
    let metrics = compared.metrics;
    ui.label(format!("FLIP {:.4}, SSIM {:.4}", metrics.flip, metrics.ssim));
    ui.label(format!("relative error {:.2} %", 100.0 * metrics.mean_relative_error));
    if let Some(error) = compared.temporal_error {
        ui.label(format!("temporal error {error:.4}"));
    }
}

fn milliseconds(report: &FrameReport) -> String {
    let ms = report.figures.total_ms;
    if ms > 0.0 { format!("{:.1} frames/s ({ms:.1} ms)", 1e3 / ms) } else { "stands still".to_owned() }
}

/// Names the methods that light a picture.
fn described(settings: &Settings) -> String {
    let indirect = estimators::method(settings).short_name(settings);
    format!("{indirect}; {}, {}", name_of(&settings.direct), name_of(&settings.antialiasing))
}
