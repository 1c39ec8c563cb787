//! The last seconds as plots: frame rate, pass times, VPLs.

use egui::{Color32, Grid, RichText, Ui};
use egui_plot::{FilledArea, Line, Plot, PlotPoints};

use super::Shown;
use crate::demo::history::Sample;
use crate::report::{PASS_COLOURS, PASS_NAMES};

/// Height of a plot, points.
const HEIGHT: f32 = 90.0;

/// What is counted of VPLs, with its colour.
type Counter = (&'static str, Color32, fn(&Sample) -> u32);
const COUNTERS: [Counter; 5] = [
    ("valid", Color32::from_rgb(110, 200, 110), |sample| sample.report.figures.vpls.valid),
    ("escaped", Color32::from_rgb(110, 160, 230), |sample| sample.report.figures.vpls.escaped),
    ("stale", Color32::from_rgb(200, 200, 90), |sample| sample.report.figures.vpls.stale),
    ("invalidated", Color32::from_rgb(230, 90, 80), |sample| sample.report.figures.vpls.invalidated),
    ("shot", Color32::from_rgb(230, 160, 60), |sample| sample.report.figures.vpls.shot),
];

pub(super) fn show(ui: &mut Ui, shown: &Shown<'_>) {
    let samples: Vec<&Sample> = shown.history.samples().collect();
    if samples.is_empty() {
        return;
    }
    ui.small("milliseconds between frames");
    let intervals = samples.iter().map(|sample| sample.interval_ms);
    plot("intervals", ui, |plot| plot.line(line("interval", Color32::LIGHT_GRAY, intervals)));
    figures(ui, shown, "frame", Color32::LIGHT_GRAY, |sample| sample.interval_ms);
    figures(ui, shown, "panel, CPU", Color32::LIGHT_GRAY, |sample| sample.ui_cpu_ms);
    figures(ui, shown, "panel, device", Color32::LIGHT_GRAY, |sample| sample.ui_device_ms);
    ui.separator();
    ui.small("milliseconds of each pass, stacked");
    passes(ui, &samples);
    for (index, name) in PASS_NAMES.iter().enumerate().rev() {
        figures(ui, shown, name, pass_colour(index), |sample| sample.report.figures.passes.0[index]);
    }
    ui.separator();
    ui.small("VPLs");
    plot("vpls", ui, |plot| {
        for (name, colour, count) in COUNTERS {
            plot.line(line(name, colour, samples.iter().map(|sample| f64::from(count(sample)))));
        }
    });
    let last = samples[samples.len() - 1];
    Grid::new("counters").num_columns(2).show(ui, |ui| {
        for (name, colour, count) in COUNTERS {
            ui.label(RichText::new(name).small().color(colour));
            ui.small(count(last).to_string());
            ui.end_row();
        }
    });
}

fn passes(ui: &mut Ui, samples: &[&Sample]) {
    let xs: Vec<f64> = (0..samples.len()).map(|x| x as f64).collect();
    plot("passes", ui, |plot| {
        let mut below = vec![0.0; samples.len()];
        for (index, name) in PASS_NAMES.into_iter().enumerate() {
            let above: Vec<f64> = below
                .iter()
                .zip(samples)
                .map(|(below, sample)| below + sample.report.figures.passes.0[index])
                .collect();
            let area = FilledArea::new(name, &xs, &below, &above).fill_color(pass_colour(index));
            plot.add(area.allow_hover(false));
            below = above;
        }
    });
}

fn line<'a>(name: &str, colour: Color32, values: impl Iterator<Item = f64>) -> Line<'a> {
    let points: PlotPoints<'a> = values.enumerate().map(|(x, value)| [x as f64, value]).collect();
    Line::new(name, points).color(colour).width(1.0).allow_hover(false)
}

fn plot<'a>(id: &str, ui: &mut Ui, content: impl FnOnce(&mut egui_plot::PlotUi<'a>) + 'a) {
    Plot::new(id)
        .height(HEIGHT)
        .include_y(0.0)
        .show_x(false)
        .show_axes([false, true])
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
    ui.horizontal(|ui| {
        ui.label(RichText::new(name.replace('_', " ")).small().color(colour));
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            ui.small(format!("{median:.2}, p95 {p95:.2} ms"));
        });
    });
}

fn pass_colour(index: usize) -> Color32 {
    let [r, g, b] = PASS_COLOURS[index];
    Color32::from_rgb(r, g, b)
}
