//! The panel, one file per section. Sections show state and return actions; they change nothing themselves.

mod bar;
mod compare;
mod environment;
mod help;
mod legend;
mod material;
mod notices;
mod objects;
mod plots;
mod scene;
mod settings;
mod split;
mod thumbnails;
mod time;
mod tree;
mod unsaved;
mod views;
mod vpls;
mod welcome;

use std::collections::BTreeMap;
use std::path::Path;
use std::time::{Duration, Instant};

use egui::{Frame, Id, Rect, Response, RichText, ScrollArea, Sense, Ui, UiBuilder, pos2, vec2};

use super::action::Action;
use super::clock::Clock;
use super::compare::Comparison;
use super::gpu::Gpu;
use super::handles::{self, Mode};
use super::history::History;
use super::inspector::Inspector;
use super::loader::Loader;
use super::preparation::Preparation;
use super::recorder::Recording;
use super::resolution::Resolution;
use super::session::{Selected, Session};
use super::split::Split;

pub(super) use scene::{Purpose, is_map, is_picture};
pub(super) use vpls::PathsState;

/// A scene that is loaded sooner needs no word.
const SOON: Duration = Duration::from_millis(500);
/// Width of the panel, points.
const WIDTH: f32 = 250.0;
/// Height of the two lines at the head of the panel, points.
const STATUS: f32 = 34.0;
/// How long the speed of flight is shown after the wheel has turned.
const SPEED_SHOWN: Duration = Duration::from_millis(1500);

/// State of the panel.
#[derive(Default)]
pub(super) struct PanelState {
    /// Whether panel and overlays are hidden.
    pub hidden: bool,
    /// Whether overlays alone are hidden.
    pub bare: bool,
    /// Whether keys go to the panel.
    pub has_keyboard: bool,
    pub help: bool,
    /// Whether the first lines are shown.
    pub welcome: bool,
    /// The last error, until dismissed.
    pub error: Option<String>,
    /// The last status message.
    pub message: String,
    /// What the next frames wait for.
    pub preparation: Option<Preparation>,
    /// The action that waits until edits are saved or discarded.
    pub pending: Option<Action>,
    pub scene: scene::SceneState,
    /// What the list of lights and objects is searched for.
    searched: String,
    split: split::SplitState,
    pub compare: compare::CompareState,
    pub paths: PathsState,
    pub places: Places,
    /// The speed of flight, and since when it is shown.
    speed: Option<(String, Instant)>,
    /// The widget that had the keyboard in the last frame.
    focused: Option<Id>,
    thumbnails: thumbnails::Thumbnails,
    /// What was selected in the last frame.
    selected: Option<Selected>,
}

impl PanelState {
    /// `hidden`: for the tour; `welcome`: with the first lines.
    pub fn new(hidden: bool, welcome: bool) -> Self {
        Self { hidden, welcome, ..Self::default() }
    }

    /// Forgets the textures, which another device knows nothing of.
    pub fn forget_textures(&mut self) {
        self.split = split::SplitState::default();
        self.thumbnails = thumbnails::Thumbnails::default();
    }

    /// The part of the window that panel and bar leave to the picture, points.
    pub fn viewport(&self, context: &egui::Context) -> Rect {
        let window = context.content_rect();
        if self.hidden {
            return window;
        }
        let (right, top) = (window.right() - WIDTH, window.top() + bar::height(window.width()));
        let corner = pos2(window.left(), top.min(window.bottom() - 1.0));
        Rect::from_min_max(corner, pos2(right.max(window.left() + 1.0), window.bottom()))
    }

    /// Shows the speed of flight for a while.
    pub fn show_speed(&mut self, speed: String) {
        self.speed = Some((speed, Instant::now()));
    }
}

/// Input of the panel.
pub(super) struct Shown<'a> {
    pub session: Option<&'a Session>,
    pub split: Option<&'a Split>,
    pub comparison: Option<&'a Comparison>,
    /// The caption of the tour.
    pub caption: Option<String>,
    pub assets: Option<&'a Path>,
    pub clock: &'a mut Clock,
    pub history: &'a History,
    pub loader: &'a Loader,
    pub gpu: &'a Gpu,
    pub inspector: &'a Inspector,
    pub mode: Mode,
    pub resolution: &'a Resolution,
    pub recording: &'a Recording,
}

/// Size of a window that has room for a picture of this size and the panel, pixels.
pub(super) fn window_around(picture: [u32; 2], scale: f32) -> [u32; 2] {
    let width = picture[0] as f32 / scale + WIDTH;
    let height = picture[1] as f32 / scale + bar::height(width);
    [width, height].map(|points| (points * scale).round() as u32)
}

/// Lays out panel and overlays; returns the user's actions.
pub(super) fn draw(ui: &mut Ui, state: &mut PanelState, shown: &mut Shown<'_>) -> Vec<Action> {
    let mut actions = Vec::new();
    state.places.clear();
    let viewport = state.viewport(ui.ctx());
    let Rect { min, max } = viewport;
    state.places.insert("picture".to_owned(), [min.x, min.y, max.x, max.y].map(f32::round));
    if let Some(split) = shown.split {
        split::pictures(ui, state, split);
    }
    if let Some(caption) = &shown.caption {
        notices::caption(ui, viewport, caption);
    }
    if state.help {
        help::draw(ui, state);
    }
    notices::error(ui, state);
    unsaved::draw(ui, state, &mut actions);
    state.scene.ask(ui.ctx(), &mut actions);
    if shown.session.is_none() {
        notices::loading(ui, viewport, shown.loader);
    }
    if let Some(preparation) = &state.preparation {
        notices::preparing(ui, viewport, &preparation.what);
    }
    compare::draw(ui, state, shown, &mut actions);
    if state.hidden {
        return actions;
    }
    if let Some(session) = shown.session.filter(|_| !state.bare) {
        overlays(ui, state, session, shown.mode);
    }
    let bar = egui::Panel::top("bar").exact_size(bar::height(ui.ctx().content_rect().width()));
    bar.resizable(false).frame(Frame::side_top_panel(ui.style())).show(ui, |ui| {
        bar::draw(ui, state, shown, &mut actions);
    });
    let panel = egui::Panel::right("panel").exact_size(WIDTH).resizable(false);
    panel.frame(Frame::side_top_panel(ui.style())).show(ui, |ui| {
        status(ui, state, shown);
        ui.separator();
        ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
            sections(ui, state, shown, &mut actions);
            follow_focus(ui, state);
        });
    });
    split::draw(ui, state, shown, &mut actions);
    material::draw(ui, state, shown, &mut actions);
    if shown.inspector.is_on() {
        vpls::inspector(ui, viewport, shown, &mut actions);
    }
    release_number(ui.ctx(), state);
    if state.welcome && shown.session.is_some() {
        welcome::draw(ui, state, &mut actions);
    }
    actions
}

/// Draws handles, legend and hints over the picture.
fn overlays(ui: &Ui, state: &PanelState, session: &Session, mode: Mode) {
    let viewport = state.viewport(ui.ctx());
    handles::paint(ui, session, viewport, mode);
    legend::draw(ui, session.renderer.view(), &session.settings);
    if session.camera_is_outside() {
        let hint = "The camera has left the scene: Home brings it back.";
        notices::caption(ui, viewport, hint);
    }
    if let Some((speed, since)) = &state.speed
        && since.elapsed() < SPEED_SHOWN
    {
        notices::caption(ui, viewport, speed);
    }
}

fn sections(ui: &mut Ui, state: &mut PanelState, shown: &mut Shown<'_>, actions: &mut Vec<Action>) {
    let mut places = std::mem::take(&mut state.places);
    let mut header = |ui: &Ui, title: &str, response: Response| place(ui, &mut places, title, &response);
    let mut inner = Places::new();
    let scene = section(ui, "Scene", true, |ui| scene::draw(ui, state, shown, &mut inner, actions));
    header(ui, "Scene", scene);
    let environment = section(ui, "Environment", false, |ui| {
        environment::draw(ui, state, shown, &mut inner, actions);
    });
    header(ui, "Environment", environment);
    let time = section(ui, "Time", true, |ui| time::draw(ui, shown, &mut inner, actions));
    header(ui, "Time", time);
    // It opens with a selection.
    let selected = shown.session.and_then(|session| session.selected);
    let opens = std::mem::replace(&mut state.selected, selected) != selected && selected.is_some();
    let objects = egui::CollapsingHeader::new(RichText::new("Lights and objects").strong());
    let objects = objects.open(opens.then_some(true));
    let searched = &mut state.searched;
    let objects = objects.show(ui, |ui| objects::draw(ui, searched, shown, &mut inner, actions));
    let objects = objects.header_response;
    header(ui, "Lights and objects", objects);
    let views = section(ui, "Debug views", false, |ui| views::draw(ui, shown, actions));
    header(ui, "Debug views", views);
    let plots = section(ui, "Performance", false, |ui| plots::draw(ui, shown, &mut inner, actions));
    header(ui, "Performance", plots);
    let settings = section(ui, "Settings", false, |ui| settings::draw(ui, shown, actions));
    header(ui, "Settings", settings);
    places.extend(inner);
    state.places = places;
}

/// Scrolls to the widget that has received the keyboard.
fn follow_focus(ui: &mut Ui, state: &mut PanelState) {
    let focused = ui.memory(egui::Memory::focused);
    if std::mem::replace(&mut state.focused, focused) == focused || !state.has_keyboard {
        return;
    }
    let widget = focused.and_then(|focused| ui.ctx().read_response(focused));
    if let Some(rect) = widget.map(|widget| widget.rect)
        && rect.left() >= ui.min_rect().left()
    {
        ui.scroll_to_rect(rect, None);
    }
}

/// Shows what goes on, in the same space whatever it is, so that nothing below moves.
fn status(ui: &mut Ui, state: &PanelState, shown: &Shown<'_>) {
    let (room, _) = ui.allocate_exact_size(vec2(ui.available_width(), STATUS), Sense::hover());
    let mut ui = ui.new_child(UiBuilder::new().max_rect(room));
    ui.set_clip_rect(room);
    let progress = shown.loader.progress();
    if let Some((name, step, elapsed)) = progress.filter(|progress| progress.2 > SOON) {
        ui.horizontal_wrapped(|ui| {
            ui.small(format!("{}: {} ({:.0} s)", scene::short(name), step.label(), elapsed.as_secs_f32()));
        });
    } else if !state.message.is_empty() {
        ui.small(&state.message).on_hover_text(&state.message);
    }
}

/// Notes that a field of text has the keyboard: it keeps it wherever the pointer goes, which a number does not.
fn keep_keyboard(ui: &Ui, field: &Response) {
    if field.has_focus() {
        ui.data_mut(|data| data.insert_temp(Id::new(TEXT_FIELD), field.id));
    }
}

/// Key of the last field of text that had the keyboard.
const TEXT_FIELD: &str = "text field";

/// Takes the keyboard from a number whose field the pointer has left for the picture.
fn release_number(context: &egui::Context, state: &PanelState) {
    let Some(focused) = context.memory(egui::Memory::focused) else { return };
    let kept: Option<Id> = context.data(|data| data.get_temp(Id::new(TEXT_FIELD)));
    let is_number = kept != Some(focused) && !state.scene.is_asking() && context.text_edit_focused();
    if is_number && !state.has_keyboard && !context.egui_wants_pointer_input() {
        context.memory_mut(|memory| memory.surrender_focus(focused));
    }
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

/// Records the rectangle of a slider's track, without the value and the text beside it.
fn place_track(ui: &Ui, places: &mut Places, name: &str, slider: &Response) {
    let width = ui.spacing().slider_width.min(slider.rect.width());
    let rect = slider.rect.with_max_x(slider.rect.min.x + width);
    place(ui, places, name, &slider.clone().with_new_rect(rect));
}

fn section(ui: &mut Ui, title: &str, open: bool, content: impl FnOnce(&mut Ui)) -> Response {
    let header = egui::CollapsingHeader::new(RichText::new(title).strong()).default_open(open);
    header.show(ui, content).header_response
}
