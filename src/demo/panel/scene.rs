//! Opening and saving scenes, screenshots, the window itself.

use egui::{ComboBox, TextEdit, Ui};

use super::{PanelState, Shown};
use crate::demo::action::Action;
use crate::scene::BUILTIN_SCENES;

/// What is being typed.
#[derive(Default)]
pub(in crate::demo) struct SceneState {
    path: String,
}

pub(super) fn show(ui: &mut Ui, state: &mut PanelState, shown: &Shown<'_>, wishes: &mut Vec<Action>) {
    let name = shown.stage.map_or("none", |stage| stage.name.as_str());
    ComboBox::from_id_salt("scene").selected_text(name).width(180.0).show_ui(ui, |ui| {
        for scene in BUILTIN_SCENES {
            if ui.selectable_label(scene == name, scene).clicked() {
                wishes.push(Action::Open(scene.to_owned()));
            }
        }
    });
    ui.horizontal(|ui| {
        let field = TextEdit::singleline(&mut state.scene.path).hint_text("scene.toml or model.obj");
        let field = ui.add(field.desired_width(150.0));
        let entered = field.lost_focus() && ui.input(|input| input.key_pressed(egui::Key::Enter));
        let typed = state.scene.path.trim();
        if (ui.button("Open").clicked() || entered) && !typed.is_empty() {
            wishes.push(Action::Open(typed.to_owned()));
        }
    });
    ui.horizontal(|ui| {
        if ui.button("Screenshot").on_hover_text("F12; with shift: EXR").clicked() {
            wishes.push(Action::Screenshot { exr: false });
        }
        if ui.button("Command").on_hover_text("Copies the command line that renders this (F4)").clicked() {
            wishes.push(Action::CopyCommand);
        }
        if ui.button("Keys").on_hover_text("F1").clicked() {
            wishes.push(Action::ToggleHelp);
        }
    });
    window(ui, shown, wishes);
}

fn window(ui: &mut Ui, shown: &Shown<'_>, wishes: &mut Vec<Action>) {
    let mode = shown.gpu.presenter.mode();
    ComboBox::from_label("present mode").selected_text(mode.label()).show_ui(ui, |ui| {
        for offered in &shown.gpu.modes {
            if ui.selectable_label(*offered == mode, offered.label()).clicked() {
                wishes.push(Action::SetPresentMode(*offered));
            }
        }
    });
    let current = shown.gpu.device.info();
    let combo = ComboBox::from_id_salt("device").selected_text(&current.name).width(210.0).truncate();
    combo.show_ui(ui, |ui| {
        for device in shown.gpu.devices.iter().filter(|device| device.unusable.is_none()) {
            if ui.selectable_label(device.index == current.index, &device.name).clicked() {
                wishes.push(Action::RestartDevice(Some(device.index)));
            }
        }
    });
}
