//! Atomic file output: files appear complete or not at all.

use std::fs::{self, File};
use std::io::{self, BufWriter, ErrorKind, Write};
use std::path::{Path, PathBuf};

use super::error::OutputError;
use super::temporary::Temporary;

/// An output file: checked to be writable first, written to a temporary file in the same folder, then moved to its place. Mode and
/// hard links of an existing file are kept.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OutputFile {
    path: PathBuf,
}

impl OutputFile {
    /// Checks that `path` is writable, without leaving a file behind.
    pub fn new(path: impl Into<PathBuf>) -> Result<Self, OutputError> {
        let file = Self { path: path.into() };
        let folder = folder_of(&file.final_path());
        match fs::metadata(&folder) {
            Ok(found) if found.is_dir() => {}
            Err(source) if source.kind() == ErrorKind::PermissionDenied => return Err(file.error(source)),
            _ => return Err(OutputError::NoFolder(file.path, folder)),
        }
        if file.path.file_name().is_none() || file.path.is_dir() {
            return Err(OutputError::NotAFile(file.path));
        }
        if fs::metadata(&file.path).is_ok_and(|old| old.permissions().readonly()) {
            return Err(OutputError::ReadOnly(file.path));
        }
        file.temporary()?;
        Ok(file)
    }

    /// The file's name.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Whether `other` is the same file.
    pub fn is_same(&self, other: &Path) -> bool {
        identity(&self.path) == identity(other)
    }

    /// Writes the file with `write`. On failure an existing file is unchanged.
    pub fn save(
        &self,
        write: impl FnOnce(&mut BufWriter<&mut File>) -> Result<(), OutputError>,
    ) -> Result<(), OutputError> {
        let mut temporary = self.temporary()?;
        let mut writer = BufWriter::new(&mut temporary.file);
        write(&mut writer)?;
        writer.flush().map_err(|source| self.error(source))?;
        drop(writer);
        temporary.finish().map_err(|source| self.error(source))
    }

    /// Starts a file that is written incrementally. An existing file is unchanged until [`Growing::finish`].
    pub fn grow(self) -> Result<Growing, OutputError> {
        let temporary = self.temporary()?;
        let writer = BufWriter::new(temporary.file.try_clone().map_err(|source| self.error(source))?);
        Ok(Growing { writer, temporary, file: self })
    }

    /// Writes a text.
    pub fn save_text(&self, text: &str) -> Result<(), OutputError> {
        self.save(|writer| writer.write_all(text.as_bytes()).map_err(|source| self.error(source)))
    }

    /// Writes `value` as JSON.
    pub fn save_json(&self, value: &impl serde::Serialize) -> Result<(), OutputError> {
        let text = serde_json::to_string_pretty(value).map_err(|error| self.error(error.into()))?;
        self.save_text(&(text + "\n"))
    }

    pub(super) fn error(&self, source: io::Error) -> OutputError {
        OutputError::Write { path: self.path.clone(), source }
    }

    fn temporary(&self) -> Result<Temporary, OutputError> {
        let target = self.final_path();
        Temporary::of(&target, &folder_of(&target)).map_err(|source| self.error(source))
    }

    /// The target of symbolic links, so that it is replaced, not the link.
    fn final_path(&self) -> PathBuf {
        target_of(&self.path)
    }
}

/// A file that is written incrementally.
#[derive(Debug)]
pub struct Growing {
    writer: BufWriter<File>,
    temporary: Temporary,
    file: OutputFile,
}

impl Growing {
    /// Appends to the file.
    pub fn write(&mut self, bytes: &[u8]) -> Result<(), OutputError> {
        self.writer.write_all(bytes).map_err(|source| self.file.error(source))
    }

    /// Moves the temporary file to its place.
    pub fn finish(mut self) -> Result<(), OutputError> {
        let written = self.writer.flush().and_then(|()| self.temporary.finish());
        written.map_err(|source| self.file.error(source))
    }
}

/// The canonical path of a file that may not exist yet.
fn identity(path: &Path) -> PathBuf {
    let path = target_of(path);
    let folder = folder_of(&path);
    fs::canonicalize(&folder).unwrap_or(folder).join(path.file_name().unwrap_or_default())
}

/// Where symbolic links lead, also to what does not exist yet.
fn target_of(path: &Path) -> PathBuf {
    let mut path = path.to_owned();
    // As many as the system follows.
    for _ in 0..40 {
        let Ok(target) = fs::read_link(&path) else { break };
        path = folder_of(&path).join(target);
    }
    path
}

pub(super) fn folder_of(path: &Path) -> PathBuf {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder.to_path_buf(),
        _ => PathBuf::from("."),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<_> = fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn a_failed_run_loses_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        fs::write(&path, "old").unwrap();
        let file = OutputFile::new(&path).unwrap();
        let result = file.save(|writer| {
            writer.write_all(&[0; 100_000]).map_err(|source| file.error(source))?;
            Err(file.error(io::Error::from_raw_os_error(28)))
        });
        let message = result.unwrap_err().to_string();
        assert!(message.contains("a.png") && message.contains("No space left"), "{message}");
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(names(folder.path()), ["a.png"]);
    }

    #[test]
    fn a_good_run_replaces_the_file_and_leaves_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.json");
        fs::write(&path, "old").unwrap();
        OutputFile::new(&path).unwrap().save_json(&[1, 2]).unwrap();
        assert_eq!(serde_json::from_slice::<Vec<i32>>(&fs::read(&path).unwrap()).unwrap(), [1, 2]);
        assert_eq!(names(folder.path()), ["a.json"]);
    }

    #[cfg(unix)]
    #[test]
    fn links_and_permissions_are_as_for_any_other_file() {
        use std::os::unix::fs::{PermissionsExt, symlink};
        let folder = tempfile::tempdir().unwrap();
        let (real, link) = (folder.path().join("real.json"), folder.path().join("link.json"));
        let plain = folder.path().join("plain");
        File::create(&real).unwrap();
        File::create(&plain).unwrap();
        symlink(&real, &link).unwrap();
        OutputFile::new(&link).unwrap().save_json(&7).unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read_to_string(&real).unwrap(), "7\n");
        let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode();
        assert_eq!(mode(&real), mode(&plain));
        // Links to what is not there yet, relative to their folder, one after the other.
        let (first, second) = (folder.path().join("first.json"), folder.path().join("second.json"));
        symlink("second.json", &first).unwrap();
        symlink("new.json", &second).unwrap();
        OutputFile::new(&first).unwrap().save_json(&8).unwrap();
        assert!([first, second].iter().all(|link| fs::symlink_metadata(link).unwrap().is_symlink()));
        assert_eq!(fs::read_to_string(folder.path().join("new.json")).unwrap(), "8\n");
        assert_eq!(
            names(folder.path()),
            ["first.json", "link.json", "new.json", "plain", "real.json", "second.json"]
        );
    }

    #[cfg(unix)]
    #[test]
    fn modes_and_hard_links_stay_and_read_only_files_too() {
        use std::os::unix::fs::{FileTypeExt, MetadataExt, PermissionsExt};
        let folder = tempfile::tempdir().unwrap();
        let (path, link) = (folder.path().join("a.json"), folder.path().join("b.json"));
        let set_mode = |mode| fs::set_permissions(&path, fs::Permissions::from_mode(mode)).unwrap();
        fs::write(&path, "a longer old text").unwrap();
        set_mode(0o606);
        OutputFile::new(&path).unwrap().save_json(&7).unwrap();
        assert_eq!(fs::metadata(&path).unwrap().mode() & 0o777, 0o606);
        fs::hard_link(&path, &link).unwrap();
        OutputFile::new(&link).unwrap().save_json(&8).unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "8\n");
        assert_eq!(fs::metadata(&path).unwrap().nlink(), 2);
        set_mode(0o444);
        let error = OutputFile::new(&path).unwrap_err().to_string();
        assert!(error.ends_with("a.json: is read-only; make it writable, or give another name"), "{error}");
        OutputFile::new("/dev/null").unwrap().save_json(&9).unwrap();
        assert!(fs::metadata("/dev/null").unwrap().file_type().is_char_device());
        assert_eq!(names(folder.path()), ["a.json", "b.json"]);
    }

    #[test]
    fn the_longest_names_are_names_too() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a".repeat(255));
        OutputFile::new(&path).unwrap().save_json(&7).unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "7\n");
        assert!(OutputFile::new(folder.path().join("a".repeat(256))).is_err());
    }

    #[test]
    fn what_cannot_be_written_is_found_beforehand() {
        let folder = tempfile::tempdir().unwrap();
        let a_file = folder.path().join("file");
        File::create(&a_file).unwrap();
        for path in [
            folder.path().join("missing/a.png"),
            a_file.join("a.png"),
            folder.path().to_path_buf(),
            PathBuf::from("/proc/a.png"),
            PathBuf::from("/"),
            PathBuf::new(),
        ] {
            let error = OutputFile::new(&path).unwrap_err().to_string();
            assert!(!error.contains('\n') && error.starts_with(path.to_str().unwrap()), "{error}");
        }
        assert_eq!(names(folder.path()), ["file"]);
    }
}
