//! The Vulkan surface of a window.

use std::sync::Arc;

use ash::{khr, vk};
use raw_window_handle::{HandleError, HasDisplayHandle, HasWindowHandle};

use super::{Instance, VulkanError};

/// A window's surface.
pub struct Surface {
    functions: khr::surface::Instance,
    raw: vk::SurfaceKHR,
    instance: Arc<Instance>,
    // Dropped after the surface.
    _window: Arc<dyn Window>,
}

/// A window of any library.
trait Window: Send + Sync {}

impl<W: Send + Sync> Window for W {}

impl Surface {
    /// Creates the surface of `window` and keeps the window open; `instance` was created for its display.
    pub fn new<W>(instance: &Arc<Instance>, window: &Arc<W>) -> Result<Self, VulkanError>
    where
        W: HasDisplayHandle + HasWindowHandle + Send + Sync + 'static,
    {
        let no_handle = |error: HandleError| VulkanError::NoDevice(format!("the window has gone: {error}"));
        let display = window.display_handle().map_err(no_handle)?.as_raw();
        let handle = window.window_handle().map_err(no_handle)?.as_raw();
        // SAFETY: the window is kept until the surface is gone; the instance has its extensions.
        let raw =
            unsafe { ash_window::create_surface(instance.entry(), instance.raw(), display, handle, None) }
                .map_err(VulkanError::call("creation", "surface of the window"))?;
        Ok(Self {
            functions: khr::surface::Instance::new(instance.entry(), instance.raw()),
            raw,
            instance: Arc::clone(instance),
            _window: Arc::<W>::clone(window),
        })
    }

    /// Instance.
    pub fn instance(&self) -> &Arc<Instance> {
        &self.instance
    }

    pub(super) fn raw(&self) -> vk::SurfaceKHR {
        self.raw
    }

    pub(super) fn supports(&self, device: vk::PhysicalDevice, queue_family: u32) -> bool {
        // SAFETY: the device is of the surface's instance and has that queue family.
        unsafe { self.functions.get_physical_device_surface_support(device, queue_family, self.raw) }
            .unwrap_or(false)
    }

    pub(super) fn capabilities(
        &self,
        device: vk::PhysicalDevice,
    ) -> Result<vk::SurfaceCapabilitiesKHR, VulkanError> {
        // SAFETY: the device is of the surface's instance.
        unsafe { self.functions.get_physical_device_surface_capabilities(device, self.raw) }
            .map_err(VulkanError::call("query", "window"))
    }

    pub(super) fn formats(
        &self,
        device: vk::PhysicalDevice,
    ) -> Result<Vec<vk::SurfaceFormatKHR>, VulkanError> {
        // SAFETY: the device is of the surface's instance.
        unsafe { self.functions.get_physical_device_surface_formats(device, self.raw) }
            .map_err(VulkanError::call("query of formats", "window"))
    }

    pub(super) fn present_modes(
        &self,
        device: vk::PhysicalDevice,
    ) -> Result<Vec<vk::PresentModeKHR>, VulkanError> {
        // SAFETY: the device is of the surface's instance.
        unsafe { self.functions.get_physical_device_surface_present_modes(device, self.raw) }
            .map_err(VulkanError::call("query of present modes", "window"))
    }
}

impl Drop for Surface {
    fn drop(&mut self) {
        // SAFETY: swapchains keep an `Arc` of their surface, so none is left.
        unsafe { self.functions.destroy_surface(self.raw, None) };
    }
}
