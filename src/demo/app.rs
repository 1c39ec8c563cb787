//! The application's state: its parts, how they begin, and what they do together.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

use serde_json::json;
use winit::event_loop::ActiveEventLoop;
use winit::window::Window;

use super::action::{Actions, AppAction};
use super::clock::{Clock, FramePacing};
use super::compare::Comparison;
use super::error::DemoError;
use super::gpu::Gpu;
use super::history::History;
use super::input::Input;
use super::interface::Interface;
use super::launch::Launch;
use super::loader::{Edited, LoadRequest, Loader};
use super::log::Log;
use super::panel;
use super::picture_size::PictureSize;
use super::recorder::Recording;
use super::saving::Saving;
use super::screen::Screen;
use super::session::{Session, SessionState};
use super::split::Split;
use super::tour::Tour;
use super::view::View;
use crate::settings::Settings;
use crate::vulkan::Instance;

/// The application.
pub(super) struct App {
    pub launch: Launch,
    /// None before the window is open and after it is closed.
    pub open: Option<OpenWindow>,
    pub log: Log,
    /// Outlives the device, for its validation messages.
    instance: Option<Arc<Instance>>,
    /// When the device was lost the last time, and the file of the edits that were unsaved then.
    pub lost: Option<(Instant, Option<PathBuf>)>,
    failed: Option<DemoError>,
}

/// State while the window is open. Drop order: users of the device, then the device.
pub(super) struct OpenWindow {
    pub view: View,
    pub comparison: Option<Comparison>,
    pub tour: Option<Tour>,
    /// Whether the tour is to begin with the first scene.
    pub tour_waits: bool,
    pub loader: Loader,
    pub gpu: Gpu,
    pub screen: Screen,
    pub input: Input,
    pub history: History,
    /// The session's state, until it goes on with another device.
    pub state: Option<SessionState>,
    /// Actions for the next frame.
    pub actions: Actions,
    /// Files being written.
    pub saving: Vec<Saving>,
    pub closing: bool,
}

impl App {
    pub fn new(launch: Launch) -> Result<Self, DemoError> {
        let log = Log::new(launch.json.as_deref())?;
        Ok(Self { launch, open: None, log, instance: None, lost: None, failed: None })
    }

    /// Returns the validation messages, or the error that ended the run.
    pub fn finish(mut self) -> Result<Vec<String>, DemoError> {
        self.open = None;
        let instance = self.instance.take();
        let messages = instance.map(|instance| instance.validation_messages()).unwrap_or_default();
        self.log.event("closed", json!({ "validation_messages": messages.len() }));
        let written = self.log.finish();
        match self.failed {
            Some(error) => Err(error),
            None => written.map(|()| messages),
        }
    }

    /// Opens the window.
    pub fn start(&mut self, events: &ActiveEventLoop) -> Result<(), DemoError> {
        let [width, height] = self.window_size(events);
        let attributes = Window::default_attributes()
            .with_title("glowworm")
            .with_min_inner_size(winit::dpi::PhysicalSize::new(64, 64))
            .with_inner_size(winit::dpi::PhysicalSize::new(width, height));
        let window =
            events.create_window(attributes).map_err(|error| DemoError::Window(error.to_string()))?;
        let window = Arc::new(window);
        let gpu = Gpu::open(&window, &self.launch)?;
        self.instance = Some(Arc::clone(&gpu.instance));
        let info = gpu.device.info();
        self.log.event("window", json!({ "size": [width, height], "device": info.name, "kind": info.kind }));
        let pacing =
            if self.launch.given.has("time_step") { FramePacing::Steps } else { FramePacing::RealTime };
        let (hidden, welcome) = (self.launch.tour, self.launch.is_first_start());
        let interface = Interface { hidden, welcome, ..Interface::default() };
        let mut actions = Actions::default();
        actions.push(AppAction::Open(self.launch.scene.clone()));
        self.open = Some(OpenWindow {
            view: View::new(Clock::new(pacing), PictureSize::new(!self.launch.given.has("size")), interface),
            comparison: None,
            tour: None,
            tour_waits: self.launch.tour,
            loader: Loader::new(&self.launch),
            gpu,
            screen: Screen::new(window),
            input: Input::default(),
            history: History::default(),
            state: None,
            actions,
            saving: Vec::new(),
            closing: false,
        });
        Ok(())
    }

    /// Size of the window, pixels: by default that of the settings; one that is given is the picture's, with the panel beside.
    fn window_size(&self, events: &ActiveEventLoop) -> [u32; 2] {
        let size = Settings::from_table(self.launch.given.table()).unwrap_or_default().size;
        if self.launch.tour || !self.launch.given.has("size") {
            return size;
        }
        let scale = events.primary_monitor().map_or(1.0, |monitor| monitor.scale_factor());
        panel::window_around(size, scale as f32)
    }

    /// Exits because of an error.
    pub fn fail(&mut self, events: &ActiveEventLoop, error: DemoError) {
        self.failed.get_or_insert(error);
        events.exit();
    }

    /// Reports finished file writes.
    pub fn take_saved(&mut self) {
        let Some(open) = &mut self.open else { return };
        let (done, waiting) = std::mem::take(&mut open.saving).into_iter().partition(Saving::is_done);
        open.saving = waiting;
        for mut saving in done {
            let scene = saving.scene.take();
            match saving.finish() {
                Ok(path) => {
                    // One that could not be written is not saved.
                    if let (Some(scene), Some(session)) = (scene, &mut open.view.session)
                        && scene.name == session.name
                    {
                        (session.saved_edits, session.saved) = (scene.edits, Some(scene.saved));
                    }
                    self.log.event("saved", &path);
                    open.view.interface.message = format!("saved {}", path.display());
                }
                Err(error) => {
                    self.log.event("not-saved", &error);
                    open.view.interface.error = Some(error);
                }
            }
        }
    }

    /// Waits for files and scenes in flight, and closes the window.
    pub fn close(&mut self) {
        if let Some(open) = &mut self.open {
            open.loader.stop();
            while !open.saving.iter().all(Saving::is_done) {
                std::thread::sleep(Duration::from_millis(10));
            }
        }
        self.take_saved();
        self.open = None;
    }
}

impl OpenWindow {
    /// Whether the scene has unsaved edits.
    pub fn is_edited(&self) -> bool {
        self.view.session.as_ref().is_some_and(Session::is_edited)
    }

    /// Whether frames are being measured, so that the window is to leave the machine alone.
    pub fn is_measuring(&self) -> bool {
        self.comparison.as_ref().is_some_and(|comparison| comparison.bench.is_running())
    }

    /// Whether something else needs the machine.
    pub fn is_busy(&self) -> bool {
        self.loader.progress().is_some() || self.is_measuring()
    }

    /// Whether no frame would differ from the last one: a scene is loaded, or the picture is frozen.
    pub fn is_calm(&self) -> bool {
        let View { session, split, size, .. } = &self.view;
        let is_frozen = session.as_ref().is_none_or(|session| session.renderer.is_frozen())
            && split.as_ref().is_none_or(Split::is_frozen);
        let waits = self.actions.0.is_empty() && self.saving.is_empty() && size.changed.is_none();
        let waits = waits && !(self.view.follows_rate(self.is_busy()) && size.resolution.awaits_rest());
        is_frozen && waits && self.tour.is_none() && !self.screen.context().has_requested_repaint()
    }

    /// Requests a scene, as edited or from disk.
    pub fn request_scene(&mut self, name: String, edited: Option<Edited>) {
        let viewport = self.screen.viewport(&self.view.interface);
        let (device, size) = (Arc::clone(&self.gpu.device), self.view.size.in_viewport(viewport));
        self.loader.start(LoadRequest { name, edited, device, size });
    }

    /// Builds the scene of the current document, with a renderer of its own if the current one cannot go on with it, or if a
    /// recording waits for one.
    pub fn rebuild(&mut self) {
        let Some(session) = &self.view.session else { return };
        let edited = session.to_build(matches!(self.view.recording, Recording::Waiting));
        self.request_scene(session.name.clone(), Some(edited));
    }
}
