//! The window on screen with its user interface: egui and the panel.

use std::sync::Arc;

use egui::{ClippedPrimitive, Order, Pos2};
use winit::window::Window;

use super::action::Actions;
use super::interface::Interface;
use super::panel::{self, Layout, PanelState, Shown};
use crate::vulkan::Viewport;

/// The window and its interface.
pub(super) struct Screen {
    pub window: Arc<Window>,
    pub egui: egui_winit::State,
    pub panel: PanelState,
    /// Textures of the interface that were not uploaded yet.
    pub textures: egui::TexturesDelta,
    layout: Layout,
    /// Whether the layout differs from the one last logged.
    has_moved: bool,
    title: String,
    /// Whether nothing of the window is on screen.
    pub is_hidden: bool,
}

impl Screen {
    /// The interface of a new window.
    pub fn new(window: Arc<Window>) -> Self {
        Self {
            egui: egui_of(&window, slow_click_context()),
            window,
            panel: PanelState::default(),
            textures: egui::TexturesDelta::default(),
            layout: Layout::default(),
            has_moved: false,
            title: String::new(),
            is_hidden: false,
        }
    }

    /// Recreates the egui context with its state, so that it uploads its textures again.
    pub fn recreate_context(&mut self) {
        let context = slow_click_context();
        let memory = self.context().memory(Clone::clone);
        context.memory_mut(|fresh| *fresh = memory);
        self.egui = egui_of(&self.window, context);
        self.textures = egui::TexturesDelta::default();
    }

    pub fn context(&self) -> &egui::Context {
        self.egui.egui_ctx()
    }

    /// The part of the window that panel and bar leave to the picture, points.
    pub fn picture_area(&self, interface: &Interface) -> egui::Rect {
        panel::picture_area(self.context(), interface.hidden)
    }

    /// The part of the window that panel and bar leave to the picture, pixels.
    pub fn viewport(&self, interface: &Interface) -> Viewport {
        let (area, scale) = (self.picture_area(interface), self.context().pixels_per_point());
        let pixels = |points: Pos2| [points.x, points.y].map(|at| (at * scale).round().max(0.0) as u32);
        let (corner, end) = (pixels(area.min), pixels(area.max));
        Viewport { corner, size: [0, 1].map(|axis| end[axis].saturating_sub(corner[axis])) }
    }

    /// Frames that the display shows per second, if that is known.
    pub fn refresh_rate(&self) -> Option<f64> {
        let millihertz = self.window.current_monitor()?.refresh_rate_millihertz()?;
        Some(f64::from(millihertz) / 1e3)
    }

    /// Converts a position from pixels to points.
    pub fn points(&self, pixels: [f32; 2]) -> Pos2 {
        Pos2::from(pixels) / self.context().pixels_per_point()
    }

    /// Whether the interface takes a press at a position: egui itself only knows where the pointer was in the last frame.
    pub fn takes_pointer(&self, at: Pos2, interface: &Interface) -> bool {
        let context = self.context();
        let is_beside = !self.picture_area(interface).contains(at);
        let is_overlay = context.layer_id_at(at).is_some_and(|layer| layer.order != Order::Background);
        is_beside || is_overlay || context.egui_is_using_pointer()
    }

    /// Gives the keyboard to the panel, at its first widget.
    pub fn give_keyboard(&mut self, interface: &mut Interface) {
        interface.has_keyboard = true;
        interface.hidden = false;
        let tab = egui::Event::Key {
            key: egui::Key::Tab,
            physical_key: None,
            pressed: true,
            repeat: false,
            modifiers: egui::Modifiers::NONE,
        };
        self.egui.egui_input_mut().events.push(tab);
    }

    /// Takes the keyboard back from the panel.
    pub fn take_keyboard(&self, interface: &mut Interface) {
        interface.has_keyboard = false;
        self.context().memory_mut(|memory| {
            if let Some(focused) = memory.focused() {
                memory.surrender_focus(focused);
            }
        });
    }

    /// Lays the panel out; returns the user's actions, the shapes to draw and the pixels of a point.
    pub fn run_panel(&mut self, shown: &Shown<'_>) -> (Actions, Vec<ClippedPrimitive>, f32) {
        let input = self.egui.take_egui_input(&self.window);
        let context = self.context().clone();
        let (mut actions, mut layout) = (Actions::default(), Layout::default());
        let output = context.run_ui(input, |ui| {
            let drawn = panel::draw(ui, &mut self.panel, shown);
            actions.extend(drawn.actions.0);
            layout = drawn.layout;
        });
        self.has_moved |= self.layout != layout;
        self.layout = layout;
        self.egui.handle_platform_output(&self.window, output.platform_output);
        self.textures.append(output.textures_delta);
        let scale = output.pixels_per_point;
        (actions, context.tessellate(output.shapes, scale), scale)
    }

    /// The rectangles of the widgets, once where they differ from the last ones.
    pub fn take_layout(&mut self) -> Option<&Layout> {
        std::mem::take(&mut self.has_moved).then_some(&self.layout)
    }

    /// Sets the window's title.
    pub fn set_title(&mut self, title: String) {
        if self.title != title {
            self.window.set_title(&title);
            self.title = title;
        }
    }
}

fn egui_of(window: &Window, context: egui::Context) -> egui_winit::State {
    let scale = Some(window.scale_factor() as f32);
    egui_winit::State::new(context, egui::ViewportId::ROOT, window, scale, None, None)
}

/// An egui context that accepts slow clicks: at a few frames per second every press is slow.
fn slow_click_context() -> egui::Context {
    let context = egui::Context::default();
    context.options_mut(|options| options.input_options.max_click_duration = 5.0);
    context.all_styles_mut(|style| {
        style.text_styles.insert(egui::TextStyle::Small, egui::FontId::proportional(12.0));
    });
    context
}
