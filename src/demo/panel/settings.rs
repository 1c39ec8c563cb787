//! Every setting, with its documentation, a reset, and presets.
//!
//! The documentation comes from the command line's help, where it is written once.

use std::collections::BTreeMap;

use clap::Args;
use egui::{Align, ComboBox, DragValue, Layout, Slider, Ui};

use super::{PanelState, Places, Shown, place};
use crate::demo::action::Action;
use crate::settings::{MissingSets, Sequence, Settings, TracerKind};

/// Which settings stand together.
const GROUPS: [(&str, &[&str]); 4] = [
    ("Virtual point lights", &["vpls", "bounces", "budget", "clamp", "seed", "sequence"]),
    ("Over time", &["temporal_sets", "missing_sets", "position_cutoff", "time_step"]),
    ("Over pixels", &["interleave", "roulette", "size"]),
    ("Picture", &["exposure", "tracer"]),
];

/// Documentation of each setting.
pub(super) struct SettingsDocs(BTreeMap<String, String>);

impl Default for SettingsDocs {
    fn default() -> Self {
        let command = Settings::augment_args(clap::Command::new("settings"));
        let doc = |argument: &clap::Arg| {
            let help = argument.get_help().map(ToString::to_string).unwrap_or_default();
            (argument.get_id().to_string(), help)
        };
        Self(command.get_arguments().map(doc).collect())
    }
}

/// Settings that go together well.
fn presets(now: &Settings) -> [(&'static str, &'static str, Settings); 4] {
    // What is not a matter of quality stays.
    let base = Settings {
        size: now.size,
        seed: now.seed,
        time_step: now.time_step,
        tracer: now.tracer,
        exposure: now.exposure,
        ..Settings::default()
    };
    [
        (
            "draft",
            "Few VPLs, one bounce: for slow devices.",
            Settings { vpls: 128, bounces: 1, budget: 32, ..base.clone() },
        ),
        ("balanced", "The defaults.", base.clone()),
        (
            "quality",
            "Many VPLs, four bounces, a large budget: for fast devices.",
            Settings { vpls: 4096, bounces: 4, budget: 512, clamp: 1600.0, ..base.clone() },
        ),
        (
            "as in the dissertation",
            "512 VPLs in 16 sets, 4x4 interleaving; surfaces missing from a set stay dark (Tonna 2019).",
            Settings { missing_sets: MissingSets::Dark, ..base },
        ),
    ]
}

pub(super) fn show(
    ui: &mut Ui,
    state: &PanelState,
    shown: &Shown<'_>,
    places: &mut Places,
    wishes: &mut Vec<Action>,
) {
    let Some(stage) = shown.stage else { return };
    let mut settings = stage.settings.clone();
    ui.horizontal_wrapped(|ui| {
        for (name, what, preset) in presets(&stage.settings) {
            let label = ui.selectable_label(preset == stage.settings, name).on_hover_text(what);
            place(ui, places, name, &label);
            if label.clicked() {
                settings = preset;
            }
        }
    });
    let defaults = Settings { size: settings.size, ..Settings::default() };
    for (title, names) in GROUPS {
        ui.separator();
        ui.small(title);
        for name in names {
            let doc = state.settings.0.get(*name).map_or("", String::as_str);
            row(ui, name, doc, &mut settings, &defaults);
        }
    }
    let mut coarseness = shown.coarseness;
    ui.horizontal(|ui| {
        ui.label("window pixels a pixel");
        ui.add(DragValue::new(&mut coarseness).range(1..=8).speed(0.03));
    })
    .response
    .on_hover_text(
        "The size follows the window. 2: every pixel covers 2x2 of the window, at a quarter of the cost.",
    );
    if coarseness != shown.coarseness {
        wishes.push(Action::SetCoarseness(coarseness));
    }
    if settings != stage.settings {
        wishes.push(Action::Set(Box::new(settings)));
    }
}

/// One setting: its name, its value, a reset.
fn row(ui: &mut Ui, name: &str, doc: &str, settings: &mut Settings, defaults: &Settings) {
    ui.horizontal(|ui| {
        let label = ui.label(name.replace('_', " ")).on_hover_text(doc);
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            let mut reset = settings.clone();
            copy(name, defaults, &mut reset);
            let differs = reset != *settings;
            if ui.add_enabled(differs, egui::Button::new("reset").small()).clicked() {
                *settings = reset;
            }
            field(ui, name, settings).labelled_by(label.id).on_hover_text(doc);
        });
    });
}

/// The widget of a setting.
fn field(ui: &mut Ui, name: &str, settings: &mut Settings) -> egui::Response {
    let whole = |ui: &mut Ui, value: &mut u32, most: u32| {
        ui.add(DragValue::new(value).range(1..=most).speed(f64::from(most) * 2e-3))
    };
    match name {
        "vpls" => {
            // More sets than VPLs to fill them is an error.
            let least = settings.temporal_sets;
            ui.add(DragValue::new(&mut settings.vpls).range(least..=65_536).speed(8.0))
        }
        "bounces" => whole(ui, &mut settings.bounces, 16),
        "budget" => whole(ui, &mut settings.budget, 65_536),
        "clamp" => ui.add(DragValue::new(&mut settings.clamp).range(0.0..=1e9).speed(5.0)),
        "roulette" => ui.add(DragValue::new(&mut settings.roulette).range(0.0..=1.0).speed(0.005)),
        "seed" => ui.add(DragValue::new(&mut settings.seed)),
        "sequence" => choice(
            ui,
            name,
            &mut settings.sequence,
            &[(Sequence::Sobol, "sobol"), (Sequence::Random, "random")],
        ),
        "temporal_sets" => {
            let most = settings.vpls.min(64);
            whole(ui, &mut settings.temporal_sets, most)
        }
        "missing_sets" => choice(
            ui,
            name,
            &mut settings.missing_sets,
            &[(MissingSets::Scale, "scale"), (MissingSets::Dark, "dark")],
        ),
        "position_cutoff" => {
            let slider = Slider::new(&mut settings.position_cutoff, 1e-4..=1.0).logarithmic(true);
            ui.spacing_mut().slider_width = 50.0;
            ui.add(slider)
        }
        "time_step" => {
            let value = DragValue::new(&mut settings.time_step).range(0.0..=10.0).speed(1e-3);
            ui.add(value.max_decimals(4).suffix(" s"))
        }
        "interleave" => whole(ui, &mut settings.interleave, 8),
        "size" => ui.label(format!("{}x{}", settings.size[0], settings.size[1])),
        "exposure" => exposure(ui, &mut settings.exposure),
        _ => choice(
            ui,
            name,
            &mut settings.tracer,
            &[
                (TracerKind::Auto, "auto"),
                (TracerKind::Software, "software"),
                (TracerKind::Hardware, "hardware"),
            ],
        ),
    }
}

fn exposure(ui: &mut Ui, exposure: &mut Option<f32>) -> egui::Response {
    let mut automatic = exposure.is_none();
    let mut response = ui.checkbox(&mut automatic, "auto");
    if response.changed() {
        *exposure = if automatic { None } else { Some(0.0) };
    }
    if let Some(stops) = exposure {
        response |= ui.add(DragValue::new(stops).range(-64.0..=64.0).speed(0.05).suffix(" EV"));
    }
    response
}

fn choice<Value: Copy + PartialEq>(
    ui: &mut Ui,
    name: &str,
    value: &mut Value,
    choices: &[(Value, &str)],
) -> egui::Response {
    let chosen = choices.iter().find(|(choice, _)| choice == value).map_or("", |(_, label)| label);
    let combo = ComboBox::from_id_salt(name).selected_text(chosen).width(80.0);
    combo
        .show_ui(ui, |ui| {
            for (choice, label) in choices {
                ui.selectable_value(value, *choice, *label);
            }
        })
        .response
}

/// Copies one setting.
fn copy(name: &str, from: &Settings, to: &mut Settings) {
    match name {
        "vpls" => to.vpls = from.vpls.max(to.temporal_sets),
        "bounces" => to.bounces = from.bounces,
        "budget" => to.budget = from.budget,
        "clamp" => to.clamp = from.clamp,
        "roulette" => to.roulette = from.roulette,
        "seed" => to.seed = from.seed,
        "sequence" => to.sequence = from.sequence,
        "temporal_sets" => to.temporal_sets = from.temporal_sets.min(to.vpls),
        "missing_sets" => to.missing_sets = from.missing_sets,
        "position_cutoff" => to.position_cutoff = from.position_cutoff,
        "time_step" => to.time_step = from.time_step,
        "interleave" => to.interleave = from.interleave,
        "size" => to.size = from.size,
        "exposure" => to.exposure = from.exposure,
        _ => to.tracer = from.tracer,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every field of the struct is in one group, has documentation, and can be copied.
    #[test]
    fn no_setting_is_missing() {
        let docs = SettingsDocs::default().0;
        let mut shown: Vec<&str> = GROUPS.iter().flat_map(|(_, names)| names.iter().copied()).collect();
        shown.sort_unstable();
        assert_eq!(shown, docs.keys().map(String::as_str).collect::<Vec<_>>());
        assert!(docs.values().all(|doc| doc.len() > 20), "{docs:?}");
        let other = Settings {
            vpls: 77,
            bounces: 7,
            interleave: 2,
            temporal_sets: 3,
            budget: 5,
            clamp: 1.5,
            roulette: 0.5,
            position_cutoff: 0.5,
            size: [8, 9],
            seed: 4,
            sequence: Sequence::Random,
            time_step: 0.5,
            tracer: TracerKind::Software,
            missing_sets: MissingSets::Dark,
            exposure: Some(1.0),
        };
        let mut copied = Settings::default();
        for name in shown {
            let before = copied.clone();
            copy(name, &other, &mut copied);
            assert_ne!(copied, before, "{name}");
        }
        assert_eq!(copied, other);
    }

    #[test]
    fn presets_can_be_used() {
        for (name, _, preset) in presets(&Settings::default()) {
            assert_eq!(preset.check(), Ok(()), "{name}");
        }
    }
}
