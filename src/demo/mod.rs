//! The interactive window: navigate, edit and inspect a scene.
//!
//! In: a scene and settings, as for `render`. Out: a window, and a log of its events. The picture is the one that
//! `render` draws.

mod action;
mod app;
mod clock;
mod command;
mod compare;
mod edit;
mod file_picture;
mod flight;
mod frame;
mod gpu;
mod handles;
mod history;
mod inspector;
mod keys;
mod live_metrics;
mod live_reference;
mod loader;
mod log;
mod loss;
mod mouse;
mod panel;
mod perform;
mod pointer;
mod preparation;
mod recorder;
mod resolution;
mod screenshot;
mod session;
mod split;
mod tour;
mod transform;
mod undo;
mod viewport;
mod views;

use std::path::PathBuf;

use winit::error::EventLoopError;
use winit::event_loop::EventLoop;

use crate::formats::SceneError;
use crate::output::OutputError;
use crate::renderer::RenderError;
use crate::settings::{GivenSettings, SettingsError};
use crate::vulkan::VulkanError;

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
    /// Folder of what is kept between starts.
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
    fn is_first_start(&self) -> bool {
        self.cache.as_ref().is_some_and(|cache| !cache.join(WELCOMED).exists())
    }

    /// Notes that the first lines were dismissed; where that fails, they are shown again.
    fn note_welcomed(&self) {
        if let Some(cache) = &self.cache {
            let noted =
                std::fs::create_dir_all(cache).and_then(|()| std::fs::write(cache.join(WELCOMED), ""));
            noted.unwrap_or_else(|error| ::log::warn!("{}: {error}", cache.display()));
        }
    }
}

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
        /// What is wrong.
        error: SettingsError,
    },
    /// The log cannot be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// The thread that loads scenes has failed.
    #[error("loading: {0}")]
    Loading(String),
    /// The device was lost for good; unsaved edits were kept.
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
    fn is_device_lost(&self) -> bool {
        match self {
            Self::Vulkan(error) | Self::Render(RenderError::Vulkan(error)) => error.is_device_lost(),
            _ => false,
        }
    }
}

/// Shows the window until it is closed. Returns the validation messages.
///
/// # Errors
/// [`DemoError::NoDisplay`] before any side effect; any other after the window was opened.
pub fn run(launch: Launch) -> Result<Vec<String>, DemoError> {
    let events = EventLoop::new().map_err(|error| match error {
        EventLoopError::NotSupported(_) | EventLoopError::Os(_) => DemoError::NoDisplay(reason(&error)),
        other => DemoError::Window(other.to_string()),
    })?;
    let mut app = app::App::new(launch)?;
    events.run_app(&mut app).map_err(|error| DemoError::Window(error.to_string()))?;
    app.finish()
}

/// The message without the source location in winit.
fn reason(error: &EventLoopError) -> String {
    if std::env::var_os("DISPLAY").is_none() && std::env::var_os("WAYLAND_DISPLAY").is_none() {
        return "neither DISPLAY nor WAYLAND_DISPLAY is set".to_owned();
    }
    let text = error.to_string();
    text.rsplit(": ").next().unwrap_or(&text).to_owned()
}
