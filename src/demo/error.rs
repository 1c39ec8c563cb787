//! Errors of the window.

use std::path::PathBuf;

use crate::formats::SceneError;
use crate::output::OutputError;
use crate::renderer::RenderError;
use crate::settings::SettingsError;
use crate::vulkan::VulkanError;

/// Errors of the window.
#[derive(Debug, thiserror::Error)]
pub enum DemoError {
    /// There is no display.
    #[error("no display to open a window on ({0})")]
    NoDisplay(String),
    /// The window could not be opened or was lost.
    #[error("the window: {0}")]
    Window(String),
    /// Vulkan failed.
    #[error(transparent)]
    Vulkan(#[from] VulkanError),
    /// The scene cannot be rendered.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// The scene cannot be loaded.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The scene's settings cannot be used.
    #[error("{error}")]
    Settings {
        /// The scene.
        scene: String,
        /// The invalid setting.
        error: SettingsError,
    },
    /// The log cannot be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// The thread that loads scenes has failed.
    #[error("loading: {0}")]
    Loading(String),
    /// The device was lost for good; unsaved edits are in a file.
    #[error("{error}; the scene with its unsaved edits is in {}", file.display())]
    Lost {
        /// Why there is no device.
        error: Box<DemoError>,
        /// The scene file.
        file: PathBuf,
    },
}

impl DemoError {
    /// Whether the device is lost and must be recreated.
    pub(super) fn is_device_lost(&self) -> bool {
        match self {
            Self::Vulkan(error) | Self::Render(RenderError::Vulkan(error)) => error.is_device_lost(),
            _ => false,
        }
    }
}
