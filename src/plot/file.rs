//! Plots as files, in PNG or SVG.

use std::path::PathBuf;

use plotters::coord::Shift;
use plotters::prelude::*;

use super::page::Plot;
use super::text::prepare_font;
use crate::output::{OutputError, OutputFile};

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

/// The output file of a plot, with its format; checked to be writable.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PlotFile {
    file: OutputFile,
    is_png: bool,
}

impl PlotFile {
    /// Checks the extension and that `path` is writable.
    ///
    /// # Errors
    /// If the extension is neither `.svg` nor `.png`, or the file is not writable.
    pub fn new(path: impl Into<PathBuf>) -> Result<Self, OutputError> {
        let path = path.into();
        let is = |kind: &str| path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case(kind));
        if !is("png") && !is("svg") {
            return Err(OutputError::UnknownPlot(path));
        }
        let is_png = is("png");
        Ok(Self { file: OutputFile::new(path)?, is_png })
    }

    /// The file.
    pub fn file(&self) -> &OutputFile {
        &self.file
    }

    /// Draws and writes `plot`.
    ///
    /// # Errors
    /// If it cannot be drawn or written.
    pub fn save(&self, plot: &impl Plot) -> Result<(), OutputError> {
        let error = |reason| OutputError::Encode(self.file.path().to_path_buf(), reason);
        if !self.is_png {
            return self.file.save_text(&svg_text(plot).map_err(error)?);
        }
        let size = plot.size();
        let mut pixels = vec![u8::MAX; 3 * size.0 as usize * size.1 as usize];
        let canvas = BitMapBackend::with_buffer(&mut pixels, size).into_drawing_area();
        draw(plot, &canvas).map_err(error)?;
        drop(canvas);
        self.file.save_png([size.0, size.1], &pixels)
    }
}
