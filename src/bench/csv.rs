//! The report as CSV in long format: one line per run, quantity and statistic.

use super::axis::Axis;
use super::report::Report;
use super::run::Run;
use super::summary::{Noise, Summary, key};

/// The whole text.
pub(super) fn long(report: &Report) -> String {
    let noise = Noise::of(&report.runs);
    let mut writer = ::csv::Writer::from_writer(Vec::new());
    let axes = Axis::all();
    let head = ["scene"].into_iter().chain(axes.iter().map(|axis| axis.key())).chain([
        "quantity",
        "unit",
        "statistic",
        "value",
    ]);
    // Writing to memory cannot fail.
    let _ = writer.write_record(head);
    for run in &report.runs {
        let settings: Vec<String> = axes.iter().map(|axis| axis.text(run)).collect();
        for (quantity, unit, statistic, value) in lines(run, &noise) {
            let quantity = key(quantity);
            let run = std::iter::once(run.scene.as_str()).chain(settings.iter().map(String::as_str));
            let value = value.to_string();
            let _ = writer.write_record(run.chain([&*quantity, unit, statistic, &value]));
        }
    }
    String::from_utf8(writer.into_inner().unwrap_or_default()).unwrap_or_default()
}

/// Quantity, unit, statistic, value.
type Line = (&'static str, &'static str, &'static str, f64);

fn lines(run: &Run, noise: &Noise) -> Vec<Line> {
    let Some(summary) = Summary::of(run, noise) else { return Vec::new() };
    let mut lines = Vec::new();
    for figure in &summary.figures {
        let statistics = figure.statistics().into_iter();
        lines.extend(statistics.map(|(name, value)| (figure.name, figure.unit.symbol(), name, value)));
    }
    if let Some(peak) = run.cpu_peak() {
        lines.push(("cpu_memory", "B", "peak", peak as f64));
    }
    lines.push(("device_memory", "B", "peak", run.device_peak() as f64));
    if let Some(quality) = &run.quality {
        lines.push(("flip", "", "mean", quality.mean(|frame| frame.flip)));
        lines.push(("ssim", "", "mean", quality.mean(|frame| frame.ssim)));
        lines.extend(quality.relative_error().map(|error| ("relative_error", "", "mean", error)));
        lines.push(("settling_frames", "", "value", quality.settling_frames.into()));
        lines.push(("temporal_error", "W/m^2/sr", "mean", quality.temporal_error));
        lines.push(("still_flip", "", "value", quality.still.error.flip));
        lines.push(("still_time", "ms", "value", quality.still.ms));
        lines.push(("still_frames", "", "value", quality.still.frames.into()));
    }
    lines
}
