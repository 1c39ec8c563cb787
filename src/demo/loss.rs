//! Another device while the window is open, because the last one was lost or another is chosen; the scene and its edits stay.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use serde_json::json;

use super::action::AppAction;
use super::app::{App, OpenWindow};
use super::error::DemoError;
use super::gpu::Gpu;
use super::saving::{Saving, free_name};

/// Time within which a device that is lost again is given up.
const RELAPSE: Duration = Duration::from_secs(60);

impl App {
    /// Goes on with a new device after one was lost, or ends where that one is lost, too. Either way unsaved edits are in a file.
    pub(super) fn recover(&mut self, error: DemoError) -> Result<(), DemoError> {
        self.log.event("device-lost", error.to_string());
        let last = self.lost.take().filter(|(at, _)| at.elapsed() < RELAPSE);
        let again = last.is_some();
        let written = self.open.as_ref().and_then(write_edits);
        let file = written.or_else(|| last.and_then(|(_, file)| file));
        self.lost = Some((Instant::now(), file.clone()));
        let gone_on = if again { Err(error) } else { self.restart_device(None) };
        match (gone_on, file) {
            (Err(error), Some(file)) => Err(DemoError::Lost { error: error.into(), file }),
            (Ok(()), file) => {
                if let Some(open) = &mut self.open {
                    let edits = file.map(|file| format!("; unsaved edits are also in {}", file.display()));
                    open.view.interface.message =
                        format!("the device was lost and is open again{}", edits.unwrap_or_default());
                }
                Ok(())
            }
            (gone_on, None) => gone_on,
        }
    }

    /// Closes the device and opens another or the same one, with the same scene.
    pub(super) fn restart_device(&mut self, index: Option<usize>) -> Result<(), DemoError> {
        let Some(open) = &mut self.open else { return Ok(()) };
        open.loader.stop();
        (open.view.split, open.comparison) = (None, None);
        open.screen.panel.forget_textures();
        let session = open.view.session.take();
        let requested = index.map(|index| index.to_string()).or_else(|| self.launch.device.clone());
        let mode = open.gpu.presenter.mode();
        open.gpu.presenter.close();
        open.gpu = Gpu::open_on(&open.gpu.instance, &open.screen.window, requested.as_deref(), mode)?;
        let info = open.gpu.device.info();
        self.log.event("device", json!({ "name": info.name, "index": info.index }));
        if let Some(session) = session {
            let edited = session.to_build(true);
            open.request_scene(session.name.clone(), Some(edited));
            open.state = Some(session.into_state());
        } else {
            open.actions.push(AppAction::Open(self.launch.scene.clone()));
        }
        // Last: until its first frame a new one knows no viewport, thus no size of the picture.
        open.screen.recreate_context();
        Ok(())
    }
}

/// Writes the scene with its unsaved edits to a new file in the current folder; none where there are none, or that fails.
fn write_edits(open: &OpenWindow) -> Option<PathBuf> {
    let session = open.view.session.as_ref().filter(|session| session.is_edited())?;
    let stem = format!("glowworm-{}-unsaved", session.live_scene.name.replace(['/', '\\'], "-"));
    let written = free_name(&stem, ".toml").and_then(|path| {
        let text = session.document_to_save(Some(&session.pose.camera)).text_to_save(&path);
        Saving::text(path, text).finish()
    });
    written.inspect_err(|error| log::warn!("{error}")).ok()
}
