//! The GPU passes of a frame, one file each, with the shader of the same name.
//!
//! A pass owns its pipeline and its outputs, takes a struct of typed inputs and records itself into a
//! [`crate::vulkan::Frame`].

pub mod buffer_view;
pub mod cast_rays;
mod closed;
pub mod clusters;
pub mod combine;
pub mod direct_shading;
pub mod direct_shadows;
pub mod gbuffer;
pub mod indirect_reprojection;
pub mod indirect_shading;
pub mod indirect_shadows;
pub mod outlines;
pub mod overlay;
pub mod scene_buffers;
pub mod set_history;
pub mod shadow_tiles;
pub mod still;
pub mod structs;
pub mod tracer;
mod tracer_hardware;
mod tracer_software;
pub mod vpl_light;
pub mod vpl_sets;
mod work;

use std::sync::Arc;

use crate::vulkan::{Buffer, Device, Image, ImageDescription, VulkanError, vk};

/// An image of the picture's size that compute shaders write.
fn storage_image(
    device: &Arc<Device>,
    name: &str,
    format: vk::Format,
    extent: [u32; 2],
) -> Result<Image, VulkanError> {
    let usage = vk::ImageUsageFlags::STORAGE;
    Image::new(device, &ImageDescription { name, format, extent, layers: None, levels: 1, usage })
}

/// A list with room for `tiles` tiles of the picture; see shaders/include/tile_list.glsl.
fn tile_list(device: &Arc<Device>, name: &str, tiles: u32) -> Result<Buffer, VulkanError> {
    const HEADER_WORDS: u64 = 4;
    Buffer::new(device, name, (HEADER_WORDS + u64::from(tiles)) * 4)
}

/// Pixels of a thread, one below the other, in passes whose pixels share nothing: to start a vector of threads that has
/// nothing to do takes llvmpipe a third of the time of combining its pixels.
fn rows_of_thread(device: &Device) -> u32 {
    if device.is_cpu() { 4 } else { 1 }
}

/// A count as shaders take it.
fn to_u32(count: usize) -> u32 {
    u32::try_from(count).unwrap_or(u32::MAX)
}
