//! Options that subcommands share, apart from the settings.

use std::path::PathBuf;

/// Which device does the work.
#[derive(Clone, Debug, Default, clap::Args)]
#[command(next_help_heading = "Device")]
pub(super) struct DeviceOptions {
    /// Vulkan device: its index in `glowworm info` or a part of its name. Otherwise the best one.
    #[arg(long, value_name = "NAME|INDEX")]
    pub device: Option<String>,
    /// Switch the Vulkan validation layer on; slow, and any message of it makes the run fail.
    #[arg(long)]
    pub validate: bool,
}

/// What every run over a scene on a device takes.
#[derive(Clone, Debug, Default, clap::Args)]
pub(super) struct RunOptions {
    #[command(flatten)]
    pub device: DeviceOptions,
    #[command(flatten)]
    pub files: FileOptions,
}

/// What every command over a scene reads and writes.
#[derive(Clone, Debug, Default, clap::Args)]
pub(super) struct FileOptions {
    /// Folder with the downloaded models of scenes whose models are not shipped. Otherwise the
    /// environment variable `GLOWWORM_ASSETS`.
    #[arg(long, value_name = "DIR", help_heading = "Files")]
    assets: Option<PathBuf>,
    /// Write what was measured to FILE.
    #[arg(long, value_name = "FILE", help_heading = "Files")]
    pub json: Option<PathBuf>,
}

impl FileOptions {
    /// `--assets`, or else `GLOWWORM_ASSETS`, or none.
    pub fn assets_folder(&self) -> Option<PathBuf> {
        let from_environment =
            || std::env::var_os("GLOWWORM_ASSETS").filter(|folder| !folder.is_empty()).map(PathBuf::from);
        self.assets.clone().or_else(from_environment)
    }
}
