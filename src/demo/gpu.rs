//! The device and its presenter.

use std::sync::Arc;

use raw_window_handle::HasDisplayHandle;
use winit::window::Window;

use super::error::DemoError;
use super::launch::Launch;
use crate::vulkan::{Device, DeviceInfo, Instance, InstanceOptions, PresentMode, Presenter, Surface};

/// A device that presents to the window.
pub(super) struct Gpu {
    // Dropped first.
    pub presenter: Presenter,
    pub device: Arc<Device>,
    pub modes: Vec<PresentMode>,
    pub devices: Vec<DeviceInfo>,
    /// Outlives the device.
    pub instance: Arc<Instance>,
}

impl Gpu {
    /// Opens the device of the command line, or the best one that can present to the window.
    pub fn open(window: &Arc<Window>, launch: &Launch) -> Result<Self, DemoError> {
        let display = window.display_handle().map_err(|error| DemoError::Window(error.to_string()))?;
        let options = InstanceOptions { validate: launch.validate, display: Some(display.as_raw()) };
        Self::open_on(&Instance::new(options)?, window, launch.device.as_deref(), PresentMode::default())
    }

    /// Opens a device after everything on the last one was dropped.
    pub fn open_on(
        instance: &Arc<Instance>,
        window: &Arc<Window>,
        requested: Option<&str>,
        mode: PresentMode,
    ) -> Result<Self, DemoError> {
        let surface = Arc::new(Surface::new(instance, window)?);
        let device = Device::open_for(instance, requested, Some(&surface))?;
        let size = window.inner_size();
        Ok(Self {
            presenter: Presenter::new(&device, &surface, [size.width, size.height], mode)?,
            modes: PresentMode::offered(&device, &surface)?,
            devices: Device::list(instance)?,
            device,
            instance: Arc::clone(instance),
        })
    }
}
