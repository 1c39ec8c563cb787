//! Buffers of which shaders read texels of four 32-bit words.
//!
//! They hold what a storage buffer could hold as well, but CPU drivers are faster with them: llvmpipe reads a texel with
//! one 16-byte load for each lane, and storage buffers word by word.

use std::sync::Arc;

use ash::vk;
use bytemuck::Pod;

use super::{Buffer, Device, VulkanError};

/// Bytes of a texel.
const TEXEL: u64 = 16;

/// A buffer with a view of all of it.
pub struct TexelBuffer {
    pub(super) view: vk::BufferView,
    buffer: Buffer,
    device: Arc<Device>,
}

impl TexelBuffer {
    /// Holds `data`, whose elements are of whole texels.
    ///
    /// # Errors
    /// Where the device fails, or cannot address so many texels.
    pub fn with_data<T: Pod>(device: &Arc<Device>, name: &str, data: &[T]) -> Result<Self, VulkanError> {
        assert!((size_of::<T>() as u64).is_multiple_of(TEXEL), "{name}: elements are of whole texels");
        let buffer = Buffer::with_data(device, name, data)?;
        let limit = u64::from(device.limits().max_texel_buffer_elements);
        let texels = buffer.size() / TEXEL;
        if texels > limit {
            return Err(VulkanError::Limit { what: format!("buffer {name} of {texels} texels"), limit });
        }
        let info = vk::BufferViewCreateInfo::default()
            .buffer(buffer.raw)
            .format(vk::Format::R32G32B32A32_UINT)
            .range(vk::WHOLE_SIZE);
        // SAFETY: the buffer may be viewed, every device offers the format; the view is destroyed in `drop`.
        let view = unsafe { device.raw().create_buffer_view(&info, None) }
            .map_err(VulkanError::call("creation", format!("view of buffer {name}")))?;
        Ok(Self { view, buffer, device: Arc::clone(device) })
    }

    /// The buffer itself, to be copied to.
    pub fn buffer(&self) -> &Buffer {
        &self.buffer
    }
}

impl Drop for TexelBuffer {
    fn drop(&mut self) {
        // SAFETY: the owner waits for the device before dropping what a submitted frame uses.
        unsafe { self.device.raw().destroy_buffer_view(self.view, None) };
    }
}
