//! Texel buffers: of four 32-bit words, `utextureBuffer`, or of RGBA8, `textureBuffer`.

use std::sync::Arc;

use ash::vk;

use super::{Buffer, Device, VulkanError};

/// Bytes per texel.
pub(super) const TEXEL_SIZE: u64 = 16;

impl Buffer {
    /// Adds a texel view of the whole buffer, which `utextureBuffer` bindings use regardless of the bound range.
    ///
    /// # Errors
    /// If its texels exceed `maxTexelBufferElements`.
    pub fn with_texels(self) -> Result<Self, VulkanError> {
        self.with_view(vk::Format::R32G32B32A32_UINT, TEXEL_SIZE)
    }

    /// A buffer that shaders read as a `textureBuffer` of RGBA8, and as nothing else: `maxStorageBufferRange` does not matter.
    ///
    /// # Errors
    /// If there are more than [`Self::most_rgba8_texels`].
    pub fn of_rgba8_texels(device: &Arc<Device>, name: &str, texels: &[u8]) -> Result<Self, VulkanError> {
        let buffer =
            Self::in_memory(device, name, texels.len() as u64, gpu_allocator::MemoryLocation::GpuOnly)?;
        buffer.fill(texels)?;
        buffer.with_view(vk::Format::R8G8B8A8_UNORM, 4)
    }

    /// How many texels a buffer of them can have.
    pub fn most_rgba8_texels(device: &Device) -> u64 {
        u64::from(device.limits().max_texel_buffer_elements)
    }

    fn with_view(mut self, format: vk::Format, texel_size: u64) -> Result<Self, VulkanError> {
        let limit = u64::from(self.device.limits().max_texel_buffer_elements);
        let count = self.size / texel_size;
        if count > limit {
            let what = format!("buffer {} of {count} texels", self.name);
            return Err(VulkanError::Limit { what, limit });
        }
        let info =
            vk::BufferViewCreateInfo::default().buffer(self.raw).format(format).range(count * texel_size);
        // SAFETY: the buffer was made for such views; this one is destroyed before it, in `drop`.
        self.texels = unsafe { self.device.raw().create_buffer_view(&info, None) }
            .map_err(VulkanError::call("creation", format!("texels of buffer {}", self.name)))?;
        Ok(self)
    }
}
