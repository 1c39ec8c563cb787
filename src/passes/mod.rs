//! The GPU passes that all methods share, one file each, with the shader of the same name.
//!
//! A pass owns its pipeline and its outputs, takes a struct of typed inputs and records itself into a
//! [`crate::vulkan::Frame`].

pub mod buffer_view;
pub mod cast_rays;
pub mod clock;
pub mod combine;
pub mod direct_shading;
pub mod direct_shadows;
pub mod effect_view;
pub mod frame_inputs;
pub mod gbuffer;
pub mod history;
pub mod hits;
pub mod overlay;
pub mod reprojection;
pub mod spatial_filter;
pub mod still;
pub mod taa;
pub mod thin_surfaces;

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

/// An image with array layers that compute shaders write.
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
