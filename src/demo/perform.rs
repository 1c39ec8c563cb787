//! Executes actions between frames.

use std::path::PathBuf;

use super::action::{Action, AppAction, EditAction, RequestedSettings};
use super::app::{App, OpenWindow};
use super::command::command;
use super::compare::Comparison;
use super::error::DemoError;
use super::launch::Launch;
#[cfg(feature = "shader-reload")]
use super::loader::Edited;
use super::panel::Purpose;
use super::recorder::Recording;
use super::saving::{self, SavedScene, Saving, free_name};
use super::session::{Change, Saved};
use super::tour::{Before, Tour};
use crate::settings::Settings;

impl App {
    /// Executes the actions in their order. One that must be announced waits with all after it.
    pub(super) fn perform_all(&mut self) -> Result<(), DemoError> {
        let actions = self.open.as_mut().map(|open| std::mem::take(&mut open.actions)).unwrap_or_default();
        for action in actions.0 {
            let Some(OpenWindow { view, actions, .. }) = &mut self.open else { return Ok(()) };
            if view.interface.must_wait(&action, view.session.as_ref(), view.split.as_ref()) {
                actions.push(action);
            } else {
                self.perform(action)?;
            }
        }
        Ok(())
    }

    /// Executes an action. Errors are shown, but for the loss of the device.
    fn perform(&mut self, action: Action) -> Result<(), DemoError> {
        self.log.event("action", &action);
        let Some(open) = &mut self.open else { return Ok(()) };
        let press = open.input.press;
        let performed = match action {
            Action::App(action) => return self.perform_app(action),
            Action::View(action) => open.view.perform(action, press, &open.gpu.device),
            Action::Edit(EditAction::Select(None)) if open.end_something()? => Ok(()),
            Action::Edit(action) => open.view.edit(action, press).map(|change| open.take(change)),
        };
        match performed {
            Err(error) if !error.is_device_lost() => open.view.interface.error = Some(error.to_string()),
            other => return other,
        }
        Ok(())
    }

    fn perform_app(&mut self, action: AppAction) -> Result<(), DemoError> {
        let Self { open: Some(open), launch, log, .. } = self else { return Ok(()) };
        let interface = &mut open.view.interface;
        let files = &mut open.screen.panel.files;
        let session = open.view.session.as_ref();
        match action {
            AppAction::ToggleHelp => interface.help = !interface.help,
            AppAction::DismissWelcome => {
                interface.welcome = false;
                launch.note_welcomed();
            }
            AppAction::DismissError => interface.error = None,
            AppAction::TogglePanel => interface.hidden = !interface.hidden,
            AppAction::ToggleOverlays => interface.bare = !interface.bare,
            // It has taken effect with the event.
            AppAction::ToggleKeyboard => {}
            AppAction::ToggleTour => return open.toggle_tour(launch),
            AppAction::ToggleFullscreen => {
                let is_full = open.screen.window.fullscreen().is_some();
                let full = (!is_full).then_some(winit::window::Fullscreen::Borderless(None));
                open.screen.window.set_fullscreen(full);
            }
            AppAction::ToggleCompare => match (session, &open.comparison) {
                (Some(session), None) => match open.screen.panel.compare.requested(&session.settings) {
                    Ok(requested) => open.compare(requested, launch),
                    Err(error) => interface.error = Some(error),
                },
                _ => open.comparison = None,
            },
            AppAction::Compare(None) => open.comparison = None,
            AppAction::Compare(Some(requested)) => open.compare(requested, launch),
            AppAction::SaveComparison => {
                if let (Some(comparison), Some(session)) = (&open.comparison, session) {
                    open.saving.extend(comparison.save(&session.live_scene.name));
                }
            }
            AppAction::SetPresentMode(mode) => open.gpu.presenter.set_mode(mode),
            AppAction::RestartDevice(index) => return self.restart_device(index),
            AppAction::Open(name) => open.load(name.clone(), AppAction::Open(name)),
            AppAction::Reload => {
                if let Some(name) = session.map(|session| session.name.clone()) {
                    open.load(name, AppAction::Reload);
                }
            }
            #[cfg(feature = "shader-reload")]
            AppAction::ReloadShaders => {
                if let Some(session) = session {
                    let edited = Edited { compiles_shaders: true, ..session.to_build(true) };
                    open.request_scene(session.name.clone(), Some(edited));
                }
            }
            AppAction::Save(path) => open.save(path),
            AppAction::AskOpen => files.ask_for(Purpose::Open, ""),
            AppAction::AskSave => {
                let name = session.map_or("scene", |session| session.live_scene.name.as_str());
                files.ask_for(Purpose::Save, name);
            }
            AppAction::AskMap => files.ask_for(Purpose::Map, ""),
            AppAction::AskPicture => files.ask_for(Purpose::Picture, ""),
            AppAction::AskModel => files.ask_for(Purpose::Model, ""),
            AppAction::Screenshot { exr } => {
                if let Some(session) = session {
                    open.saving.push(saving::take(session, exr)?);
                }
            }
            AppAction::ToggleRecording => open.toggle_recording(),
            AppAction::CopyCommand => {
                if let Some((command, scene)) = command(&open.view) {
                    open.actions.extend(scene.map(AppAction::Save));
                    log.event("command", &command);
                    open.view.interface.message = format!("copied: {command}");
                    open.screen.egui.set_clipboard_text(command);
                }
            }
            AppAction::KeepScene => interface.pending = None,
            AppAction::Quit => open.closing |= open.confirm_discard(AppAction::Quit),
        }
        Ok(())
    }
}

impl OpenWindow {
    /// Ends the tour, or else a measurement, or else dismisses the error; false where there is none, so that Escape selects nothing.
    fn end_something(&mut self) -> Result<bool, DemoError> {
        if self.tour.is_some() {
            self.end_tour()?;
        } else if self.is_measuring() {
            self.comparison = None;
        } else {
            return Ok(self.view.interface.error.take().is_some());
        }
        Ok(true)
    }

    /// Rebuilds the renderer if an edit needs it.
    pub(super) fn take(&mut self, change: Change) {
        if change == Change::Rebuild {
            self.rebuild();
        }
    }

    /// Whether an action may end the scene: there are no unsaved edits, or the user discards them by the same action again.
    /// Otherwise the panel asks.
    fn confirm_discard(&mut self, action: AppAction) -> bool {
        let asked = self.view.interface.pending.take();
        let may = !self.is_edited() || asked.as_ref() == Some(&action);
        if !may {
            self.view.interface.pending = Some(action);
        }
        may
    }

    /// Loads a scene in place of the current one, if that may end.
    fn load(&mut self, name: String, action: AppAction) {
        if self.confirm_discard(action) {
            self.view.interface.error = None;
            self.request_scene(name, None);
        }
    }

    /// Saves the current scene with the current camera.
    fn save(&mut self, path: PathBuf) {
        let Some(session) = &self.view.session else { return };
        let camera = self.view.flight.moved.map(|_| &session.pose.camera);
        let text = session.document_to_save(camera).text_to_save(&path);
        let saved = Saved { path: path.clone(), camera: session.pose.camera };
        let scene = SavedScene { name: session.name.clone(), edits: session.edits, saved };
        self.saving.push(Saving { scene: Some(scene), ..Saving::text(path, text) });
    }

    /// Starts a recording with a new renderer, since the picture depends on its history; or saves the current
    /// recording.
    fn toggle_recording(&mut self) {
        match std::mem::take(&mut self.view.recording) {
            Recording::Off => {
                self.view.recording = Recording::Waiting;
                self.rebuild();
            }
            Recording::Waiting => {}
            Recording::On(recorder) => {
                let session = self.view.session.as_ref();
                let name = session.map_or("scene", |session| session.live_scene.name.as_str());
                match free_name(&format!("glowworm-{name}-recording"), ".toml") {
                    Ok(path) => self.saving.push(recorder.save(path)),
                    Err(error) => self.view.interface.error = Some(error),
                }
            }
        }
    }

    /// Measures these settings on the scene on screen.
    fn compare(&mut self, requested: RequestedSettings, launch: &Launch) {
        self.comparison = None;
        let Some(session) = &self.view.session else { return };
        let camera = self.view.flight.moved.map(|_| &session.pose.camera);
        let document = session.document_to_save(camera);
        let (device, assets) = (&self.gpu.device, launch.assets.clone());
        self.comparison = Some(Comparison::start(device, session, document, assets, requested));
    }

    /// Begins the tour, with a contact sheet at its end if that has a file; or ends it.
    fn toggle_tour(&mut self, launch: &Launch) -> Result<(), DemoError> {
        if self.tour.is_some() {
            return self.end_tour();
        }
        let Some(session) = &mut self.view.session else { return Ok(()) };
        let before = Before {
            settings: session.settings.clone(),
            view: session.renderer.view().clone(),
            camera: self.view.flight.moved,
            paused: self.view.clock.paused,
            automatic: self.view.size.resolution.automatic,
            undo: std::mem::take(&mut session.undo),
        };
        self.tour = Some(Tour::new(before, launch.contact_sheet.clone()));
        self.view.split = None;
        self.view.interface.hidden = true;
        Ok(())
    }

    /// Ends the tour where it is; everything goes back to how it was.
    fn end_tour(&mut self) -> Result<(), DemoError> {
        let (Some(tour), Some(session)) = (self.tour.take(), &mut self.view.session) else { return Ok(()) };
        let (before, closes) = tour.end()?;
        self.closing |= closes;
        session.undo = before.undo;
        let settings = Settings { size: session.settings.size, ..before.settings };
        let view = &mut self.view;
        view.interface.hidden = false;
        (view.clock.paused, view.size.resolution.automatic) = (before.paused, before.automatic);
        (view.split, self.comparison) = (None, None);
        view.flight.moved = before.camera;
        view.show(&before.view)?;
        view.set(&settings, None)
    }

    /// Goes on with the tour; returns the caption of a stop that begins.
    pub(super) fn follow_tour(&mut self, launch: &Launch) -> Result<Option<&'static str>, DemoError> {
        if self.view.session.is_some() && std::mem::take(&mut self.tour_waits) {
            self.toggle_tour(launch)?;
        }
        if self.view.interface.has_waiting() {
            return Ok(None);
        }
        let own = self.view.scene_camera();
        let (Some(session), Some(tour), Some(own)) = (&self.view.session, &mut self.tour, own) else {
            return Ok(None);
        };
        let seconds = self.view.clock.interval_ms() * 1e-3;
        let Some(frame) = tour.advance(seconds, &own, session, self.view.split.as_ref())? else {
            self.end_tour()?;
            return Ok(None);
        };
        let caption = frame.begins.then(|| tour.caption());
        self.view.flight.moved = Some(frame.camera);
        self.actions.extend(frame.actions.0);
        Ok(caption)
    }
}
