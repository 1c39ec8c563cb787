//! The question before edits are lost.

use egui::{Id, Modal, Ui};

use super::shown::Shown;
use super::widgets::{Output, short};
use crate::demo::action::AppAction;

pub(super) fn draw(ui: &Ui, shown: &Shown<'_>, out: &mut Output) {
    let Some(pending) = &shown.view.interface.pending else { return };
    let what = match pending {
        AppAction::Open(name) => format!("Opening {}", short(name)),
        AppAction::Reload => "Reloading".to_owned(),
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
                out.place(ui, name, button);
            }
            buttons.map(|(_, button)| button.clicked())
        })
        .inner
    });
    let [saves, discards, stays] = modal.inner;
    if saves {
        out.push(AppAction::AskSave);
    } else if discards {
        out.push(pending.clone());
    }
    if saves || stays || modal.should_close() {
        out.push(AppAction::KeepScene);
    }
}
