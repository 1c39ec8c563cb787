//! Open and save scenes, screenshots, window and device.

use std::path::Path;

use egui::{ComboBox, TextEdit, Ui};
use egui_file_dialog::{DialogState, FileDialog, Filter};

use super::shown::Shown;
use super::widgets::{Layout, keep_keyboard, place};
use crate::demo::action::{Action, Actions, AppAction, EditAction, NewObject, RightSide, ViewAction};
use crate::demo::recorder::Recording;

/// Text field and file dialog.
#[derive(Default)]
pub(in crate::demo) struct SceneState {
    path: String,
    dialog: Option<(FileDialog, Purpose)>,
}

/// Purpose of the file dialog.
#[derive(Clone, Copy)]
pub(in crate::demo) enum Purpose {
    Open,
    Save,
    /// The map of an environment.
    Map,
    /// The model of an object that is added.
    Model,
    /// The picture right of the divider.
    Picture,
}

/// Whether a file is the map of an environment, by its ending.
pub(in crate::demo) fn is_map(path: &Path) -> bool {
    has_ending(path, &["hdr", "exr"])
}

/// Whether a file is a picture for the right side of the divider, by its ending.
pub(in crate::demo) fn is_picture(path: &Path) -> bool {
    is_map(path) || has_ending(path, &["png"])
}

fn has_ending(path: &Path, endings: &[&str]) -> bool {
    let extension = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    endings.contains(&extension.as_str())
}

impl SceneState {
    /// Opens the dialog; `name` is the default name of a new file.
    pub fn ask_for(&mut self, purpose: Purpose, name: &str) {
        let scenes: Filter<Path> =
            Filter::new(|path: &Path| has_ending(path, &["toml", "obj", "gltf", "glb"]));
        let models: Filter<Path> = Filter::new(|path: &Path| has_ending(path, &["obj", "gltf", "glb"]));
        let shown = match purpose {
            Purpose::Map => "maps",
            Purpose::Model => "models",
            Purpose::Picture => "pictures",
            Purpose::Open | Purpose::Save => "scenes",
        };
        let mut dialog = FileDialog::new()
            .add_file_filter("scenes", scenes)
            .add_file_filter("models", models)
            .add_file_filter("maps", Filter::new(is_map))
            .add_file_filter("pictures", Filter::new(is_picture))
            .default_file_filter(shown)
            .default_file_name(&format!("{name}.toml"));
        match purpose {
            Purpose::Save => dialog.save_file(),
            _ => dialog.pick_file(),
        }
        self.dialog = Some((dialog, purpose));
    }

    /// Whether the dialog is open.
    pub(super) fn is_asking(&self) -> bool {
        self.dialog.is_some()
    }

    /// Shows the dialog, if it is open.
    pub(super) fn ask(&mut self, context: &egui::Context, actions: &mut Actions) {
        let Some((dialog, purpose)) = &mut self.dialog else { return };
        dialog.update(context);
        let picked = dialog.take_picked();
        let done = picked.is_some() || !matches!(dialog.state(), DialogState::Open);
        actions.extend(picked.map(|path| match purpose {
            Purpose::Open => Action::from(AppAction::Open(path.to_string_lossy().into_owned())),
            Purpose::Save => AppAction::Save(path).into(),
            Purpose::Map => EditAction::OpenMap(path).into(),
            Purpose::Model => EditAction::AddObject(NewObject::File(path)).into(),
            Purpose::Picture => ViewAction::Split(Some(RightSide::Picture(path))).into(),
        }));
        if done {
            self.dialog = None;
        }
    }
}

pub(super) fn draw(
    ui: &mut Ui,
    state: &mut SceneState,
    shown: &Shown<'_>,
    layout: &mut Layout,
    actions: &mut Actions,
) {
    ui.horizontal(|ui| {
        let field = TextEdit::singleline(&mut state.path).hint_text("scene.toml, model.obj or model.glb");
        let field = ui.add(field.desired_width(150.0));
        place(ui, layout, "path", &field);
        keep_keyboard(ui, &field);
        let entered = field.lost_focus() && ui.input(|input| input.key_pressed(egui::Key::Enter));
        let typed = state.path.trim();
        if (ui.button("Open").clicked() || entered) && !typed.is_empty() {
            actions.push(AppAction::Open(typed.to_owned()));
        }
    });
    ui.horizontal(|ui| {
        if ui.button("Open …").on_hover_text("Ctrl+O; files can also be dropped on the window").clicked() {
            actions.push(AppAction::AskOpen);
        }
        if ui
            .button("Save …")
            .on_hover_text("The scene with all changes, camera and settings (Ctrl+S)")
            .clicked()
        {
            actions.push(AppAction::AskSave);
        }
    });
    ui.horizontal_wrapped(|ui| {
        if ui.button("Screenshot").on_hover_text("F12; with shift: EXR").clicked() {
            actions.push(AppAction::Screenshot { exr: false });
        }
        if ui.button("Command").on_hover_text("Copies the command line that renders this (F4)").clicked() {
            actions.push(AppAction::CopyCommand);
        }
        let (label, recording) = match &shown.view.recording {
            Recording::On(recorder) => (format!("Stop ({})", recorder.count()), true),
            Recording::Waiting => ("Stop".to_owned(), true),
            Recording::Off => ("Record".to_owned(), false),
        };
        let button = ui.selectable_label(recording, label);
        if button.on_hover_text("Records camera and edits; render replays the file (Ctrl+R)").clicked() {
            actions.push(AppAction::ToggleRecording);
        }
        if ui.button("Keys").on_hover_text("F1").clicked() {
            actions.push(AppAction::ToggleHelp);
        }
    });
    window(ui, shown, actions);
}

fn window(ui: &mut Ui, shown: &Shown<'_>, actions: &mut Actions) {
    let mode = shown.gpu.presenter.mode();
    ComboBox::from_label("present mode").selected_text(mode.label()).show_ui(ui, |ui| {
        for offered in &shown.gpu.modes {
            if ui.selectable_label(*offered == mode, offered.label()).clicked() {
                actions.push(AppAction::SetPresentMode(*offered));
            }
        }
    });
    let now = ui.ctx().zoom_factor();
    let percent = |scale: f32| format!("{:.0} %", 100.0 * scale);
    ComboBox::from_label("interface size").selected_text(percent(now)).show_ui(ui, |ui| {
        for scale in [0.75, 1.0, 1.25, 1.5, 2.0] {
            if ui.selectable_label(scale == now, percent(scale)).clicked() {
                ui.ctx().set_zoom_factor(scale);
            }
        }
    });
    let current = shown.gpu.device.info();
    let combo = ComboBox::from_id_salt("device").selected_text(&current.name).width(210.0).truncate();
    combo.show_ui(ui, |ui| {
        for device in shown.gpu.devices.iter().filter(|device| device.unusable.is_none()) {
            if ui.selectable_label(device.index == current.index, &device.name).clicked() {
                actions.push(AppAction::RestartDevice(Some(device.index)));
            }
        }
    });
}
