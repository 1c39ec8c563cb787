//! Random numbers of rays: a table of spatiotemporal blue noise (Wolfe et al. 2022), made by examples/blue_noise.rs.

use std::sync::Arc;

use crate::vulkan::{Buffer, Device, VulkanError};

/// 32 frames of 64 x 64 texels of two bytes. Twin: shaders/include/noise.glsl.
static TABLE: &[u8] = include_bytes!("blue_noise.bin");

/// The table on a device.
pub fn table(device: &Arc<Device>) -> Result<Buffer, VulkanError> {
    Buffer::with_data(device, "blue_noise", TABLE)
}
