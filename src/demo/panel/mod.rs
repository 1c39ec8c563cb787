//! The panel, one file a section. Sections show state and give back wishes; they change nothing themselves.

mod help;
mod inspector;
mod objects;
mod plots;
mod scene;
mod settings;
mod time;
mod views;

use std::collections::BTreeMap;

use egui::{Frame, Response, RichText, ScrollArea, Ui};

use super::action::Action;
use super::app::Recording;
use super::clock::Clock;
use super::gpu::Gpu;
use super::handles::{self, Mode};
use super::history::History;
use super::inspector::Inspector;
use super::loader::Loader;
use super::stage::Stage;

pub(super) use scene::Purpose;

/// Width of the panel in points.
const WIDTH: f32 = 250.0;

/// What a person has set that concerns the panel alone.
#[derive(Default)]
pub(super) struct PanelState {
    /// Nothing is drawn over the picture.
    pub hidden: bool,
    pub help: bool,
    /// What went wrong last, until it is dismissed.
    pub error: Option<String>,
    /// What was done last.
    pub message: String,
    pub scene: scene::SceneState,
    pub places: Places,
    /// What the pointer is over, for people who ask.
    settings: settings::SettingsDocs,
}

/// What the panel shows.
pub(super) struct Shown<'a> {
    pub stage: Option<&'a Stage>,
    pub clock: &'a mut Clock,
    pub history: &'a History,
    pub loader: &'a Loader,
    pub gpu: &'a Gpu,
    pub inspector: &'a Inspector,
    pub mode: Mode,
    pub coarseness: u32,
    pub recording: &'a Recording,
}

/// Lays out everything that is drawn over the picture.
pub(super) fn show(ui: &mut Ui, state: &mut PanelState, shown: &mut Shown<'_>) -> Vec<Action> {
    let mut wishes = Vec::new();
    if state.help {
        help::show(ui, state);
    }
    if state.hidden {
        return wishes;
    }
    if let Some(stage) = shown.stage {
        handles::paint(ui, stage, shown.mode);
    }
    state.scene.ask(ui.ctx(), &mut wishes);
    state.places.clear();
    let fill = ui.visuals().panel_fill.gamma_multiply(0.93);
    let frame = Frame::side_top_panel(ui.style()).fill(fill);
    egui::Panel::right("panel").exact_size(WIDTH).resizable(false).frame(frame).show(ui, |ui| {
        head(ui, state, shown);
        ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
            let mut places = std::mem::take(&mut state.places);
            let mut header =
                |ui: &Ui, title: &str, response: Response| place(ui, &mut places, title, &response);
            let mut inner = Places::new();
            let scene = section(ui, "Scene", true, |ui| {
                scene::show(ui, state, shown, &mut inner, &mut wishes);
            });
            header(ui, "Scene", scene);
            let time = section(ui, "Time", true, |ui| time::show(ui, shown, &mut inner, &mut wishes));
            header(ui, "Time", time);
            let objects = section(ui, "Lights and things", false, |ui| {
                objects::show(ui, shown, &mut inner, &mut wishes);
            });
            header(ui, "Lights and things", objects);
            let views = section(ui, "Look inside", false, |ui| views::show(ui, shown, &mut wishes));
            header(ui, "Look inside", views);
            let plots = section(ui, "Measured", false, |ui| plots::show(ui, shown));
            header(ui, "Measured", plots);
            let settings = section(ui, "Settings", false, |ui| {
                settings::show(ui, state, shown, &mut inner, &mut wishes);
            });
            header(ui, "Settings", settings);
            places.extend(inner);
            state.places = places;
        });
    });
    if shown.inspector.is_on() {
        inspector::show(ui, shown, &mut wishes);
    }
    wishes
}

/// Where things are in the window, in points: for the log, so that tests find them.
pub(super) type Places = BTreeMap<String, [f32; 4]>;

/// Notes where a thing is, if it can be seen.
fn place(ui: &Ui, places: &mut Places, name: &str, response: &Response) {
    if ui.clip_rect().contains(response.rect.center()) {
        let rect = response.rect;
        places.insert(name.to_owned(), [rect.min.x, rect.min.y, rect.max.x, rect.max.y].map(f32::round));
    }
}

fn section(ui: &mut Ui, title: &str, open: bool, content: impl FnOnce(&mut Ui)) -> Response {
    let header = egui::CollapsingHeader::new(RichText::new(title).strong()).default_open(open);
    header.show(ui, content).header_response
}

/// Frame rate, notes and errors.
fn head(ui: &mut Ui, state: &mut PanelState, shown: &Shown<'_>) {
    let median = shown.history.median_and_p95(|sample| sample.interval_ms).map_or(0.0, |[median, _]| median);
    let rate = if median > 0.0 { 1e3 / median } else { 0.0 };
    ui.horizontal(|ui| {
        ui.strong("glowworm");
        ui.label(format!("{rate:.0} frames a second"));
    });
    if shown.gpu.device.is_cpu() {
        ui.small("Runs on the CPU: slow, so small and with fewer VPLs.")
            .on_hover_text(&shown.gpu.device.info().name);
    }
    if let Some((name, step, elapsed)) = shown.loader.progress() {
        ui.horizontal(|ui| {
            ui.spinner();
            ui.label(format!("{name}: {} ({:.0} s)", step.label(), elapsed.as_secs_f32()));
        });
    }
    if let Some(error) = &state.error {
        let text = RichText::new(error).color(ui.visuals().error_fg_color);
        let dismissed = ui.horizontal_wrapped(|ui| {
            ui.label(text);
            ui.small_button("dismiss").clicked()
        });
        if dismissed.inner {
            state.error = None;
        }
    }
    if !state.message.is_empty() {
        ui.small(&state.message);
    }
    ui.separator();
}
