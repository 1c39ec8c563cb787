//! Executes actions between frames.

use std::path::PathBuf;

use super::DemoError;
use super::action::Action;
use super::app::{App, Open, slow_click_context};
use super::edit::{Entry, free_name, free_place, new_light};
use super::loader::{Edited, LoadRequest};
use super::panel::Purpose;
use super::recorder::Recording;
use super::screenshot::{self, SavedScene, Saving};
use super::session::{Change, Saved, Selected, Session, carry};
use super::transform::{moved_instance, moved_light};
use super::undo::State;
use crate::formats::{InstanceEntry, LightEntry, SceneError};
use crate::output::automatic_exposure;
use crate::settings::Settings;

impl App {
    /// Executes an action. Invalid input is reported in the panel; an error ends the program.
    pub(super) fn perform(&mut self, action: Action) -> Result<(), DemoError> {
        self.log.event("action", &action);
        let Some(open) = &mut self.open else { return Ok(()) };
        let own = open.session.as_ref().map(|session| session.live_scene.pose(open.clock.time).camera);
        match action {
            Action::ToggleHelp => open.panel.help = !open.panel.help,
            Action::DismissWelcome => {
                open.panel.welcome = false;
                self.launch.note_welcomed();
            }
            Action::TogglePanel => open.panel.hidden = !open.panel.hidden,
            Action::ToggleOverlays => open.panel.bare = !open.panel.bare,
            // It takes effect with the event, so that the next key goes where it belongs.
            Action::ToggleKeyboard => {}
            Action::TogglePause => open.clock.paused = !open.clock.paused,
            Action::Pause(paused) => open.clock.paused = paused,
            Action::ToggleTour => return open.toggle_tour(self.launch.contact_sheet.clone()),
            Action::Select(None) if open.tour.is_some() => return open.end_tour(),
            Action::Select(None) if open.is_measuring() => open.comparison = None,
            Action::Select(None) if open.panel.error.is_some() => open.panel.error = None,
            Action::Scrub(time) => open.clock.time = time.max(0.0),
            Action::Home => open.flight.home(),
            Action::StoreBookmark(number) => {
                if let Some(own) = own {
                    open.flight.store(number, open.flight.camera(&own));
                    open.panel.message = format!("camera stored as bookmark {}", number + 1);
                }
            }
            Action::GoToBookmark(number) => {
                if let Some(camera) = open.flight.bookmark(number) {
                    open.flight.go_to(camera);
                }
            }
            Action::ToggleFullscreen => {
                let full = open.window.fullscreen().is_some();
                let wanted = (!full).then_some(winit::window::Fullscreen::Borderless(None));
                open.window.set_fullscreen(wanted);
            }
            Action::ToggleCompare => open.toggle_compare(self.launch.assets.clone()),
            Action::Compare(wanted) => open.compare(wanted, self.launch.assets.clone()),
            Action::SaveComparison => open.save_comparison(),
            Action::SetPresentMode(mode) => open.gpu.presenter.set_mode(mode),
            Action::RestartDevice(index) => return self.restart_device(index),
            Action::Open(name) => {
                if open.confirm_discard(Action::Open(name.clone())) {
                    open.panel.error = None;
                    open.request_scene(name, None);
                }
            }
            Action::Reload => {
                if let Some(name) = open.session.as_ref().map(|session| session.name.clone())
                    && open.confirm_discard(Action::Reload)
                {
                    open.request_scene(name, None);
                }
            }
            Action::SetCoarseness(pixels) => open.set_coarseness(pixels),
            Action::Set(settings) => open.set_and_remember(&settings)?,
            Action::Undo => open.step_back()?,
            Action::Redo => open.step_forward()?,
            Action::Screenshot { exr } => {
                if let Some(session) = &open.session {
                    open.saving.push(screenshot::take(session, exr)?);
                }
            }
            Action::ToggleRecording => open.toggle_recording(),
            Action::CopyCommand => {
                if let Some(command) = open.command() {
                    self.log.event("command", &command);
                    open.panel.message = format!("copied: {command}");
                    open.egui.set_clipboard_text(command);
                }
            }
            Action::Quit => open.closing |= open.confirm_discard(Action::Quit),
            other => open.change(other)?,
        }
        Ok(())
    }
}

impl Open {
    /// Whether the scene has unsaved edits.
    pub(super) fn is_edited(&self) -> bool {
        self.session.as_ref().is_some_and(Session::is_edited)
    }

    /// Whether an action may end the scene: there are no unsaved edits, or the user discards them by the same action again.
    /// Otherwise the panel asks.
    fn confirm_discard(&mut self, action: Action) -> bool {
        let asked = self.panel.pending.take();
        let may = !self.is_edited() || asked.as_ref() == Some(&action);
        if !may {
            self.panel.pending = Some(action);
        }
        may
    }

    /// Executes the actions that edit the document; the others choose what is shown.
    fn change(&mut self, action: Action) -> Result<(), DemoError> {
        match action {
            Action::Select(selected) => {
                if let Some(session) = &mut self.session {
                    session.selected = selected;
                }
                self.inspector.choose(None);
            }
            #[cfg(feature = "shader-reload")]
            Action::ReloadShaders => {
                if let Some(session) = &self.session {
                    let edited = Edited { compiles_shaders: true, ..session.to_build(true) };
                    self.request_scene(session.name.clone(), Some(edited));
                }
            }
            Action::Handles(mode) => self.mode = mode.unwrap_or(self.mode.next()),
            Action::EditLight(index, entry) => self.edit(|session| session.set_light(index, *entry)),
            Action::EditInstance(index, entry) => self.edit(|session| session.set_instance(index, *entry)),
            Action::EditMaterial(edit) => self.edit(|session| session.set_material(*edit)),
            Action::EditEnvironment(entry) => {
                self.edit(|session| session.set_environment(entry.map(|entry| *entry)))
            }
            Action::OpenMap(path) => {
                self.panel.error = None;
                self.edit(|session| session.set_map(path));
            }
            Action::AskMap => self.panel.scene.ask_for(Purpose::Map, ""),
            Action::AskPicture => self.panel.scene.ask_for(Purpose::Picture, ""),
            Action::AddObject(object) => self.edit(|session| session.add_object(object)),
            Action::AskModel => self.panel.scene.ask_for(Purpose::Model, ""),
            Action::AddLight(kind) => self.edit(|session| session.add_light(new_light(session, kind))),
            Action::Duplicate => self.duplicate(),
            Action::Delete => {
                self.edit(|session| match session.selected {
                    Some(Selected::Light(index)) => session.remove_light(index),
                    Some(Selected::Instance(index)) => session.remove_instance(index),
                    None => Ok(Change::Live),
                });
            }
            Action::ToggleHeadlamp => self.toggle_headlamp(),
            Action::AskOpen => self.panel.scene.ask_for(Purpose::Open, ""),
            Action::AskSave => {
                let name = self.session.as_ref().map_or("scene", |session| session.live_scene.name.as_str());
                self.panel.scene.ask_for(Purpose::Save, name);
            }
            Action::Save(path) => self.save(path),
            Action::Expose(stops) => self.expose(stops)?,
            other => self.look(other)?,
        }
        Ok(())
    }

    /// Requests a scene, as edited or from disk.
    pub(super) fn request_scene(&mut self, name: String, edited: Option<Edited>) {
        let request = LoadRequest {
            name,
            edited,
            device: std::sync::Arc::clone(&self.gpu.device),
            size: self.picture_size(),
        };
        self.loader.start(request);
    }

    /// Executes an edit, and rebuilds the renderer if needed.
    fn edit(&mut self, edit: impl FnOnce(&mut Session) -> Result<Change, SceneError>) {
        let Some(session) = &mut self.session else { return };
        let before = session.state();
        let change = edit(session);
        if change.is_ok() && session.state() != before {
            session.undo.remember(before, self.press);
        }
        self.take(change);
    }

    /// Rebuilds the renderer if an edit needs it.
    fn take(&mut self, change: Result<Change, SceneError>) {
        match change {
            Ok(Change::Live) => {}
            Ok(Change::Rebuild) => self.rebuild(),
            Err(error) => self.panel.error = Some(error.to_string()),
        }
    }

    fn step_back(&mut self) -> Result<(), DemoError> {
        let state = self.session.as_mut().and_then(|session| session.undo.back(session.state()));
        self.go_to(state)
    }

    fn step_forward(&mut self) -> Result<(), DemoError> {
        let state = self.session.as_mut().and_then(|session| session.undo.forward(session.state()));
        self.go_to(state)
    }

    /// Goes to a state that was before or after the current one; the window keeps its size.
    fn go_to(&mut self, state: Option<State>) -> Result<(), DemoError> {
        let (Some(state), Some(session)) = (state, &mut self.session) else { return Ok(()) };
        let settings = Settings { size: session.settings.size, ..state.settings.clone() };
        let change = session.go_to(&state);
        let differs = settings != session.settings;
        self.take(change);
        if differs { self.set(&settings) } else { Ok(()) }
    }

    /// Builds the scene of the current document, with a renderer of its own if the current one cannot go on with it, or if a
    /// recording waits for one.
    pub(super) fn rebuild(&mut self) {
        let Some(session) = &self.session else { return };
        let edited = session.to_build(matches!(self.recording, Recording::Waiting));
        self.request_scene(session.name.clone(), Some(edited));
    }

    /// Starts a recording with a new renderer, since the picture depends on its history; or saves the current
    /// recording.
    fn toggle_recording(&mut self) {
        match std::mem::take(&mut self.recording) {
            Recording::Off => {
                self.recording = Recording::Waiting;
                self.rebuild();
            }
            Recording::Waiting => {}
            Recording::On(recorder) => {
                let name = self.session.as_ref().map_or("scene", |session| session.live_scene.name.as_str());
                match screenshot::free_name(&format!("glowworm-{name}-recording"), ".toml") {
                    Ok(path) => self.saving.push(recorder.save(path)),
                    Err(error) => self.panel.error = Some(error),
                }
            }
        }
    }

    fn duplicate(&mut self) {
        self.edit(|session| {
            let place = session.selected.and_then(|selected| session.place_of(selected)).unwrap_or_default();
            let way = free_place(session, place) - place;
            match session.selected.and_then(|selected| session.entry(selected)) {
                Some(Entry::Light(_, light)) => {
                    let name = light.name.as_ref().map(|name| format!("{name} copy"));
                    session.add_light(moved_light(&LightEntry { name, ..light }, way))
                }
                Some(Entry::Instance(_, instance)) => {
                    let name = Some(free_name(session, instance.shown_name()));
                    session.add_instance(moved_instance(&InstanceEntry { name, ..instance }, way))
                }
                None => Ok(Change::Live),
            }
        });
    }

    /// Attaches the selected light to the camera, and detaches the one attached before.
    fn toggle_headlamp(&mut self) {
        self.edit(|session| {
            if let Some(index) = session.headlamp.take() {
                let Some(light) = session.document.lights().nth(index) else { return Ok(Change::Live) };
                let mut light = light.clone();
                carry(&mut light, &session.pose.camera);
                return session.set_light(index, light);
            }
            if let Some(Selected::Light(index)) = session.selected {
                session.headlamp = Some(index);
            }
            Ok(Change::Live)
        });
    }

    /// Saves the current scene with the current camera.
    fn save(&mut self, path: PathBuf) {
        let Some(session) = &mut self.session else { return };
        let camera = self.flight.has_moved().then_some(&session.pose.camera);
        let text = session.document_to_save(camera).text_to_save(&path);
        let saved = Saved { path: path.clone(), camera: session.pose.camera };
        let scene = SavedScene { name: session.name.clone(), edits: session.edits, saved };
        self.saving.push(Saving { scene: Some(scene), ..Saving::text(path, text) });
    }

    /// Changes the settings of the current scene, so that it can be taken back; a change of the window's size alone cannot.
    fn set_and_remember(&mut self, settings: &Settings) -> Result<(), DemoError> {
        let Some(before) = self.session.as_ref().map(Session::state) else { return Ok(()) };
        self.set(settings)?;
        // What a method gains is to be seen in the rate, not in the number of pixels.
        let method = |of: &Settings| (of.indirect, of.vpl.temporal_sets);
        if self.resolution.automatic && method(settings) != method(&before.settings) {
            if self.resolution.hold() {
                self.resized = Some(std::time::Instant::now());
            }
            self.panel.message = "pixel size no longer follows the rate, so that rates compare".to_owned();
        }
        if let Some(session) = &mut self.session
            && session.settings != (Settings { size: session.settings.size, ..before.settings.clone() })
        {
            session.undo.remember(before, self.press);
        }
        Ok(())
    }

    /// Changes the exposure by stops, from what it is now; or makes it automatic.
    fn expose(&mut self, stops: Option<f32>) -> Result<(), DemoError> {
        let Some(session) = &self.session else { return Ok(()) };
        let mut settings = session.settings.clone();
        settings.exposure = match (stops, settings.exposure) {
            (None, _) => None,
            (Some(stops), Some(now)) => Some(now + stops),
            (Some(stops), None) => {
                let picture = session.renderer.read_picture(false)?;
                let now = automatic_exposure(&picture, settings.tone_map, std::iter::repeat(1.0)).log2();
                Some((2.0 * now).round() * 0.5 + stops)
            }
        };
        self.panel.message = match settings.exposure {
            Some(stops) => format!("exposure {stops:+.1} stops (0: automatic)"),
            None => "automatic exposure".to_owned(),
        };
        self.set_and_remember(&settings)
    }

    /// Changes the settings of the current scene.
    pub(super) fn set(&mut self, settings: &Settings) -> Result<(), DemoError> {
        let Some(session) = &mut self.session else { return Ok(()) };
        if let Err(error) = settings.check() {
            self.panel.error = Some(error.to_string());
            return Ok(());
        }
        match session.renderer.set_settings(settings, &session.pose).map_err(DemoError::from) {
            Ok(()) => {
                if settings.size == session.settings.size {
                    self.resolution.forget();
                }
                let method = |of: &Settings| (of.indirect, of.reflections);
                if method(settings) != method(&session.settings) {
                    self.panel.message = session.renderer.warnings().join("; ");
                }
                session.settings.clone_from(settings);
            }
            Err(error) if error.is_device_lost() => return Err(error),
            Err(error) => self.panel.error = Some(error.to_string()),
        }
        Ok(())
    }

    /// Recreates the egui context with its state, so that it uploads its textures again.
    pub(super) fn recreate_ui(&mut self) {
        let context = slow_click_context();
        let memory = self.egui.egui_ctx().memory(Clone::clone);
        context.memory_mut(|fresh| *fresh = memory);
        let scale = Some(self.window.scale_factor() as f32);
        self.egui = egui_winit::State::new(context, egui::ViewportId::ROOT, &self.window, scale, None, None);
        self.textures = egui::TexturesDelta::default();
    }
}
