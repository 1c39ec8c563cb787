//! The panel, one file per section. Sections show state and return actions; they change nothing themselves.

mod bar;
mod environment;
mod help;
mod inspector;
mod legend;
mod material;
mod objects;
mod plots;
mod scene;
mod settings;
mod split;
mod time;
mod views;

use std::collections::BTreeMap;
use std::time::Duration;

use egui::{Frame, Response, RichText, ScrollArea, Ui};

use super::action::Action;
use super::app::Recording;
use super::clock::Clock;
use super::gpu::Gpu;
use super::handles::{self, Mode};
use super::history::History;
use super::inspector::Inspector;
use super::loader::Loader;
use super::split::Split;
use super::stage::Stage;

pub(super) use scene::{Purpose, is_map};
pub(super) use split::SplitState;

/// What is loaded sooner needs no word, which would move the panel under the pointer.
const SOON: Duration = Duration::from_millis(500);
/// Width of the panel in points.
const WIDTH: f32 = 250.0;

/// State of the panel.
#[derive(Default)]
pub(super) struct PanelState {
    /// Whether panel and overlays are hidden.
    pub hidden: bool,
    pub help: bool,
    /// The last error, until dismissed.
    pub error: Option<String>,
    /// The last status message.
    pub message: String,
    pub scene: scene::SceneState,
    pub split: SplitState,
    pub places: Places,
    /// Documentation of the settings, for tooltips.
    settings: settings::SettingsDocs,
}

/// Input of the panel.
pub(super) struct Shown<'a> {
    pub stage: Option<&'a Stage>,
    pub split: Option<&'a Split>,
    /// Of the tour.
    pub caption: Option<&'static str>,
    pub clock: &'a mut Clock,
    pub history: &'a History,
    pub loader: &'a Loader,
    pub gpu: &'a Gpu,
    pub inspector: &'a Inspector,
    pub mode: Mode,
    pub coarseness: u32,
    pub recording: &'a Recording,
}

/// Lays out panel and overlays; returns the user's actions.
pub(super) fn show(ui: &mut Ui, state: &mut PanelState, shown: &mut Shown<'_>) -> Vec<Action> {
    let mut actions = Vec::new();
    if let Some(split) = shown.split {
        split::pictures(ui, &mut state.split, split);
    }
    if let Some(caption) = shown.caption {
        caption_below(ui, caption);
    }
    if state.help {
        help::show(ui, state);
    }
    if state.hidden {
        return actions;
    }
    if let Some(stage) = shown.stage {
        handles::paint(ui, stage, shown.mode);
        legend::show(ui, stage.renderer.view());
        if stage.camera_is_outside() {
            caption_below(ui, "The camera has left the scene: Home brings it back.");
        }
    }
    state.scene.ask(ui.ctx(), &mut actions);
    state.places.clear();
    let fill = ui.visuals().panel_fill.gamma_multiply(0.93);
    let frame = Frame::side_top_panel(ui.style()).fill(fill);
    let bar = Frame::side_top_panel(ui.style()).fill(fill);
    egui::Panel::top("bar").resizable(false).frame(bar).show(ui, |ui| {
        bar::show(ui, shown, &mut state.places, &mut actions);
    });
    egui::Panel::right("panel").exact_size(WIDTH).resizable(false).frame(frame).show(ui, |ui| {
        head(ui, state, shown);
        ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
            let mut places = std::mem::take(&mut state.places);
            let mut header =
                |ui: &Ui, title: &str, response: Response| place(ui, &mut places, title, &response);
            let mut inner = Places::new();
            let scene = section(ui, "Scene", true, |ui| {
                scene::show(ui, state, shown, &mut inner, &mut actions);
            });
            header(ui, "Scene", scene);
            let environment = section(ui, "Environment", false, |ui| {
                environment::show(ui, state, shown, &mut inner, &mut actions);
            });
            header(ui, "Environment", environment);
            let time = section(ui, "Time", true, |ui| time::show(ui, shown, &mut inner, &mut actions));
            header(ui, "Time", time);
            let objects = section(ui, "Lights and objects", false, |ui| {
                objects::show(ui, shown, &mut inner, &mut actions);
            });
            header(ui, "Lights and objects", objects);
            let views = section(ui, "Debug views", false, |ui| views::show(ui, shown, &mut actions));
            header(ui, "Debug views", views);
            let plots = section(ui, "Performance", false, |ui| plots::show(ui, shown));
            header(ui, "Performance", plots);
            let settings = section(ui, "Settings", false, |ui| {
                settings::show(ui, state, shown, &mut actions);
            });
            header(ui, "Settings", settings);
            places.extend(inner);
            state.places = places;
        });
    });
    split::show(ui, shown, &state.settings, &mut state.places, &mut actions);
    if shown.inspector.is_on() {
        material::show(ui, shown, &mut state.places, &mut actions);
        inspector::show(ui, shown, &mut actions);
    }
    actions
}

/// What the tour says, or a hint, at the lower edge.
fn caption_below(ui: &Ui, caption: &str) {
    let window = ui.ctx().content_rect();
    let area = egui::Area::new(egui::Id::new("caption")).anchor(egui::Align2::CENTER_BOTTOM, [0.0, -12.0]);
    area.interactable(false).show(ui.ctx(), |ui| {
        let fill = egui::Color32::from_black_alpha(200);
        Frame::popup(ui.style()).fill(fill).show(ui, |ui| {
            ui.set_max_width((window.width() - 40.0).min(720.0));
            ui.label(RichText::new(caption).size(16.0).color(egui::Color32::WHITE));
        });
    });
}

/// Widget rectangles in the window, points; logged so that tests find them.
pub(super) type Places = BTreeMap<String, [f32; 4]>;

/// Records a widget's rectangle, if visible.
fn place(ui: &Ui, places: &mut Places, name: &str, response: &Response) {
    if ui.clip_rect().contains(response.rect.center()) {
        let rect = response.rect;
        places.insert(name.to_owned(), [rect.min.x, rect.min.y, rect.max.x, rect.max.y].map(f32::round));
    }
}

/// The same of a slider's track, without the value and the text beside it.
fn place_track(ui: &Ui, places: &mut Places, name: &str, slider: &Response) {
    let width = ui.spacing().slider_width.min(slider.rect.width());
    let rect = slider.rect.with_max_x(slider.rect.min.x + width);
    place(ui, places, name, &slider.clone().with_new_rect(rect));
}

fn section(ui: &mut Ui, title: &str, open: bool, content: impl FnOnce(&mut Ui)) -> Response {
    let header = egui::CollapsingHeader::new(RichText::new(title).strong()).default_open(open);
    header.show(ui, content).header_response
}

/// Messages and errors.
fn head(ui: &mut Ui, state: &mut PanelState, shown: &Shown<'_>) {
    if shown.gpu.device.is_cpu() {
        ui.small("CPU driver: smaller picture and fewer VPLs by default.")
            .on_hover_text(&shown.gpu.device.info().name);
    }
    let progress = shown.loader.progress();
    if let Some((name, step, elapsed)) = progress.filter(|progress| progress.2 > SOON) {
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
