//! The panel, one file per section: a function from the window's state to actions. It changes the state of its widgets alone.

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
mod shown;
mod split;
mod thumbnails;
mod time;
mod tree;
mod unsaved;
mod views;
mod vpls;
mod welcome;
mod widgets;

use std::time::Duration;

use egui::{CollapsingHeader, Frame, Id, Rect, RichText, ScrollArea, Sense, Ui, UiBuilder, vec2};

use super::action::Selected;
use super::handles;
use super::session::Session;
use shown::{WIDTH, bar_height};
use widgets::{is_text_field, short};

pub(super) use scene::{Purpose, is_map, is_picture};
pub(super) use shown::{Shown, picture_area, window_around};
pub(super) use widgets::{Layout, Output};

/// A scene that is loaded sooner needs no word.
const SOON: Duration = Duration::from_millis(500);
/// Height of the two lines at the head of the panel, points.
const STATUS: f32 = 34.0;
/// Time for which the speed of flight is shown after the wheel has turned.
const SPEED_SHOWN: Duration = Duration::from_millis(1500);

/// State of the panel's widgets.
#[derive(Default)]
pub(super) struct PanelState {
    pub files: scene::SceneState,
    pub compare: compare::CompareState,
    /// Typed name of an environment's map.
    map: String,
    /// Typed part of the names of lights and objects to list.
    searched: String,
    split: split::SplitState,
    thumbnails: thumbnails::Thumbnails,
    /// The widget that had the keyboard in the last frame.
    focused: Option<Id>,
    /// The selection of the last frame.
    selected: Option<Selected>,
}

impl PanelState {
    /// Forgets the textures, which another device knows nothing of.
    pub fn forget_textures(&mut self) {
        self.split = split::SplitState::default();
        self.thumbnails = thumbnails::Thumbnails::default();
    }
}

/// Lays out panel and overlays.
pub(super) fn draw(ui: &mut Ui, state: &mut PanelState, shown: &Shown<'_>) -> Output {
    let mut out = Output::default();
    let (viewport, interface) = (shown.picture_area(ui.ctx()), &shown.view.interface);
    let Rect { min, max } = viewport;
    let corners = [min.x, min.y, max.x, max.y].map(f32::round);
    out.layout.insert("picture".to_owned(), corners);
    if let Some(split) = &shown.view.split {
        split::pictures(ui, &mut state.split, viewport, split);
    }
    if let Some(caption) = &shown.caption {
        notices::caption(ui, viewport, caption);
    }
    if interface.help {
        help::draw(ui, shown, &mut out);
    }
    notices::error(ui, shown, &mut out);
    unsaved::draw(ui, shown, &mut out);
    state.files.ask(ui.ctx(), &mut out);
    if shown.session().is_none() {
        notices::loading(ui, viewport, shown.loader);
    }
    if let Some(preparation) = &interface.preparation {
        notices::preparing(ui, viewport, &preparation.subject);
    }
    compare::draw(ui, &mut state.compare, shown, &mut out);
    if !interface.hidden {
        draw_hideable(ui, state, shown, &mut out);
    }
    out
}

/// Lays out what Tab hides: bar, panel and overlays.
fn draw_hideable(ui: &mut Ui, state: &mut PanelState, shown: &Shown<'_>, out: &mut Output) {
    let (viewport, interface) = (shown.picture_area(ui.ctx()), &shown.view.interface);
    if let Some(session) = shown.session().filter(|_| !interface.bare) {
        overlays(ui, viewport, shown, session);
    }
    let bar = egui::Panel::top("bar").exact_size(bar_height(ui.ctx().content_rect().width()));
    bar.resizable(false).frame(Frame::side_top_panel(ui.style())).show(ui, |ui| {
        bar::draw(ui, &mut state.thumbnails, shown, out);
    });
    let panel = egui::Panel::right("panel").exact_size(WIDTH).resizable(false);
    panel.frame(Frame::side_top_panel(ui.style())).show(ui, |ui| {
        status(ui, shown);
        ui.separator();
        ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
            sections(ui, state, shown, out);
            follow_focus(ui, &mut state.focused, interface.has_keyboard);
        });
    });
    split::draw(ui, shown, out);
    material::draw(ui, shown, out);
    if shown.view.inspector.is_on {
        vpls::inspector(ui, viewport, shown, out);
    }
    if !interface.has_keyboard && !state.files.is_asking() {
        release_number(ui.ctx());
    }
    if interface.welcome && shown.session().is_some() {
        welcome::draw(ui, shown, out);
    }
}

/// Draws handles, legend and hints over the picture.
fn overlays(ui: &Ui, viewport: Rect, shown: &Shown<'_>, session: &Session) {
    handles::paint(ui, session, viewport, shown.view.handles);
    legend::draw(ui, session.renderer.view(), &session.settings);
    if session.camera_is_outside() {
        let hint = "The camera has left the scene: Home brings it back.";
        notices::caption(ui, viewport, hint);
    }
    if let Some((speed, since)) = &shown.view.interface.speed
        && since.elapsed() < SPEED_SHOWN
    {
        notices::caption(ui, viewport, speed);
    }
}

fn sections(ui: &mut Ui, state: &mut PanelState, shown: &Shown<'_>, out: &mut Output) {
    let mut section = |title: &str,
                       (is_open, opens): (bool, Option<bool>),
                       content: &mut dyn FnMut(&mut Ui, &mut Output)| {
        let header = CollapsingHeader::new(RichText::new(title).strong());
        let header = header.default_open(is_open).open(opens);
        let header = header.show(ui, |ui| content(ui, out)).header_response;
        out.place(ui, title, &header);
    };
    let (open, closed) = ((true, None), (false, None));
    section("Scene", open, &mut |ui, out| scene::draw(ui, &mut state.files, shown, out));
    section("Environment", closed, &mut |ui, out| {
        environment::draw(ui, &mut state.map, shown, out);
    });
    section("Time", open, &mut |ui, out| time::draw(ui, shown, out));
    // It opens with a selection.
    let selected = shown.session().and_then(|session| session.selected);
    let opens = std::mem::replace(&mut state.selected, selected) != selected && selected.is_some();
    section("Lights and objects", (false, opens.then_some(true)), &mut |ui, out| {
        objects::draw(ui, &mut state.searched, shown, out);
    });
    section("Debug views", closed, &mut |ui, out| views::draw(ui, shown, out));
    section("Performance", closed, &mut |ui, out| plots::draw(ui, shown, out));
    section("Settings", closed, &mut |ui, out| settings::draw(ui, shown, out));
}

/// Scrolls to the widget that has received the keyboard.
fn follow_focus(ui: &mut Ui, last: &mut Option<Id>, has_keyboard: bool) {
    let focused = ui.memory(egui::Memory::focused);
    if std::mem::replace(last, focused) == focused || !has_keyboard {
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
fn status(ui: &mut Ui, shown: &Shown<'_>) {
    let (room, _) = ui.allocate_exact_size(vec2(ui.available_width(), STATUS), Sense::hover());
    let mut ui = ui.new_child(UiBuilder::new().max_rect(room));
    ui.set_clip_rect(room);
    let message = &shown.view.interface.message;
    let progress = shown.loader.progress();
    if let Some((name, step, elapsed)) = progress.filter(|progress| progress.2 > SOON) {
        ui.horizontal_wrapped(|ui| {
            ui.small(format!("{}: {} ({:.0} s)", short(name), step.label(), elapsed.as_secs_f32()));
        });
    } else if !message.is_empty() {
        ui.small(message).on_hover_text(message);
    }
}

/// Takes the keyboard from a number whose field the pointer has left for the picture.
fn release_number(context: &egui::Context) {
    let Some(focused) = context.memory(egui::Memory::focused) else { return };
    let is_number = !is_text_field(context, focused) && context.text_edit_focused();
    if is_number && !context.egui_wants_pointer_input() {
        context.memory_mut(|memory| memory.surrender_focus(focused));
    }
}
