//! The environment: none, one colour, or a map.

use egui::{ComboBox, Slider, Ui};

use super::shown::Shown;
use super::widgets::{Output, power, short};
use crate::demo::action::{AppAction, EditAction};
use crate::formats::EnvironmentEntry;

/// The first colour, W/m^2/sr.
const COLOUR: [f32; 3] = [0.5; 3];
/// Strength of a map: the most, and the least above 0.
const STRENGTH: [f32; 2] = [100.0, 0.01];

pub(super) fn draw(ui: &mut Ui, typed: &mut String, shown: &Shown<'_>, out: &mut Output) {
    let Some(session) = shown.session() else { return };
    let now = session.document.environment();
    kind(ui, now, out);
    let entered = out.entry(ui, ("map", "Use"), typed, "map.hdr or map.exr");
    out.extend(entered.map(|map| EditAction::OpenMap(map.into())));
    let Some(now) = now else { return };
    let mut entry = now.clone();
    if entry.has_map() {
        map(ui, &mut entry, out);
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
        out.push(EditAction::EditEnvironment(Some(Box::new(entry))));
    }
}

/// The choice of what it is.
fn kind(ui: &mut Ui, now: Option<&EnvironmentEntry>, out: &mut Output) {
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
                out.push(EditAction::EditEnvironment(entry.map(Box::new)));
            }
        }
        let label = ui.selectable_label(false, "map …").on_hover_text("or drop it on the window");
        out.on_click(&label, AppAction::AskMap);
    });
}

/// Brightness and rotation of a map.
fn map(ui: &mut Ui, entry: &mut EnvironmentEntry, out: &mut Output) {
    let mut strength = entry.strength.unwrap_or(1.0);
    let slider = Slider::new(&mut strength, 0.0..=STRENGTH[0]).logarithmic(true).text("strength");
    if out.slider(ui, "strength", slider.smallest_positive(f64::from(STRENGTH[1]))).changed() {
        entry.strength = Some(strength);
    }
    let mut degrees = entry.rotation_deg.unwrap_or(0.0);
    let slider = Slider::new(&mut degrees, -180.0..=180.0).suffix("°").text("rotation");
    if out.slider(ui, "rotation", slider).changed() {
        entry.rotation_deg = Some(degrees);
    }
}
