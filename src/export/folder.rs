//! The output folder of an export: replaced as a whole, without touching files that are not of an earlier export.
//!
//! Files are written to a staging folder within it and moved when all are complete. The report lists all files; it
//! identifies an earlier export and the files of it to remove.

use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use serde::Deserialize;
use tempfile::TempDir;

use super::exporter::{OWN_FILES, REPORT_FILE};
use crate::output::{OutputError, OutputFile};

/// Name prefix of staging folders.
const STAGING_PREFIX: &str = ".glowworm-export.";

/// Folders within it.
const SUBFOLDERS: [&str; 2] = ["meshes", "textures"];

/// Why a scene cannot be exported.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// The parent folder does not exist.
    #[error("--out {out}: there is no folder {parent}; create it first")]
    NoParent {
        /// The folder of the export.
        out: PathBuf,
        /// Parent.
        parent: PathBuf,
    },
    /// A file has the folder's name.
    #[error("--out {0}: is not a folder; give another name")]
    NotAFolder(PathBuf),
    /// The folder contains other files.
    #[error("--out {0}: contains files that are not of an earlier export; give a new folder")]
    Foreign(PathBuf),
    /// A file to write exists and is not of an earlier export.
    #[error("{0}: exists and is not of an earlier export; move it away")]
    InTheWay(PathBuf),
    /// A file or folder cannot be written.
    #[error(transparent)]
    Output(#[from] OutputError),
}

/// The output folder: new, empty, or with an earlier export.
#[derive(Clone, Debug)]
pub struct ExportFolder {
    path: PathBuf,
    exists: bool,
    /// Files of the earlier export.
    earlier: Vec<String>,
}

/// The file list of a report.
#[derive(Deserialize)]
struct Listing {
    format: String,
    files: Vec<String>,
}

impl ExportFolder {
    /// Checks that `path` is usable, without changing the disk.
    ///
    /// # Errors
    /// One line that names the folder.
    pub fn new(path: impl Into<PathBuf>) -> Result<Self, ExportError> {
        let path = path.into();
        if !path.exists() {
            let parent = parent_of(&path);
            if !parent.is_dir() {
                return Err(ExportError::NoParent { out: path, parent });
            }
            let folder = Self { path, exists: false, earlier: Vec::new() };
            folder.staging_in(&parent)?;
            return Ok(folder);
        }
        if !path.is_dir() {
            return Err(ExportError::NotAFolder(path));
        }
        let mut folder = Self { path, exists: true, earlier: Vec::new() };
        match folder.listing() {
            Some(earlier) => folder.earlier = earlier,
            None if folder.is_used()? => return Err(ExportError::Foreign(folder.path)),
            None => {}
        }
        folder.staging_in(&folder.path)?;
        Ok(folder)
    }

    /// The folder.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Whether an export to this folder may write `file`.
    pub fn may_write(&self, file: &OutputFile) -> bool {
        let within = |name: &str| file.is_same(&self.path.join(name));
        let below = |folder: &&str| {
            let own = fs::canonicalize(self.path.join(folder));
            own.is_ok_and(|own| fs::canonicalize(parent_of(file.path())).is_ok_and(|other| other == own))
        };
        OWN_FILES.into_iter().any(within) || SUBFOLDERS.iter().any(below)
    }

    /// Whether the folder contains anything besides the staging folders of killed exports.
    fn is_used(&self) -> Result<bool, ExportError> {
        for entry in fs::read_dir(&self.path).map_err(|source| self.error("", source))? {
            let entry = entry.map_err(|source| self.error("", source))?;
            if !entry.file_name().to_string_lossy().starts_with(STAGING_PREFIX) {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Files of the earlier export in this folder, if any. Invalid names are skipped.
    fn listing(&self) -> Option<Vec<String>> {
        let text = fs::read(self.path.join(REPORT_FILE)).ok()?;
        let listing: Listing = serde_json::from_slice(&text).ok()?;
        let is_ours = |name: &String| match name.split_once('/') {
            None => OWN_FILES.contains(&name.as_str()),
            Some((folder, file)) => {
                let plain = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
                SUBFOLDERS.contains(&folder) && file.chars().all(plain) && !file.starts_with('.')
            }
        };
        (listing.format == "mitsuba").then(|| listing.files.into_iter().filter(is_ours).collect())
    }

    /// Replaces the earlier export by the files that `write` adds, all of them or none.
    pub(super) fn replace(
        &self,
        write: impl FnOnce(&mut Staging<'_>) -> Result<(), ExportError>,
    ) -> Result<(), ExportError> {
        if !self.exists {
            fs::create_dir(&self.path).map_err(|source| self.error("", source))?;
        }
        let replaced = self.stage(write);
        if replaced.is_err() && !self.exists {
            // Fails unless it is empty, as intended.
            let _ = fs::remove_dir(&self.path);
        }
        replaced
    }

    fn stage(
        &self,
        write: impl FnOnce(&mut Staging<'_>) -> Result<(), ExportError>,
    ) -> Result<(), ExportError> {
        let create = |within: &Path, subfolder: &str| {
            fs::create_dir_all(within.join(subfolder)).map_err(|source| self.error(subfolder, source))
        };
        let place = self.staging_in(&self.path)?;
        SUBFOLDERS.iter().try_for_each(|subfolder| create(place.path(), subfolder))?;
        let mut staging = Staging { folder: self, place: place.path(), files: Vec::new() };
        write(&mut staging)?;
        let files = staging.files;
        let foreign = |name: &&String| !self.earlier.contains(name) && self.path.join(name).exists();
        if let Some(name) = files.iter().find(foreign) {
            return Err(ExportError::InTheWay(self.path.join(name)));
        }
        SUBFOLDERS.iter().try_for_each(|subfolder| create(&self.path, subfolder))?;
        for name in &files {
            let moved = fs::rename(place.path().join(name), self.path.join(name));
            moved.map_err(|source| self.error(name, source))?;
        }
        // Files and folders that cannot be removed do no harm; folders in use cannot, as intended.
        for name in self.earlier.iter().filter(|name| !files.contains(name)) {
            let _ = fs::remove_file(self.path.join(name));
        }
        for subfolder in SUBFOLDERS {
            let _ = fs::remove_dir(self.path.join(subfolder));
        }
        Ok(())
    }

    fn staging_in(&self, folder: &Path) -> Result<TempDir, ExportError> {
        let made = tempfile::Builder::new().prefix(STAGING_PREFIX).tempdir_in(folder);
        made.map_err(|source| self.error("", source))
    }

    fn error(&self, name: &str, source: io::Error) -> ExportError {
        let path = if name.is_empty() { self.path.clone() } else { self.path.join(name) };
        ExportError::Output(OutputError::Write { path, source })
    }
}

/// The files of an export in progress.
pub(super) struct Staging<'a> {
    folder: &'a ExportFolder,
    place: &'a Path,
    files: Vec<String>,
}

impl Staging<'_> {
    /// Writes the file `name` (relative to the folder).
    pub(super) fn write(
        &mut self,
        name: &str,
        write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> Result<(), ExportError> {
        let write_to = |path: &Path| {
            let mut output = BufWriter::new(File::create(path)?);
            write(&mut output)?;
            // Some file systems report a full disk only on sync.
            output.into_inner()?.sync_all()
        };
        write_to(&self.place.join(name)).map_err(|source| self.folder.error(name, source))?;
        self.files.push(name.to_owned());
        Ok(())
    }
}

fn parent_of(path: &Path) -> PathBuf {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent.to_path_buf(),
        _ => PathBuf::from("."),
    }
}
