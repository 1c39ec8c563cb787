//! The report of `compare`: its JSON, a table, and curves over the frames of a sequence.

use std::fmt::Write as _;

use serde::Serialize;

use crate::metrics::{Encoding, Exposures, FrameMetrics, Metrics, SequenceMetrics};
use crate::plot::{Axis, Curves, Line, Panel, short};

/// The JSON of `compare`.
#[derive(Debug, Serialize)]
pub(super) struct CompareReport {
    pub image: String,
    pub reference: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub layer: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reference_layer: Option<String>,
    pub width: usize,
    pub height: usize,
    pub encoding: Encoding,
    /// Exposure of linear pictures, stops.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub exposure: Option<f32>,
    /// The exposures of HDR-FLIP, of the last frame.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub flip_exposures: Option<Exposures>,
    /// For a single picture only the means.
    #[serde(flatten)]
    pub metrics: SequenceMetrics,
}

/// A figure of one frame; none if undefined.
type Figure = fn(&FrameMetrics) -> Option<f64>;

/// The figures as a table. For a sequence: mean, minimum and maximum over the frames.
pub(super) fn table(report: &CompareReport) -> String {
    let (metrics, frames) = (&report.metrics.means, &report.metrics.frames);
    let mut text = format!("{} against {}: {}\n", report.image, report.reference, described(report));
    let whole = FrameMetrics {
        frame: 0,
        metrics: *metrics,
        temporal_error: report.metrics.temporal_error,
        reference_temporal_error: report.metrics.reference_temporal_error,
        luminance_temporal_error: report.metrics.luminance_temporal_error,
    };
    // Writing to a String cannot fail.
    if !frames.is_empty() {
        let _ = writeln!(text, "{:<32}{:<12}{:<12}greatest", "", "mean", "least");
    }
    for (name, figure) in rows(metrics, report) {
        let Some(value) = figure(&whole) else { continue };
        let _ = write!(text, "{name:<32}{:<12}", short(value));
        let values = || frames.iter().filter_map(figure);
        if !frames.is_empty() {
            let (least, greatest) =
                (values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max));
            let _ = write!(text, "{:<12}{}", short(least), short(greatest));
        }
        text.push('\n');
    }
    text
}

fn described(report: &CompareReport) -> String {
    let kind = match report.encoding {
        Encoding::Linear => "linear",
        Encoding::Display => "display values",
    };
    let frames = match report.metrics.frames.as_slice() {
        [] => String::new(),
        [first, .., last] => format!("frames {} to {}, ", first.frame, last.frame),
        [only] => format!("frame {}, ", only.frame),
    };
    format!("{frames}{}x{} pixels, {kind}", report.width, report.height)
}

fn rows(metrics: &Metrics, report: &CompareReport) -> Vec<(String, Figure)> {
    let side = metrics.blocks.side;
    let display =
        report.exposure.map(|stops| format!(" at exposure {}", short(stops.into()))).unwrap_or_default();
    let flip = if report.flip_exposures.is_some() { "HDR-FLIP" } else { "FLIP" };
    vec![
        ("MAE".to_owned(), |f| Some(f.metrics.mae)),
        ("RMSE".to_owned(), |f| Some(f.metrics.rmse)),
        ("relative MSE".to_owned(), |f| Some(f.metrics.relmse)),
        (format!("PSNR, dB{display}"), |f| Some(f.metrics.psnr)),
        (format!("SSIM{display}"), |f| Some(f.metrics.ssim)),
        (flip.to_owned(), |f| Some(f.metrics.flip)),
        ("mean luminance ratio".to_owned(), |f| Some(f.metrics.mean_ratio)),
        ("relative error, mean".to_owned(), |f| Some(f.metrics.mean_relative_error)),
        ("relative error, 95th percentile".to_owned(), |f| Some(f.metrics.p95_relative_error)),
        (format!("{side}x{side} blocks, mean"), |f| Some(f.metrics.blocks.mean_relative_error)),
        (format!("{side}x{side} blocks, 95th percentile"), |f| Some(f.metrics.blocks.p95_relative_error)),
        (format!("{side}x{side} blocks, share within 3 %"), |f| Some(f.metrics.blocks.within_3_percent)),
        (format!("{side}x{side} blocks, share within 5 %"), |f| Some(f.metrics.blocks.within_5_percent)),
        ("temporal error".to_owned(), |f| f.temporal_error),
        ("reference's temporal error".to_owned(), |f| f.reference_temporal_error),
        ("display luminance, RMSE".to_owned(), |f| Some(f.metrics.luminance?.rmse)),
        ("display luminance, SSIM".to_owned(), |f| Some(f.metrics.luminance?.ssim)),
        ("display luminance, temporal error".to_owned(), |f| f.luminance_temporal_error),
    ]
}

/// Curves of the figures over the frames.
pub(super) fn curves(report: &CompareReport) -> Curves {
    let line = |name: &str, figure: Figure| {
        let frames = report.metrics.frames.iter();
        let points: Vec<_> = frames.filter_map(|f| Some((f.frame as f64, figure(f)?))).collect();
        Line { name: name.to_owned(), points, ..Line::default() }
    };
    let panel = |title: &str, figure: Figure| Panel::linear(title, vec![line("", figure)]);
    let flip = if report.flip_exposures.is_some() { "HDR-FLIP" } else { "FLIP" };
    let mut temporal = panel("temporal error", |f| f.temporal_error);
    if report.metrics.reference_temporal_error.is_some() {
        temporal.lines[0].name = "image".to_owned();
        temporal.lines.push(line("reference", |f| f.reference_temporal_error));
    }
    Curves {
        title: format!("{} against {}", report.image, report.reference),
        x: Axis::linear("frame"),
        panels: vec![
            panel("RMSE", |f| Some(f.metrics.rmse)),
            panel("relative MSE", |f| Some(f.metrics.relmse)),
            panel("PSNR, dB", |f| Some(f.metrics.psnr)),
            panel("SSIM", |f| Some(f.metrics.ssim)),
            panel(flip, |f| Some(f.metrics.flip)),
            panel("mean luminance ratio", |f| Some(f.metrics.mean_ratio)),
            panel("relative error of luminance, 95th percentile", |f| Some(f.metrics.p95_relative_error)),
            temporal,
        ],
        ..Curves::default()
    }
}
