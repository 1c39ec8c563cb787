//! The window's event loop: events go to the interface, the input or the list of actions; frames follow them.

use std::path::PathBuf;
use std::sync::{Arc, TryLockError};
use std::time::{Duration, Instant};

use winit::application::ApplicationHandler;
use winit::event::{ElementState, MouseScrollDelta, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow};
use winit::keyboard::{KeyCode, PhysicalKey};
use winit::window::WindowId;

use super::action::{Action, AppAction, EditAction, RightSide, ViewAction};
use super::app::{App, OpenWindow};
use super::panel::{is_map, is_picture};

/// Time between frames while nothing changes, and between polls while the window is hidden.
const CALM: Duration = Duration::from_millis(100);
/// Time after which the window asks a measurement again whether it may draw.
const MEASURING_POLL: Duration = Duration::from_millis(10);

impl App {
    /// Draws the next frame, unless frames are being measured; recreates the device if it was lost.
    fn draw(&mut self, events: &ActiveEventLoop) {
        let comparison = self.open.as_ref().and_then(|open| open.comparison.as_ref());
        let turn = comparison.map(|comparison| Arc::clone(comparison.bench.turn()));
        let held = turn.as_ref().map(|turn| turn.try_lock());
        if matches!(held, Some(Err(TryLockError::WouldBlock))) {
            return;
        }
        let drawn = match self.frame() {
            Err(error) if error.is_device_lost() => self.recover(error),
            other => other,
        };
        if let Err(error) = drawn {
            self.fail(events, error);
        }
        if self.open.as_ref().is_some_and(|open| open.closing) {
            events.exit();
        }
    }
}

/// The action for a dropped file: a picture goes right of the divider, if there is one or nothing else can be made of it.
fn action_of_file(path: PathBuf, is_divided: bool) -> Action {
    if is_map(&path) && !is_divided {
        EditAction::OpenMap(path).into()
    } else if is_picture(&path) {
        ViewAction::Split(Some(RightSide::Picture(path))).into()
    } else {
        AppAction::Open(path.to_string_lossy().into_owned()).into()
    }
}

impl ApplicationHandler for App {
    fn resumed(&mut self, events: &ActiveEventLoop) {
        if self.open.is_none()
            && let Err(error) = self.start(events)
        {
            self.fail(events, error);
        }
    }

    fn window_event(&mut self, events: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let Some(open) = &mut self.open else { return };
        let is_edited = open.is_edited();
        let OpenWindow { view, screen, input, actions, .. } = open;
        // A clicked widget keeps the focus, but consumes keys only during text input; Escape closes its popups.
        input.woken |= !matches!(event, WindowEvent::RedrawRequested);
        let typing = view.interface.has_keyboard || screen.context().text_edit_focused();
        let key = match &event {
            WindowEvent::KeyboardInput { event, .. } => Some(event.physical_key),
            _ => None,
        };
        let is_key = |code: KeyCode| key == Some(PhysicalKey::Code(code));
        let ours = key.is_some() && (!typing || is_key(KeyCode::F6)) && !is_key(KeyCode::Escape);
        let consumed = !ours && screen.egui.on_window_event(&screen.window, &event).consumed;
        let pointer_taken = screen.takes_pointer(screen.points(input.pointer), &view.interface);
        match event {
            WindowEvent::CloseRequested if screen.is_hidden && !is_edited => events.exit(),
            WindowEvent::CloseRequested => {
                // A hidden window draws no frame, in which it could ask.
                screen.window.set_minimized(false);
                actions.push(AppAction::Quit);
            }
            WindowEvent::RedrawRequested => self.draw(events),
            WindowEvent::Focused(false) => {
                view.flight.release();
                input.cancel(screen);
            }
            WindowEvent::ModifiersChanged(modifiers) => input.modifiers = modifiers.state(),
            WindowEvent::KeyboardInput { event, .. } => {
                let released = event.state == ElementState::Released;
                if let PhysicalKey::Code(code) = event.physical_key
                    && (!typing || released || code == KeyCode::F6)
                {
                    input.key((code, event.state, event.repeat), view, screen, actions);
                } else if is_key(KeyCode::Escape) {
                    screen.take_keyboard(&mut view.interface);
                }
            }
            WindowEvent::CursorMoved { position, .. } => {
                input.move_to([position.x as f32, position.y as f32], view, screen);
            }
            WindowEvent::MouseInput { state: ElementState::Released, button, .. } => {
                input.press.turn(false);
                input.button_up(button, screen);
            }
            WindowEvent::MouseInput { state: ElementState::Pressed, button, .. } => {
                input.press.turn(true);
                if !pointer_taken {
                    input.button_down(button, view, screen, actions);
                }
            }
            WindowEvent::MouseWheel { delta, .. } if !pointer_taken && !consumed => {
                let notches = match delta {
                    MouseScrollDelta::LineDelta(_, lines) => lines,
                    MouseScrollDelta::PixelDelta(pixels) => pixels.y as f32 / 50.0,
                };
                input.wheel(notches, view);
            }
            WindowEvent::DroppedFile(path) => actions.push(action_of_file(path, view.split.is_some())),
            _ => {}
        }
    }

    fn about_to_wait(&mut self, events: &ActiveEventLoop) {
        let Some(open) = &mut self.open else { return };
        let window = &open.screen.window;
        let size = window.inner_size();
        let hidden = size.width == 0 || size.height == 0 || window.is_minimized() == Some(true);
        if hidden != open.screen.is_hidden {
            open.screen.is_hidden = hidden;
            self.log.event(if hidden { "hidden" } else { "seen" }, ());
        }
        if hidden {
            events.set_control_flow(ControlFlow::WaitUntil(Instant::now() + CALM));
        } else if open.is_measuring() {
            events.set_control_flow(ControlFlow::WaitUntil(Instant::now() + MEASURING_POLL));
            open.screen.window.request_redraw();
        } else if open.is_calm() && !std::mem::take(&mut open.input.woken) {
            let next = open.view.clock.last_frame + CALM;
            events.set_control_flow(ControlFlow::WaitUntil(next));
            if Instant::now() >= next {
                open.screen.window.request_redraw();
            }
        } else {
            events.set_control_flow(ControlFlow::Wait);
            open.screen.window.request_redraw();
        }
    }

    fn exiting(&mut self, _: &ActiveEventLoop) {
        self.close();
    }
}
