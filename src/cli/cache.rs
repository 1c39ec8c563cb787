//! The user's cache folder.

use std::env::var_os;
use std::path::PathBuf;

/// `glowworm` in the user's cache folder: `XDG_CACHE_HOME`, or else `.cache` in the home folder; none where there is
/// neither.
pub(super) fn folder() -> Option<PathBuf> {
    let folder = |variable| var_os(variable).map(PathBuf::from).filter(|folder| folder.is_absolute());
    let caches = folder("XDG_CACHE_HOME").or_else(|| Some(folder("HOME")?.join(".cache")));
    caches.map(|caches| caches.join("glowworm"))
}
