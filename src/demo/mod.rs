//! The interactive window: navigate, edit and inspect a scene.
//!
//! In: a scene and settings, as for `render`. Out: a window, and a log of its events. The picture is the one that
//! `render` draws. Events go to `input` or the panel, which answer with actions; each frame performs them: `perform` those of the
//! window, `view` those of what is shown, `edit` those of the document.

mod action;
mod app;
mod bindings;
mod clock;
mod command;
mod compare;
mod edit;
mod error;
mod event_loop;
mod file_picture;
mod flight;
mod frame;
mod gpu;
mod handles;
mod history;
mod input;
mod inspector;
mod interface;
mod keys;
mod launch;
mod live_metrics;
mod live_reference;
mod loader;
mod log;
mod loss;
mod panel;
mod perform;
mod picture_size;
mod recorder;
mod resolution;
mod saving;
mod screen;
mod selection;
mod session;
mod split;
mod tour;
mod transform;
mod undo;
mod view;

use winit::error::EventLoopError;
use winit::event_loop::EventLoop;

pub use error::DemoError;
pub use launch::Launch;

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
