//! The window of a comparison: what to measure, progress, and the result as a table and two plots.

use egui::{Color32, Grid, ProgressBar, RichText, Ui, Window, vec2};
use egui_plot::{GridMark, Line, Plot, Points};

use super::shown::Shown;
use super::widgets::Output;
use crate::bench::Method;
use crate::demo::action::{AppAction, EditAction, RequestedSettings};
use crate::demo::compare::{Comparison, Row};
use crate::demo::session::Session;
use crate::estimators;
use crate::settings::Settings;

/// Size of a plot, points.
const PLOT: egui::Vec2 = vec2(230.0, 150.0);
const BLUE: Color32 = Color32::from_rgb(86, 180, 233);
const ORANGE: Color32 = Color32::from_rgb(230, 159, 0);

/// The typed settings.
pub(in crate::demo) struct CompareState {
    sets: String,
    methods: String,
}

impl Default for CompareState {
    fn default() -> Self {
        Self { sets: "1,4,8,16,32".to_owned(), methods: "vpls".to_owned() }
    }
}

impl CompareState {
    /// The settings to compare, or what is wrong with them. Numbers of sets that the VPLs do not allow are left out.
    pub fn requested(&self, settings: &Settings) -> Result<RequestedSettings, String> {
        let number = |text: &str| text.trim().parse().map_err(|_| format!("T: {text} is no number"));
        let sets: Vec<u32> = self.sets.split(',').map(number).collect::<Result<_, _>>()?;
        let sets = sets.into_iter().filter(|sets| *sets <= settings.vpl.slots).collect();
        let methods = self.methods.split(',').map(|name| Method::list(name.trim()));
        Ok(RequestedSettings { sets, methods: methods.collect::<Result<Vec<_>, _>>()?.concat() })
    }
}

pub(super) fn draw(ui: &Ui, compare: &mut CompareState, shown: &Shown<'_>, out: &mut Output) {
    let (Some(session), Some(comparison)) = (shown.session(), shown.comparison) else { return };
    let corner = shown.picture_area(ui.ctx()).min + vec2(12.0, 12.0);
    let window = Window::new("Frame rate against temporal sets").default_pos(corner).resizable(false);
    window.show(ui.ctx(), |ui| {
        let [width, height] = session.settings.size;
        ui.label(format!(
            "{} at {width}x{height}, frames that are not presented, one after the other.",
            session.live_scene.name
        ));
        // Above all that may be taller than the window.
        let requested = compare.requested(&session.settings);
        ui.horizontal(|ui| {
            let mut button = |name: &str, is_on: bool, action: AppAction| {
                let button = ui.add_enabled(is_on, egui::Button::new(name));
                out.click(ui, &format!("compare: {name}"), &button, action);
            };
            if comparison.bench.is_running() {
                return button("Cancel", true, AppAction::Compare(None));
            }
            button("Save report", !comparison.rows.is_empty(), AppAction::SaveComparison);
            button("Measure again", requested.is_ok(), AppAction::Compare(requested.clone().ok()));
            button("Close", true, AppAction::Compare(None));
        });
        if let Err(error) = requested {
            ui.colored_label(ui.visuals().error_fg_color, error);
        }
        if comparison.bench.is_running() {
            progress(ui, comparison);
        } else {
            result(ui, session, &comparison.rows, out);
            for (name, what, text) in [
                ("T =", "Numbers of temporal sets", &mut compare.sets),
                ("methods", "Such as vpls,paths,paths@denoise=bmfr,none,reference@1", &mut compare.methods),
            ] {
                ui.horizontal(|ui| {
                    ui.label(name);
                    out.text_field(ui, &format!("compare {name}"), text, ("", 330.0)).on_hover_text(what);
                });
            }
        }
    });
}

fn progress(ui: &mut Ui, comparison: &Comparison) {
    let (share, left) = comparison.bench.progress();
    ui.label(comparison.bench.task());
    ui.add(ProgressBar::new(share).desired_width(2.0 * PLOT.x));
    ui.label(format!("about {} s left; the window waits meanwhile", left.as_secs()));
}

fn result(ui: &mut Ui, session: &Session, rows: &[Row], out: &mut Output) {
    let Some(first) = rows.first() else { return };
    let is_on = |row: &Row| {
        let known = &row.settings;
        let Settings { size, time_step, still_frames, .. } = session.settings;
        Settings { size, time_step, still_frames, ..known.clone() } == session.settings
    };
    let mut chosen = None;
    Grid::new("compared").num_columns(5).striped(true).show(ui, |ui| {
        for head in ["", "frames/s", "ms", "FLIP error", "settles in"] {
            ui.strong(head);
        }
        ui.end_row();
        for (at, row) in rows.iter().enumerate() {
            let label = ui.selectable_label(is_on(row), &row.name).on_hover_text("Switch to it.");
            out.place(ui, &format!("compared {}", row.name), &label);
            if label.clicked() {
                chosen = Some(at);
            }
            let [low, high] = row.interval;
            ui.label(format!("{:.1}", row.fps)).on_hover_text(format!(
                "{low:.1} to {high:.1} in another run, with 95 % confidence; {:.2} times as many as {}",
                row.fps / first.fps.max(1e-9),
                first.name
            ));
            ui.label(format!("{:.1}", row.ms));
            ui.label(if at == 0 { "(0)".to_owned() } else { format!("{:.3}", row.flip) });
            ui.label(format!("{} frames", row.settles));
            ui.end_row();
        }
    });
    ui.small(format!("Error: against {}. A click on a row or a point switches to it.", first.name));
    ui.horizontal(|ui| {
        let rate = |row: &Row| (row.fps, row.interval);
        let error = |row: &Row| (row.flip, [row.flip; 2]);
        let at = plot(ui, "frames per second", BLUE, rows, &rate);
        chosen = chosen.or(at).or(plot(ui, "FLIP error", ORANGE, rows, &error));
    });
    let settings = chosen.and_then(|at| rows.get(at)).map(|row| &row.settings);
    if let Some(settings) = settings {
        // The window keeps its own.
        let Settings { size, time_step, still_frames, .. } = session.settings;
        let settings = Settings { size, time_step, still_frames, ..settings.clone() };
        out.push(EditAction::Set(Box::new(settings)));
    }
}

/// A plot with a point for each row; the row whose point was clicked.
fn plot(
    ui: &mut Ui,
    name: &str,
    colour: Color32,
    rows: &[Row],
    value: &dyn Fn(&Row) -> (f64, [f64; 2]),
) -> Option<usize> {
    let names: Vec<String> = rows.iter().map(short).collect();
    let mark = move |mark: GridMark, _: &std::ops::RangeInclusive<f64>| {
        names.get(mark.value.round() as usize).cloned().unwrap_or_default()
    };
    let last = rows.len().saturating_sub(1);
    let marks = move |_| (0..=last).map(|x| GridMark { value: x as f64, step_size: 1.0 }).collect();
    ui.vertical(|ui| {
        ui.label(RichText::new(name).color(colour));
        let plot = Plot::new(name)
            .width(PLOT.x)
            .height(PLOT.y)
            .include_y(0.0)
            .include_x(-0.4)
            .include_x(last as f64 + 0.4)
            .x_grid_spacer(marks)
            .x_axis_formatter(mark)
            .show_x(false)
            .show_grid([false, true])
            .allow_drag(false)
            .allow_zoom(false)
            .allow_scroll(false)
            .allow_boxed_zoom(false)
            .allow_double_click_reset(false);
        let shown = plot.show(ui, |plot| {
            let points: Vec<[f64; 2]> =
                rows.iter().enumerate().map(|(x, row)| [x as f64, value(row).0]).collect();
            plot.line(
                Line::new("curve", points.clone()).color(colour.gamma_multiply(0.5)).allow_hover(false),
            );
            for (x, row) in rows.iter().enumerate() {
                let bar = value(row).1.map(|end| [x as f64, end]).to_vec();
                plot.line(Line::new("interval", bar).color(colour).width(2.0).allow_hover(false));
            }
            plot.points(Points::new(name, points).radius(5.0).color(colour));
        });
        let at = shown.response.interact_pointer_pos().filter(|_| shown.response.clicked())?;
        let x = shown.transform.value_from_position(at).x.round();
        Some(x.clamp(0.0, last as f64) as usize)
    })
    .inner
}

/// The name of a row below a plot: without the method where sets tell them apart.
fn short(row: &Row) -> String {
    let axes = estimators::method(&row.settings).axes;
    let first = axes.first().and_then(|axis| row.name.split_once(&format!("@{}=", axis.short?)));
    first.map_or_else(|| row.name.clone(), |(_, value)| value.to_owned())
}
