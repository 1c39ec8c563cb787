//! Texel buffers of four 32-bit words, `utextureBuffer`.

use ash::vk;

use super::{Buffer, VulkanError};

/// Bytes per texel.
pub(super) const TEXEL_SIZE: u64 = 16;

impl Buffer {
    /// Adds a texel view of the whole buffer, which `utextureBuffer` bindings use regardless of the bound range.
    ///
    /// # Errors
    /// If its texels exceed `maxTexelBufferElements`.
    pub fn with_texels(mut self) -> Result<Self, VulkanError> {
        let limit = u64::from(self.device.limits().max_texel_buffer_elements);
        let count = self.size / TEXEL_SIZE;
        if count > limit {
            let what = format!("buffer {} of {count} texels", self.name);
            return Err(VulkanError::Limit { what, limit });
        }
        let info = vk::BufferViewCreateInfo::default()
            .buffer(self.raw)
            .format(vk::Format::R32G32B32A32_UINT)
            .range(count * TEXEL_SIZE);
        // SAFETY: the buffer was made for such views; this one is destroyed before it, in `drop`.
        self.texels = unsafe { self.device.raw().create_buffer_view(&info, None) }
            .map_err(VulkanError::call("creation", format!("texels of buffer {}", self.name)))?;
        Ok(self)
    }
}
