//! The question before edits are lost.

use egui::{Id, Modal, Ui};
use serde::Serialize;

use super::{PanelState, place};
use crate::demo::action::Action;

/// What ends the edits of a scene.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(in crate::demo) enum Leave {
    /// Closing the window.
    Close,
    /// Opening another scene.
    Open(String),
    /// Reading the same one again.
    Reload,
}

impl Leave {
    /// The action that does it.
    pub fn action(self) -> Action {
        match self {
            Self::Close => Action::Quit,
            Self::Open(name) => Action::Open(name),
            Self::Reload => Action::Reload,
        }
    }
}

pub(super) fn show(ui: &Ui, state: &mut PanelState, actions: &mut Vec<Action>) {
    let Some(leave) = state.leaving.clone() else { return };
    let what = match &leave {
        Leave::Close => "Closing".to_owned(),
        Leave::Open(name) => format!("Opening {}", super::scene::short(name)),
        Leave::Reload => "Reloading".to_owned(),
    };
    let modal = Modal::new(Id::new("unsaved")).show(ui.ctx(), |ui| {
        ui.set_max_width(320.0);
        ui.heading("Unsaved changes");
        ui.label(format!(
            "{what} discards the changes of this scene. The same key or button again does so, too."
        ));
        ui.add_space(6.0);
        ui.horizontal(|ui| {
            let buttons = ["Save …", "Discard", "Go on"].map(|name| (name, ui.button(name)));
            for (name, button) in &buttons {
                place(ui, &mut state.places, name, button);
            }
            buttons.map(|(_, button)| button.clicked())
        })
        .inner
    });
    let [saves, discards, stays] = modal.inner;
    if saves {
        actions.push(Action::AskSave);
    } else if discards {
        actions.push(leave.action());
    }
    if saves || stays || modal.should_close() {
        state.leaving = None;
    }
}
