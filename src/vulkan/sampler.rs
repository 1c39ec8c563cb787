//! Texture samplers.

use std::sync::Arc;

use ash::vk;

use super::{Device, VulkanError};

/// How a texture is read.
pub struct SamplerDescription {
    /// Address modes along u and v.
    pub modes: [vk::SamplerAddressMode; 2],
    /// Where it is magnified.
    pub magnified: vk::Filter,
    /// Within a level where it is minified.
    pub minified: vk::Filter,
    /// Between levels; none: the first level alone is read.
    pub levels: Option<vk::SamplerMipmapMode>,
}

/// A sampler.
pub struct Sampler {
    pub(super) raw: vk::Sampler,
    device: Arc<Device>,
}

impl Sampler {
    /// Makes a linear sampler of one level.
    pub fn linear(device: &Arc<Device>, modes: [vk::SamplerAddressMode; 2]) -> Result<Self, VulkanError> {
        let linear = vk::Filter::LINEAR;
        Self::new(device, &SamplerDescription { modes, magnified: linear, minified: linear, levels: None })
    }

    /// Makes a sampler.
    pub fn new(device: &Arc<Device>, of: &SamplerDescription) -> Result<Self, VulkanError> {
        let info = vk::SamplerCreateInfo::default()
            .address_mode_u(of.modes[0])
            .address_mode_v(of.modes[1])
            .mag_filter(of.magnified)
            .min_filter(of.minified)
            .mipmap_mode(of.levels.unwrap_or(vk::SamplerMipmapMode::NEAREST))
            // Rounds to the first level, yet tells minified from magnified.
            .max_lod(if of.levels.is_some() { vk::LOD_CLAMP_NONE } else { 0.25 });
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
