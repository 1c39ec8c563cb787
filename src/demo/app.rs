//! The window's events, and one frame after the other.

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
use super::history::{History, Sample};
use super::inspector::Inspector;
use super::loader::{Built, Loader};
use super::log::Log;
use super::panel::{self, PanelState, Places, Shown};
use super::pointer::Pointer;
use super::recorder::Recorder;
use super::screenshot::Saving;
use super::stage::{Change, Stage};
use super::{DemoError, Launch};
use crate::renderer::DebugView;
use crate::vulkan::{Instance, Presented, UiDrawing};

/// Size of the window on a CPU driver, where nobody asks for another.
pub(super) const CPU_SIZE: [u32; 2] = [640, 360];
/// Pixels of the window, each way, to a pixel of the picture there.
const CPU_COARSENESS: u32 = 2;
/// How often to look whether a hidden window can be seen again.
const HIDDEN_POLL: Duration = Duration::from_millis(100);
/// How long a window must keep its size before the picture follows; until then it is stretched.
const RESIZE_DELAY: Duration = Duration::from_millis(150);

/// The program while its window is open.
pub(super) struct App {
    pub launch: Launch,
    /// None before the window is open and after it is closed.
    pub open: Option<Open>,
    pub log: Log,
    /// Outlives the device, to ask what validation said.
    instance: Option<Arc<Instance>>,
    failed: Option<DemoError>,
}

/// Whether what is done is recorded.
#[derive(Default)]
pub(super) enum Recording {
    #[default]
    Off,
    /// It begins with the renderer that is being made.
    Waiting,
    On(Box<Recorder>),
}

/// What there is while the window is open. Dropped in this order: what uses the device, then the device.
pub(super) struct Open {
    pub stage: Option<Stage>,
    pub loader: Loader,
    pub gpu: Gpu,
    pub window: Arc<Window>,
    pub egui: egui_winit::State,
    pub panel: PanelState,
    /// Where the panel's things were in the log.
    pub places: Places,
    pub clock: Clock,
    pub flight: Flight,
    pub pointer: Pointer,
    pub history: History,
    pub inspector: Inspector,
    /// What handles do.
    pub mode: Mode,
    pub modifiers: ModifiersState,
    /// Textures of the user interface that have not reached the device.
    pub textures: egui::TexturesDelta,
    /// Pixels of the window, each way, to a pixel of the picture.
    pub coarseness: u32,
    /// When the window last changed its size.
    pub resized: Option<Instant>,
    pub hidden: bool,
    /// What the scene's view was before the device was closed.
    pub parked: Option<DebugView>,
    /// Wishes from events, for the next frame.
    pub wishes: Vec<Action>,
    pub closing: bool,
    pub recording: Recording,
    /// Files on their way to disk.
    pub saving: Vec<Saving>,
}

impl App {
    pub fn new(launch: Launch) -> Result<Self, DemoError> {
        let log = Log::new(launch.json.as_deref())?;
        Ok(Self { launch, open: None, log, instance: None, failed: None })
    }

    /// What the run came to: what validation has said.
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
        let small = info.kind == "cpu" && !self.is_given("size");
        let coarseness = if small { CPU_COARSENESS } else { 1 };
        if small {
            let [width, height] = CPU_SIZE;
            let _ = window.request_inner_size(winit::dpi::PhysicalSize::new(width, height));
        }
        let context = egui::Context::default();
        let scale = Some(window.scale_factor() as f32);
        let pace = if self.is_given("time_step") { Pace::Steps } else { Pace::RealTime };
        self.open = Some(Open {
            stage: None,
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
            textures: egui::TexturesDelta::default(),
            coarseness,
            resized: None,
            hidden: false,
            parked: None,
            wishes: vec![Action::Open(self.launch.scene.clone())],
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

    /// Ends the program because of an error.
    fn fail(&mut self, events: &ActiveEventLoop, error: DemoError) {
        self.failed.get_or_insert(error);
        events.exit();
    }

    /// Makes the next frame, and everything on the device anew where that is gone.
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

    fn frame(&mut self) -> Result<(), DemoError> {
        self.take_built()?;
        self.take_saved();
        let Some(open) = &mut self.open else { return Ok(()) };
        open.follow_size();
        let step = open.stage.as_ref().map_or(0.0, |stage| stage.settings.time_step);
        open.clock.tick(step);
        open.fly();
        open.drag_handle();
        let started = Instant::now();
        let (primitives, pixels_per_point) = open.lay_out();
        let ui_cpu_ms = started.elapsed().as_secs_f64() * 1e3;
        for wish in std::mem::take(&mut open.wishes) {
            self.perform(wish)?;
        }
        let Some(open) = &mut self.open else { return Ok(()) };
        if open.places != open.panel.places {
            open.places.clone_from(&open.panel.places);
            self.log.event("layout", &open.places);
        }
        open.draw_stage()?;
        let drawing =
            UiDrawing { primitives, textures: std::mem::take(&mut open.textures), pixels_per_point };
        let picture = open.stage.as_ref().map(|stage| stage.renderer.display());
        open.window.pre_present_notify();
        let presented = open.gpu.presenter.present(picture, &drawing)?;
        if presented == Presented::Skipped {
            open.textures.append(drawing.textures);
            return Ok(());
        }
        let sample = Sample {
            interval_ms: open.clock.interval_ms(),
            ui_cpu_ms,
            ui_device_ms: open.gpu.presenter.ui_ms(),
            report: open.stage.as_ref().map(|stage| stage.report).unwrap_or_default(),
        };
        open.history.push(sample);
        self.log.shown(&sample);
        Ok(())
    }

    /// Shows the scene that has been loaded, if one has.
    fn take_built(&mut self) -> Result<(), DemoError> {
        let Some(open) = &mut self.open else { return Ok(()) };
        match open.loader.poll() {
            None => {}
            Some(Ok(built)) => {
                self.log.event(
                    "scene",
                    json!({ "name": built.name, "settings": built.settings, "same": built.same }),
                );
                open.show(built)?;
            }
            // Without a scene there is nothing to go on with.
            Some(Err(error)) if open.stage.is_none() => return Err(error),
            Some(Err(error)) => {
                self.log.event("scene-failed", error.to_string());
                open.panel.error = Some(error.to_string());
            }
        }
        Ok(())
    }
}

impl App {
    /// Says which files have reached the disk.
    fn take_saved(&mut self) {
        let Some(open) = &mut self.open else { return };
        let (done, waiting) = std::mem::take(&mut open.saving).into_iter().partition(Saving::is_done);
        open.saving = waiting;
        for saving in done {
            match saving.finish() {
                Ok(path) => {
                    self.log.event("saved", &path);
                    open.panel.message = format!("saved {}", path.display());
                }
                Err(error) => {
                    self.log.event("not-saved", &error);
                    open.panel.error = Some(error);
                }
            }
        }
    }
}

impl Open {
    /// Shows a scene that has been loaded, or the one on show with a renderer that was made anew.
    fn show(&mut self, built: Built) -> Result<(), DemoError> {
        match &mut self.stage {
            Some(stage) if built.same && stage.name == built.name => {
                let view = stage.renderer.view().clone();
                let wanted = stage.settings.clone();
                let change = stage.renew(built)?;
                stage.renderer.set_view(&view)?;
                match &mut self.recording {
                    Recording::On(recorder) => recorder.renewed(stage),
                    Recording::Waiting => self.recording = Recording::On(Box::new(Recorder::new(stage))),
                    Recording::Off => {}
                }
                if stage.settings != wanted {
                    self.wishes.push(Action::Set(Box::new(wanted)));
                }
                // What was edited meanwhile may need another one.
                if change == Change::Rebuild {
                    self.rebuild();
                }
            }
            _ => {
                let mut stage = Stage::new(built);
                if let Some(view) = self.parked.take() {
                    stage.renderer.set_view(&view)?;
                } else {
                    stage.rest.warnings.iter().for_each(|warning| log::warn!("{warning}"));
                    self.panel.message = stage.rest.warnings.join("; ");
                    self.window.set_title(&format!("{} - glowworm", stage.name));
                    self.flight = Flight::new(stage.radius);
                    self.clock.time = 0.0;
                }
                self.stage = Some(stage);
                // A recording is of one scene.
                if !matches!(self.recording, Recording::Off) {
                    self.wishes.push(Action::ToggleRecording);
                }
            }
        }
        self.history.clear();
        // The window may have changed its size meanwhile.
        self.resized = Some(Instant::now());
        Ok(())
    }

    /// Tells the presenter the window's size, and the renderer once that has come to rest.
    fn follow_size(&mut self) {
        let size = self.window.inner_size();
        self.gpu.presenter.resize([size.width, size.height]);
        if self.resized.is_none_or(|when| when.elapsed() <= RESIZE_DELAY) {
            return;
        }
        self.resized = None;
        let size = self.picture_size();
        if let Some(stage) = self.stage.as_ref().filter(|stage| stage.settings.size != size) {
            let settings = crate::settings::Settings { size, ..stage.settings.clone() };
            self.wishes.push(Action::Set(Box::new(settings)));
        }
    }

    /// Pixels of the picture in a window of this size.
    pub fn picture_size(&self) -> [u32; 2] {
        let size = self.window.inner_size();
        [size.width, size.height].map(|side| side.div_ceil(self.coarseness).max(1))
    }

    /// Moves the camera by the keys that are held.
    fn fly(&mut self) {
        let Some(stage) = &self.stage else { return };
        let own = stage.rest.pose(self.clock.time).camera;
        self.flight.running = self.modifiers.shift_key();
        self.flight.advance(&own, self.clock.seconds() as f32);
    }

    fn lay_out(&mut self) -> (Vec<egui::ClippedPrimitive>, f32) {
        let input = self.egui.take_egui_input(&self.window);
        let context = self.egui.egui_ctx().clone();
        let mut wishes = Vec::new();
        let output = context.run_ui(input, |ui| {
            let mut shown = Shown {
                stage: self.stage.as_ref(),
                clock: &mut self.clock,
                history: &self.history,
                loader: &self.loader,
                gpu: &self.gpu,
                coarseness: self.coarseness,
                recording: &self.recording,
                inspector: &self.inspector,
                mode: self.mode,
            };
            wishes.extend(panel::show(ui, &mut self.panel, &mut shown));
        });
        self.wishes.extend(wishes);
        self.egui.handle_platform_output(&self.window, output.platform_output);
        self.textures.append(output.textures_delta);
        let scale = output.pixels_per_point;
        (context.tessellate(output.shapes, scale), scale)
    }

    fn draw_stage(&mut self) -> Result<(), DemoError> {
        let Some(stage) = &mut self.stage else { return Ok(()) };
        self.inspector.refresh(stage)?;
        let camera = self.flight.camera(&stage.rest.pose(self.clock.time).camera);
        stage.render(self.clock.time, camera)?;
        if let Recording::On(recorder) = &mut self.recording {
            recorder.frame(stage);
        }
        Ok(())
    }
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
        // Keys that mean something here would also go from widget to widget there.
        let ours = matches!(&event, WindowEvent::KeyboardInput { event, .. }
            if event.physical_key == PhysicalKey::Code(KeyCode::Tab) && !open.egui.egui_ctx().egui_wants_keyboard_input());
        let consumed = !ours && open.egui.on_window_event(&open.window, &event).consumed;
        let context = open.egui.egui_ctx();
        let (keys_taken, pointer_taken) =
            (context.egui_wants_keyboard_input(), context.egui_wants_pointer_input());
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
                    && (!keys_taken || released)
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
                open.wishes.push(Action::Open(path.to_string_lossy().into_owned()));
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
            // What was being saved is saved.
            while !open.saving.iter().all(Saving::is_done) {
                std::thread::sleep(Duration::from_millis(10));
            }
        }
        self.take_saved();
        self.open = None;
    }
}
