//! The handle of a logical device, which lives as long as anything made with it.

use std::ops::Deref;
use std::sync::Arc;

use super::Instance;
use super::instance::creation_lock;

/// The handle and functions of a logical device, destroyed when the [`Device`](super::Device) and all that it made are gone.
pub(super) struct RawDevice {
    pub functions: ash::Device,
    pub _instance: Arc<Instance>,
}

impl Deref for RawDevice {
    type Target = ash::Device;

    fn deref(&self) -> &ash::Device {
        &self.functions
    }
}

impl Drop for RawDevice {
    fn drop(&mut self) {
        let _guard = creation_lock();
        // SAFETY: every object of the device holds an `Arc` of this or of the `Device`, so none is left.
        unsafe { self.functions.destroy_device(None) };
    }
}
