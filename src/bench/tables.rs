//! The report as tables, for Markdown, HTML and the terminal.

use super::equal_time::EqualTime;
use super::plan::Axis;
use super::quality::FrameQuality;
use super::report::{Report, Run};
use super::samples::{FPS, TOTAL, stages};
use super::summary::{Noise, Summary};
use crate::settings::Settings;

/// A table of texts.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    /// Title.
    pub title: String,
    /// Explanation of the figures.
    pub note: String,
    /// Column headings; the first column names the rows.
    pub columns: Vec<String>,
    /// A cell for each column.
    pub rows: Vec<Vec<String>>,
    /// Whether it belongs to the details.
    pub detail: bool,
}

/// Runs arranged for one axis: columns are its values, rows the other varied settings.
pub(super) struct Grid<'a> {
    pub axis: Axis,
    /// The values of the axis.
    pub columns: Vec<String>,
    pub rows: Vec<GridRow<'a>>,
}

/// The runs of one row.
pub(super) struct GridRow<'a> {
    /// The scene and the other varied settings.
    pub label: String,
    /// One for each column.
    pub runs: Vec<Option<&'a Run>>,
}

/// All tables, in order.
pub fn tables(report: &Report) -> Vec<Table> {
    let noise = Noise::of(&report.runs);
    let grids: Vec<Grid<'_>> = axes(report).into_iter().map(|axis| grid(report, axis)).collect();
    let mut tables: Vec<Table> = grids.iter().flat_map(|grid| times(grid, &noise)).collect();
    tables.extend(speed_up(&grids[0], &noise));
    tables.extend(quality(report, &noise));
    tables.extend(equal_time(report));
    tables.extend(grids[0].rows.iter().map(|row| stage_times(&grids[0], row, &noise)));
    tables.push(spread(report, &noise));
    tables.push(counters(report, &noise));
    tables
}

/// The settings with tables and plots of their own: those with several values, and temporal sets.
pub(super) fn axes(report: &Report) -> Vec<Axis> {
    let varied = report.varied();
    if varied.is_empty() { vec![Axis::TemporalSets] } else { varied }
}

/// Arranges all runs for one axis.
pub(super) fn grid(report: &Report, axis: Axis) -> Grid<'_> {
    let others: Vec<Axis> = report.varied().into_iter().filter(|other| *other != axis).collect();
    let mut grid = Grid { axis, columns: Vec::new(), rows: Vec::<GridRow<'_>>::new() };
    for run in &report.runs {
        let column = axis.text(run);
        if !grid.columns.contains(&column) {
            grid.columns.push(column);
        }
    }
    for run in report.runs.iter() {
        let label = label(run, &others);
        let column = axis.text(run);
        let at = grid.columns.iter().position(|known| *known == column).unwrap_or(0);
        if !grid.rows.iter().any(|row| row.label == label) {
            let runs = vec![None; grid.columns.len()];
            grid.rows.push(GridRow { label: label.clone(), runs });
        }
        if let Some(row) = grid.rows.iter_mut().find(|row| row.label == label) {
            row.runs[at] = Some(run);
        }
    }
    grid
}

/// Label of a run: its scene and the varied settings.
fn label(run: &Run, varied: &[Axis]) -> String {
    let phrases = varied.iter().map(|axis| axis.phrase(run));
    std::iter::once(run.scene.clone()).chain(phrases).collect::<Vec<_>>().join(", ")
}

/// The settings common to all runs.
pub(super) fn common_settings(report: &Report) -> String {
    let Some(first) = report.runs.first() else { return String::new() };
    let is_common = |axis: &Axis| report.runs.iter().all(|run| axis.text(run) == axis.text(first));
    let axes = Axis::ALL.into_iter().filter(is_common);
    axes.map(|axis| match axis {
        Axis::Interleave => format!("{0}x{0} interleaving", axis.text(first)),
        Axis::Size => format!("{} pixels", axis.text(first)),
        _ => axis.phrase(first),
    })
    .collect::<Vec<_>>()
    .join(", ")
}

/// Frame times in the layout of Tonna 2019, figure 24, and frames per second.
fn times(grid: &Grid<'_>, noise: &Noise) -> Vec<Table> {
    let table = |title: String, note: &str, cell: &dyn Fn(&Summary) -> String| {
        grid_table(grid, title, note, &|run| Summary::of(run, noise).map(|summary| cell(&summary)))
    };
    let by = grid.axis.label();
    let frame = |summary: &Summary| milliseconds(summary.median(TOTAL));
    let certain = |summary: &Summary| {
        let figure = summary.figure(TOTAL).and_then(|figure| Some((figure.spread.median, figure.interval?)));
        figure.map(|(median, [_, high])| percent(high / median - 1.0)).unwrap_or_default()
    };
    vec![
        table(
            format!("Frame time in ms, by {by}"),
            "Median over all measured frames, from the start of a frame until the device has finished it.",
            &frame,
        ),
        table(
            format!("Frames per second, by {by}"),
            "Median; frames do not overlap here, as they do in the window.",
            &|summary| format!("{:.1}", summary.median(FPS)),
        ),
        Table {
            detail: true,
            ..table(
                format!("Confidence interval of the frame time, ± %, by {by}"),
                "95 % confidence interval of the median of another run on this machine.",
                &certain,
            )
        },
    ]
}

fn grid_table(grid: &Grid<'_>, title: String, note: &str, cell: &dyn Fn(&Run) -> Option<String>) -> Table {
    let columns = std::iter::once(corner(grid)).chain(grid.columns.iter().cloned()).collect();
    let row = |row: &GridRow<'_>| {
        let cells = row.runs.iter().map(|run| run.and_then(cell).unwrap_or_default());
        std::iter::once(row.label.clone()).chain(cells).collect()
    };
    Table { title, note: note.to_owned(), columns, rows: grid.rows.iter().map(row).collect(), detail: false }
}

/// Heading of the row labels.
fn corner(grid: &Grid<'_>) -> String {
    match grid.axis {
        Axis::TemporalSets => "T".to_owned(),
        axis => axis.label().to_owned(),
    }
}

/// Speed-up over a single set.
fn speed_up(grid: &Grid<'_>, noise: &Noise) -> Option<Table> {
    let ones = |row: &GridRow<'_>| single_set_time(row, noise);
    if grid.axis != Axis::TemporalSets
        || grid.columns.len() < 2
        || !grid.rows.iter().any(|row| ones(row).is_some())
    {
        return None;
    }
    let columns = std::iter::once(corner(grid)).chain(grid.columns.iter().cloned()).collect();
    let row = |row: &GridRow<'_>| {
        let cell = |run: &Option<&Run>| {
            let time = Summary::of((*run)?, noise)?.median(TOTAL);
            Some(format!("{:.2}", ones(row)? / time))
        };
        let cells = row.runs.iter().map(|run| cell(run).unwrap_or_default());
        std::iter::once(row.label.clone()).chain(cells).collect()
    };
    Some(Table {
        title: "Speed-up over a single temporal set".to_owned(),
        note: "Median frame time at T = 1 over that at T.".to_owned(),
        columns,
        rows: grid.rows.iter().map(row).collect(),
        detail: false,
    })
}

/// Median frame time of the run with a single temporal set.
pub(super) fn single_set_time(row: &GridRow<'_>, noise: &Noise) -> Option<f64> {
    let one = row.runs.iter().flatten().find(|run| run.settings.vpl.temporal_sets == 1)?;
    Some(Summary::of(one, noise)?.median(TOTAL))
}

/// Time of each stage.
fn stage_times(grid: &Grid<'_>, row: &GridRow<'_>, noise: &Noise) -> Table {
    let summaries: Vec<Option<Summary>> =
        row.runs.iter().map(|run| run.and_then(|run| Summary::of(run, noise))).collect();
    let line = |name: &str| {
        let cell = |summary: &Option<Summary>| {
            summary.as_ref().map(|summary| milliseconds(summary.midmean(name))).unwrap_or_default()
        };
        std::iter::once(name.to_owned()).chain(summaries.iter().map(cell)).collect::<Vec<_>>()
    };
    Table {
        title: format!("Stages of {} in ms, by {}", row.label, grid.axis.label()),
        note: "Interquartile means over the frames: they add up to the total and ignore slow frames. \
               `other` is the time between passes: recording, uploads, submission, waiting."
            .to_owned(),
        columns: std::iter::once(corner(grid)).chain(grid.columns.iter().cloned()).collect(),
        rows: stages(row.runs.iter().copied().flatten()).into_iter().chain([TOTAL]).map(line).collect(),
        detail: true,
    }
}

/// Distribution of frame times.
fn spread(report: &Report, noise: &Noise) -> Table {
    let row = |run: &Run, varied: &[Axis]| {
        let figure = *Summary::of(run, noise)?.figure(TOTAL)?;
        let [low, high] = figure.interval?;
        let spread = figure.spread;
        let times = [spread.median, low, high, spread.mean, spread.p5, spread.p95, spread.worst];
        Some(std::iter::once(label(run, varied)).chain(times.map(milliseconds)).collect())
    };
    let varied = row_axes(report);
    Table {
        title: "Spread of the frame time in ms".to_owned(),
        note: "low and high: 95 % confidence interval of the median of another run on this machine. p5 and p95: \
               5th and 95th percentile of the frames."
            .to_owned(),
        columns: ["run", "median", "low", "high", "mean", "p5", "p95", "worst"].map(str::to_owned).into(),
        rows: report.runs.iter().filter_map(|run| row(run, &varied)).collect(),
        detail: true,
    }
}

/// VPLs, rays, memory.
fn counters(report: &Report, noise: &Noise) -> Table {
    let mebibytes = |bytes: u64| format!("{:.1}", bytes as f64 / f64::from(1 << 20));
    let row = |run: &Run, varied: &[Axis]| {
        let summary = Summary::of(run, noise)?;
        let mut cells = vec![label(run, varied)];
        for name in ["vpls.valid", "vpls.escaped", "vpls.stale", "vpls.invalidated", "vpls.shot"] {
            cells.push(format!("{:.1}", summary.mean(name)));
        }
        cells.push(format!("{:.0}", summary.mean("shadow_rays")));
        cells.push(run.cpu_peak().map(mebibytes).unwrap_or_default());
        cells.push(mebibytes(run.device_peak()));
        Some(cells)
    };
    let heads =
        ["run", "valid", "escaped", "stale", "invalidated", "shot", "shadow rays", "CPU MiB", "device MiB"];
    let varied = row_axes(report);
    Table {
        title: "VPLs, shadow rays and memory".to_owned(),
        note: "Means over the frames; memory at its peak: of the whole program, and of its buffers and images on the \
               device. On a CPU driver the latter is part of the former."
            .to_owned(),
        columns: heads.map(str::to_owned).into(),
        rows: report.runs.iter().filter_map(|run| row(run, &varied)).collect(),
        detail: true,
    }
}

/// The settings that row labels name.
fn row_axes(report: &Report) -> Vec<Axis> {
    let mut axes = report.varied();
    if !axes.contains(&Axis::TemporalSets) && !axes.contains(&Axis::Method) {
        axes.insert(0, Axis::TemporalSets);
    }
    axes
}

/// Quality against frame time.
fn quality(report: &Report, noise: &Noise) -> Vec<Table> {
    let varied = row_axes(report);
    let Some(first) = report.runs.iter().find_map(|run| run.quality.as_ref()) else { return Vec::new() };
    let frames: Vec<String> = first.frames.iter().map(|frame| frame.frame.to_string()).collect();
    let spp = report.plan.spp;
    let moving = |run: &Run| {
        let (quality, summary) = (run.quality.as_ref()?, Summary::of(run, noise)?);
        Some(vec![
            label(run, &varied),
            milliseconds(summary.median(TOTAL)),
            error(quality.mean(|frame| frame.flip)),
            error(quality.mean(|frame| frame.ssim)),
            quality.relative_error().map(percent).unwrap_or_default(),
            quality.settling_frames.to_string(),
            error(quality.temporal_error),
        ])
    };
    let still = |run: &Run| {
        let still = &run.quality.as_ref()?.still;
        let mut cells = vec![label(run, &varied), still.frames.to_string(), milliseconds(still.ms)];
        cells.extend(errors(&still.error));
        Some(cells)
    };
    let table =
        |title: &str, note: String, columns: &[&str], row: &dyn Fn(&Run) -> Option<Vec<String>>| Table {
            title: title.to_owned(),
            note,
            columns: columns.iter().map(|&head| head.to_owned()).collect(),
            rows: report.runs.iter().filter_map(row).collect(),
            detail: false,
        };
    vec![
        table(
            "Quality in motion, and after it stops",
            format!(
                "Means over frames {} of the animation, against the path tracer with {spp} samples a pixel and as many \
                 bounces. FLIP: 0 is best (HDR-FLIP); SSIM: 1 is best; relative error of luminance. Settling: frames until \
                 the picture is stationary after all motion stops; temporal error: mean change from frame to frame \
                 after that, W/m²/sr.",
                frames.join(", ")
            ),
            &["run", "frame ms", "FLIP", "SSIM", "relative error %", "settling frames", "temporal error"],
            &moving,
        ),
        table(
            "Quality of a still picture",
            "The last of these moments from a fresh start: frames and time until the picture stands still, and its error \
             then. The path tracer's is its first one."
                .to_owned(),
            &["run", "frames", "ms", "FLIP", "SSIM", "relative error %"],
            &still,
        ),
    ]
}

/// Methods at equal time.
fn equal_time(report: &Report) -> Option<Table> {
    let first = report.equal_time.first()?;
    let row = |equal: &EqualTime| {
        let amount = equal.vpls.or(equal.method.samples()).map(|amount| amount.to_string());
        let name = format!("{}, {}", equal.scene, equal.run);
        let mut cells = vec![name, amount.unwrap_or_default(), milliseconds(equal.ms)];
        cells.extend(errors(&equal.error));
        cells
    };
    Some(Table {
        title: "Methods at equal time".to_owned(),
        note: format!(
            "Each with as many VPLs, or samples a pixel, that a frame takes about as long as one of {}; in motion, at frame {}.",
            first.run, first.error.frame
        ),
        columns: ["run", "VPLs or samples", "frame ms", "FLIP", "SSIM", "relative error %"]
            .map(str::to_owned)
            .into(),
        rows: report.equal_time.iter().map(row).collect(),
        detail: false,
    })
}

fn errors(quality: &FrameQuality) -> [String; 3] {
    [error(quality.flip), error(quality.ssim), quality.relative_error.map(percent).unwrap_or_default()]
}

/// Formats milliseconds.
pub fn milliseconds(value: f64) -> String {
    format!("{value:.3}")
}

fn error(value: f64) -> String {
    format!("{value:.4}")
}

fn percent(share: f64) -> String {
    format!("{:.1}", share * 100.0)
}

/// Whether settings are those of a scene's representative run.
pub(super) fn is_shown(report: &Report, settings: &Settings) -> bool {
    settings.vpl.temporal_sets == report.shown_sets()
}
