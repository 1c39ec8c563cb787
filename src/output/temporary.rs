//! Temporary files beside their targets: each becomes its target whole, or goes.
//!
//! In: a target, which may exist. Out: a file to write, which then takes its place. A target of one name and of this user is
//! replaced by renaming and keeps its mode; any other one, such as a hard link, is written through.

use std::fs::{self, File, Metadata, OpenOptions};
use std::io::{self, ErrorKind, Seek, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Those that are there now.
static PRESENT: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

fn present() -> MutexGuard<'static, Vec<PathBuf>> {
    PRESENT.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Ends the program with this exit code. Files that are being written are not left behind.
pub fn exit(code: i32) -> ! {
    // Held until the end, so that no thread makes another one.
    let present = present();
    for path in present.iter() {
        let _ = fs::remove_file(path);
    }
    std::process::exit(code)
}

/// A temporary file, removed when dropped.
#[derive(Debug)]
pub(super) struct Temporary {
    pub file: File,
    path: PathBuf,
    target: PathBuf,
    /// Whether the target is written through instead of replaced.
    in_place: bool,
}

impl Temporary {
    /// Makes one for `target`, in its `folder`.
    pub fn of(target: &Path, folder: &Path) -> io::Result<Self> {
        let old = match fs::metadata(target) {
            Ok(old) => Some(old),
            Err(error) if error.kind() == ErrorKind::NotFound => None,
            Err(error) => return Err(error),
        };
        let is_regular = old.as_ref().is_none_or(Metadata::is_file);
        if old.is_some() && is_regular {
            // Fails if it may not be written to, and changes nothing.
            OpenOptions::new().write(true).open(target)?;
        }
        let mut builder = tempfile::Builder::new();
        // A name of its own length, as that of the target may be the longest there is.
        builder.prefix(".glowworm-").suffix(".tmp");
        // Temporary files are readable by their owner only; use the default mode instead, to which the umask applies.
        #[cfg(unix)]
        let permissions = std::os::unix::fs::PermissionsExt::from_mode(0o666);
        #[cfg(unix)]
        builder.permissions(permissions);
        let mut present = present();
        let made = if is_regular { builder.tempfile_in(folder)? } else { builder.tempfile()? };
        let (file, path) = made.keep().map_err(|error| error.error)?;
        present.push(path.clone());
        drop(present);
        let mut temporary = Self { file, path, target: target.to_owned(), in_place: false };
        if let Some(old) = old {
            temporary.in_place = !is_replaceable(&old, &temporary.file.metadata()?);
            if !temporary.in_place {
                temporary.file.set_permissions(old.permissions())?;
            }
        }
        Ok(temporary)
    }

    /// Puts it in the place of its target.
    pub fn finish(mut self) -> io::Result<()> {
        // Some file systems report a full disk only on sync.
        self.file.sync_all()?;
        if !self.in_place {
            let _present = present();
            return fs::rename(&self.path, &self.target);
        }
        let mut target = OpenOptions::new().write(true).truncate(true).open(&self.target)?;
        self.file.rewind()?;
        io::copy(&mut self.file, &mut target)?;
        target.flush()?;
        if target.metadata()?.is_file() { target.sync_all() } else { Ok(()) }
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        let mut present = present();
        // Fails if it has become its target.
        let _ = fs::remove_file(&self.path);
        present.retain(|path| *path != self.path);
    }
}

/// Whether a new file may stand in for the old one: that has no other name and the same owner.
#[cfg(unix)]
fn is_replaceable(old: &Metadata, new: &Metadata) -> bool {
    use std::os::unix::fs::MetadataExt;
    old.is_file() && old.nlink() == 1 && (old.uid(), old.gid()) == (new.uid(), new.gid())
}

#[cfg(not(unix))]
fn is_replaceable(old: &Metadata, _: &Metadata) -> bool {
    old.is_file()
}
