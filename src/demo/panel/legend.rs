//! The legend: lines at the lower edge name what stands in place of the picture or over it.

use egui::{Align2, Area, Color32, Frame, Id, RichText, Sense, Ui, vec2};

use super::vpls;
use crate::estimators::views;
use crate::passes::buffer_view::COMBINED;
use crate::renderer::DebugView;
use crate::settings::Settings;

pub(super) fn draw(ui: &Ui, view: &DebugView, settings: &Settings) {
    let buffer = views().find(|known| known.name == view.buffer && known.name != COMBINED);
    let buffer = buffer.map(|buffer| format!("{}{}", buffer.label, vpls::hint(view)));
    let colours = vpls::legends(view, &settings.vpl);
    let isolated = vpls::isolated(view);
    if buffer.is_none() && isolated.is_none() && colours.is_empty() {
        return;
    }
    let area = Area::new(Id::new("legend")).anchor(Align2::LEFT_BOTTOM, [4.0, -2.0]).interactable(false);
    area.show(ui.ctx(), |ui| {
        // One line, however wide the last one was.
        ui.style_mut().wrap_mode = Some(egui::TextWrapMode::Extend);
        Frame::NONE.fill(Color32::from_black_alpha(190)).inner_margin(2.0).show(ui, |ui| {
            for (title, entries) in colours {
                ui.horizontal(|ui| {
                    ui.label(white(&title));
                    for (name, [r, g, b]) in entries {
                        let [r, g, b] = [r, g, b].map(|channel| (channel * 255.0) as u8);
                        let (place, _) = ui.allocate_exact_size(vec2(10.0, 10.0), Sense::hover());
                        ui.painter().rect_filled(place, 2.0, Color32::from_rgb(r, g, b));
                        ui.label(white(&name));
                    }
                });
            }
            for line in [isolated, buffer].into_iter().flatten() {
                ui.label(white(&line));
            }
        });
    });
}

fn white(text: &str) -> RichText {
    RichText::new(text).size(12.0).color(Color32::WHITE)
}
