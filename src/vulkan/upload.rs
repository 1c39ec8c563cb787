//! Blocking transfers to and from device memory, outside of frames.

use std::sync::Arc;

use ash::vk;
use bytemuck::Pod;
use gpu_allocator::MemoryLocation;

use super::access::Access;
use super::barrier::barrier_for_image;
use super::{Buffer, Device, Image, VulkanError};

impl Buffer {
    /// Creates a device-local buffer with the content `data`.
    pub fn with_data<T: Pod>(device: &Arc<Device>, name: &str, data: &[T]) -> Result<Self, VulkanError> {
        let bytes: &[u8] = bytemuck::cast_slice(data);
        let buffer = Self::new(device, name, bytes.len() as u64)?;
        buffer.fill(bytes)?;
        Ok(buffer)
    }

    /// Copies `bytes`, which fit, to its beginning; waits for the device.
    pub(super) fn fill(&self, bytes: &[u8]) -> Result<(), VulkanError> {
        if bytes.is_empty() {
            return Ok(());
        }
        let device = &self.device;
        let staging = staging_with(device, &self.name, bytes)?;
        device.run_once(|commands| {
            let region = [vk::BufferCopy::default().size(bytes.len() as u64)];
            // SAFETY: both buffers are at least as long as `bytes` and live until the wait is over.
            unsafe { device.raw().cmd_copy_buffer(commands, staging.raw, self.raw, &region) };
        })
    }

    /// Reads the buffer's content back; waits for the device.
    pub fn read(&self, device: &Arc<Device>) -> Result<Vec<u8>, VulkanError> {
        device.wait_idle()?;
        let target = Self::in_memory(device, "readback", self.size, MemoryLocation::GpuToCpu)?;
        device.run_once(|commands| {
            let region = [vk::BufferCopy::default().size(self.size)];
            // SAFETY: both buffers have the same size and live until the wait is over.
            unsafe { device.raw().cmd_copy_buffer(commands, self.raw, target.raw, &region) };
        })?;
        Ok(mapped(&target)[..usize_of(self.size)].to_vec())
    }
}

impl Image {
    /// Creates a texture with its mip chain, in shader-read layout. Each level is (width, height, texels of the format).
    pub fn with_levels(
        device: &Arc<Device>,
        name: &str,
        format: vk::Format,
        levels: &[(u32, u32, Vec<u8>)],
    ) -> Result<Self, VulkanError> {
        let image = Self::new(
            device,
            &super::ImageDescription {
                name,
                format,
                extent: [levels[0].0, levels[0].1],
                layers: None,
                levels: u32::try_from(levels.len()).unwrap_or(1),
                usage: vk::ImageUsageFlags::empty(),
            },
        )?;
        let bytes: Vec<u8> = levels.iter().flat_map(|level| level.2.iter().copied()).collect();
        let staging = staging_with(device, name, &bytes)?;
        let regions = level_regions(levels);
        device.run_once(|commands| {
            // SAFETY: the staging buffer holds every level, one after the other, as the regions say.
            unsafe {
                barrier_for_image(device, commands, &image, Access::TransferWrite);
                device.raw().cmd_copy_buffer_to_image(
                    commands,
                    staging.raw,
                    image.raw,
                    vk::ImageLayout::TRANSFER_DST_OPTIMAL,
                    &regions,
                );
                barrier_for_image(device, commands, &image, Access::GraphicsRead);
            }
        })?;
        Ok(image)
    }

    /// Replaces mip level 0 by `texels`, tightly packed rows of the format; waits for the device.
    ///
    /// # Panics
    /// If `texels` are not as many as the image has, of `texel_bytes` each.
    pub fn write(&self, device: &Arc<Device>, texels: &[u8], texel_bytes: u64) -> Result<(), VulkanError> {
        let [width, height] = self.extent();
        assert_eq!(texels.len() as u64, u64::from(width) * u64::from(height) * texel_bytes, "{}", self.name);
        device.wait_idle()?;
        let staging = staging_with(device, &self.name, texels)?;
        let region = [whole_layer(self, 0)];
        device.run_once(|commands| {
            // SAFETY: the staging buffer holds width * height texels; both live until the wait is over.
            unsafe {
                barrier_for_image(device, commands, self, Access::TransferWrite);
                device.raw().cmd_copy_buffer_to_image(
                    commands,
                    staging.raw,
                    self.raw,
                    vk::ImageLayout::TRANSFER_DST_OPTIMAL,
                    &region,
                );
            }
        })
    }

    /// Reads back layer `layer` of mip level 0, tightly packed rows; waits for the device.
    pub fn read_layer(
        &self,
        device: &Arc<Device>,
        layer: u32,
        texel_bytes: u64,
    ) -> Result<Vec<u8>, VulkanError> {
        device.wait_idle()?;
        let [width, height] = self.extent();
        let size = u64::from(width) * u64::from(height) * texel_bytes;
        let target = Buffer::in_memory(device, "readback", size, MemoryLocation::GpuToCpu)?;
        let region = [whole_layer(self, layer)];
        device.run_once(|commands| {
            // SAFETY: the target holds width * height texels; the image lives until the wait is over.
            unsafe {
                barrier_for_image(device, commands, self, Access::TransferRead);
                device.raw().cmd_copy_image_to_buffer(
                    commands,
                    self.raw,
                    vk::ImageLayout::TRANSFER_SRC_OPTIMAL,
                    target.raw,
                    &region,
                );
            }
        })?;
        Ok(mapped(&target)[..usize_of(size)].to_vec())
    }
}

/// Mip level 0 of a layer, in a buffer of tightly packed rows.
fn whole_layer(image: &Image, layer: u32) -> vk::BufferImageCopy {
    let [width, height] = image.extent();
    vk::BufferImageCopy::default()
        .image_subresource(vk::ImageSubresourceLayers {
            aspect_mask: image.aspect(),
            mip_level: 0,
            base_array_layer: layer,
            layer_count: 1,
        })
        .image_extent(vk::Extent3D { width, height, depth: 1 })
}

fn staging_with(device: &Arc<Device>, name: &str, bytes: &[u8]) -> Result<Buffer, VulkanError> {
    let mut staging = Buffer::in_memory(
        device,
        &format!("staging for {name}"),
        bytes.len() as u64,
        MemoryLocation::CpuToGpu,
    )?;
    if let Some(target) = staging.allocation.mapped_slice_mut() {
        target[..bytes.len()].copy_from_slice(bytes);
    }
    Ok(staging)
}

fn level_regions(levels: &[(u32, u32, Vec<u8>)]) -> Vec<vk::BufferImageCopy> {
    let mut offset = 0;
    let mut regions = Vec::with_capacity(levels.len());
    for (mip_level, (width, height, texels)) in (0..).zip(levels) {
        regions.push(
            vk::BufferImageCopy::default()
                .buffer_offset(offset)
                .image_subresource(vk::ImageSubresourceLayers {
                    aspect_mask: vk::ImageAspectFlags::COLOR,
                    mip_level,
                    base_array_layer: 0,
                    layer_count: 1,
                })
                .image_extent(vk::Extent3D { width: *width, height: *height, depth: 1 }),
        );
        offset += texels.len() as u64;
    }
    regions
}

pub(super) fn mapped(buffer: &Buffer) -> &[u8] {
    buffer.allocation.mapped_slice().unwrap_or_default()
}

fn usize_of(size: u64) -> usize {
    usize::try_from(size).unwrap_or(usize::MAX)
}
