//! Buffers whose content shaders see as texels, `utextureBuffer` and `uimageBuffer`.

use std::sync::Arc;

use ash::vk;
use gpu_allocator::MemoryLocation;

use super::{Buffer, Device, VulkanError};

/// What a texel is made of, unsigned integers. Every device can read and write both.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Texels {
    /// One of 32 bits.
    R32,
    /// Two of 32 bits.
    Rg32,
    /// Four of 32 bits.
    Rgba32,
}

impl Texels {
    /// Bytes of one.
    pub const fn size(self) -> u64 {
        match self {
            Self::R32 => 4,
            Self::Rg32 => 8,
            Self::Rgba32 => 16,
        }
    }

    fn format(self) -> vk::Format {
        match self {
            Self::R32 => vk::Format::R32_UINT,
            Self::Rg32 => vk::Format::R32G32_UINT,
            Self::Rgba32 => vk::Format::R32G32B32A32_UINT,
        }
    }
}

impl Buffer {
    /// Memory of `count` texels that only the device reads and writes.
    ///
    /// # Errors
    /// If that is more than the device can address.
    pub fn of_texels(
        device: &Arc<Device>,
        name: &str,
        count: u64,
        texels: Texels,
    ) -> Result<Self, VulkanError> {
        Self::in_memory(device, name, count * texels.size(), MemoryLocation::GpuOnly)?.seen_as(texels)
    }

    /// The same buffer, that `utextureBuffer` shows in texels of four words from its beginning, whatever part is bound.
    ///
    /// # Errors
    /// If it has more of them than the device can address.
    pub fn with_texels(self) -> Result<Self, VulkanError> {
        self.seen_as(Texels::Rgba32)
    }

    fn seen_as(mut self, texels: Texels) -> Result<Self, VulkanError> {
        let limit = u64::from(self.device.limits().max_texel_buffer_elements);
        let count = self.size / texels.size();
        if count > limit {
            let what = format!("buffer {} of {count} texels", self.name);
            return Err(VulkanError::Limit { what, limit });
        }
        let info = vk::BufferViewCreateInfo::default()
            .buffer(self.raw)
            .format(texels.format())
            .range(count * texels.size());
        // SAFETY: the buffer was made for such views; this one is destroyed before it, in `drop`.
        self.texels = unsafe { self.device.raw().create_buffer_view(&info, None) }
            .map_err(VulkanError::call("creation", format!("texels of buffer {}", self.name)))?;
        Ok(self)
    }
}
