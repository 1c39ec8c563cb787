//! The window's event loop.

use std::path::PathBuf;
use std::sync::{Arc, TryLockError};
use std::time::{Duration, Instant};

use serde_json::json;
use winit::application::ApplicationHandler;
use winit::event::{ElementState, MouseScrollDelta, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow};
use winit::keyboard::{KeyCode, ModifiersState, PhysicalKey};
use winit::window::{Window, WindowId};

use super::action::Action;
use super::clock::{Clock, Pace};
use super::compare::{Comparison, POLL};
use super::file_picture::Reading;
use super::flight::Flight;
use super::gpu::Gpu;
use super::handles::Mode;
use super::history::History;
use super::inspector::Inspector;
use super::loader::Loader;
use super::log::Log;
use super::loss::Kept;
use super::panel::{self, PanelState, Places, is_map, is_picture};
use super::pointer::Pointer;
use super::recorder::Recording;
use super::resolution::Resolution;
use super::screenshot::Saving;
use super::session::Session;
use super::split::{RightSide, Split};
use super::tour::Tour;
use super::undo::Press;
use super::viewport::Standing;
use super::{DemoError, Launch};
use crate::settings::Settings;
use crate::vulkan::{Instance, Viewport};

/// Time between frames while nothing changes.
const CALM: Duration = Duration::from_millis(100);
/// Poll interval while the window is hidden.
const HIDDEN_POLL: Duration = Duration::from_millis(100);

/// The application.
pub(super) struct App {
    pub launch: Launch,
    /// None before the window is open and after it is closed.
    pub open: Option<Open>,
    pub log: Log,
    /// Outlives the device, for its validation messages.
    instance: Option<Arc<Instance>>,
    /// When the device was lost the last time, and the file of the edits that were unsaved then.
    pub lost: Option<(Instant, Option<PathBuf>)>,
    failed: Option<DemoError>,
}

/// State while the window is open. Drop order: users of the device, then the device.
pub(super) struct Open {
    pub session: Option<Session>,
    pub split: Option<Split>,
    /// The picture that is to be right of the divider.
    pub reading: Option<Reading>,
    pub tour: Option<Tour>,
    pub comparison: Option<Comparison>,
    /// Whether the tour is to begin with the first scene.
    pub tour_waits: bool,
    pub loader: Loader,
    pub gpu: Gpu,
    pub window: Arc<Window>,
    pub title: String,
    pub egui: egui_winit::State,
    pub panel: PanelState,
    /// The panel's widget rectangles as last logged.
    pub places: Places,
    pub clock: Clock,
    pub flight: Flight,
    pub pointer: Pointer,
    pub history: History,
    pub inspector: Inspector,
    /// Mode of the handles.
    pub mode: Mode,
    pub modifiers: ModifiersState,
    pub press: Press,
    /// Textures of the user interface that were not uploaded yet.
    pub textures: egui::TexturesDelta,
    pub resolution: Resolution,
    /// The viewport of the last frame.
    pub last_viewport: Viewport,
    /// Time of the last change of the viewport or the resolution.
    pub resized: Option<Instant>,
    pub standing: Option<Standing>,
    pub hidden: bool,
    /// Whether there was input since the last frame.
    pub woken: bool,
    /// What to restore of the session after the device is recreated.
    pub kept: Option<Kept>,
    /// Actions from events, for the next frame.
    pub actions: Vec<Action>,
    pub closing: bool,
    pub recording: Recording,
    /// Files being written.
    pub saving: Vec<Saving>,
}

impl App {
    pub fn new(launch: Launch) -> Result<Self, DemoError> {
        let log = Log::new(launch.json.as_deref())?;
        Ok(Self { launch, open: None, log, instance: None, lost: None, failed: None })
    }

    /// Returns the validation messages, or the error that ended the run.
    pub fn finish(mut self) -> Result<Vec<String>, DemoError> {
        self.open = None;
        let messages = self.instance.take().map(|instance| instance.validation_messages());
        let messages = messages.unwrap_or_default();
        self.log.event("closed", json!({ "validation_messages": messages.len() }));
        let written = self.log.finish();
        match self.failed {
            Some(error) => Err(error),
            None => written.map(|()| messages),
        }
    }

    fn start(&mut self, events: &ActiveEventLoop) -> Result<(), DemoError> {
        let [width, height] = self.window_size(events);
        let attributes = Window::default_attributes()
            .with_title("glowworm")
            .with_min_inner_size(winit::dpi::PhysicalSize::new(64, 64))
            .with_inner_size(winit::dpi::PhysicalSize::new(width, height));
        let window =
            events.create_window(attributes).map_err(|error| DemoError::Window(error.to_string()))?;
        let window = Arc::new(window);
        let gpu = Gpu::open(&window, &self.launch)?;
        self.instance = Some(Arc::clone(gpu.instance()));
        let info = gpu.device.info();
        self.log.event("window", json!({ "size": [width, height], "device": info.name, "kind": info.kind }));
        let resolution = Resolution::full(!self.is_given("size"));
        let context = slow_click_context();
        let scale = Some(window.scale_factor() as f32);
        let pace = if self.is_given("time_step") { Pace::Steps } else { Pace::RealTime };
        self.open = Some(Open {
            session: None,
            split: None,
            reading: None,
            tour: None,
            comparison: None,
            tour_waits: self.launch.tour,
            loader: Loader::new(&self.launch),
            egui: egui_winit::State::new(context, egui::ViewportId::ROOT, &window, scale, None, None),
            gpu,
            window,
            title: String::new(),
            panel: PanelState::new(self.launch.tour, self.launch.is_first_start()),
            places: Places::default(),
            clock: Clock::new(pace),
            flight: Flight::new(1.0, None),
            pointer: Pointer::default(),
            history: History::default(),
            inspector: Inspector::default(),
            mode: Mode::default(),
            modifiers: ModifiersState::empty(),
            press: Press::default(),
            textures: egui::TexturesDelta::default(),
            resolution,
            last_viewport: Viewport::default(),
            resized: None,
            standing: None,
            hidden: false,
            woken: false,
            kept: None,
            actions: vec![Action::Open(self.launch.scene.clone())],
            closing: false,
            recording: Recording::default(),
            saving: Vec::new(),
        });
        Ok(())
    }

    fn is_given(&self, setting: &str) -> bool {
        self.launch.given.has(setting)
    }

    /// Size of the window, pixels: by default that of the settings; one that is given is the picture's, with the panel beside.
    fn window_size(&self, events: &ActiveEventLoop) -> [u32; 2] {
        let size = Settings::from_table(self.launch.given.table()).unwrap_or_default().size;
        if self.launch.tour || !self.is_given("size") {
            return size;
        }
        let scale = events.primary_monitor().map_or(1.0, |monitor| monitor.scale_factor());
        panel::window_around(size, scale as f32)
    }

    /// Exits because of an error.
    fn fail(&mut self, events: &ActiveEventLoop, error: DemoError) {
        self.failed.get_or_insert(error);
        events.exit();
    }

    /// Draws the next frame, unless frames are being measured; recreates the device if it was lost.
    fn draw(&mut self, events: &ActiveEventLoop) {
        let comparison = self.open.as_ref().and_then(|open| open.comparison.as_ref());
        let turn = comparison.map(|comparison| Arc::clone(comparison.bench.turn()));
        let held = turn.as_ref().map(|turn| turn.try_lock());
        if matches!(held, Some(Err(TryLockError::WouldBlock))) {
            return;
        }
        let drawn = self.frame();
        let drawn = match drawn {
            Err(error) if error.is_device_lost() => self.recover(error),
            other => other,
        };
        if let Err(error) = drawn {
            self.fail(events, error);
        }
        if self.open.as_ref().is_some_and(|open| open.closing) {
            events.exit();
        }
    }
}

/// The action for a dropped file: a picture goes right of the divider, if there is one or nothing else can be made of it.
fn action_of_file(path: PathBuf, is_divided: bool) -> Action {
    if is_map(&path) && !is_divided {
        Action::OpenMap(path)
    } else if is_picture(&path) {
        Action::Split(Some(RightSide::Picture(path)))
    } else {
        Action::Open(path.to_string_lossy().into_owned())
    }
}

/// An egui context that accepts slow clicks: at a few frames per second every press is slow.
pub(super) fn slow_click_context() -> egui::Context {
    let context = egui::Context::default();
    context.options_mut(|options| options.input_options.max_click_duration = 5.0);
    context.all_styles_mut(|style| {
        style.text_styles.insert(egui::TextStyle::Small, egui::FontId::proportional(12.0));
    });
    context
}

impl ApplicationHandler for App {
    fn resumed(&mut self, events: &ActiveEventLoop) {
        if self.open.is_none()
            && let Err(error) = self.start(events)
        {
            self.fail(events, error);
        }
    }

    fn window_event(&mut self, events: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let Some(open) = &mut self.open else { return };
        // A clicked widget keeps the focus, but consumes keys only during text input; Escape closes its popups.
        open.woken |= !matches!(event, WindowEvent::RedrawRequested);
        let typing = open.panel.has_keyboard || open.egui.egui_ctx().text_edit_focused();
        let key = match &event {
            WindowEvent::KeyboardInput { event, .. } => Some(event.physical_key),
            _ => None,
        };
        let is_key = |code: KeyCode| key == Some(PhysicalKey::Code(code));
        let ours = key.is_some() && (!typing || is_key(KeyCode::F6)) && !is_key(KeyCode::Escape);
        let consumed = !ours && open.egui.on_window_event(&open.window, &event).consumed;
        let pointer_taken = open.takes_pointer();
        if let WindowEvent::MouseInput { state, .. } = &event {
            open.press.turn(*state == ElementState::Pressed);
        }
        match event {
            WindowEvent::CloseRequested if open.hidden && !open.is_edited() => events.exit(),
            WindowEvent::CloseRequested => {
                // A hidden window draws no frame, in which it could ask.
                open.window.set_minimized(false);
                open.actions.push(Action::Quit);
            }
            WindowEvent::RedrawRequested => self.draw(events),
            WindowEvent::Focused(false) => {
                open.flight.release();
                open.pointer.cancel();
                open.window.set_cursor_visible(true);
            }
            WindowEvent::ModifiersChanged(modifiers) => open.modifiers = modifiers.state(),
            WindowEvent::KeyboardInput { event, .. } => {
                let released = event.state == ElementState::Released;
                if let PhysicalKey::Code(code) = event.physical_key
                    && (!typing || released || code == KeyCode::F6)
                {
                    open.key(code, event.state, event.repeat);
                } else if is_key(KeyCode::Escape) {
                    open.take_keyboard();
                }
            }
            WindowEvent::CursorMoved { position, .. } => {
                open.pointer_moved([position.x as f32, position.y as f32]);
            }
            WindowEvent::MouseInput { state, button, .. }
                if !pointer_taken || state == ElementState::Released =>
            {
                if state == ElementState::Pressed {
                    open.panel.has_keyboard = false;
                }
                open.button(button, state);
            }
            WindowEvent::MouseWheel { delta, .. } if !pointer_taken && !consumed => {
                let notches = match delta {
                    MouseScrollDelta::LineDelta(_, lines) => lines,
                    MouseScrollDelta::PixelDelta(pixels) => pixels.y as f32 / 50.0,
                };
                open.wheel(notches);
            }
            WindowEvent::DroppedFile(path) => {
                open.actions.push(action_of_file(path, open.split.is_some()));
            }
            _ => {}
        }
    }

    fn about_to_wait(&mut self, events: &ActiveEventLoop) {
        let Some(open) = &mut self.open else { return };
        let size = open.window.inner_size();
        let hidden = size.width == 0 || size.height == 0 || open.window.is_minimized() == Some(true);
        if hidden != open.hidden {
            open.hidden = hidden;
            self.log.event(if hidden { "hidden" } else { "seen" }, ());
        }
        if hidden {
            events.set_control_flow(ControlFlow::WaitUntil(Instant::now() + HIDDEN_POLL));
        } else if open.is_measuring() {
            events.set_control_flow(ControlFlow::WaitUntil(Instant::now() + POLL));
            open.window.request_redraw();
        } else if open.is_calm() && !std::mem::take(&mut open.woken) {
            let next = open.clock.last_frame() + CALM;
            events.set_control_flow(ControlFlow::WaitUntil(next));
            if Instant::now() >= next {
                open.window.request_redraw();
            }
        } else {
            events.set_control_flow(ControlFlow::Wait);
            open.window.request_redraw();
        }
    }

    fn exiting(&mut self, _: &ActiveEventLoop) {
        if let Some(open) = &mut self.open {
            open.loader.stop();
            // Finish pending saves.
            while !open.saving.iter().all(Saving::is_done) {
                std::thread::sleep(Duration::from_millis(10));
            }
        }
        self.take_saved();
        self.open = None;
    }
}
