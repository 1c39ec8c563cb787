//! Helpers of the sections: places of widgets, fields of text, colours with a strength, names.

use std::collections::BTreeMap;
use std::path::Path;

use clap::ValueEnum;
use egui::{DragValue, Id, Response, Ui};
use glam::Vec3;

/// Widget rectangles in the window, points; logged so that tests find them.
pub(in crate::demo) type Layout = BTreeMap<String, [f32; 4]>;

/// Records a widget's rectangle, if visible.
pub(super) fn place(ui: &Ui, layout: &mut Layout, name: &str, response: &Response) {
    if ui.clip_rect().contains(response.rect.center()) {
        let rect = response.rect;
        layout.insert(name.to_owned(), [rect.min.x, rect.min.y, rect.max.x, rect.max.y].map(f32::round));
    }
}

/// Records the rectangle of a slider's track, without the value and the text beside it.
pub(super) fn place_track(ui: &Ui, layout: &mut Layout, name: &str, slider: &Response) {
    let width = ui.spacing().slider_width.min(slider.rect.width());
    let rect = slider.rect.with_max_x(slider.rect.min.x + width);
    place(ui, layout, name, &slider.clone().with_new_rect(rect));
}

/// Key of the last field of text that had the keyboard.
const TEXT_FIELD: &str = "text field";

/// Notes that a field of text has the keyboard: it keeps it wherever the pointer goes, which a number does not.
pub(super) fn keep_keyboard(ui: &Ui, field: &Response) {
    if field.has_focus() {
        ui.data_mut(|data| data.insert_temp(Id::new(TEXT_FIELD), field.id));
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
