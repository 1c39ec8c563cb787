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
    pub fn new(path: impl Into<PathBuf>) -> Result<Self, PlotError> {
        let path = path.into();
        let is = |kind: &str| path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case(kind));
        if !is("png") && !is("svg") {
            return Err(PlotError::UnknownExtension(path));
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
    pub fn save(&self, plot: &impl Plot) -> Result<(), PlotError> {
        let error = |reason| PlotError::Draw { path: self.file.path().to_path_buf(), reason };
        if !self.is_png {
            return Ok(self.file.save_text(&svg_text(plot).map_err(error)?)?);
        }
        let size = plot.size();
        let mut pixels = vec![u8::MAX; 3 * size.0 as usize * size.1 as usize];
        let canvas = BitMapBackend::with_buffer(&mut pixels, size).into_drawing_area();
        draw(plot, &canvas).map_err(error)?;
        drop(canvas);
        Ok(self.file.save_png([size.0, size.1], &pixels)?)
    }
}
