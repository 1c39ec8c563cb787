//! The folder of a report. An unfinished report lies in a subfolder, so that an earlier report stays until the new
//! one is complete.

use std::fs;
use std::path::{Path, PathBuf};

use super::micro::MicroReport;
use super::report::{FORMAT, PictureEntry, Report};
use super::{BenchError, charts, csv, html, markdown, tables};
use crate::output::{OutputError, OutputFile, Picture};
use crate::plot::PlotFile;

/// The whole report, as JSON.
pub const REPORT_FILE: &str = "bench.json";
/// The report of micro-benchmarks, as JSON.
pub const MICRO_FILE: &str = "micro.json";
const UNFINISHED: &str = "unfinished";
const PICTURES: &str = "pictures";
const PLOTS: &str = "plots";

/// The folder of a report.
#[derive(Clone, Debug)]
pub struct Folder {
    path: PathBuf,
}

impl Folder {
    /// Checks that a report can be written to `path`, without changing anything on disk.
    ///
    /// # Errors
    /// If it cannot be written, or would overwrite a file that is no report.
    pub fn new(path: &Path) -> Result<Self, BenchError> {
        let folder = Self { path: path.to_owned() };
        let report = path.join(REPORT_FILE);
        if report.exists() {
            read_report(&report)?;
        }
        if path.is_dir() {
            OutputFile::new(report)?;
        } else if path.exists() {
            return Err(BenchError::Report { path: folder.path, reason: "is not a folder".to_owned() });
        } else {
            OutputFile::new(path)?;
        }
        Ok(folder)
    }

    /// Path.
    pub fn path(&self) -> &Path {
        &self.path
    }

    fn unfinished(&self) -> PathBuf {
        self.path.join(UNFINISHED)
    }

    /// The report of an earlier run, complete or not, with its path.
    ///
    /// # Errors
    /// If it cannot be read.
    pub fn earlier(&self) -> Result<Option<(PathBuf, Report)>, BenchError> {
        for path in [self.unfinished().join(REPORT_FILE), self.path.join(REPORT_FILE)] {
            if path.exists() {
                let report = read_report(&path)?;
                return Ok(Some((path, report)));
            }
        }
        Ok(None)
    }

    /// Saves an unfinished report.
    pub(super) fn keep(&self, report: &Report) -> Result<(), BenchError> {
        self.make_unfinished()?;
        Ok(OutputFile::new(self.unfinished().join(REPORT_FILE))?.save_json(report)?)
    }

    /// Saves a picture of an unfinished report.
    pub(super) fn keep_picture(&self, entry: &PictureEntry, picture: &Picture) -> Result<(), BenchError> {
        self.make_unfinished()?;
        Ok(OutputFile::new(self.unfinished().join(&entry.file))?.save_picture(picture)?)
    }

    /// Writes a complete report in all formats and removes the unfinished one.
    ///
    /// # Errors
    /// If something cannot be written.
    pub fn write(&self, report: &Report) -> Result<(), BenchError> {
        make_folder(&self.path)?;
        let pictures = self.path.join(PICTURES);
        make_folder(&pictures)?;
        for entry in &report.pictures {
            let from = self.unfinished().join(&entry.file);
            let to = pictures.join(&entry.file);
            if from.exists() {
                fs::rename(&from, &to).map_err(|source| OutputError::Write { path: to, source })?;
            }
        }
        let charts = charts::charts(report);
        let plots = self.path.join(PLOTS);
        make_folder(&plots)?;
        for chart in &charts {
            for kind in ["svg", "png"] {
                chart.save(&PlotFile::new(plots.join(format!("{}.{kind}", chart.name)))?)?;
            }
        }
        let tables = tables::tables(report);
        self.save("report.html", &html::page(report, &tables, &charts, &pictures)?)?;
        self.save("bench.md", &markdown::page(report, &tables, &charts))?;
        self.save("bench.csv", &csv::long(report))?;
        OutputFile::new(self.path.join(REPORT_FILE))?.save_json(report)?;
        if self.unfinished().exists() {
            let path = self.unfinished();
            fs::remove_dir_all(&path).map_err(|source| OutputError::Write { path, source })?;
        }
        Ok(())
    }

    /// Writes the report of micro-benchmarks; other files stay.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn write_micro(&self, report: &MicroReport) -> Result<(), BenchError> {
        make_folder(&self.path)?;
        self.save("micro.md", &markdown::micro_page(report))?;
        Ok(OutputFile::new(self.path.join(MICRO_FILE))?.save_json(report)?)
    }

    fn make_unfinished(&self) -> Result<(), OutputError> {
        make_folder(&self.path)?;
        make_folder(&self.unfinished())
    }

    fn save(&self, name: &str, text: &str) -> Result<(), BenchError> {
        Ok(OutputFile::new(self.path.join(name))?.save_text(text)?)
    }
}

/// Creates a folder, unless it exists, in an existing one.
fn make_folder(path: &Path) -> Result<(), OutputError> {
    if path.is_dir() {
        return Ok(());
    }
    fs::create_dir(path).map_err(|source| OutputError::Write { path: path.to_owned(), source })
}

/// Reads a report.
///
/// # Errors
/// If the file cannot be read or is no report.
pub fn read_report(path: &Path) -> Result<Report, BenchError> {
    let error = |reason: String| BenchError::Report { path: path.to_owned(), reason };
    let text = fs::read(path).map_err(|source| OutputError::Read { path: path.to_owned(), source })?;
    let not_one = |reason: String| error(format!("is not a report of glowworm bench ({reason})"));
    let report: Report = serde_json::from_slice(&text).map_err(|reason| not_one(reason.to_string()))?;
    if report.format != FORMAT {
        return Err(not_one(format!("its format is \"{}\", not \"{FORMAT}\"", report.format)));
    }
    if !report.is_sound() || !report.pictures.iter().all(PictureEntry::is_sound) {
        return Err(not_one("its contents are inconsistent".to_owned()));
    }
    Ok(report)
}
