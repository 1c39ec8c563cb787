//! The window's event loop.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

use serde_json::json;
use winit::application::ApplicationHandler;
use winit::event::{ElementState, MouseScrollDelta, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow};
use winit::keyboard::{KeyCode, ModifiersState, PhysicalKey};
use winit::window::{Window, WindowId};

use super::action::Action;
use super::clock::{Clock, Pace};
use super::flight::Flight;
use super::gpu::Gpu;
use super::handles::Mode;
use super::history::History;
use super::inspector::Inspector;
use super::loader::Loader;
use super::log::Log;
use super::panel::{PanelState, Places, is_map};
use super::pointer::Pointer;
use super::recorder::Recorder;
use super::screenshot::Saving;
use super::split::Split;
use super::stage::Stage;
use super::tour::Tour;
use super::undo::Press;
use super::{DemoError, Launch};
use crate::renderer::DebugView;
use crate::vulkan::Instance;

/// Default size of the window on a CPU driver, logical pixels.
const CPU_SIZE: [u32; 2] = [640, 360];
/// Default logical pixels per picture pixel in each direction, on a CPU driver.
const CPU_COARSENESS: f64 = 2.0;
/// Poll interval while the window is hidden.
const HIDDEN_POLL: Duration = Duration::from_millis(100);
/// Delay from the last resize of the window to that of the picture, which is scaled meanwhile.
pub(super) const RESIZE_DELAY: Duration = Duration::from_millis(150);

/// The application.
pub(super) struct App {
    pub launch: Launch,
    /// None before the window is open and after it is closed.
    pub open: Option<Open>,
    pub log: Log,
    /// Outlives the device, for its validation messages.
    instance: Option<Arc<Instance>>,
    failed: Option<DemoError>,
}

/// State of the recording.
#[derive(Default)]
pub(super) enum Recording {
    #[default]
    Off,
    /// Starts with the renderer that is being built.
    Waiting,
    On(Box<Recorder>),
}

/// State while the window is open. Drop order: users of the device, then the device.
pub(super) struct Open {
    pub stage: Option<Stage>,
    pub split: Option<Split>,
    pub tour: Option<Tour>,
    /// Whether the tour is to begin with the first scene.
    pub tour_waits: bool,
    pub loader: Loader,
    pub gpu: Gpu,
    pub window: Arc<Window>,
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
    /// Window pixels per picture pixel in each direction.
    pub coarseness: u32,
    /// Time of the last resize.
    pub resized: Option<Instant>,
    pub hidden: bool,
    /// The debug view to restore after the device is recreated.
    pub saved_view: Option<DebugView>,
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
        Ok(Self { launch, open: None, log, instance: None, failed: None })
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
        let [width, height] = self.window_size();
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
        let small = info.is_cpu() && !self.is_given("size");
        let mut coarseness = 1;
        if small {
            let [width, height] = CPU_SIZE;
            let _ = window.request_inner_size(winit::dpi::LogicalSize::new(width, height));
            coarseness = coarseness_at(window.scale_factor());
        }
        let context = slow_click_context();
        let scale = Some(window.scale_factor() as f32);
        let pace = if self.is_given("time_step") { Pace::Steps } else { Pace::RealTime };
        self.open = Some(Open {
            stage: None,
            split: None,
            tour: None,
            tour_waits: self.launch.tour,
            loader: Loader::new(&self.launch),
            egui: egui_winit::State::new(context, egui::ViewportId::ROOT, &window, scale, None, None),
            gpu,
            window,
            panel: PanelState::default(),
            places: Places::default(),
            clock: Clock::new(pace),
            flight: Flight::new(1.0),
            pointer: Pointer::default(),
            history: History::default(),
            inspector: Inspector::default(),
            mode: Mode::default(),
            modifiers: ModifiersState::empty(),
            press: Press::default(),
            textures: egui::TexturesDelta::default(),
            coarseness,
            resized: None,
            hidden: false,
            saved_view: None,
            actions: vec![Action::Open(self.launch.scene.clone())],
            closing: false,
            recording: Recording::default(),
            saving: Vec::new(),
        });
        Ok(())
    }

    fn is_given(&self, setting: &str) -> bool {
        self.launch.given.iter().any(|given| given == setting)
    }

    fn window_size(&self) -> [u32; 2] {
        self.launch.settings.size
    }

    /// Exits because of an error.
    fn fail(&mut self, events: &ActiveEventLoop, error: DemoError) {
        self.failed.get_or_insert(error);
        events.exit();
    }

    /// Draws the next frame; recreates the device if it was lost.
    fn draw(&mut self, events: &ActiveEventLoop) {
        let drawn = self.frame();
        let drawn = match drawn {
            Err(error) if error.is_device_lost() => {
                self.log.event("device-lost", error.to_string());
                self.restart_device(None)
            }
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

/// What a dropped file is for.
fn action_of_file(path: PathBuf) -> Action {
    if is_map(&path) { Action::OpenMap(path) } else { Action::Open(path.to_string_lossy().into_owned()) }
}

/// Default window pixels per picture pixel on a CPU driver, for this scale factor of the display.
fn coarseness_at(scale: f64) -> u32 {
    (CPU_COARSENESS * scale).round().clamp(1.0, 8.0) as u32
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
        let typing = open.egui.egui_ctx().text_edit_focused();
        let ours = matches!(&event, WindowEvent::KeyboardInput { event, .. }
            if !typing && event.physical_key != PhysicalKey::Code(KeyCode::Escape));
        let consumed = !ours && open.egui.on_window_event(&open.window, &event).consumed;
        let pointer_taken = open.egui.egui_ctx().egui_wants_pointer_input();
        if let WindowEvent::MouseInput { state, .. } = &event {
            open.press.turn(*state == ElementState::Pressed);
        }
        match event {
            WindowEvent::CloseRequested => events.exit(),
            WindowEvent::RedrawRequested => self.draw(events),
            WindowEvent::Resized(_) | WindowEvent::ScaleFactorChanged { .. } => {
                open.resized = Some(Instant::now());
            }
            WindowEvent::Focused(false) => {
                open.flight.release();
                open.pointer.cancel();
                open.window.set_cursor_visible(true);
            }
            WindowEvent::ModifiersChanged(modifiers) => open.modifiers = modifiers.state(),
            WindowEvent::KeyboardInput { event, .. } => {
                let released = event.state == ElementState::Released;
                if let PhysicalKey::Code(code) = event.physical_key
                    && (!typing || released)
                {
                    open.key(code, event.state, event.repeat);
                }
            }
            WindowEvent::CursorMoved { position, .. } => {
                open.pointer_moved([position.x as f32, position.y as f32]);
            }
            WindowEvent::MouseInput { state, button, .. }
                if !pointer_taken || state == ElementState::Released =>
            {
                open.button(button, state);
            }
            WindowEvent::MouseWheel { delta, .. } if !pointer_taken && !consumed => {
                open.flight.change_speed(match delta {
                    MouseScrollDelta::LineDelta(_, lines) => lines,
                    MouseScrollDelta::PixelDelta(pixels) => pixels.y as f32 / 50.0,
                });
            }
            WindowEvent::DroppedFile(path) => {
                open.actions.push(action_of_file(path));
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
