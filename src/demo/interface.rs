//! State of the interface around the picture: what is hidden, messages, questions, and the notice before shaders are compiled.

use std::time::Instant;

use super::action::{Action, AppAction, EditAction, RightSide, ViewAction};
use super::session::Session;
use super::split::{Right, Split};
use crate::settings;

/// Settings that choose shaders.
const METHODS: [&str; 5] = ["indirect", "direct", "reflections", "antialiasing", "denoise"];

/// The interface's state, which the panel reads and actions change.
#[derive(Default)]
pub(super) struct Interface {
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
    /// The speed of flight, and when it changed.
    pub speed: Option<(String, Instant)>,
    /// The notice that the next frames wait for.
    pub preparation: Option<Preparation>,
    /// The action that waits until edits are saved or discarded.
    pub pending: Option<AppAction>,
}

/// An announcement of actions that compile shaders: a frame shows it before, as the window stands still meanwhile.
pub(super) struct Preparation {
    pub subject: String,
    /// Frames that were presented meanwhile.
    frames: u32,
    has_begun: bool,
}

impl Preparation {
    /// Frames after which it is seen: in the first one the area of the notice has no size yet.
    const ANNOUNCED: u32 = 2;
    /// Frames until its own are there: some drivers compile shaders when they first run.
    const OVER: u32 = Self::ANNOUNCED + 4;
}

impl Interface {
    /// Counts a frame that was presented.
    pub fn count_announced(&mut self) {
        if let Some(preparation) = &mut self.preparation {
            preparation.frames += 1;
        }
        self.preparation.take_if(|preparation| preparation.frames >= Preparation::OVER);
    }

    /// Whether actions wait: settings that are made meanwhile would take theirs back.
    pub fn has_waiting(&self) -> bool {
        self.preparation.as_ref().is_some_and(|preparation| !preparation.has_begun)
    }

    /// Whether an action must wait until the window has announced it.
    pub fn must_wait(&mut self, action: &Action, session: Option<&Session>, split: Option<&Split>) -> bool {
        if let Some(preparation) = self.preparation.as_mut().filter(|preparation| !preparation.has_begun) {
            preparation.has_begun = preparation.frames >= Preparation::ANNOUNCED;
            return !preparation.has_begun;
        }
        let Some(subject) = session.and_then(|session| shaders_of(action, session, split)) else {
            return false;
        };
        self.preparation = Some(Preparation { subject, frames: 0, has_begun: false });
        true
    }
}

/// Names the picture or the method for which an action compiles shaders.
fn shaders_of(action: &Action, session: &Session, split: Option<&Split>) -> Option<String> {
    let is_divided = matches!(split, Some(Split { right: Right::Renderer(_), .. }));
    match action {
        Action::View(ViewAction::ToggleSplit | ViewAction::Split(Some(RightSide::Settings(_))))
            if !is_divided =>
        {
            Some("the right side".to_owned())
        }
        Action::Edit(EditAction::Set(requested)) => {
            let mut methods = METHODS.into_iter().filter_map(settings::find);
            let other =
                methods.find(|setting| setting.value(requested) != setting.value(&session.settings))?;
            let method = other.value(requested);
            Some(format!("{} {}", other.key, method.as_str().unwrap_or_default()))
        }
        _ => None,
    }
}
