//! All settings, with tooltips and reset buttons. Rows, ranges and tooltips come from the settings' descriptors.

use egui::{Align, ComboBox, DragValue, Layout, Response, Ui};
use toml::Value;

use super::shown::Shown;
use super::widgets::Output;
use crate::demo::action::{EditAction, ViewAction};
use crate::demo::resolution::{COARSEST, Resolution};
use crate::settings::{GROUPS, Kind, Setting, Settings};

pub(super) fn draw(ui: &mut Ui, shown: &Shown<'_>, out: &mut Output) {
    let Some(session) = shown.session() else { return };
    let mut settings = session.settings.clone();
    let defaults = Settings::default();
    for group in GROUPS {
        ui.separator();
        ui.small(group.title);
        ui.add_enabled_ui((group.in_use)(&session.settings), |ui| {
            for setting in group.settings {
                row(ui, setting, &mut settings, &defaults);
            }
        });
    }
    coarseness(ui, &shown.view.size.resolution, out);
    if settings != session.settings {
        out.push(EditAction::Set(Box::new(settings)));
    }
}

fn coarseness(ui: &mut Ui, resolution: &Resolution, out: &mut Output) {
    let (mut pixels, mut automatic) = (resolution.coarseness, resolution.automatic);
    let line = ui.horizontal(|ui| {
        ui.label("pixel size");
        let field = DragValue::new(&mut pixels).range(1..=COARSEST).speed(0.03);
        ui.add_enabled(!automatic, field.suffix(" px"));
        ui.checkbox(&mut automatic, "auto").on_hover_text("As small as the target fps allow.");
    });
    line.response.on_hover_text(
        "The size follows the window. 2: each pixel covers 2x2 of the window, at a quarter of the cost.",
    );
    if (pixels, automatic) != (resolution.coarseness, resolution.automatic) {
        out.push(ViewAction::SetCoarseness((!automatic).then_some(pixels)));
    }
}

/// One setting: its name, its value, a reset.
pub(super) fn row(ui: &mut Ui, setting: &Setting, settings: &mut Settings, defaults: &Settings) {
    ui.horizontal(|ui| {
        let label = ui.label(setting.key.replace('_', " ")).on_hover_text(setting.full_help());
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            let (text, default) = (setting.text(settings), setting.text(defaults));
            let can_reset = setting.live && text != default;
            let mut wanted = text.clone();
            if ui.add_enabled(can_reset, egui::Button::new("reset").small()).clicked() {
                wanted = default;
            }
            let field = if setting.live {
                field(ui, (setting.key, setting.kind), &setting.value(settings), &mut wanted)
            } else {
                ui.label(&text)
            };
            field.labelled_by(label.id).on_hover_text(setting.full_help());
            let mut changed = settings.clone();
            if wanted != text && setting.set(&mut changed, &wanted).is_ok() && changed.check().is_ok() {
                *settings = changed;
            }
        });
    });
}

/// The widget of a setting; writes the chosen value to `wanted`.
fn field(ui: &mut Ui, (key, kind): (&str, Kind), value: &Value, wanted: &mut String) -> Response {
    // As fast as the number is large, but steps can be seen.
    let drag = |ui: &mut Ui, now: f64, [least, most]: [f64; 2], suffix: &str, wanted: &mut String| {
        let mut number = now;
        let is_whole = value.is_integer();
        let least_speed = if is_whole { 0.05 } else { 1e-3 };
        let field =
            DragValue::new(&mut number).range(least..=most).speed((0.01 * now).abs().max(least_speed));
        let field = if is_whole { field.max_decimals(0) } else { field.max_decimals(4) };
        let response = ui.add(field.suffix(suffix));
        if response.changed() {
            *wanted = if is_whole { number.round() } else { number }.to_string();
        }
        response
    };
    let number = value.as_float().unwrap_or_default();
    match kind {
        Kind::Whole { least, most, .. } => {
            let whole = value.as_integer().unwrap_or_default() as f64;
            drag(ui, whole, [least, most].map(f64::from), "", wanted)
        }
        Kind::Number { least, most, above, .. } => {
            let least = if above { least + 1e-4 } else { least };
            drag(ui, number, [least, most.min(1e9)], "", wanted)
        }
        Kind::Seconds { most } => drag(ui, number, [0.0, most.min(10.0)], " s", wanted),
        Kind::Auto(kind) => {
            let mut automatic = value.is_str();
            let mut response = ui.checkbox(&mut automatic, "auto");
            if response.changed() {
                *wanted = if automatic { "auto" } else { "0" }.to_owned();
            } else if !automatic {
                response |= field(ui, (key, *kind), value, wanted);
            }
            response
        }
        Kind::Features => {
            // Text that is being typed is no list yet.
            let typed = ui.id().with(key);
            let kept = ui.data(|data| data.get_temp(typed));
            let mut names = kept.unwrap_or_else(|| wanted.clone());
            let response = ui.text_edit_singleline(&mut names);
            if response.lost_focus() {
                *wanted = names;
                ui.data_mut(|data| data.remove::<String>(typed));
            } else if response.changed() {
                ui.data_mut(|data| data.insert_temp(typed, names));
            }
            response
        }
        Kind::Flag => {
            let mut flag = value.as_bool().unwrap_or_default();
            let response = ui.checkbox(&mut flag, "");
            *wanted = flag.to_string();
            response
        }
        Kind::Choice(choices) => {
            let combo = ComboBox::from_id_salt(key).selected_text(wanted.as_str()).width(64.0);
            let menu = combo.show_ui(ui, |ui| {
                for choice in choices() {
                    let name = choice.get_name().to_owned();
                    let label = ui.selectable_value(wanted, name.clone(), name);
                    if let Some(help) = choice.get_help() {
                        label.on_hover_text(help.to_string());
                    }
                }
            });
            menu.response
        }
        Kind::Size { .. } => ui.label(wanted.as_str()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::{Direct, Indirect, Preset, Reflections};

    #[test]
    fn settings_of_what_is_not_in_use_are_disabled() {
        let in_use = |settings: &Settings| -> Vec<&str> {
            GROUPS.iter().filter(|group| (group.in_use)(settings)).map(|group| group.table).collect()
        };
        let (direct, reflections) = (Direct::Hard, Reflections::None);
        let plain = Settings { direct, reflections, ..Settings::default() };
        let none = Settings { indirect: Indirect::NONE, ..Settings::default() };
        assert_eq!(
            in_use(&Settings::default()),
            ["settings", "settings.effects", "settings.svgf", "settings.vpls"]
        );
        assert_eq!(in_use(&plain), ["settings", "settings.vpls"]);
        assert_eq!(in_use(&none), ["settings", "settings.effects", "settings.svgf"]);
    }

    /// Each setting has a row, which changes nothing unless somebody uses it.
    #[test]
    fn rows_leave_settings_alone() {
        let context = egui::Context::default();
        let mut settings = Settings { exposure: Some(1.5), ..Settings::default() }.with_preset(Preset::Tonna);
        let before = settings.clone();
        for _ in 0..2 {
            let _ = context.run_ui(egui::RawInput::default(), |ui| {
                let defaults = Settings::default();
                crate::settings::all().for_each(|setting| row(ui, setting, &mut settings, &defaults));
            });
        }
        assert_eq!(settings, before);
    }
}
