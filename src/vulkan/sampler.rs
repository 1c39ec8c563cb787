//! Texture samplers.

use std::sync::Arc;

use ash::vk;

use super::{Device, VulkanError};

/// A trilinear sampler.
pub struct Sampler {
    pub(super) raw: vk::Sampler,
    device: Arc<Device>,
}

impl Sampler {
    /// Makes a sampler for surface textures, with the modes along u and v; `nearest`: where they are magnified, the nearest texel
    /// shows.
    pub fn for_textures(
        device: &Arc<Device>,
        [u, v]: [vk::SamplerAddressMode; 2],
        nearest: bool,
    ) -> Result<Self, VulkanError> {
        let info = vk::SamplerCreateInfo::default()
            .address_mode_u(u)
            .address_mode_v(v)
            .mag_filter(if nearest { vk::Filter::NEAREST } else { vk::Filter::LINEAR })
            .min_filter(vk::Filter::LINEAR)
            .mipmap_mode(vk::SamplerMipmapMode::LINEAR)
            .max_lod(vk::LOD_CLAMP_NONE);
        // SAFETY: `info` asks for nothing that is not core.
        let raw = unsafe { device.raw().create_sampler(&info, None) }
            .map_err(VulkanError::call("creation", "sampler"))?;
        device.set_name(raw, "texture sampler");
        Ok(Self { raw, device: Arc::clone(device) })
    }
}

impl Drop for Sampler {
    fn drop(&mut self) {
        // SAFETY: the owner waits for the device before dropping what a submitted frame uses.
        unsafe { self.device.raw().destroy_sampler(self.raw, None) };
    }
}
