//! Draws a moving scene in a window of winit: `cargo run --release --example window`.

use std::error::Error;
use std::sync::Arc;
use std::time::Instant;

use glowworm::formats::load_scene;
use glowworm::renderer::Renderer;
use glowworm::scene::Scene;
use glowworm::settings::Settings;
use glowworm::vulkan::{
    Device, Instance, InstanceOptions, Pane, PresentMode, Presenter, Surface, UiDrawing, Viewport,
};
use raw_window_handle::HasDisplayHandle;
use winit::application::ApplicationHandler;
use winit::event::WindowEvent;
use winit::event_loop::{ActiveEventLoop, EventLoop};
use winit::window::{Window, WindowId};

struct View {
    renderer: Renderer,
    presenter: Presenter,
    window: Arc<Window>,
}

struct App {
    scene: Arc<Scene>,
    began: Instant,
    view: Option<View>,
}

impl App {
    fn open(&self, events: &ActiveEventLoop) -> Result<View, Box<dyn Error>> {
        let window = Arc::new(events.create_window(Window::default_attributes().with_title("playroom"))?);
        let display = Some(window.display_handle()?.as_raw());
        let instance = Instance::new(InstanceOptions { validate: false, display })?;
        let surface = Arc::new(Surface::new(&instance, &window)?);
        let device = Device::open_for(&instance, None, Some(&surface))?;
        let size = window.inner_size().into();
        let presenter = Presenter::new(&device, &surface, size, PresentMode::default())?;
        let settings = Settings { size, ..Settings::default() };
        let renderer = Renderer::new(&device, &self.scene, &settings, &self.scene.pose(0.0))?;
        Ok(View { renderer, presenter, window })
    }

    fn draw(&mut self) -> Result<(), Box<dyn Error>> {
        let Some(view) = &mut self.view else { return Ok(()) };
        view.renderer.render(&self.scene.pose(self.began.elapsed().as_secs_f64()))?;
        let pane = Pane { picture: view.renderer.display(), columns: [0.0, 1.0] };
        let whole = Viewport { corner: [0, 0], size: view.window.inner_size().into() };
        view.presenter.present(&[pane], whole, &UiDrawing::default())?;
        view.window.request_redraw();
        Ok(())
    }
}

impl ApplicationHandler for App {
    fn resumed(&mut self, events: &ActiveEventLoop) {
        match self.open(events) {
            Ok(view) => self.view = Some(view),
            Err(error) => {
                eprintln!("{error}");
                events.exit();
            }
        }
    }

    fn window_event(&mut self, events: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        match event {
            WindowEvent::CloseRequested => events.exit(),
            WindowEvent::Resized(size) => {
                if let Some(view) = &mut self.view {
                    view.presenter.resize(size.into());
                }
            }
            WindowEvent::RedrawRequested => {
                if let Err(error) = self.draw() {
                    eprintln!("{error}");
                    events.exit();
                }
            }
            _ => {}
        }
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let scene = Arc::new(load_scene("playroom", None)?);
    EventLoop::new()?.run_app(&mut App { scene, began: Instant::now(), view: None })?;
    Ok(())
}
