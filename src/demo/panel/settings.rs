//! All settings, with tooltips, reset buttons and presets.
//!
//! The tooltips come from the command line's help.

use std::collections::BTreeMap;

use clap::{Args, ValueEnum};
use egui::{Align, ComboBox, DragValue, Layout, Slider, Ui};

use super::{PanelState, Shown};
use crate::demo::action::Action;
use crate::demo::resolution::{COARSEST, Resolution};
use crate::settings::{
    Denoise, Direct, Group, Indirect, MissingSets, Reflections, Settings, SvgfSettings, VplSettings, groups,
};

/// The groups of settings, and the documentation of each setting.
pub(super) struct SettingsDocs {
    groups: Vec<Group>,
    docs: BTreeMap<String, String>,
}

impl Default for SettingsDocs {
    fn default() -> Self {
        let command = Settings::augment_args(clap::Command::new("settings"));
        let doc = |argument: &clap::Arg| {
            let help = argument.get_help().map(ToString::to_string).unwrap_or_default();
            (argument.get_id().to_string(), help)
        };
        Self { groups: groups(), docs: command.get_arguments().map(doc).collect() }
    }
}

impl SettingsDocs {
    /// What a setting is for.
    pub fn doc(&self, setting: &str) -> &str {
        self.docs.get(setting).map_or("", String::as_str)
    }
}

/// Whether the method that a group belongs to is in use.
fn is_in_use(group: &Group, settings: &Settings) -> bool {
    let has_effects = settings.direct == Direct::Rays || settings.reflections != Reflections::None;
    match group.table.as_str() {
        "settings.vpls" => settings.indirect == Indirect::VPLS,
        "settings.effects" => has_effects,
        "settings.svgf" => has_effects && settings.effects.denoise == Denoise::Svgf,
        _ => true,
    }
}

/// Presets.
pub(super) fn presets(now: &Settings) -> [(&'static str, &'static str, Settings); 4] {
    // Keep what does not affect quality.
    let base = Settings {
        indirect: now.indirect,
        direct: now.direct,
        reflections: now.reflections,
        antialiasing: now.antialiasing,
        effects: now.effects,
        svgf: now.svgf,
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
            Settings { bounces: 1, vpl: VplSettings { slots: 128, budget: 32, ..base.vpl }, ..base.clone() },
        ),
        ("normal", "The defaults.", base.clone()),
        (
            "fine",
            "Many VPLs, four bounces, a large budget: for fast devices.",
            Settings {
                bounces: 4,
                vpl: VplSettings { slots: 4096, budget: 512, clamp: 1600.0, ..base.vpl },
                ..base.clone()
            },
        ),
        (
            "as in the dissertation",
            "512 VPLs in 16 sets, 4x4 interleaving; surfaces missing from a set stay dark (Tonna 2019).",
            Settings { vpl: VplSettings { missing_sets: MissingSets::Dark, ..base.vpl }, ..base },
        ),
    ]
}

pub(super) fn show(ui: &mut Ui, state: &PanelState, shown: &Shown<'_>, actions: &mut Vec<Action>) {
    let Some(session) = shown.session else { return };
    let mut settings = session.settings.clone();
    let [.., (name, what, dissertation)] = presets(&session.settings);
    if ui.selectable_label(dissertation == settings, name).on_hover_text(what).clicked() {
        settings = dissertation;
    }
    let defaults = Settings { size: settings.size, ..Settings::default() };
    for group in &state.settings.groups {
        ui.separator();
        ui.small(&group.heading);
        ui.add_enabled_ui(is_in_use(group, &session.settings), |ui| {
            for name in &group.settings {
                row(ui, name, state.settings.doc(name), &mut settings, &defaults);
            }
        });
    }
    coarseness(ui, shown.resolution, actions);
    if settings != session.settings {
        actions.push(Action::Set(Box::new(settings)));
    }
}

fn coarseness(ui: &mut Ui, resolution: &Resolution, actions: &mut Vec<Action>) {
    let (mut pixels, mut automatic) = (resolution.coarseness, resolution.automatic);
    let line = ui.horizontal(|ui| {
        ui.label("pixel size");
        let field = DragValue::new(&mut pixels).range(1..=COARSEST).speed(0.03);
        ui.add_enabled(!automatic, field.suffix(" px"));
        ui.checkbox(&mut automatic, "auto").on_hover_text("As few as 15 frames a second allow.");
    });
    line.response.on_hover_text(
        "The size follows the window. 2: each pixel covers 2x2 of the window, at a quarter of the cost.",
    );
    if (pixels, automatic) != (resolution.coarseness, resolution.automatic) {
        actions.push(Action::SetCoarseness((!automatic).then_some(pixels)));
    }
}

/// One setting: its name, its value, a reset.
pub(super) fn row(ui: &mut Ui, name: &str, doc: &str, settings: &mut Settings, defaults: &Settings) {
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
            // There must be at least as many VPLs as sets.
            let least = settings.vpl.temporal_sets;
            ui.add(DragValue::new(&mut settings.vpl.slots).range(least..=65_536).speed(8.0))
        }
        "indirect" => choice(ui, name, &mut settings.indirect),
        "direct" => choice(ui, name, &mut settings.direct),
        "reflections" => choice(ui, name, &mut settings.reflections),
        "antialiasing" => choice(ui, name, &mut settings.antialiasing),
        "denoise" => choice(ui, name, &mut settings.effects.denoise),
        "noise" => choice(ui, name, &mut settings.effects.noise),
        "reflection_depth" => whole(ui, &mut settings.effects.reflection_depth, 8),
        "reflection_roughness" => {
            ui.add(DragValue::new(&mut settings.effects.reflection_roughness).range(0.0..=1.0).speed(0.01))
        }
        name if name.starts_with("svgf_") => svgf_field(ui, name, &mut settings.svgf),
        "bounces" => whole(ui, &mut settings.bounces, 16),
        "candidates" => ui.add(DragValue::new(&mut settings.vpl.candidates).range(1..=64).speed(0.1)),
        "pool" => ui.add(DragValue::new(&mut settings.vpl.pool).range(1..=65_536).speed(64.0)),
        "budget" => whole(ui, &mut settings.vpl.budget, 65_536),
        "refresh" => ui.add(DragValue::new(&mut settings.vpl.refresh).range(0..=63)),
        "clamp" => ui.add(DragValue::new(&mut settings.vpl.clamp).range(0.0..=1e9).speed(5.0)),
        "seed" => ui.add(DragValue::new(&mut settings.seed)),
        "sequence" => choice(ui, name, &mut settings.vpl.sequence),
        "temporal_sets" => {
            let most = settings.vpl.slots.min(64);
            whole(ui, &mut settings.vpl.temporal_sets, most)
        }
        "missing_sets" => choice(ui, name, &mut settings.vpl.missing_sets),
        "position_cutoff" => {
            let slider = Slider::new(&mut settings.vpl.position_cutoff, 1e-4..=1.0).logarithmic(true);
            ui.spacing_mut().slider_width = 50.0;
            ui.add(slider)
        }
        "time_step" => {
            let value = DragValue::new(&mut settings.time_step).range(0.0..=10.0).speed(1e-3);
            ui.add(value.max_decimals(4).suffix(" s"))
        }
        "interleave" => whole(ui, &mut settings.vpl.interleave, 8),
        "size" => ui.label(format!("{}x{}", settings.size[0], settings.size[1])),
        "exposure" => exposure(ui, &mut settings.exposure),
        _ => choice(ui, name, &mut settings.tracer),
    }
}

fn svgf_field(ui: &mut Ui, name: &str, svgf: &mut SvgfSettings) -> egui::Response {
    let share = |ui: &mut Ui, value: &mut f32| ui.add(DragValue::new(value).range(0.0..=1.0).speed(0.005));
    let above_0 = |ui: &mut Ui, value: &mut f32| ui.add(DragValue::new(value).range(1e-3..=1e3).speed(0.05));
    match name {
        "svgf_alpha" => share(ui, &mut svgf.alpha),
        "svgf_moments_alpha" => share(ui, &mut svgf.moments_alpha),
        "svgf_history" => ui.add(DragValue::new(&mut svgf.longest_history).range(1..=1024)),
        "svgf_clamp" => ui.add(DragValue::new(&mut svgf.clamp).range(0.0..=1e3).speed(0.05)),
        "svgf_firefly" => ui.add(DragValue::new(&mut svgf.firefly).range(0.0..=1e3).speed(0.1)),
        "svgf_levels" => ui.add(DragValue::new(&mut svgf.levels).range(0..=5).speed(0.05)),
        "svgf_feedback" => ui.add(DragValue::new(&mut svgf.feedback).range(0..=4).speed(0.05)),
        "svgf_separable" => ui.checkbox(&mut svgf.separable, ""),
        "svgf_adaptive" => ui.checkbox(&mut svgf.adaptive, ""),
        "svgf_reinhard" => ui.checkbox(&mut svgf.reinhard, ""),
        "svgf_depth" => above_0(ui, &mut svgf.depth_tolerance),
        "svgf_normal" => ui.add(DragValue::new(&mut svgf.normal_exponent).range(0.0..=1024.0)),
        _ => above_0(ui, &mut svgf.luminance_tolerance),
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

/// The name of a value on the command line.
pub(super) fn name_of(value: &impl ValueEnum) -> String {
    value.to_possible_value().map(|possible| possible.get_name().to_owned()).unwrap_or_default()
}

/// One of an enum's values.
fn choice<Value: ValueEnum + PartialEq>(ui: &mut Ui, name: &str, value: &mut Value) -> egui::Response {
    let combo = ComboBox::from_id_salt(name).selected_text(name_of(value)).width(64.0);
    combo
        .show_ui(ui, |ui| {
            for choice in Value::value_variants() {
                ui.selectable_value(value, choice.clone(), name_of(choice));
            }
        })
        .response
}

/// Copies one setting.
fn copy(name: &str, from: &Settings, to: &mut Settings) {
    match name {
        "vpls" => to.vpl.slots = from.vpl.slots.max(to.vpl.temporal_sets),
        "indirect" => to.indirect = from.indirect,
        "direct" => to.direct = from.direct,
        "reflections" => to.reflections = from.reflections,
        "antialiasing" => to.antialiasing = from.antialiasing,
        "denoise" => to.effects.denoise = from.effects.denoise,
        "noise" => to.effects.noise = from.effects.noise,
        "reflection_depth" => to.effects.reflection_depth = from.effects.reflection_depth,
        "reflection_roughness" => to.effects.reflection_roughness = from.effects.reflection_roughness,
        name if name.starts_with("svgf_") => copy_svgf(name, &from.svgf, &mut to.svgf),
        "bounces" => to.bounces = from.bounces,
        "candidates" => to.vpl.candidates = from.vpl.candidates,
        "pool" => to.vpl.pool = from.vpl.pool,
        "budget" => to.vpl.budget = from.vpl.budget,
        "refresh" => to.vpl.refresh = from.vpl.refresh,
        "clamp" => to.vpl.clamp = from.vpl.clamp,
        "seed" => to.seed = from.seed,
        "sequence" => to.vpl.sequence = from.vpl.sequence,
        "temporal_sets" => to.vpl.temporal_sets = from.vpl.temporal_sets.min(to.vpl.slots),
        "missing_sets" => to.vpl.missing_sets = from.vpl.missing_sets,
        "position_cutoff" => to.vpl.position_cutoff = from.vpl.position_cutoff,
        "time_step" => to.time_step = from.time_step,
        "interleave" => to.vpl.interleave = from.vpl.interleave,
        "size" => to.size = from.size,
        "exposure" => to.exposure = from.exposure,
        _ => to.tracer = from.tracer,
    }
}

fn copy_svgf(name: &str, from: &SvgfSettings, to: &mut SvgfSettings) {
    match name {
        "svgf_alpha" => to.alpha = from.alpha,
        "svgf_moments_alpha" => to.moments_alpha = from.moments_alpha,
        "svgf_history" => to.longest_history = from.longest_history,
        "svgf_clamp" => to.clamp = from.clamp,
        "svgf_firefly" => to.firefly = from.firefly,
        "svgf_levels" => to.levels = from.levels,
        "svgf_feedback" => to.feedback = from.feedback,
        "svgf_separable" => to.separable = from.separable,
        "svgf_adaptive" => to.adaptive = from.adaptive,
        "svgf_reinhard" => to.reinhard = from.reinhard,
        "svgf_depth" => to.depth_tolerance = from.depth_tolerance,
        "svgf_normal" => to.normal_exponent = from.normal_exponent,
        _ => to.luminance_tolerance = from.luminance_tolerance,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::{Antialiasing, EffectSettings, Noise, Sequence, TracerKind};

    /// Every field of the struct is in one group, has documentation, and can be copied.
    #[test]
    fn no_setting_is_missing() {
        let SettingsDocs { groups, docs } = SettingsDocs::default();
        let mut shown: Vec<&str> =
            groups.iter().flat_map(|group| &group.settings).map(String::as_str).collect();
        shown.sort_unstable();
        assert_eq!(shown, docs.keys().map(String::as_str).collect::<Vec<_>>());
        assert!(docs.values().all(|doc| doc.len() > 20), "{docs:?}");
        let other = Settings {
            indirect: Indirect::NONE,
            direct: Direct::Rays,
            reflections: Reflections::Rays,
            antialiasing: Antialiasing::None,
            bounces: 7,
            size: [8, 9],
            seed: 4,
            time_step: 0.5,
            tracer: TracerKind::Software,
            exposure: Some(1.0),
            effects: EffectSettings {
                denoise: Denoise::None,
                noise: Noise::White,
                reflection_depth: 3,
                reflection_roughness: 0.2,
            },
            svgf: SvgfSettings {
                alpha: 0.1,
                moments_alpha: 0.3,
                longest_history: 16,
                clamp: 1.0,
                firefly: 5.0,
                levels: 3,
                feedback: 2,
                separable: true,
                adaptive: false,
                reinhard: true,
                depth_tolerance: 2.0,
                normal_exponent: 64.0,
                luminance_tolerance: 8.0,
            },
            vpl: VplSettings {
                slots: 77,
                pool: 99,
                candidates: 3,
                refresh: 3,
                interleave: 2,
                temporal_sets: 3,
                budget: 5,
                clamp: 1.5,
                position_cutoff: 0.5,
                sequence: Sequence::Random,
                missing_sets: MissingSets::Dark,
            },
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
    fn settings_of_what_is_not_in_use_are_hidden() {
        let none = Settings { indirect: Indirect::NONE, ..Settings::default() };
        let in_use = |settings: &Settings| {
            let groups = groups();
            groups
                .into_iter()
                .filter(|group| is_in_use(group, settings))
                .map(|group| group.table)
                .collect::<Vec<_>>()
        };
        let plain = Settings { reflections: Reflections::None, ..Settings::default() };
        assert_eq!(
            in_use(&Settings::default()),
            ["settings", "settings.effects", "settings.svgf", "settings.vpls"]
        );
        assert_eq!(in_use(&plain), ["settings", "settings.vpls"]);
        assert_eq!(in_use(&none), ["settings", "settings.effects", "settings.svgf"]);
    }

    #[test]
    fn presets_can_be_used() {
        for (name, _, preset) in presets(&Settings::default()) {
            assert_eq!(preset.check(), Ok(()), "{name}");
        }
    }
}
