//! Undo: edits of the scene, and settings, can be taken back.

use super::action::Selected;
use crate::formats::SceneDocument;
use crate::settings::Settings;

/// Steps to keep.
const LENGTH: usize = 200;

/// The state that an edit changes.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct State {
    pub document: SceneDocument,
    /// Settings; their size is not taken back, since it is the window's.
    pub settings: Settings,
    pub headlamp: Option<usize>,
    pub selected: Option<Selected>,
}

/// A press of a mouse button; all it changes is one step.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Press {
    number: u64,
    is_down: bool,
    is_released: bool,
}

/// States before and after the current one, the nearest last.
#[derive(Default)]
pub(super) struct Undo {
    past: Vec<State>,
    future: Vec<State>,
    /// The press that the last step belongs to.
    press: Option<u64>,
}

impl Press {
    /// A button was pressed or released.
    pub fn turn(&mut self, pressed: bool) {
        if pressed {
            *self = Self { number: self.number + 1, is_down: true, is_released: false };
        } else {
            self.is_released = true;
        }
    }

    /// Notes that the frame has executed the actions of the press.
    pub fn end_frame(&mut self) {
        self.is_down &= !self.is_released;
    }

    fn current(self) -> Option<u64> {
        self.is_down.then_some(self.number)
    }
}

impl Undo {
    /// Whether a change during `press` would be a step of its own; if not, it belongs to the last one.
    pub fn begins_step(&self, press: Press) -> bool {
        press.current().is_none() || press.current() != self.press
    }

    /// Notes the state before the first change of a step; none: the step goes on.
    pub fn remember(&mut self, before: Option<State>, press: Press) {
        self.press = press.current();
        self.future.clear();
        if self.past.len() == LENGTH && before.is_some() {
            self.past.remove(0);
        }
        self.past.extend(before);
    }

    /// Steps from `now` to the state before it, or forward again to the one after it.
    pub fn step(&mut self, is_back: bool, now: State) -> Option<State> {
        let (mut from, mut to) = (&mut self.past, &mut self.future);
        if !is_back {
            std::mem::swap(&mut from, &mut to);
        }
        let state = from.pop()?;
        to.push(now);
        Some(state)
    }
}
