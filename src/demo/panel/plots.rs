//! Plots of the last frames: frame intervals, pass times, counters of the method.

use egui::{Align, Color32, Grid, Label, RichText, TextStyle, Ui, vec2};
use egui_plot::{AxisHints, FilledArea, Line, Plot, PlotPoints};

use super::shown::Shown;
use super::widgets::Output;
use crate::demo::action::EditAction;
use crate::demo::history::Sample;
use crate::estimators::{self, CounterInfo};
use crate::settings::{self, Settings};

/// Height of a plot, points.
const HEIGHT: f32 = 120.0;

/// Parts that a frame can do without: name, setting, and the value that leaves it out.
const SWITCHES: [(&str, &str, &str); 5] = [
    ("indirect light", "indirect", "none"),
    ("soft shadows", "direct", "hard"),
    ("reflections", "reflections", "none"),
    ("denoiser", "denoise", "none"),
    ("antialiasing", "antialiasing", "none"),
];

pub(super) fn draw(ui: &mut Ui, shown: &Shown<'_>, out: &mut Output) {
    let samples: Vec<&Sample> = shown.history.samples.iter().collect();
    if samples.is_empty() {
        return;
    }
    ui.small("milliseconds between frames");
    let intervals = samples.iter().map(|sample| sample.interval_ms);
    plot("intervals", "ms", ui, |plot| plot.line(line("interval", Color32::LIGHT_GRAY, intervals)));
    figures(ui, shown, "frame", Color32::LIGHT_GRAY, |sample| sample.interval_ms);
    figures(ui, shown, "panel, CPU", Color32::LIGHT_GRAY, |sample| sample.ui_cpu_ms);
    figures(ui, shown, "panel, device", Color32::LIGHT_GRAY, |sample| sample.ui_device_ms);
    let memory = shown.gpu.device.memory_peak() as f64 / f64::from(1 << 20);
    ui.small(format!("device memory: {memory:.0} MiB at most"));
    ui.separator();
    if let Some(session) = shown.session() {
        switches(ui, &session.settings, out);
    }
    ui.small("milliseconds of each pass, stacked");
    let last = samples[samples.len() - 1];
    let names: Vec<&str> = last.report.figures.passes.keys().copied().collect();
    let whole: Vec<&str> = names.iter().copied().filter(|name| !estimators::is_part(name)).collect();
    passes(ui, &samples, &whole);
    let ran = |name: &&&str| samples.iter().any(|sample| pass_ms(sample, name) > 0.0);
    for name in names.iter().rev().filter(ran) {
        figures(ui, shown, name, pass_colour(name), |sample| pass_ms(sample, name));
    }
    let Some(session) = shown.session() else { return };
    let method = estimators::method(&session.settings);
    let plotted = |counter: &CounterInfo| {
        let [r, g, b] = counter.colour?;
        Some((counter.name, counter.label?, Color32::from_rgb(r, g, b)))
    };
    let counters: Vec<_> = method.counters.iter().filter_map(plotted).collect();
    if counters.is_empty() {
        return;
    }
    ui.separator();
    ui.small(method.label);
    let count = |sample: &Sample, key: &str| sample.report.figures.counters.get(key);
    plot("counters", method.label, ui, |plot| {
        for (key, name, colour) in &counters {
            plot.line(line(name, *colour, samples.iter().map(|sample| count(sample, key) as f64)));
        }
    });
    Grid::new("counts").num_columns(2).show(ui, |ui| {
        for (key, name, colour) in &counters {
            ui.label(RichText::new(*name).small().color(*colour));
            ui.small(count(last, key).to_string());
            ui.end_row();
        }
    });
}

/// Leaves passes out, or has them again as they are by default.
fn switches(ui: &mut Ui, settings: &Settings, out: &mut Output) {
    ui.horizontal_wrapped(|ui| {
        for (name, key, off) in SWITCHES {
            let Some(setting) = settings::find(key) else { continue };
            let mut is_on = setting.text(settings) != off;
            let switch = ui.checkbox(&mut is_on, name).on_hover_text(setting.option());
            out.place(ui, name, &switch);
            let wanted = if is_on { setting.text(&Settings::default()) } else { off.to_owned() };
            let mut changed = settings.clone();
            if switch.changed() && setting.set(&mut changed, &wanted).is_ok() {
                out.push(EditAction::Set(Box::new(changed)));
            }
        }
    });
}

fn passes(ui: &mut Ui, samples: &[&Sample], names: &[&str]) {
    let xs: Vec<f64> = (0..samples.len()).map(|x| x as f64).collect();
    plot("passes", "ms", ui, |plot| {
        let mut below = vec![0.0; samples.len()];
        for name in names {
            let above: Vec<f64> =
                below.iter().zip(samples).map(|(below, sample)| below + pass_ms(sample, name)).collect();
            let area = FilledArea::new(*name, &xs, &below, &above).fill_color(pass_colour(name));
            plot.add(area.allow_hover(false));
            below = above;
        }
    });
}

fn line<'a>(name: &str, colour: Color32, values: impl Iterator<Item = f64>) -> Line<'a> {
    let points: PlotPoints<'a> = values.enumerate().map(|(x, value)| [x as f64, value]).collect();
    Line::new(name, points).color(colour).width(1.0).allow_hover(false)
}

fn plot<'a>(id: &str, unit: &str, ui: &mut Ui, content: impl FnOnce(&mut egui_plot::PlotUi<'a>) + 'a) {
    Plot::new(id)
        .height(HEIGHT)
        .include_y(0.0)
        .show_x(false)
        .custom_x_axes(vec![AxisHints::new_x().label("frame")])
        // Narrow enough for some numbers at this height.
        .custom_y_axes(vec![AxisHints::new_y().label(unit).label_spacing(8.0..=16.0)])
        .show_grid([false, true])
        .allow_drag(false)
        .allow_zoom(false)
        .allow_scroll(false)
        .allow_boxed_zoom(false)
        .allow_double_click_reset(false)
        .show(ui, content);
}

/// Median and 95th percentile of a figure.
fn figures(ui: &mut Ui, shown: &Shown<'_>, name: &str, colour: Color32, figure: impl Fn(&Sample) -> f64) {
    let Some([median, p95]) = shown.history.median_and_p95(figure) else { return };
    let row = vec2(ui.available_width(), ui.text_style_height(&TextStyle::Small));
    ui.allocate_ui_with_layout(row, egui::Layout::right_to_left(Align::Center), |ui| {
        ui.small(format!("{median:.2}, p95 {p95:.2} ms"));
        // A long name is cut off, not drawn over its figures.
        ui.with_layout(egui::Layout::left_to_right(Align::Center), |ui| {
            let name = RichText::new(name.replace('_', " ")).small().color(colour);
            ui.add(Label::new(name).truncate());
        });
    });
}

fn pass_ms(sample: &Sample, name: &str) -> f64 {
    sample.report.figures.passes.get(name).copied().unwrap_or(0.0)
}

fn pass_colour(name: &str) -> Color32 {
    let colour = estimators::passes().find(|(_, pass)| pass.name == name).map(|(_, pass)| pass.colour);
    let [r, g, b] = colour.unwrap_or([186; 3]);
    Color32::from_rgb(r, g, b)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn switches_are_settings_with_such_a_value() {
        for (_, key, off) in SWITCHES {
            let (setting, mut settings) = (settings::find(key).unwrap(), Settings::default());
            assert!(setting.text(&settings) != off && setting.set(&mut settings, off).is_ok(), "{key}");
            assert_eq!(settings.check(), Ok(()));
        }
    }
}
