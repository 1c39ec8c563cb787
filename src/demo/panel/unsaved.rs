//! The question before edits are lost.

use egui::{Id, Modal, Ui};

use super::{PanelState, place};
use crate::demo::action::Action;

pub(super) fn draw(ui: &Ui, state: &mut PanelState, actions: &mut Vec<Action>) {
    let Some(pending) = state.pending.clone() else { return };
    let what = match &pending {
        Action::Open(name) => format!("Opening {}", super::scene::short(name)),
        Action::Reload => "Reloading".to_owned(),
        _ => "Closing".to_owned(),
    };
    let modal = Modal::new(Id::new("unsaved")).show(ui.ctx(), |ui| {
        ui.set_max_width(320.0);
        ui.heading("Unsaved changes");
        ui.label(format!("{what} discards the changes of this scene."));
        ui.add_space(6.0);
        ui.horizontal(|ui| {
            let buttons = ["Save …", "Discard", "Cancel"].map(|name| (name, ui.button(name)));
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
        actions.push(pending);
    }
    if saves || stays || modal.should_close() {
        state.pending = None;
    }
}
