//! Keyboard and mouse input outside of the panel.

use egui::{Order, Pos2};
use glam::Vec2;
use winit::event::{ElementState, MouseButton};
use winit::keyboard::KeyCode;

use super::action::{Action, action_of};
use super::app::Open;
use super::edit::Entry;
use super::handles::{HandleDrag, light_at};
use super::pointer::Drag;
use crate::vulkan::Viewport;

impl Open {
    /// Pointer position in the picture, from (0, 0) at the top left to (1, 1).
    pub(super) fn pointer_in_picture(&self) -> Vec2 {
        let Viewport { corner, size } = self.viewport();
        let float = |pixels: [u32; 2]| Vec2::from_array(pixels.map(|side| side as f32));
        (Vec2::from_array(self.pointer.position) - float(corner)) / float(size).max(Vec2::ONE)
    }

    pub(super) fn key(&mut self, code: KeyCode, state: ElementState, repeat: bool) {
        let pressed = state == ElementState::Pressed;
        let plain = !self.modifiers.control_key() && !self.modifiers.alt_key();
        if !pressed || plain {
            self.flight.key(code, pressed);
        }
        if pressed && !repeat {
            let action = action_of(code, self.modifiers);
            if action == Some(Action::ToggleKeyboard) {
                self.toggle_keyboard();
            }
            self.actions.extend(action);
        }
    }

    /// Gives the keyboard to the panel, at its first widget, or back to the picture.
    fn toggle_keyboard(&mut self) {
        if self.panel.has_keyboard {
            return self.take_keyboard();
        }
        self.panel.has_keyboard = true;
        self.panel.hidden = false;
        self.flight.release();
        let tab = egui::Event::Key {
            key: egui::Key::Tab,
            physical_key: None,
            pressed: true,
            repeat: false,
            modifiers: egui::Modifiers::NONE,
        };
        self.egui.egui_input_mut().events.push(tab);
    }

    /// Takes the keyboard back from the panel.
    pub(super) fn take_keyboard(&mut self) {
        self.panel.has_keyboard = false;
        self.egui.egui_ctx().memory_mut(|memory| {
            if let Some(focused) = memory.focused() {
                memory.surrender_focus(focused);
            }
        });
    }

    /// Whether the interface takes a press where the pointer is now: egui itself only knows where it was in the last frame.
    pub(super) fn takes_pointer(&self) -> bool {
        let (context, at) = (self.egui.egui_ctx(), self.pointer_in_points());
        let is_beside = !self.panel.viewport(context).contains(at);
        let is_overlay = context.layer_id_at(at).is_some_and(|layer| layer.order != Order::Background);
        is_beside || is_overlay || context.egui_is_using_pointer()
    }

    pub(super) fn button(&mut self, button: MouseButton, state: ElementState) {
        if state == ElementState::Released {
            if self.pointer.release(button) {
                self.window.set_cursor_visible(true);
            }
            return;
        }
        match button {
            MouseButton::Right => {
                self.window.set_cursor_visible(false);
                self.pointer.begin(button, Drag::Look);
            }
            MouseButton::Middle => {
                let at = self.pointer_in_picture();
                if let Some(picked) = self.session.as_ref().and_then(|session| session.pick(at)) {
                    self.pointer.begin(button, Drag::Orbit(picked.surface.position));
                }
            }
            MouseButton::Left if self.inspector.is_on() => {
                let at = self.pointer_in_picture();
                if let Some(session) = &self.session {
                    self.inspector.look(session, at);
                }
            }
            MouseButton::Left => self.choose(),
            _ => {}
        }
    }

    /// Starts a drag of the handle under the pointer, or selects the object there.
    fn choose(&mut self) {
        let (at, viewport) = (self.pointer_in_points(), self.panel.viewport(self.egui.egui_ctx()));
        let in_picture = self.pointer_in_picture();
        let time = self.clock.paused.then_some(self.clock.time);
        let Some(session) = &self.session else { return };
        if self.panel.hidden {
            return;
        }
        if let Some(drag) = HandleDrag::begin(session, self.mode, time, viewport, at) {
            self.pointer.begin(MouseButton::Left, Drag::Handle(Box::new(drag)));
            return;
        }
        let selected = light_at(session, viewport, at).or_else(|| session.selected_at(in_picture));
        self.actions.push(Action::Select(selected));
    }

    /// Applies the drag of a handle to the selected entry, once per frame.
    pub(super) fn drag_handle(&mut self) {
        let (Some(session), Some(Drag::Handle(drag))) = (&self.session, self.pointer.drag()) else { return };
        let dragged = drag.dragged(&session.ray(self.pointer_in_picture()));
        let now = session.selected.and_then(|selected| session.entry(selected));
        self.actions.extend(dragged.filter(|entry| now.as_ref() != Some(entry)).map(Entry::edit));
    }

    /// Zooms with Ctrl, or else changes the speed of flight.
    pub(super) fn wheel(&mut self, notches: f32) {
        if !self.modifiers.control_key() {
            self.flight.change_speed(notches);
            return self.panel.show_speed(self.flight.speed_text());
        }
        if let Some(session) = &self.session {
            let own = session.live_scene.pose(self.clock.time).camera;
            self.flight.zoom(&own, notches);
        }
    }

    fn pointer_in_points(&self) -> Pos2 {
        let scale = self.egui.egui_ctx().pixels_per_point();
        Pos2::new(self.pointer.position[0] / scale, self.pointer.position[1] / scale)
    }

    pub(super) fn pointer_moved(&mut self, position: [f32; 2]) {
        let way = self.pointer.move_to(position);
        let (Some(session), Some(drag)) = (&self.session, self.pointer.drag()) else { return };
        let own = session.live_scene.pose(self.clock.time).camera;
        match *drag {
            Drag::Handle(_) => {}
            Drag::Look => {
                self.flight.look(&own, way);
                self.keep_pointer_inside();
            }
            Drag::Orbit(pivot) => self.flight.orbit(&own, pivot, way),
        }
    }

    /// Warps the pointer to the centre when it nears an edge, for unlimited rotation. Where the system forbids
    /// that, rotation stops at the edge.
    fn keep_pointer_inside(&mut self) {
        let at = self.pointer_in_picture();
        let is_inside = at.cmpge(Vec2::splat(0.1)).all() && at.cmple(Vec2::splat(0.9)).all();
        if !is_inside {
            let Viewport { corner, size } = self.viewport();
            let [x, y] = [0, 1].map(|axis| corner[axis] as f32 + 0.5 * size[axis] as f32);
            if self.window.set_cursor_position(winit::dpi::PhysicalPosition::new(x, y)).is_ok() {
                self.pointer.move_to([x, y]);
            }
        }
    }
}
