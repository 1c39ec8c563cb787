//! Keyboard and mouse input outside of the panel: keys, the pointer and its drags.

use std::time::Instant;

use glam::{Vec2, Vec3};
use winit::event::{ElementState, MouseButton};
use winit::keyboard::{KeyCode, ModifiersState};

use super::action::{Action, Actions, AppAction, EditAction, Entry};
use super::bindings::action_of;
use super::handles::{HandleDrag, light_at};
use super::screen::Screen;
use super::undo::Press;
use super::view::View;
use crate::vulkan::Viewport;

/// State of keyboard and mouse.
#[derive(Default)]
pub(super) struct Input {
    pub modifiers: ModifiersState,
    pub press: Press,
    /// Position of the pointer in the window, pixels.
    pub pointer: [f32; 2],
    /// The drag in progress, and the button that holds it.
    drag: Option<(MouseButton, Drag)>,
    /// Whether there was input since the last frame.
    pub woken: bool,
}

/// A drag, from button down to button up.
enum Drag {
    /// Rotates the view.
    Look,
    /// Orbits around a point.
    Orbit(Vec3),
    /// Drags a handle.
    Handle(Box<HandleDrag>),
}

impl Input {
    /// Pointer position in the picture, from (0, 0) at the top left to (1, 1).
    pub fn in_picture(&self, view: &View, screen: &Screen) -> Vec2 {
        let Viewport { corner, size } = screen.viewport(&view.interface);
        let float = |pixels: [u32; 2]| Vec2::from_array(pixels.map(|side| side as f32));
        (Vec2::from_array(self.pointer) - float(corner)) / float(size).max(Vec2::ONE)
    }

    /// Handles a key press or release.
    pub fn key(
        &self,
        (code, state, repeat): (KeyCode, ElementState, bool),
        view: &mut View,
        screen: &mut Screen,
        actions: &mut Actions,
    ) {
        let pressed = state == ElementState::Pressed;
        let plain = !self.modifiers.control_key() && !self.modifiers.alt_key();
        if !pressed || plain {
            view.flight.key(code, pressed);
        }
        if pressed && !repeat {
            let action = action_of(code, self.modifiers);
            // It takes effect with the event, so that the next key goes where it belongs.
            if action == Some(Action::App(AppAction::ToggleKeyboard)) {
                if view.interface.has_keyboard {
                    screen.take_keyboard(&mut view.interface);
                } else {
                    screen.give_keyboard(&mut view.interface);
                    view.flight.release();
                }
            }
            actions.extend(action);
        }
    }

    /// Handles a press of a mouse button on the picture.
    pub fn button_down(
        &mut self,
        button: MouseButton,
        view: &mut View,
        screen: &Screen,
        actions: &mut Actions,
    ) {
        view.interface.has_keyboard = false;
        let at = self.in_picture(view, screen);
        let Some(session) = &view.session else { return };
        match button {
            MouseButton::Right => {
                screen.window.set_cursor_visible(false);
                self.drag.get_or_insert((button, Drag::Look));
            }
            MouseButton::Middle => {
                if let Some(picked) = session.pick(at) {
                    self.drag.get_or_insert((button, Drag::Orbit(picked.surface.position)));
                }
            }
            MouseButton::Left if view.inspector.is_on => view.inspector.look(session, at),
            // A handle under the pointer is dragged, or else the object there selected.
            MouseButton::Left if !view.interface.hidden => {
                let (area, point) = (screen.picture_area(&view.interface), screen.points(self.pointer));
                let time = view.clock.paused.then_some(view.clock.time);
                if let Some(drag) = HandleDrag::begin(session, view.handles, time, area, point) {
                    self.drag.get_or_insert((button, Drag::Handle(Box::new(drag))));
                } else {
                    let selected = light_at(session, area, point).or_else(|| session.selected_at(at));
                    actions.push(EditAction::Select(selected));
                }
            }
            _ => {}
        }
    }

    /// Handles the release of a mouse button.
    pub fn button_up(&mut self, button: MouseButton, screen: &Screen) {
        if self.drag.take_if(|(held, _)| *held == button).is_some() {
            screen.window.set_cursor_visible(true);
        }
    }

    /// Ends any drag, as when the window loses the focus.
    pub fn cancel(&mut self, screen: &Screen) {
        self.drag = None;
        screen.window.set_cursor_visible(true);
    }

    /// The edit that drags a handle to the pointer, if that changes the selected entry.
    pub fn dragged(&self, view: &View, screen: &Screen) -> Option<EditAction> {
        let (Some(session), Some((_, Drag::Handle(drag)))) = (&view.session, &self.drag) else { return None };
        let dragged = drag.dragged(&session.ray(self.in_picture(view, screen)));
        let now = session.selected.and_then(|selected| session.entry(selected));
        dragged.filter(|entry| now.as_ref() != Some(entry)).map(Entry::edit)
    }

    /// Zooms with Ctrl, or else changes the speed of flight.
    pub fn wheel(&self, notches: f32, view: &mut View) {
        if !self.modifiers.control_key() {
            view.flight.change_speed(notches);
            view.interface.speed = Some((view.flight.speed_text(), Instant::now()));
        } else if let Some(own) = view.scene_camera() {
            view.flight.zoom(&own, notches);
        }
    }

    /// Moves the pointer, pixels; drags the camera.
    pub fn move_to(&mut self, position: [f32; 2], view: &mut View, screen: &Screen) {
        let last = std::mem::replace(&mut self.pointer, position);
        let way = [position[0] - last[0], position[1] - last[1]];
        let (Some(own), Some((_, drag))) = (view.scene_camera(), &self.drag) else { return };
        match *drag {
            Drag::Handle(_) => {}
            Drag::Look => {
                view.flight.look(&own, way);
                self.keep_inside(view, screen);
            }
            Drag::Orbit(pivot) => view.flight.orbit(&own, pivot, way),
        }
    }

    /// Warps the pointer to the centre when it nears an edge, for unlimited rotation. Where the system forbids
    /// that, rotation stops at the edge.
    fn keep_inside(&mut self, view: &View, screen: &Screen) {
        let at = self.in_picture(view, screen);
        let is_inside = at.cmpge(Vec2::splat(0.1)).all() && at.cmple(Vec2::splat(0.9)).all();
        if !is_inside {
            let Viewport { corner, size } = screen.viewport(&view.interface);
            let [x, y] = [0, 1].map(|axis| corner[axis] as f32 + 0.5 * size[axis] as f32);
            if screen.window.set_cursor_position(winit::dpi::PhysicalPosition::new(x, y)).is_ok() {
                self.pointer = [x, y];
            }
        }
    }
}
