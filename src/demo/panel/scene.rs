//! Open and save scenes, screenshots, window and device.

use std::path::Path;

use egui::{ComboBox, Ui};
use egui_file_dialog::{DialogState, FileDialog, Filter};

use super::shown::Shown;
use super::widgets::Output;
use crate::demo::action::{Action, AppAction, EditAction, NewObject, RightSide, ViewAction};
use crate::demo::recorder::Recording;

/// Endings of files by their use.
const SCENES: &[&str] = &["toml", "obj", "gltf", "glb"];
const MODELS: &[&str] = &["obj", "gltf", "glb"];
const MAPS: &[&str] = &["hdr", "exr"];
const PICTURES: &[&str] = &["hdr", "exr", "png"];

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
    has_ending(path, MAPS)
}

/// Whether a file is a picture for the right side of the divider, by its ending.
pub(in crate::demo) fn is_picture(path: &Path) -> bool {
    has_ending(path, PICTURES)
}

fn has_ending(path: &Path, endings: &[&str]) -> bool {
    let extension = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    endings.contains(&extension.as_str())
}

impl SceneState {
    /// Opens the dialog; `name` is the default name of a new file.
    pub fn ask_for(&mut self, purpose: Purpose, name: &str) {
        let shown = match purpose {
            Purpose::Map => "maps",
            Purpose::Model => "models",
            Purpose::Picture => "pictures",
            Purpose::Open | Purpose::Save => "scenes",
        };
        let mut dialog = FileDialog::new().default_file_filter(shown);
        for (name, endings) in
            [("scenes", SCENES), ("models", MODELS), ("maps", MAPS), ("pictures", PICTURES)]
        {
            let filter = Filter::new(move |path: &Path| has_ending(path, endings));
            dialog = dialog.add_file_filter(name, filter);
        }
        dialog = dialog.default_file_name(&format!("{name}.toml"));
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
    pub(super) fn ask(&mut self, context: &egui::Context, out: &mut Output) {
        let Some((dialog, purpose)) = &mut self.dialog else { return };
        dialog.update(context);
        let picked = dialog.take_picked();
        let done = picked.is_some() || !matches!(dialog.state(), DialogState::Open);
        out.extend(picked.map(|path| match purpose {
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

pub(super) fn draw(ui: &mut Ui, state: &mut SceneState, shown: &Shown<'_>, out: &mut Output) {
    let hint = "scene.toml, model.obj or model.glb";
    let entered = out.entry(ui, ("path", "Open"), &mut state.path, hint);
    out.extend(entered.map(AppAction::Open));
    ui.horizontal(|ui| {
        out.button(ui, "Open …", "Ctrl+O; files can also be dropped on the window", AppAction::AskOpen);
        let about = "The scene with all changes, camera and settings (Ctrl+S)";
        out.button(ui, "Save …", about, AppAction::AskSave);
    });
    ui.horizontal_wrapped(|ui| {
        out.button(ui, "Screenshot", "F12; with shift: EXR", AppAction::Screenshot { exr: false });
        let about = "Copies the command line that renders this (F4)";
        out.button(ui, "Command", about, AppAction::CopyCommand);
        let (label, recording) = match &shown.view.recording {
            Recording::On(recorder) => (format!("Stop ({})", recorder.count), true),
            Recording::Waiting => ("Stop".to_owned(), true),
            Recording::Off => ("Record".to_owned(), false),
        };
        let button = ui.selectable_label(recording, label);
        let button = button.on_hover_text("Records camera and edits; render replays the file (Ctrl+R)");
        out.on_click(&button, AppAction::ToggleRecording);
        out.button(ui, "Keys", "F1", AppAction::ToggleHelp);
    });
    window(ui, shown, out);
}

fn window(ui: &mut Ui, shown: &Shown<'_>, out: &mut Output) {
    let mode = shown.gpu.presenter.mode();
    ComboBox::from_label("present mode").selected_text(mode.label()).show_ui(ui, |ui| {
        for offered in &shown.gpu.modes {
            let label = ui.selectable_label(*offered == mode, offered.label());
            out.on_click(&label, AppAction::SetPresentMode(*offered));
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
            let label = ui.selectable_label(device.index == current.index, &device.name);
            out.on_click(&label, AppAction::RestartDevice(Some(device.index)));
        }
    });
}
