//! The report as tables, for Markdown, HTML and the terminal.

use super::axis::Axis;
use super::report::{EqualTime, Report};
use super::run::{FrameQuality, Run, stages};
use super::samples::{FPS, TOTAL};
use super::summary::{Noise, Summary};
use crate::estimators;

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

impl Table {
    /// A table of results.
    pub(super) fn new<Head: Into<String>>(
        title: impl Into<String>,
        note: impl Into<String>,
        columns: impl IntoIterator<Item = Head>,
        rows: impl IntoIterator<Item = Vec<String>>,
    ) -> Self {
        Self {
            title: title.into(),
            note: note.into(),
            columns: columns.into_iter().map(Into::into).collect(),
            rows: rows.into_iter().collect(),
            detail: false,
        }
    }

    fn detail(self) -> Self {
        Self { detail: true, ..self }
    }
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

/// The settings with tables and plots of their own: those with several values, or else the main one of the method.
pub(super) fn axes(report: &Report) -> Vec<Axis> {
    let varied = report.varied();
    let main = || report.runs.first().and_then(Axis::main).unwrap_or(Axis::Size);
    if varied.is_empty() { vec![main()] } else { varied }
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

/// The settings that all runs have in common and the method of some changes along.
pub(super) fn common_settings(report: &Report) -> String {
    let Some(first) = report.runs.first() else { return String::new() };
    let is_common = |axis: &Axis| report.runs.iter().all(|run| axis.text(run) == axis.text(first));
    let is_used = |axis: &Axis| report.runs.iter().any(|run| Axis::of(run).any(|own| own == *axis));
    let axes = Axis::all().into_iter().filter(|axis| is_common(axis) && is_used(axis));
    let phrase = |axis: Axis| axis.phrase(first) + if axis == Axis::Size { " pixels" } else { "" };
    axes.map(phrase).collect::<Vec<_>>().join(", ")
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
        table(
            format!("Confidence interval of the frame time, ± %, by {by}"),
            "95 % confidence interval of the median of another run on this machine.",
            &certain,
        )
        .detail(),
    ]
}

fn grid_table(grid: &Grid<'_>, title: String, note: &str, cell: &dyn Fn(&Run) -> Option<String>) -> Table {
    let row = |row: &GridRow<'_>| {
        let cells = row.runs.iter().map(|run| run.and_then(cell).unwrap_or_default());
        std::iter::once(row.label.clone()).chain(cells).collect()
    };
    Table::new(title, note, heads(grid), grid.rows.iter().map(row))
}

/// Headings of the row labels and of the values.
fn heads<'a>(grid: &'a Grid<'_>) -> impl Iterator<Item = &'a str> {
    let corner = match grid.axis {
        Axis::Number(axis) => axis.short.unwrap_or(axis.label),
        axis => axis.label(),
    };
    std::iter::once(corner).chain(grid.columns.iter().map(String::as_str))
}

/// Speed-up over undivided work.
fn speed_up(grid: &Grid<'_>, noise: &Noise) -> Option<Table> {
    let one = undivided(grid).filter(|_| grid.columns.len() > 1)?;
    let ones: Vec<f64> = grid.rows.iter().filter_map(|row| undivided_ms(grid, row, noise)).collect();
    let note = format!(
        "Median frame time at {one} over that at each value. Where --interleave is more than 1, several sets have half the \
         resolution in each direction and one set has all of it: part of the speed-up comes from that. (half): one set at \
         half the resolution, so that the quotient of two columns is what several sets gain by themselves."
    );
    let cell = |run: &Run| {
        let row = grid.rows.iter().find(|row| row.runs.iter().flatten().any(|other| other.is_same(run)))?;
        Some(format!("{:.2}", undivided_ms(grid, row, noise)? / Summary::of(run, noise)?.median(TOTAL)))
    };
    (!ones.is_empty()).then(|| grid_table(grid, format!("Speed-up over {one}"), &note, &cell))
}

/// The value 1 of the axis as a phrase, where a greater one divides the work.
pub(super) fn undivided(grid: &Grid<'_>) -> Option<String> {
    match grid.axis {
        Axis::Number(axis) if axis.divides_work => Some(axis.phrase(1)),
        _ => None,
    }
}

/// Median frame time of a row's run with undivided work.
pub(super) fn undivided_ms(grid: &Grid<'_>, row: &GridRow<'_>, noise: &Noise) -> Option<f64> {
    let one = row.runs.iter().flatten().find(|run| grid.axis.value(run) == Some(1.0))?;
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
    let lines = stages(row.runs.iter().copied().flatten()).into_iter().chain([TOTAL]).map(line);
    let note = "Interquartile means over the frames: they add up to the total and ignore slow frames. `other` is the time \
                between passes: recording, uploads, submission, waiting.";
    Table::new(format!("Stages of {} in ms, by {}", row.label, grid.axis.label()), note, heads(grid), lines)
        .detail()
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
    Table::new(
        "Spread of the frame time in ms",
        "low and high: 95 % confidence interval of the median of another run on this machine. p5 and p95: 5th and 95th \
         percentile of the frames.",
        ["run", "median", "low", "high", "mean", "p5", "p95", "worst"],
        report.runs.iter().filter_map(|run| row(run, &varied)),
    )
    .detail()
}

/// Counters of the methods, and memory.
fn counters(report: &Report, noise: &Noise) -> Table {
    let mebibytes = |bytes: u64| format!("{:.1}", bytes as f64 / f64::from(1 << 20));
    let measured = |name: &str| {
        report.runs.iter().flat_map(Run::rounds).any(|round| round.counters.0.contains_key(name))
    };
    let shown = estimators::counters().filter(|counter| counter.label.is_some() && measured(counter.name));
    let shown: Vec<_> = shown.collect();
    let row = |run: &Run, varied: &[Axis]| {
        let summary = Summary::of(run, noise)?;
        let mut cells = vec![label(run, varied)];
        cells.extend(shown.iter().map(|counter| format!("{:.1}", summary.mean(counter.name))));
        cells.push(run.cpu_peak().map(mebibytes).unwrap_or_default());
        cells.push(mebibytes(run.device_peak()));
        Some(cells)
    };
    let labels = shown.iter().filter_map(|counter| counter.label);
    let heads = ["run"].into_iter().chain(labels).chain(["CPU MiB", "device MiB"]);
    let varied = row_axes(report);
    Table::new(
        "Counters and memory",
        "Means over the frames; memory at its peak: of the whole program, and of its buffers and images on the device. On a \
         CPU driver the latter is part of the former.",
        heads,
        report.runs.iter().filter_map(|run| row(run, &varied)),
    )
    .detail()
}

/// The settings that row labels name.
fn row_axes(report: &Report) -> Vec<Axis> {
    let mut axes = report.varied();
    let main = report.runs.first().and_then(Axis::main).filter(|main| !axes.contains(main));
    if let Some(main) = main.filter(|_| !axes.contains(&Axis::Method)) {
        axes.insert(0, main);
    }
    axes
}

/// Quality against frame time.
fn quality(report: &Report, noise: &Noise) -> Vec<Table> {
    let varied = row_axes(report);
    let Some(first) = report.runs.iter().find_map(|run| run.quality.as_ref()) else { return Vec::new() };
    let frames: Vec<String> = first.frames.iter().map(|frame| frame.frame.to_string()).collect();
    let against = match report.plan.spp {
        0 => "the same pictures of each scene's first run".to_owned(),
        spp => format!("the path tracer with {spp} samples a pixel and as many bounces"),
    };
    let moving = |run: &Run| {
        let (quality, summary) = (run.quality.as_ref()?, Summary::of(run, noise)?);
        Some(vec![
            label(run, &varied),
            milliseconds(summary.median(TOTAL)),
            error(quality.mean(|frame| frame.flip)),
            similarity(quality.mean(|frame| frame.ssim)),
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
    vec![
        Table::new(
            "Quality in motion, and after it stops",
            format!(
                "Means over frames {} of the animation, against {against}. FLIP: 0 is best (HDR-FLIP); SSIM: 1 is best; relative error of luminance. Settling: frames until \
                 the picture is stationary after all motion stops; temporal error: mean change from frame to frame \
                 after that, W/m²/sr.",
                frames.join(", ")
            ),
            ["run", "frame ms", "FLIP", "SSIM", "relative error %", "settling frames", "temporal error"],
            report.runs.iter().filter_map(moving),
        ),
        Table::new(
            "Quality of a still picture",
            "The last of these moments from a fresh start: frames and time until the picture is frozen, and its error \
             then. The path tracer's is its first one.",
            ["run", "frames", "ms", "FLIP", "SSIM", "relative error %"],
            report.runs.iter().filter_map(still),
        ),
    ]
}

/// Methods at equal time.
fn equal_time(report: &Report) -> Option<Table> {
    let first = report.equal_time.first()?;
    let row = |equal: &EqualTime| {
        let chosen = equal.setting.as_ref().map(|(setting, value)| format!("{setting} {value}"));
        let samples = equal.method.samples().map(|samples| format!("{samples} samples"));
        let name = format!("{}, {}", equal.scene, equal.run);
        let mut cells = vec![name, chosen.or(samples).unwrap_or_default(), milliseconds(equal.ms)];
        cells.extend(errors(&equal.error));
        cells
    };
    let note = format!(
        "Each with so much of a setting, or so many samples a pixel, that a frame takes about as long as one of {}; in \
         motion, at frame {}.",
        first.run, first.error.frame
    );
    let columns = ["run", "chosen", "frame ms", "FLIP", "SSIM", "relative error %"];
    Some(Table::new("Methods at equal time", note, columns, report.equal_time.iter().map(row)))
}

fn errors(quality: &FrameQuality) -> [String; 3] {
    [error(quality.flip), similarity(quality.ssim), quality.relative_error.map(percent).unwrap_or_default()]
}

/// Formats milliseconds.
pub fn milliseconds(value: f64) -> String {
    format!("{value:.3}")
}

/// Formats an error with two significant digits.
fn error(value: f64) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    let decimals = (1.0 - value.abs().log10().floor()).clamp(0.0, 9.0) as usize;
    format!("{value:.decimals$}")
}

/// Formats a similarity, whose difference to 1 matters.
fn similarity(value: f64) -> String {
    format!("{value:.4}")
}

fn percent(share: f64) -> String {
    error(share * 100.0)
}
