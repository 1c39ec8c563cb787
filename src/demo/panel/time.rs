//! Animation time: the clock, and the timeline with the keys of what is selected.

use egui::{Align2, Color32, DragValue, FontId, Id, Pos2, Rect, Sense, Shape, Stroke, Ui, pos2, vec2};

use super::shown::Shown;
use super::widgets::Output;
use crate::demo::action::{Selected, ViewAction};
use crate::demo::clock::FramePacing;
use crate::demo::keys::{key_at, move_key, rounded};
use crate::demo::session::Session;
use crate::formats::AnimationEntry;

/// Minimum length of the timeline, seconds; it grows by as much.
const LEAST_SPAN: f64 = 10.0;
/// Numbers on it.
const NUMBERS: i32 = 5;
/// Height of the timeline, and of its row of numbers, points.
const HEIGHT: f32 = 36.0;
const SCALE: f32 = 14.0;
/// Half the width of a key, points.
const KEY: f32 = 5.0;
/// Colour of the playhead, and of the key at it.
const PLAYHEAD: Color32 = Color32::from_rgb(255, 200, 0);

/// The entry with the keys on the timeline.
type Keyed<'a> = (&'a Session, Selected, AnimationEntry);

pub(super) fn draw(ui: &mut Ui, shown: &Shown<'_>, out: &mut Output) {
    let clock = &shown.view.clock;
    let mut time = clock.time;
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        let label = if clock.paused { "Play" } else { "Pause" };
        out.button(ui, label, "Space", ViewAction::TogglePause);
        for (pacing, label, about) in [
            (FramePacing::RealTime, "real time", "The animation follows real time."),
            (FramePacing::Steps, "steps", "Each frame advances by time_step, as in render."),
        ] {
            let label = ui.selectable_label(clock.pacing == pacing, label).on_hover_text(about);
            if label.clicked() && clock.pacing != pacing {
                out.push(ViewAction::SetPacing(pacing));
            }
        }
        let number = DragValue::new(&mut time).range(0.0..=1e6).speed(0.02).fixed_decimals(2).suffix(" s");
        let number = ui.add(number);
        out.place(ui, "scrub value", &number);
        if number.changed() {
            out.push(ViewAction::Scrub(time));
        }
    });
    let session = shown.session();
    let keyed = session.and_then(|session| {
        let of = session.animated(session.selected?);
        Some((session, of, session.entry(of)?.animation().take().unwrap_or_default()))
    });
    timeline(ui, (shown.view.clock.time, shown.view.clock.paused), keyed.as_ref(), out);
    match keyed {
        Some(keyed) => keys(ui, shown.view.clock.time, keyed, out),
        None => drop(ui.small("Select a light or an object to give its motion keys.")),
    }
}

/// The playhead over a scale of seconds, and a diamond for each key.
fn timeline(ui: &mut Ui, (time, paused): (f64, bool), keyed: Option<&Keyed<'_>>, out: &mut Output) {
    let id = Id::new("timeline");
    // The panel's scroll bar lies at the right.
    let (rect, _) = ui.allocate_exact_size(vec2(ui.available_width() - 8.0, HEIGHT), Sense::hover());
    let track = ui.interact(rect, id, Sense::click_and_drag());
    out.place(ui, "scrub", &track);
    let keyframes = keyed.map_or(&[][..], |(.., animation)| &animation.keyframes[..]);
    // Its length stays while something is dragged along it.
    let end = keyframes.last().map_or(time, |last| last.time.max(time));
    let fitting = LEAST_SPAN * (end / LEAST_SPAN + 1e-9).ceil().max(1.0);
    let held = ui.data(|data| data.get_temp(id)).filter(|_| ui.input(|input| input.pointer.any_down()));
    let span: f64 = held.unwrap_or(fitting);
    ui.data_mut(|data| data.insert_temp(id, span));
    let line = rect.x_range().shrink(2.0 * KEY);
    let x_of = |time: f64| line.min + line.span() * (time / span).min(1.0) as f32;
    let time_of = |at: Pos2| rounded(span * f64::from((at.x - line.min) / line.span()).min(1.0));

    let (painter, visuals) = (ui.painter_at(rect), ui.visuals());
    let (weak, top) = (Stroke::new(1.0, visuals.weak_text_color()), rect.top() + SCALE);
    painter.rect_filled(rect.with_min_y(top), 3.0, visuals.extreme_bg_color);
    for number in 0..=2 * NUMBERS {
        let at = span * f64::from(number) / f64::from(2 * NUMBERS);
        painter.vline(x_of(at), top..=top + 4.0, weak);
        if number % 2 == 0 {
            let font = FontId::proportional(10.0);
            painter.text(pos2(x_of(at), rect.top()), Align2::CENTER_TOP, format!("{at}"), font, weak.color);
        }
    }
    let playhead = x_of(time);
    painter.vline(playhead, top - 3.0..=rect.bottom(), Stroke::new(1.5, PLAYHEAD));
    if (track.is_pointer_button_down_on() || track.clicked())
        && let Some(wanted) = track.interact_pointer_pos().map(time_of)
        && wanted != time
    {
        out.push(ViewAction::Scrub(wanted));
    }
    track.on_hover_text("Drag the playhead to set the animation time.");

    for (index, key) in keyframes.iter().enumerate().filter(|(_, key)| key.time >= 0.0) {
        let centre = pos2(x_of(key.time), 0.5 * (top + rect.bottom()) + 3.0);
        let grip = Rect::from_center_size(centre, vec2(2.0 * KEY + 2.0, rect.bottom() - top));
        let grip = ui.interact(grip, id.with(index), Sense::click_and_drag());
        out.place(ui, &format!("key {index}"), &grip);
        let is_now = keyed.is_some_and(|(.., animation)| key_at(animation, time) == Some(index));
        let colour = if is_now { PLAYHEAD } else { Color32::LIGHT_GRAY };
        let corners = [vec2(0.0, -KEY), vec2(KEY, 0.0), vec2(0.0, KEY), vec2(-KEY, 0.0)];
        let edge = Stroke::new(1.0, if grip.hovered() { Color32::WHITE } else { Color32::BLACK });
        painter.add(Shape::convex_polygon(corners.map(|corner| centre + corner).to_vec(), colour, edge));
        let mut now = key.time;
        if let (true, Some(at), Some((session, of, animation))) =
            (grip.dragged(), grip.interact_pointer_pos(), keyed)
        {
            let mut moved = animation.clone();
            now = move_key(&mut moved, index, time_of(at));
            out.extend(session.animate(*of, Some(moved)).filter(|_| now != key.time));
        }
        // The playhead goes with it, so that handles and buttons are for this key.
        if (grip.dragged() || grip.clicked()) && (!paused || now != time) {
            out.extend([ViewAction::Pause(true), ViewAction::Scrub(now)]);
        }
        if !grip.dragged() {
            grip.on_hover_text(format!("key at {:.2} s: drag to move it in time", key.time));
        }
    }
}

/// Buttons for the keys of what is selected.
fn keys(ui: &mut Ui, time: f64, (session, of, animation): Keyed<'_>, out: &mut Output) {
    let key = key_at(&animation, time);
    ui.horizontal(|ui| {
        let button = |ui: &mut Ui, out: &mut Output, name: &str, is_enabled: bool, about: &str| {
            let button = ui.add_enabled(is_enabled, egui::Button::new(name)).on_hover_text(about);
            out.place(ui, name, &button);
            button.clicked()
        };
        let about = "At the playhead, where it is now; then the handles pose the key.";
        if button(ui, out, "add key", key.is_none(), about) {
            let time = rounded(time);
            out.extend([ViewAction::Pause(true), ViewAction::Scrub(time)]);
            out.extend(session.animate(of, Some(session.with_key(&animation, time))));
        }
        let deletes = button(ui, out, "delete key", key.is_some(), "The one at the playhead.");
        if let Some(key) = key.filter(|_| deletes) {
            let mut rest = animation.clone();
            rest.keyframes.remove(key);
            out.extend(session.animate(of, Some(rest)));
        }
        let mut repeat = animation.repeat;
        let several = animation.keyframes.len() > 1;
        let check = ui.add_enabled(several, egui::Checkbox::new(&mut repeat, "repeat"));
        if check.on_hover_text("After the last key the motion begins again.").changed() {
            out.extend(session.animate(of, Some(AnimationEntry { repeat, ..animation })));
        }
    });
    // In one line, whatever it says, so that nothing below moves.
    let hint = if key.is_some() { "The handles pose this key." } else { &session.name_of(of) };
    ui.add(egui::Label::new(egui::RichText::new(hint).small()).truncate());
}
