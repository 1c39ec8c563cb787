//! Helpers of the sections: output, layout of widgets, fields of text, colours with a strength, names.

use std::collections::BTreeMap;
use std::path::Path;

use clap::ValueEnum;
use egui::{DragValue, Id, Rect, Response, Slider, SliderClamping, TextEdit, Ui};
use glam::Vec3;

use crate::demo::action::{Action, Actions};

/// Width of a field of text, points.
pub(super) const FIELD: f32 = 150.0;
/// Key of the last field of text that had the keyboard.
const TEXT_FIELD: &str = "text field";

/// Widget rectangles in the window, points; logged so that tests find them.
pub(in crate::demo) type Layout = BTreeMap<String, [f32; 4]>;

/// Output of the panel: the user's actions, and where its widgets are.
#[derive(Default)]
pub(in crate::demo) struct Output {
    pub actions: Actions,
    pub layout: Layout,
}

impl Output {
    pub fn push(&mut self, action: impl Into<Action>) {
        self.actions.push(action);
    }

    pub fn extend(&mut self, actions: impl IntoIterator<Item: Into<Action>>) {
        self.actions.extend(actions);
    }

    /// Records a widget's rectangle, if visible.
    pub fn place(&mut self, ui: &Ui, name: &str, response: &Response) {
        let Rect { min, max } = response.rect;
        if ui.clip_rect().contains(response.rect.center()) {
            self.layout.insert(name.to_owned(), [min.x, min.y, max.x, max.y].map(f32::round));
        }
    }

    /// Adds a slider; records the rectangle of its track, without the value and the text beside it.
    pub fn slider(&mut self, ui: &mut Ui, name: &str, slider: Slider<'_>) -> Response {
        let slider = ui.add(slider.clamping(SliderClamping::Edits));
        let width = ui.spacing().slider_width.min(slider.rect.width());
        let rect = slider.rect.with_max_x(slider.rect.min.x + width);
        self.place(ui, name, &slider.clone().with_new_rect(rect));
        slider
    }

    /// Adds a field of text. It keeps the keyboard wherever the pointer goes, which a number does not.
    pub fn text_field(
        &mut self,
        ui: &mut Ui,
        name: &str,
        text: &mut String,
        (hint, width): (&str, f32),
    ) -> Response {
        let field = ui.add(TextEdit::singleline(text).hint_text(hint).desired_width(width));
        self.place(ui, name, &field);
        if field.has_focus() {
            ui.data_mut(|data| data.insert_temp(Id::new(TEXT_FIELD), field.id));
        }
        field
    }

    /// Adds a field of text with a button; returns the text once it is entered.
    pub fn entry(
        &mut self,
        ui: &mut Ui,
        (name, button): (&str, &str),
        text: &mut String,
        hint: &str,
    ) -> Option<String> {
        ui.horizontal(|ui| {
            let field = self.text_field(ui, name, text, (hint, FIELD));
            let is_entered = field.lost_focus() && ui.input(|input| input.key_pressed(egui::Key::Enter));
            let typed = text.trim();
            ((ui.button(button).clicked() || is_entered) && !typed.is_empty()).then(|| typed.to_owned())
        })
        .inner
    }

    /// Records a widget's rectangle; a click on it is this action.
    pub fn click(&mut self, ui: &Ui, name: &str, widget: &Response, action: impl Into<Action>) {
        self.place(ui, name, widget);
        self.on_click(widget, action);
    }

    /// Adds a button for this action.
    pub fn button(&mut self, ui: &mut Ui, name: &str, about: &str, action: impl Into<Action>) {
        self.on_click(&ui.button(name).on_hover_text(about), action);
    }

    /// A click on a widget is this action.
    pub fn on_click(&mut self, widget: &Response, action: impl Into<Action>) {
        if widget.clicked() {
            self.push(action);
        }
    }
}

/// Whether a widget is the last field of text that had the keyboard.
pub(super) fn is_text_field(context: &egui::Context, widget: Id) -> bool {
    context.data(|data| data.get_temp(Id::new(TEXT_FIELD))) == Some(widget)
}

/// A colour and a scale, its largest channel.
pub(super) fn power(ui: &mut Ui, name: &str, unit: &str, value: Option<&mut [f32; 3]>, least: f32) {
    let Some(value) = value else { return };
    let now = Vec3::from_array(*value);
    let mut strength = now.max_element();
    let mut colour = coloured(now, 1.0).unwrap_or(Vec3::ONE).to_array();
    ui.horizontal(|ui| {
        let picked = ui.color_edit_button_rgb(&mut colour).changed();
        let speed = 0.02 * strength.max(0.05);
        let drag = DragValue::new(&mut strength).range(least..=1e9).speed(speed);
        let dragged = ui.add(drag.suffix(format!(" {unit}"))).changed();
        ui.label(name);
        if picked || dragged {
            *value = coloured(Vec3::from_array(colour), strength).unwrap_or(now).to_array();
        }
    });
}

/// The colour whose largest channel is `strength`: how dark it was picked is not its strength. None for black, which has no hue.
fn coloured(picked: Vec3, strength: f32) -> Option<Vec3> {
    let most = picked.max_element();
    (most > 0.0).then(|| picked / most * strength)
}

/// A path without its folder.
pub(super) fn short(name: &str) -> &str {
    Path::new(name).file_name().and_then(|name| name.to_str()).unwrap_or(name)
}

/// The name of a value on the command line.
pub(super) fn name_of(value: &impl ValueEnum) -> String {
    value.to_possible_value().map(|possible| possible.get_name().to_owned()).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_colour_that_is_picked_again_and_again_stays() {
        let dark = Vec3::new(0.4, 0.2, 0.1);
        let once = coloured(dark, 8.0).expect("it has a hue");
        assert_eq!(once, Vec3::new(8.0, 4.0, 2.0));
        // The picker held at 85 % of the brightest.
        let again = coloured(0.85 * once / once.max_element(), once.max_element());
        assert!(again.is_some_and(|again| again.abs_diff_eq(once, 1e-5)), "{again:?}");
        assert_eq!(coloured(Vec3::ZERO, 8.0), None);
    }
}
