//! Draws egui's output over a picture.

use std::mem::ManuallyDrop;
use std::sync::Arc;

use ash::vk;
use egui::{ClippedPrimitive, TextureId, TexturesDelta};
use egui_ash_renderer::allocator::GpuAllocator;
use egui_ash_renderer::{DynamicRendering, Options, RenderMode, Renderer, RendererError};

use super::{Device, VulkanError};

/// One frame of the user interface.
pub struct UiDrawing {
    /// Triangles in points.
    pub primitives: Vec<ClippedPrimitive>,
    /// Textures to create, update or free.
    pub textures: TexturesDelta,
    /// Pixels per point.
    pub pixels_per_point: f32,
}

impl Default for UiDrawing {
    /// Nothing.
    fn default() -> Self {
        Self { primitives: Vec::new(), textures: TexturesDelta::default(), pixels_per_point: 1.0 }
    }
}

/// Draws a [`UiDrawing`].
pub(super) struct UiRenderer {
    // Dropped manually, before the device.
    renderer: ManuallyDrop<Renderer<GpuAllocator>>,
    pool: vk::CommandPool,
    /// Textures to free after the frame that may still draw them.
    to_free: Vec<TextureId>,
    device: Arc<Device>,
}

impl UiRenderer {
    /// Renders to targets of `format`, with `in_flight_frames` frames in flight.
    pub fn new(
        device: &Arc<Device>,
        format: vk::Format,
        in_flight_frames: usize,
    ) -> Result<Self, VulkanError> {
        let mode = RenderMode::DynamicRendering(DynamicRendering {
            color_attachment_format: format,
            depth_attachment_format: None,
            stencil_attachment_format: None,
        });
        let options = Options { in_flight_frames, srgb_framebuffer: is_srgb(format), ..Options::default() };
        let allocator = device.shared_allocator();
        let renderer = Renderer::with_gpu_allocator(allocator, device.raw().clone(), mode, options)
            .map_err(|error| ui_error(&error))?;
        let info = vk::CommandPoolCreateInfo::default().queue_family_index(device.queue_family());
        // SAFETY: `info` is complete; `drop` destroys the pool.
        let pool = unsafe { device.raw().create_command_pool(&info, None) }
            .map_err(VulkanError::call("creation", "commands of the user interface"))?;
        Ok(Self {
            renderer: ManuallyDrop::new(renderer),
            pool,
            to_free: Vec::new(),
            device: Arc::clone(device),
        })
    }

    /// Uploads new textures and frees old ones. Waits for the device if there are any.
    pub fn update_textures(&mut self, textures: &TexturesDelta) -> Result<(), VulkanError> {
        if textures.is_empty() {
            return Ok(());
        }
        // A frame in flight may use a texture that is replaced.
        self.device.wait_idle()?;
        let queue = self.device.queue();
        for id in self.to_free.drain(..) {
            self.renderer.free_texture(id).map_err(|error| ui_error(&error))?;
        }
        for (id, deltas) in &textures.set {
            for delta in deltas {
                self.renderer.set_texture(*queue, self.pool, *id, delta).map_err(|error| ui_error(&error))?;
            }
        }
        self.to_free.extend(&textures.free);
        Ok(())
    }

    /// Records the draws; requires open rendering to a target of `extent`.
    pub fn draw(
        &mut self,
        commands: vk::CommandBuffer,
        extent: vk::Extent2D,
        drawing: &UiDrawing,
    ) -> Result<(), VulkanError> {
        self.renderer
            .cmd_draw(commands, extent, drawing.pixels_per_point, &drawing.primitives)
            .map_err(|error| ui_error(&error))
    }
}

impl Drop for UiRenderer {
    fn drop(&mut self) {
        // SAFETY: the presenter waits for the device before it drops this; the renderer is dropped once.
        unsafe {
            ManuallyDrop::drop(&mut self.renderer);
            self.device.raw().destroy_command_pool(self.pool, None);
        }
    }
}

fn is_srgb(format: vk::Format) -> bool {
    matches!(format, vk::Format::B8G8R8A8_SRGB | vk::Format::R8G8B8A8_SRGB)
}

fn ui_error(error: &RendererError) -> VulkanError {
    match error {
        RendererError::Vulkan(result) => VulkanError::call("drawing", "user interface")(*result),
        other => VulkanError::Interface(other.to_string()),
    }
}
