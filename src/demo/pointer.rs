//! Pointer position and drags.

use glam::Vec3;
use winit::event::MouseButton;

use super::handles::HandleDrag;

/// A drag, from button down to button up.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Drag {
    /// Rotates the view.
    Look,
    /// Orbits around a point.
    Orbit(Vec3),
    /// Drags a handle.
    Handle(Box<HandleDrag>),
}

/// The pointer in the window, pixels.
#[derive(Default)]
pub(super) struct Pointer {
    pub position: [f32; 2],
    drag: Option<(MouseButton, Drag)>,
}

impl Pointer {
    /// The drag in progress.
    pub fn drag(&self) -> Option<&Drag> {
        self.drag.as_ref().map(|(_, drag)| drag)
    }

    /// Begins a drag, unless one is in progress.
    pub fn begin(&mut self, button: MouseButton, drag: Drag) {
        self.drag.get_or_insert((button, drag));
    }

    /// Handles a button release; true if it ends the drag.
    pub fn release(&mut self, button: MouseButton) -> bool {
        let ends = self.drag.as_ref().is_some_and(|(held, _)| *held == button);
        if ends {
            self.drag = None;
        }
        ends
    }

    /// Ends any drag, as when the window loses the focus.
    pub fn cancel(&mut self) {
        self.drag = None;
    }

    /// Moves the pointer; returns the motion, pixels.
    pub fn move_to(&mut self, position: [f32; 2]) -> [f32; 2] {
        let last = std::mem::replace(&mut self.position, position);
        [position[0] - last[0], position[1] - last[1]]
    }
}
