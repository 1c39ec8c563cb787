//! The environment: none, one colour, or a map.

use std::path::PathBuf;

use egui::{ComboBox, Slider, SliderClamping, TextEdit, Ui};

use super::shown::Shown;
use super::widgets::{Layout, keep_keyboard, place, place_track, power, short};
use crate::demo::action::{Actions, AppAction, EditAction};
use crate::formats::EnvironmentEntry;

/// The first colour, W/m^2/sr.
const COLOUR: [f32; 3] = [0.5; 3];
/// Strength of a map: the most, and the least above 0.
const STRENGTH: [f32; 2] = [100.0, 0.01];

pub(super) fn draw(
    ui: &mut Ui,
    typed: &mut String,
    shown: &Shown<'_>,
    layout: &mut Layout,
    actions: &mut Actions,
) {
    let Some(session) = shown.session() else { return };
    let now = session.document.environment();
    kind(ui, now, actions);
    ui.horizontal(|ui| {
        let field = ui.add(TextEdit::singleline(typed).hint_text("map.hdr or map.exr").desired_width(150.0));
        place(ui, layout, "map", &field);
        keep_keyboard(ui, &field);
        let entered = field.lost_focus() && ui.input(|input| input.key_pressed(egui::Key::Enter));
        if (ui.button("Use").clicked() || entered) && !typed.trim().is_empty() {
            actions.push(EditAction::OpenMap(PathBuf::from(typed.trim())));
        }
    });
    let Some(now) = now else { return };
    let mut entry = now.clone();
    if entry.has_map() {
        map(ui, &mut entry, layout);
    } else {
        let strength = entry.strength.unwrap_or(1.0);
        let mut radiance = entry.colour.unwrap_or_default().map(|channel| channel * strength);
        let before = radiance;
        power(ui, "radiance", "W/m²/sr", Some(&mut radiance), 0.0);
        if radiance != before {
            entry = EnvironmentEntry::constant(radiance);
        }
    }
    if entry != *now {
        actions.push(EditAction::EditEnvironment(Some(Box::new(entry))));
    }
}

/// The choice of what it is.
fn kind(ui: &mut Ui, now: Option<&EnvironmentEntry>, actions: &mut Actions) {
    let label = match now {
        None => "none",
        Some(EnvironmentEntry { builtin: Some(name), .. }) => name,
        Some(EnvironmentEntry { map: Some(file), .. } | EnvironmentEntry { asset: Some(file), .. }) => {
            short(file.to_str().unwrap_or("map"))
        }
        Some(_) => "colour",
    };
    ComboBox::from_id_salt("environment").selected_text(label).width(210.0).truncate().show_ui(ui, |ui| {
        for (name, entry) in [
            ("none", None),
            ("colour", Some(EnvironmentEntry::constant(COLOUR))),
            ("sky", Some(EnvironmentEntry::sky())),
        ] {
            if ui.selectable_label(name == label, name).clicked() && name != label {
                actions.push(EditAction::EditEnvironment(entry.map(Box::new)));
            }
        }
        if ui.selectable_label(false, "map …").on_hover_text("or drop it on the window").clicked() {
            actions.push(AppAction::AskMap);
        }
    });
}

/// Brightness and rotation of a map.
fn map(ui: &mut Ui, entry: &mut EnvironmentEntry, layout: &mut Layout) {
    let mut strength = entry.strength.unwrap_or(1.0);
    let slider =
        Slider::new(&mut strength, 0.0..=STRENGTH[0]).logarithmic(true).clamping(SliderClamping::Edits);
    let slider = ui.add(slider.smallest_positive(f64::from(STRENGTH[1])).text("strength"));
    place_track(ui, layout, "strength", &slider);
    if slider.changed() {
        entry.strength = Some(strength);
    }
    let mut degrees = entry.rotation_deg.unwrap_or(0.0);
    let slider = ui.add(
        Slider::new(&mut degrees, -180.0..=180.0)
            .clamping(SliderClamping::Edits)
            .suffix("°")
            .text("rotation"),
    );
    place_track(ui, layout, "rotation", &slider);
    if slider.changed() {
        entry.rotation_deg = Some(degrees);
    }
}
