//! The arguments that the window starts with.

use std::path::PathBuf;

use crate::settings::GivenSettings;

/// The window starts with these.
#[derive(Clone, Debug)]
pub struct Launch {
    /// The scene, by name or file.
    pub scene: String,
    /// The settings that the command line gives.
    pub given: GivenSettings,
    /// Folder of the downloaded models.
    pub assets: Option<PathBuf>,
    /// File of the log.
    pub json: Option<PathBuf>,
    /// Device by name or index.
    pub device: Option<String>,
    /// Whether to enable the validation layer.
    pub validate: bool,
    /// Folder for files that outlive the program.
    pub cache: Option<PathBuf>,
    /// Whether to begin with the tour.
    pub tour: bool,
    /// File for the tour's contact sheet; the program ends with the tour then.
    pub contact_sheet: Option<PathBuf>,
}

/// The file, empty, that tells that the first lines were read.
const WELCOMED: &str = "welcomed";

impl Launch {
    /// Whether nobody has dismissed the first lines yet. Without a folder to note that in, they are not shown at all.
    pub(super) fn is_first_start(&self) -> bool {
        self.cache.as_ref().is_some_and(|cache| !cache.join(WELCOMED).exists())
    }

    /// Notes that the first lines were dismissed; where that fails, they are shown again.
    pub(super) fn note_welcomed(&self) {
        if let Some(cache) = &self.cache {
            let noted =
                std::fs::create_dir_all(cache).and_then(|()| std::fs::write(cache.join(WELCOMED), ""));
            noted.unwrap_or_else(|error| log::warn!("{}: {error}", cache.display()));
        }
    }
}
