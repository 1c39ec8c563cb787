//! The report as plots (Tonna 2019, figures 24 to 26, and further ones).

use super::axis::Axis;
use super::report::{Report, SceneFacts};
use super::run::{Run, stages};
use super::samples::TOTAL;
use super::summary::{Noise, Summary};
use super::tables::{Grid, GridRow, axes, grid, undivided, undivided_ms};
use crate::estimators;
use crate::output::OutputError;
use crate::plot::{self, Bar, BarPanel, Bars, Curves, Line, Look, Panel, PlotFile, Scale};
use crate::statistics::percentile;

/// Colour of the time between passes.
const OTHER_COLOUR: [u8; 3] = [186, 186, 186];
/// More curves cannot be told apart.
const MOST_LINES: usize = 7;
const WIDE: (u32, u32) = (860, 420);
const NARROW: (u32, u32) = (430, 340);

/// A plot with its name.
pub(super) struct Chart {
    /// Stem of its files.
    pub name: String,
    /// Title.
    pub title: String,
    drawing: Drawing,
}

enum Drawing {
    Curves(Curves),
    Bars(Bars),
}

impl Chart {
    /// Draws and writes it.
    pub fn save(&self, file: &PlotFile) -> Result<(), OutputError> {
        match &self.drawing {
            Drawing::Curves(curves) => file.save(curves),
            Drawing::Bars(bars) => file.save(bars),
        }
    }

    /// Text as an SVG.
    pub fn svg(&self) -> Result<String, String> {
        match &self.drawing {
            Drawing::Curves(curves) => plot::svg_text(curves),
            Drawing::Bars(bars) => plot::svg_text(bars),
        }
    }

    fn curves(name: &str, curves: Curves) -> Self {
        Self { name: name.to_owned(), title: curves.title.clone(), drawing: Drawing::Curves(curves) }
    }

    fn bars(name: &str, bars: Bars) -> Self {
        Self { name: name.to_owned(), title: bars.title.clone(), drawing: Drawing::Bars(bars) }
    }
}

/// All plots, in order.
pub(super) fn charts(report: &Report) -> Vec<Chart> {
    let noise = Noise::of(&report.runs);
    let grids: Vec<Grid<'_>> = axes(report).into_iter().map(|axis| grid(report, axis)).collect();
    let has_curve = |grid: &&Grid<'_>| grid.columns.len() > 1 && grid.axis != Axis::Method;
    let mut charts: Vec<Chart> =
        grids.iter().filter(has_curve).map(|grid| frame_times(grid, &noise)).collect();
    charts.extend(speed_up(&grids[0], &noise));
    charts.push(stages_by_axis(&grids[0], &noise));
    charts.push(stages_by_scene(report, &noise));
    charts.push(along_animation(report, &grids[0]));
    charts.extend(pareto(report, &noise));
    charts
}

fn axis(of: Axis, grid: &Grid<'_>) -> plot::Axis {
    let runs = grid.rows.iter().flat_map(|row| row.runs.iter().flatten());
    let mut ticks: Vec<(f64, String)> = Vec::new();
    for run in runs {
        let Some(value) = of.value(run) else { continue };
        let tick = (value, of.text(run));
        if !ticks.iter().any(|known| known.0 == tick.0) {
            ticks.push(tick);
        }
    }
    let scale = if of.key() == "bounces" { Scale::Linear } else { Scale::Logarithmic };
    plot::Axis { label: of.label().to_owned(), scale, ticks }
}

fn logarithmic(label: &str) -> plot::Axis {
    plot::Axis { label: label.to_owned(), scale: Scale::Logarithmic, ticks: Vec::new() }
}

/// One line per row, over the values of the axis.
fn line(row: &GridRow<'_>, axis: Axis, value: &dyn Fn(&Run) -> Option<f64>) -> Line {
    let point = |run: &&Run| Some((axis.value(run)?, value(run)?));
    let mut points: Vec<_> = row.runs.iter().flatten().filter_map(point).collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    // The second of two runs at one value is at half resolution, and only in the tables.
    points.dedup_by_key(|point| point.0);
    Line { name: row.label.clone(), points, look: Look::Marked }
}

/// One line per row, with the confidence intervals of the frame time.
fn certain_line(row: &GridRow<'_>, axis: Axis, noise: &Noise) -> Line {
    let figure = |run: &Run| Summary::of(run, noise)?.figure(TOTAL).copied();
    let end = |end: usize| {
        line(row, axis, &|run| {
            figure(run).map(|known| known.interval.map_or(known.spread.median, |it| it[end]))
        })
    };
    let (low, high) = (end(0).points, end(1).points);
    let intervals = low.into_iter().zip(high).map(|((_, low), (_, high))| [low, high]).collect();
    let medians = line(row, axis, &|run| figure(run).map(|figure| figure.spread.median));
    Line { look: Look::Intervals(intervals), ..medians }
}

fn frame_times(grid: &Grid<'_>, noise: &Noise) -> Chart {
    let lines = grid.rows.iter().take(MOST_LINES).map(|row| certain_line(row, grid.axis, noise)).collect();
    let title = format!("Frame time by {}", grid.axis.label());
    let panel = Panel { title: String::new(), y: logarithmic("median frame time, ms"), lines };
    let curves =
        Curves { title, x: axis(grid.axis, grid), panels: vec![panel], columns: 1, panel_size: WIDE };
    Chart::curves(&format!("frame-time-by-{}", grid.axis.key().replace('_', "-")), curves)
}

fn speed_up(grid: &Grid<'_>, noise: &Noise) -> Option<Chart> {
    let lines: Vec<Line> = grid
        .rows
        .iter()
        .take(MOST_LINES)
        .filter_map(|row| {
            let one = undivided_ms(grid, row, noise)?;
            Some(line(row, grid.axis, &|run| Some(one / Summary::of(run, noise)?.median(TOTAL))))
        })
        .collect();
    let one = undivided(grid).filter(|_| grid.columns.len() > 1 && !lines.is_empty())?;
    let x = axis(grid.axis, grid);
    let ideal = x.ticks.iter().map(|(sets, _)| (*sets, *sets)).collect();
    let ideal = Line { name: "ideal: so many times as fast".to_owned(), points: ideal, look: Look::Broken };
    let panel = Panel {
        title: String::new(),
        y: logarithmic(&format!("speed-up over {one}")),
        lines: lines.into_iter().chain([ideal]).collect(),
    };
    let title = format!("Speed-up over {one}");
    Some(Chart::curves("speed-up", Curves { title, x, panels: vec![panel], columns: 1, panel_size: WIDE }))
}

/// Stages with their colours.
fn parts(stages: &[&'static str]) -> Vec<(String, [u8; 3])> {
    let colour =
        |stage: &str| estimators::passes().find(|(_, pass)| pass.name == stage).map(|(_, pass)| pass.colour);
    stages.iter().map(|stage| ((*stage).to_owned(), colour(stage).unwrap_or(OTHER_COLOUR))).collect()
}

fn bar(run: &Run, label: String, stages: &[&'static str], noise: &Noise) -> Option<Bar> {
    let summary = Summary::of(run, noise)?;
    let total = summary.midmean(TOTAL);
    let total = if total < 10.0 { format!("{total:.2}") } else { format!("{total:.1}") };
    Some(Bar { label, total, parts: stages.iter().map(|stage| summary.midmean(stage)).collect() })
}

fn stages_by_axis(grid: &Grid<'_>, noise: &Noise) -> Chart {
    let stages = stages(grid.rows.iter().flat_map(|row| row.runs.iter().copied().flatten()));
    let panel = |row: &GridRow<'_>| {
        let bars = row.runs.iter().flatten();
        BarPanel {
            title: row.label.clone(),
            x_label: grid.axis.label().to_owned(),
            y_label: "ms".to_owned(),
            bars: bars.filter_map(|run| bar(run, grid.axis.text(run), &stages, noise)).collect(),
        }
    };
    let panels: Vec<BarPanel> = grid.rows.iter().map(panel).collect();
    let one = panels.len() == 1;
    let bars = Bars {
        title: format!("Stages of a frame by {}", grid.axis.label()),
        parts: parts(&stages),
        columns: if one { 1 } else { 2 },
        panel_size: if one { WIDE } else { NARROW },
        panels,
    };
    Chart::bars("stages-by-setting", bars)
}

fn stages_by_scene(report: &Report, noise: &Noise) -> Chart {
    let stages = stages(&report.runs);
    let bar = |scene: &SceneFacts| bar(report.shown_run(&scene.name)?, scene.name.clone(), &stages, noise);
    let bars = report.scenes.iter().filter_map(bar);
    let panel = BarPanel {
        title: String::new(),
        x_label: String::new(),
        y_label: "ms".to_owned(),
        bars: bars.collect(),
    };
    let shown = report.runs.first().and_then(|run| report.shown_run(&run.scene));
    let phrase = shown.and_then(|run| Some(Axis::main(run)?.phrase(run)));
    let title =
        format!("Stages of a frame by scene{}", phrase.map_or(String::new(), |phrase| format!(", {phrase}")));
    Chart::bars(
        "stages-by-scene",
        Bars { title, parts: parts(&stages), panels: vec![panel], columns: 1, panel_size: WIDE },
    )
}

/// Plots the median over the rounds of each frame.
fn along_animation(report: &Report, grid: &Grid<'_>) -> Chart {
    let line = |run: &&Run| {
        let time = |frame: u32| {
            let rounds = run.rounds().filter_map(|samples| samples.total_ms.get(frame as usize).copied());
            Some((f64::from(frame), percentile(rounds, 0.5)?))
        };
        let points = (0..report.plan.frames).filter_map(time).collect();
        Line { name: grid.axis.phrase(run), points, look: Look::Plain }
    };
    let panel = |row: &GridRow<'_>| Panel {
        title: row.label.clone(),
        y: logarithmic("ms"),
        lines: row.runs.iter().flatten().map(line).collect(),
    };
    let panels: Vec<Panel> = grid.rows.iter().map(panel).collect();
    let one = panels.len() == 1;
    let curves = Curves {
        title: "Frame time along the animation".to_owned(),
        x: plot::Axis::linear("frame"),
        columns: if one { 1 } else { 2 },
        panel_size: if one { WIDE } else { NARROW },
        panels,
    };
    Chart::curves("along-the-animation", curves)
}

/// Error against time, a panel for each scene: in motion, and until a still picture is frozen.
fn pareto(report: &Report, noise: &Noise) -> Vec<Chart> {
    if report.runs.iter().all(|run| run.quality.is_none()) {
        return Vec::new();
    }
    let moving = |run: &Run| {
        let (quality, summary) = (run.quality.as_ref()?, Summary::of(run, noise)?);
        Some((summary.median(TOTAL), quality.mean(|frame| frame.flip)))
    };
    let still = |run: &Run| {
        let still = &run.quality.as_ref()?.still;
        Some((still.ms, still.error.flip))
    };
    vec![
        pareto_chart(
            report,
            "pareto-moving",
            "Error against time in motion",
            "median frame time, ms",
            &moving,
        ),
        pareto_chart(
            report,
            "pareto-still",
            "Error against time of a still picture",
            "time until the picture is frozen, ms",
            &still,
        ),
    ]
}

fn pareto_chart(
    report: &Report,
    name: &str,
    title: &str,
    time: &str,
    point: &dyn Fn(&Run) -> Option<(f64, f64)>,
) -> Chart {
    let axes = axes(report);
    let panel = |scene: &SceneFacts| {
        let measured =
            |run| Some((point(run)?, axes.iter().map(|axis| axis.phrase(run)).collect::<Vec<_>>()));
        let measured: Vec<_> = report.runs_of(&scene.name).filter_map(measured).collect();
        let front = Line {
            name: "Pareto front".to_owned(),
            points: front(measured.iter().map(|(point, _)| *point).collect()),
            look: Look::Broken,
        };
        let points = measured.into_iter().map(|(point, texts)| Line {
            name: String::new(),
            points: vec![point],
            look: Look::Labelled(vec![texts.join(", ")]),
        });
        Panel {
            title: scene.name.clone(),
            y: plot::Axis {
                label: format!(
                    "FLIP error against the {}",
                    if report.plan.spp == 0 { "first run" } else { "path tracer" }
                ),
                scale: Scale::FromZero,
                ticks: Vec::new(),
            },
            lines: std::iter::once(front).chain(points).collect(),
        }
    };
    let panels = report.scenes.iter().map(panel).collect();
    let curves =
        Curves { title: title.to_owned(), x: logarithmic(time), panels, columns: 1, panel_size: WIDE };
    Chart::curves(name, curves)
}

/// The points than which none is both faster and better.
fn front(mut points: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    points.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let mut front: Vec<(f64, f64)> = Vec::new();
    for point in points {
        if front.last().is_none_or(|best| point.1 < best.1) {
            front.push(point);
        }
    }
    front
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_front_holds_what_nothing_beats() {
        let points = vec![(4.0, 0.1), (1.0, 0.5), (2.0, 0.6), (3.0, 0.2), (4.0, 0.05), (9.0, 0.05)];
        assert_eq!(front(points), [(1.0, 0.5), (3.0, 0.2), (4.0, 0.05)]);
    }
}
