//! The bar at the top: scene, method, temporal sets, quality, split view, frame rate.

use egui::{ComboBox, Ui};

use super::scene::short;
use super::settings::{choice, presets};
use super::{Places, Shown, place};
use crate::demo::action::Action;
use crate::demo::split::RightSide;
use crate::scene::BUILTIN_SCENES;
use crate::settings::{Indirect, Settings};

/// Temporal sets to choose from.
const SETS: [u32; 5] = [1, 4, 8, 16, 32];
/// Presets that are in the bar, the first ones.
const QUALITIES: usize = 3;

pub(super) fn show(ui: &mut Ui, shown: &Shown<'_>, places: &mut Places, actions: &mut Vec<Action>) {
    ui.horizontal_wrapped(|ui| {
        rate(ui, shown);
        scenes(ui, shown, actions);
        let Some(stage) = shown.stage else { return };
        let mut settings = stage.settings.clone();
        methods(ui, &mut settings, places);
        if settings.indirect == Indirect::Vpls {
            sets(ui, &mut settings, places);
        }
        ui.separator();
        for (name, what, preset) in presets(&stage.settings).into_iter().take(QUALITIES) {
            let label = ui.selectable_label(preset == stage.settings, name).on_hover_text(what);
            place(ui, places, name, &label);
            if label.clicked() {
                settings = preset;
            }
        }
        ui.separator();
        let split = ui
            .selectable_label(shown.split.is_some(), "split")
            .on_hover_text("Another method or the truth right of a divider (C).");
        place(ui, places, "split", &split);
        if split.clicked() {
            let same = RightSide::Settings(Box::new(settings.clone()));
            actions.push(Action::Split(shown.split.is_none().then_some(same)));
        }
        if settings != stage.settings {
            actions.push(Action::Set(Box::new(settings)));
        }
    });
}

/// Of the last half second.
fn rate(ui: &mut Ui, shown: &Shown<'_>) {
    let ms = shown.history.recent_ms();
    let fps = if ms > 0.0 { 1e3 / ms } else { 0.0 };
    // As wide whatever the numbers, so that nothing moves under the pointer.
    let digits = usize::from(fps < 10.0);
    ui.monospace(format!("{fps:4.digits$} fps {ms:6.1} ms"));
    ui.separator();
}

fn scenes(ui: &mut Ui, shown: &Shown<'_>, actions: &mut Vec<Action>) {
    let name = shown.stage.map_or("none", |stage| stage.name.as_str());
    let combo = ComboBox::from_id_salt("scene").selected_text(short(name)).width(120.0).truncate();
    combo.show_ui(ui, |ui| {
        for scene in BUILTIN_SCENES {
            if ui.selectable_label(scene == name, scene).clicked() {
                actions.push(Action::Open(scene.to_owned()));
            }
        }
    });
}

fn methods(ui: &mut Ui, settings: &mut Settings, places: &mut Places) {
    ui.separator();
    let indirect = choice(ui, "method", &mut settings.indirect).on_hover_text("Indirect light");
    place(ui, places, "method", &indirect);
    let direct = choice(ui, "method of direct light", &mut settings.direct).on_hover_text("Direct light");
    place(ui, places, "method of direct light", &direct);
    let reflections = choice(ui, "method of reflections", &mut settings.reflections);
    place(ui, places, "method of reflections", &reflections.on_hover_text("Reflections"));
}

fn sets(ui: &mut Ui, settings: &mut Settings, places: &mut Places) {
    ui.separator();
    ui.label("T").on_hover_text("Temporal sets: so many frames share the work of one.");
    for count in SETS.into_iter().filter(|count| *count <= settings.vpl.slots) {
        let label = ui.selectable_label(settings.vpl.temporal_sets == count, count.to_string());
        place(ui, places, &format!("T = {count}"), &label);
        if label.clicked() {
            settings.vpl.temporal_sets = count;
        }
    }
}
