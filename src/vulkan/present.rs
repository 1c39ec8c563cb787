//! Presents a picture and the user interface over it in a window.

use std::sync::Arc;

use ash::vk;

use super::present_slot::{Pane, Slot, Viewport};
use super::swapchain::Swapchain;
use super::ui::UiRenderer;
use super::{Device, PresentMode, Surface, UiDrawing, VulkanError};

/// Frames in flight, as many as the renderer's.
const IN_FLIGHT: usize = 2;
/// Timeout of acquiring a swapchain image, ns; after it the window counts as hidden.
const ACQUIRE_TIMEOUT: u64 = 100_000_000;

/// Outcome of presenting a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Presented {
    /// It was queued for presentation.
    Shown,
    /// It was skipped: the window has no area, is hidden, or was resized.
    Skipped,
}

/// Presents frames in a window. Recreates its swapchain whenever the window changed.
pub struct Presenter {
    swapchain: Option<Swapchain>,
    ui: Option<UiRenderer>,
    /// Target format of `ui`.
    ui_format: vk::Format,
    slots: Vec<Slot>,
    count: usize,
    extent: [u32; 2],
    mode: PresentMode,
    /// Whether the swapchain is out of date.
    stale: bool,
    ui_ms: f64,
    surface: Arc<Surface>,
    device: Arc<Device>,
}

impl Presenter {
    /// Presents to `surface`, whose window has `extent` pixels.
    pub fn new(
        device: &Arc<Device>,
        surface: &Arc<Surface>,
        extent: [u32; 2],
        mode: PresentMode,
    ) -> Result<Self, VulkanError> {
        let slots = (0..IN_FLIGHT).map(|_| Slot::new(device)).collect::<Result<_, _>>()?;
        Ok(Self {
            swapchain: None,
            ui: None,
            ui_format: vk::Format::UNDEFINED,
            slots,
            count: 0,
            extent,
            mode,
            stale: true,
            ui_ms: 0.0,
            surface: Arc::clone(surface),
            device: Arc::clone(device),
        })
    }

    /// Sets the window's size, pixels.
    pub fn resize(&mut self, extent: [u32; 2]) {
        self.stale |= self.extent != extent;
        self.extent = extent;
    }

    /// Releases the window for another device.
    pub fn close(&mut self) {
        // A lost device is idle too.
        let _ = self.device.wait_idle();
        self.ui = None;
        self.swapchain = None;
        self.stale = true;
    }

    /// Changes the present mode to one of [`PresentMode::offered`].
    pub fn set_mode(&mut self, mode: PresentMode) {
        self.stale |= self.mode != mode;
        self.mode = mode;
    }

    /// The present mode in use.
    pub fn mode(&self) -> PresentMode {
        self.swapchain.as_ref().map_or(self.mode, |swapchain| swapchain.mode)
    }

    /// Device time of drawing the interface in the last measured frame, ms.
    pub fn ui_ms(&self) -> f64 {
        self.ui_ms
    }

    /// Presents `panes` in `viewport`, on black, with `ui` over them.
    pub fn present(
        &mut self,
        panes: &[Pane<'_>],
        viewport: Viewport,
        ui: &UiDrawing,
    ) -> Result<Presented, VulkanError> {
        if self.stale && !self.recreate_swapchain()? {
            // The caller keeps the interface's textures, which are sent once, until there is a swapchain.
            return Ok(Presented::Skipped);
        }
        let (Some(swapchain), Some(drawer)) = (&self.swapchain, &mut self.ui) else {
            return Ok(Presented::Skipped);
        };
        drawer.update_textures(&ui.textures)?;
        let slot = &mut self.slots[self.count % IN_FLIGHT];
        if let Some(ms) = slot.finish()? {
            self.ui_ms = ms;
        }
        let Some(index) = acquire(swapchain, slot.acquired, &mut self.stale)? else {
            return Ok(Presented::Skipped);
        };
        let image = &swapchain.images[index as usize];
        slot.begin()?;
        let viewport = viewport.within([swapchain.extent.width, swapchain.extent.height]);
        slot.record((swapchain, image), panes, viewport, |commands| {
            drawer.draw(commands, swapchain.extent, ui)
        })?;
        slot.submit(image.drawn)?;
        self.count += 1;
        queue_present(&self.device, swapchain, index, &mut self.stale)
    }

    /// Recreates an out-of-date swapchain; false while the window cannot have one.
    fn recreate_swapchain(&mut self) -> Result<bool, VulkanError> {
        self.device.wait_idle()?;
        let old = self.swapchain.take();
        self.swapchain = Swapchain::new(&self.device, &self.surface, self.extent, self.mode, old)?;
        let Some(swapchain) = &self.swapchain else { return Ok(false) };
        self.stale = false;
        if self.ui.is_none() || self.ui_format != swapchain.format {
            self.ui = Some(UiRenderer::new(&self.device, swapchain.format, IN_FLIGHT)?);
            self.ui_format = swapchain.format;
        }
        Ok(true)
    }
}

impl Drop for Presenter {
    fn drop(&mut self) {
        let _ = self.device.wait_idle();
    }
}

/// Acquires the next image; none if the window changed or is hidden.
fn acquire(
    swapchain: &Swapchain,
    acquired: vk::Semaphore,
    stale: &mut bool,
) -> Result<Option<u32>, VulkanError> {
    // SAFETY: the semaphore is unsignalled: the frame that waited for it has finished.
    let result = unsafe {
        swapchain.functions.acquire_next_image(swapchain.raw, ACQUIRE_TIMEOUT, acquired, vk::Fence::null())
    };
    match result {
        Ok((index, suboptimal)) => {
            *stale |= suboptimal;
            Ok(Some(index))
        }
        Err(vk::Result::TIMEOUT | vk::Result::NOT_READY) => Ok(None),
        Err(vk::Result::ERROR_OUT_OF_DATE_KHR) => {
            *stale = true;
            Ok(None)
        }
        Err(result) => Err(VulkanError::call("acquisition", "swapchain image")(result)),
    }
}

fn queue_present(
    device: &Device,
    swapchain: &Swapchain,
    index: u32,
    stale: &mut bool,
) -> Result<Presented, VulkanError> {
    let (drawn, swapchains, indices) = ([swapchain.images[index as usize].drawn], [swapchain.raw], [index]);
    let info =
        vk::PresentInfoKHR::default().wait_semaphores(&drawn).swapchains(&swapchains).image_indices(&indices);
    // SAFETY: the image was acquired and its drawing submitted.
    match unsafe { swapchain.functions.queue_present(*device.queue(), &info) } {
        Ok(suboptimal) => *stale |= suboptimal,
        Err(vk::Result::ERROR_OUT_OF_DATE_KHR) => *stale = true,
        Err(result) => return Err(VulkanError::call("presentation", "frame")(result)),
    }
    Ok(Presented::Shown)
}
