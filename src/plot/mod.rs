//! Charts, in PNG or SVG.
//!
//! Text in a PNG uses an embedded font, so it needs none on the machine; an SVG leaves the font to its viewer.

mod axis;
mod bars;
mod curves;
mod heatmap;
mod page;

pub use axis::{Axis, Scale};
pub use bars::{Bar, BarPanel, Bars};
pub use curves::{Curves, Line, Look, Panel};
pub use heatmap::{Heatmap, magma, round_limit};

use std::path::PathBuf;
use std::sync::Once;

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::register_font;

use crate::output::{OutputError, OutputFile};

/// Font family of all text.
const FONT: &str = "sans-serif";

type Drawn<Canvas> = Result<(), DrawingAreaErrorKind<<Canvas as DrawingBackend>::ErrorType>>;

/// A chart, independent of the format.
pub trait Plot {
    /// Width and height in pixels.
    fn size(&self) -> (u32, u32);

    /// Draws it on a canvas of that size.
    ///
    /// # Errors
    /// Those of the canvas.
    fn draw<Canvas: DrawingBackend>(&self, canvas: &DrawingArea<Canvas, Shift>) -> Drawn<Canvas>;
}

/// A plot as SVG text.
///
/// # Errors
/// The reason, if it cannot be drawn.
pub fn svg_text(plot: &impl Plot) -> Result<String, String> {
    let mut text = String::new();
    draw(plot, &SVGBackend::with_string(&mut text, plot.size()).into_drawing_area())?;
    Ok(text)
}

fn draw<Canvas: DrawingBackend>(plot: &impl Plot, canvas: &DrawingArea<Canvas, Shift>) -> Result<(), String> {
    prepare_font();
    plot.draw(canvas).and_then(|()| canvas.present()).map_err(|error| error.to_string())
}

/// Why a plot cannot be written; each names the file.
#[derive(Debug, thiserror::Error)]
pub enum PlotError {
    /// Neither `.svg` nor `.png`.
    #[error("{0}: unknown kind of plot; the name must end in .svg or .png")]
    UnknownExtension(PathBuf),
    /// The file cannot be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// The plot cannot be drawn.
    #[error("{path}: cannot be drawn: {reason}")]
    Draw {
        /// The file.
        path: PathBuf,
        /// The reason.
        reason: String,
    },
}

impl PlotError {
    /// Whether the name itself is invalid, independent of the file system.
    pub fn is_usage(&self) -> bool {
        match self {
            Self::UnknownExtension(_) => true,
            Self::Output(error) => error.is_usage(),
            Self::Draw { .. } => false,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    Png,
    Svg,
}

/// The output file of a plot, with its format; checked to be writable.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PlotFile {
    file: OutputFile,
    format: Format,
}

impl PlotFile {
    /// Checks the extension and that `path` is writable.
    ///
    /// # Errors
    /// If the extension is neither `.svg` nor `.png`, or the file is not writable.
    pub fn new(path: impl Into<PathBuf>) -> Result<Self, PlotError> {
        let path = path.into();
        let is = |kind: &str| path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case(kind));
        let format = match (is("png"), is("svg")) {
            (true, _) => Format::Png,
            (_, true) => Format::Svg,
            _ => return Err(PlotError::UnknownExtension(path)),
        };
        Ok(Self { file: OutputFile::new(path)?, format })
    }

    /// The file.
    pub fn file(&self) -> &OutputFile {
        &self.file
    }

    /// Draws and writes `plot`.
    ///
    /// # Errors
    /// If it cannot be drawn or written.
    pub fn save(&self, plot: &impl Plot) -> Result<(), PlotError> {
        let error = |reason| PlotError::Draw { path: self.file.path().to_path_buf(), reason };
        match self.format {
            Format::Png => {
                let size = plot.size();
                let mut pixels = vec![u8::MAX; 3 * size.0 as usize * size.1 as usize];
                let canvas = BitMapBackend::with_buffer(&mut pixels, size).into_drawing_area();
                draw(plot, &canvas).map_err(error)?;
                drop(canvas);
                self.file.save_png([size.0, size.1], &pixels)?;
            }
            Format::Svg => self.file.save_text(&svg_text(plot).map_err(error)?)?,
        }
        Ok(())
    }
}

/// Registers the embedded font with the plotting library.
fn prepare_font() {
    static PREPARED: Once = Once::new();
    PREPARED.call_once(|| {
        let known = register_font(FONT, FontStyle::Normal, include_bytes!("DejaVuSans-Latin.ttf"));
        assert!(known.is_ok(), "the font is part of the program");
    });
}

/// Formats a number with few digits: 0.012346, 12.346, 1.235e-7.
pub fn short(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    let exponent = value.abs().log10().floor() as i32;
    if !(-4..6).contains(&exponent) {
        return format!("{value:.3e}");
    }
    let decimals = usize::try_from(4 - exponent).unwrap_or(0);
    let text = format!("{value:.decimals$}");
    if !text.contains('.') {
        return text;
    }
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        for (value, text) in [
            (0.0, "0"),
            (1.0, "1"),
            (0.25, "0.25"),
            (0.012_345_67, "0.012346"),
            (12.345_67, "12.346"),
            (-12.345_67, "-12.346"),
            (100_000.0, "100000"),
            (1.234_567e-7, "1.235e-7"),
            (1.0e9, "1.000e9"),
            (f64::INFINITY, "inf"),
        ] {
            assert_eq!(short(value), text);
        }
    }

    fn curves() -> Curves {
        let points = |slope: f64| (0..20).map(|i| (f64::from(i), slope * f64::from(i))).collect();
        let line = |name: &str, points| Line { name: name.to_owned(), points, ..Line::default() };
        let reference = || line("reference", vec![(0.0, f64::INFINITY), (3.0, 0.1)]);
        let panel = |name: &str| Panel::linear(name, vec![line("image", points(0.01)), reference()]);
        Curves {
            title: "Title".to_owned(),
            x: Axis::linear("frame"),
            panels: vec![panel("RMSE"), panel("FLIP"), panel("SSIM")],
            ..Curves::default()
        }
    }

    #[test]
    fn plots_are_drawn_in_both_formats() {
        let folder = tempfile::tempdir().unwrap();
        let save = |name: &str| {
            let file = PlotFile::new(folder.path().join(name)).unwrap();
            file.save(&curves()).unwrap();
            file.file().path().to_path_buf()
        };
        let text = std::fs::read_to_string(save("a.svg")).unwrap();
        for part in ["<svg", "Title", "RMSE", "FLIP", "SSIM", "reference", "frame", "polyline"] {
            assert!(text.contains(part), "{part}");
        }
        let picture = image::open(save("a.PNG")).unwrap().into_rgb8();
        let dark = picture.pixels().filter(|pixel| pixel.0.iter().all(|&channel| channel < 96)).count();
        // The letters of titles and labels.
        assert!(dark > 500, "{dark}");
    }

    #[test]
    fn plots_without_points_are_drawn_too() {
        let folder = tempfile::tempdir().unwrap();
        let file = PlotFile::new(folder.path().join("a.png")).unwrap();
        let mut curves = curves();
        for line in curves.panels.iter_mut().flat_map(|panel| &mut panel.lines) {
            line.points.clear();
        }
        file.save(&curves).unwrap();
        curves.panels.clear();
        file.save(&curves).unwrap();
    }

    #[test]
    fn the_name_says_which_kind_of_plot() {
        let error = PlotFile::new("a.pdf").unwrap_err();
        assert!(error.is_usage() && error.to_string().contains("must end in .svg or .png"), "{error}");
        let error = PlotFile::new("no such folder/a.svg").unwrap_err();
        assert!(!error.is_usage() && error.to_string().contains("no folder"), "{error}");
    }
}
