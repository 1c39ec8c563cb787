//! The bar at the top: scene, methods, denoiser, temporal sets, quality, split view, frame rate, still frames.

use clap::ValueEnum;
use egui::{ComboBox, Label, RichText, Ui};

use super::shown::Shown;
use super::thumbnails::Thumbnails;
use super::widgets::{Output, name_of, short};
use crate::demo::action::{AppAction, EditAction, RightSide, ViewAction};
use crate::demo::session::Session;
use crate::estimators;
use crate::settings::{Direct, Indirect, Preset, Settings};

/// Presets that are in the bar, with tooltips.
const QUALITIES: [(Preset, &str); 3] = [
    (Preset::Draft, "Few VPLs, one bounce: for slow devices."),
    (Preset::Default, "The defaults."),
    (Preset::Fine, "Many VPLs, four bounces, a large budget: for fast devices."),
];

/// Size of a scene's picture in the menu, and width of the menu, points.
const THUMBNAIL: egui::Vec2 = egui::vec2(64.0, 36.0);
const MENU: f32 = 290.0;
/// Width of a setting's values in the bar, points.
const AXIS: f32 = 160.0;
pub(super) fn draw(ui: &mut Ui, thumbnails: &mut Thumbnails, shown: &Shown<'_>, out: &mut Output) {
    ui.horizontal_wrapped(|ui| {
        rate(ui, shown);
        scenes(ui, thumbnails, shown, out);
        let Some(session) = shown.session() else { return };
        let mut settings = session.settings.clone();
        methods(ui, &mut settings, out);
        axes(ui, &mut settings, out);
        ui.separator();
        for (preset, about) in QUALITIES {
            let (name, preset) = (name_of(&preset), session.settings.with_preset(preset));
            let label = ui.selectable_label(preset == session.settings, &name).on_hover_text(about);
            out.place(ui, &name, &label);
            if label.clicked() {
                settings = preset;
            }
        }
        ui.separator();
        let split = ui
            .selectable_label(shown.view.split.is_some(), "split")
            .on_hover_text("Another method or the reference right of a divider (C).");
        out.place(ui, "split", &split);
        if split.clicked() {
            let beside = RightSide::beside(&settings);
            out.push(ViewAction::Split(shown.view.split.is_none().then_some(beside)));
        }
        let compare = ui
            .selectable_label(shown.comparison.is_some(), "compare T")
            .on_hover_text("Measures the frame rate against temporal sets, and the error (F3).");
        out.click(ui, "compare T", &compare, AppAction::ToggleCompare);
        // At the end, so that it moves nothing.
        let still = session.renderer.still_frames();
        if still > 0 {
            ui.separator();
            let text = format!("still: {still}/{}", session.settings.still_frames);
            ui.add(Label::new(RichText::new(text).weak()).extend())
                .on_hover_text("While nothing changes, the mean of all frames becomes the picture.");
        }
        if settings != session.settings {
            out.push(EditAction::Set(Box::new(settings)));
        }
    });
}

/// Shows the frame rate of the last half second.
fn rate(ui: &mut Ui, shown: &Shown<'_>) {
    let size = |session: &Session| session.settings.size.map(|side| side.to_string()).join("x");
    let size = shown.session().map(size).unwrap_or_default();
    let ms = shown.history.recent_ms();
    let fps = if ms > 0.0 { 1e3 / ms } else { 0.0 };
    // As wide whatever the numbers, so that nothing moves under the pointer.
    let digits = usize::from(fps < 10.0);
    let is_frozen = shown.session().is_some_and(|session| session.renderer.is_frozen());
    let rate = if is_frozen { "stands still".to_owned() } else { format!("{fps:4.digits$} fps {ms:6.1} ms") };
    ui.monospace(format!("{rate:18} {size:>9}"));
    ui.separator();
}

/// A menu with a picture of each scene; what lacks its models says so.
fn scenes(ui: &mut Ui, thumbnails: &mut Thumbnails, shown: &Shown<'_>, out: &mut Output) {
    let name = shown.session().map_or("none", |session| session.name.as_str());
    let combo = menu(ui, "scene", short(name), 120.0).height(600.0).truncate();
    let menu = combo.show_ui(ui, |ui| {
        ui.set_min_width(MENU);
        for scene in thumbnails.scenes(ui.ctx(), shown.assets) {
            let label = ui.horizontal(|ui| {
                ui.image((scene.picture.id(), THUMBNAIL));
                let text = RichText::new(scene.name);
                let text = if scene.missing.is_some() { text.weak() } else { text };
                let label = ui.selectable_label(scene.name == name, text);
                if scene.missing.is_some() {
                    ui.label(RichText::new("models missing").small().weak());
                }
                label
            });
            let mut label = label.inner;
            if let Some(missing) = &scene.missing {
                label =
                    label.on_hover_text(format!("{} is not there: see docs/SCENES.md", missing.display()));
            }
            out.click(ui, &format!("scene {}", scene.name), &label, AppAction::Open(scene.name.to_owned()));
        }
    });
    out.place(ui, "scenes", &menu.response);
}

/// Goes to the next row where this one has no room for what is so wide.
fn keep_together(ui: &mut Ui, width: f32) {
    if ui.available_size_before_wrap().x < width {
        ui.end_row();
    }
}

/// A menu: it does not wrap by itself.
fn menu(ui: &mut Ui, name: &str, chosen: &str, width: f32) -> ComboBox {
    keep_together(ui, width);
    ComboBox::from_id_salt(name).selected_text(chosen).width(width)
}

fn methods(ui: &mut Ui, settings: &mut Settings, out: &mut Output) {
    ui.separator();
    let indirect = settings.indirect;
    method(ui, out, ("method", "Indirect light"), &mut settings.indirect);
    method(ui, out, ("method of direct light", "Direct light"), &mut settings.direct);
    // Two of them may exclude each other: the one that was chosen last stays.
    if settings.direct == Direct::Paths && settings.indirect != Indirect::PATHS {
        if settings.indirect == indirect {
            settings.indirect = Indirect::PATHS;
        } else {
            settings.direct = Direct::Auto;
        }
    }
    method(ui, out, ("method of reflections", "Reflections"), &mut settings.reflections);
    method(ui, out, ("denoiser", "Denoiser"), &mut settings.effects.denoise);
}

/// A menu of the methods for one kind of light.
fn method<Method: ValueEnum + PartialEq>(
    ui: &mut Ui,
    out: &mut Output,
    (name, what): (&str, &str),
    chosen: &mut Method,
) {
    let menu = menu(ui, name, &name_of(chosen), 64.0).show_ui(ui, |ui| {
        for method in Method::value_variants() {
            let label = ui.selectable_value(chosen, method.clone(), name_of(method));
            out.place(ui, &format!("{name} {}", name_of(method)), &label);
        }
    });
    out.place(ui, name, &menu.response.on_hover_text(what));
}

/// Values to choose from of the settings that the method's short name states.
fn axes(ui: &mut Ui, settings: &mut Settings, out: &mut Output) {
    for axis in estimators::method(settings).axes {
        let (Some(short), Some(values)) = (axis.short, axis.default_sweep) else { continue };
        ui.separator();
        keep_together(ui, AXIS);
        ui.label(short).on_hover_text(axis.label);
        for value in values.split(',').filter_map(|value| value.parse().ok()) {
            let mut chosen = settings.clone();
            (axis.set)(&mut chosen, value);
            // Others are out of range.
            if (axis.get)(&chosen) == value {
                let label = ui.selectable_label(chosen == *settings, value.to_string());
                out.place(ui, &format!("{short} = {value}"), &label);
                if label.clicked() {
                    *settings = chosen;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use egui::{Event, Modifiers, PointerButton, RawInput, Rect, pos2, vec2};

    use super::*;
    use crate::settings::Indirect;

    #[test]
    fn the_menu_offers_every_method_that_is_registered() {
        let context = egui::Context::default();
        let mut settings = Settings::default();
        let mut run = |events: Vec<Event>| {
            let mut out = Output::default();
            let screen_rect = Some(Rect::from_min_size(pos2(0.0, 0.0), vec2(800.0, 600.0)));
            let input = RawInput { screen_rect, events, ..RawInput::default() };
            let _ = context.run_ui(input, |ui| methods(ui, &mut settings, &mut out));
            out.layout
        };
        run(Vec::new());
        let [left, top, right, bottom] = run(Vec::new())["method"];
        let pos = pos2(0.5 * (left + right), 0.5 * (top + bottom));
        let button = |pressed| Event::PointerButton {
            pos,
            button: PointerButton::Primary,
            pressed,
            modifiers: Modifiers::default(),
        };
        run(vec![Event::PointerMoved(pos), button(true)]);
        run(vec![button(false)]);
        run(Vec::new());
        let open = run(Vec::new());
        for value in Indirect::value_variants() {
            assert!(open.contains_key(&format!("method {}", value.name())), "{open:?}");
        }
    }
}
