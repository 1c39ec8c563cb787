//! Actions that compile shaders: a frame says so before, as the window stands still meanwhile.

use super::DemoError;
use super::action::Action;
use super::app::{App, Open};
use super::split::{Right, RightSide, Split};
use crate::settings;

/// Settings that choose shaders.
const METHODS: [&str; 5] = ["indirect", "direct", "reflections", "antialiasing", "denoise"];

/// What takes so long that a frame says so first.
pub(super) struct Preparation {
    pub what: String,
    /// Frames that were presented meanwhile.
    frames: u32,
    has_begun: bool,
}

impl Preparation {
    /// Frames after which it is seen: in the first one the area of the notice has no size yet.
    const ANNOUNCED: u32 = 2;
    /// Frames until its own are there: some drivers compile shaders when they first run.
    const OVER: u32 = Self::ANNOUNCED + 4;

    fn of(what: String) -> Self {
        Self { what, frames: 0, has_begun: false }
    }
}

impl App {
    /// Executes the actions in their order. One that must be announced waits with all after it.
    pub(super) fn perform_all(&mut self) -> Result<(), DemoError> {
        let actions = self.open.as_mut().map_or_else(Vec::new, |open| std::mem::take(&mut open.actions));
        for action in actions {
            let Some(open) = &mut self.open else { return Ok(()) };
            if open.must_wait(&action) {
                open.actions.push(action);
            } else {
                self.perform(action)?;
            }
        }
        Ok(())
    }
}

impl Open {
    /// Counts a frame that was presented.
    pub(super) fn count_announced(&mut self) {
        if let Some(preparation) = &mut self.panel.preparation {
            preparation.frames += 1;
        }
        self.panel.preparation.take_if(|preparation| preparation.frames >= Preparation::OVER);
    }

    /// Whether actions wait: settings that are made meanwhile would take theirs back.
    pub(super) fn has_waiting(&self) -> bool {
        self.panel.preparation.as_ref().is_some_and(|preparation| !preparation.has_begun)
    }

    /// Whether an action must wait until the window has said what takes so long.
    fn must_wait(&mut self, action: &Action) -> bool {
        match &mut self.panel.preparation {
            Some(preparation) if !preparation.has_begun => {
                preparation.has_begun = preparation.frames >= Preparation::ANNOUNCED;
                !preparation.has_begun
            }
            _ => {
                let next = self.what_takes_long(action).map(Preparation::of);
                let waits = next.is_some();
                self.panel.preparation = next.or(self.panel.preparation.take());
                waits
            }
        }
    }

    /// What an action compiles shaders for.
    fn what_takes_long(&self, action: &Action) -> Option<String> {
        let session = self.session.as_ref()?;
        let is_divided = matches!(&self.split, Some(Split { right: Right::Renderer(_), .. }));
        match action {
            Action::ToggleSplit | Action::Split(Some(RightSide::Settings(_))) if !is_divided => {
                Some("the right side".to_owned())
            }
            Action::Set(wanted) => {
                let mut methods = METHODS.into_iter().filter_map(settings::find);
                let other =
                    methods.find(|setting| setting.value(wanted) != setting.value(&session.settings))?;
                let method = other.value(wanted);
                Some(format!("{} {}", other.key, method.as_str().unwrap_or_default()))
            }
            _ => None,
        }
    }
}
