//! The GPU passes that all methods share, one file each, with the shader of the same name.
//!
//! A pass owns its pipeline and its outputs, takes a struct of typed inputs and records itself into a
//! [`crate::vulkan::Frame`].

pub mod area_lights;
pub mod buffer_view;
pub mod cast_rays;
pub mod clusters;
pub mod combine;
pub mod direct_shading;
pub mod direct_shadows;
pub mod effect_view;
pub mod environment;
pub mod gbuffer;
pub mod geometry;
pub mod hit_buffers;
pub mod overlay;
pub mod reprojection;
pub mod scene_buffers;
pub mod sheets;
pub mod skip;
pub mod structs;
pub mod taa;
pub mod tracer;
mod tracer_hardware;
mod tracer_software;

use std::sync::Arc;

use crate::vulkan::{Device, Image, ImageDescription, VulkanError, vk};

/// An image that compute shaders write.
pub(crate) fn storage_image(
    device: &Arc<Device>,
    name: &str,
    format: vk::Format,
    extent: [u32; 2],
) -> Result<Image, VulkanError> {
    let usage = vk::ImageUsageFlags::STORAGE;
    Image::new(device, &ImageDescription { name, format, extent, layers: None, levels: 1, usage })
}

/// The same with array layers.
pub(crate) fn storage_image_array(
    device: &Arc<Device>,
    name: &str,
    format: vk::Format,
    extent: [u32; 2],
    layers: u32,
) -> Result<Image, VulkanError> {
    let usage = vk::ImageUsageFlags::STORAGE;
    Image::new(device, &ImageDescription { name, format, extent, layers: Some(layers), levels: 1, usage })
}

/// A count as shaders take it.
pub(crate) fn to_u32(count: usize) -> u32 {
    u32::try_from(count).unwrap_or(u32::MAX)
}
