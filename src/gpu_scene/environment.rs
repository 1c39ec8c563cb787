//! The environment's map in device memory.
//!
//! In: the environment of a scene. Out: images for shaders/include/environment.glsl: the map, and the map without its suns.

use std::sync::Arc;

use glam::{Vec3, Vec4};

use super::Named;
use crate::scene::{Environment, EnvironmentMap, Pose, Scene};
use crate::vulkan::{Buffer, Device, Image, Sampler, VulkanError, vk};

/// Largest value of `VK_FORMAT_E5B9G9R9_UFLOAT_PACK32`.
const LARGEST: f32 = 65_408.0;

/// The environment's map: shared exponents, as its range is wide and no texel may be lost.
pub struct EnvironmentTexture {
    /// One white texel where there is no map.
    image: Image,
    /// The map without its suns, where it has any.
    sky: Option<Image>,
    /// Repeats to the sides, ends at the poles.
    sampler: Sampler,
    /// The cumulative distribution of the sky's luminance, rows first, and its integral in units of texels; a single 0 without a map.
    distribution: Buffer,
    map: Option<Arc<EnvironmentMap>>,
    /// Texels hold radiance over this power of two.
    scale: f32,
}

impl EnvironmentTexture {
    /// Uploads the map.
    pub fn new(device: &Arc<Device>, environment: Option<&Environment>) -> Result<Self, VulkanError> {
        let map = environment.and_then(|environment| environment.map.clone());
        let (width, height, texels) = map.as_ref().map_or((1, 1, &[Vec3::ONE][..]), |map| map.texels());
        let brightest = texels.iter().map(|texel| texel.max_element()).fold(0.0, f32::max);
        let scale = (brightest / LARGEST).max(f32::MIN_POSITIVE).log2().ceil().max(0.0).exp2();
        let upload = |name, texels: &[Vec3]| {
            let packed: Vec<u32> = texels.iter().map(|&texel| pack(texel / scale)).collect();
            let level = (width as u32, height as u32, bytemuck::cast_slice(&packed).to_vec());
            Image::with_levels(device, name, vk::Format::E5B9G9R9_UFLOAT_PACK32, &[level])
        };
        let sky = map.as_ref().and_then(|map| map.sky()).map(|sky| upload("sky", sky.texels().2));
        let sampled = map.as_ref().map(|map| map.sky().unwrap_or(map));
        let mut distribution = sampled.map_or_else(|| vec![0.0], EnvironmentMap::distribution);
        if let Some(integral) = distribution.last_mut() {
            *integral /= scale;
        }
        let modes = [vk::SamplerAddressMode::REPEAT, vk::SamplerAddressMode::CLAMP_TO_EDGE];
        Ok(Self {
            image: upload("environment", texels)?,
            sky: sky.transpose()?,
            sampler: Sampler::linear(device, modes)?,
            distribution: Buffer::with_data(device, "environment_distribution", &distribution)?,
            map,
            scale,
        })
    }

    /// Part of the scene set.
    pub fn resources(&self) -> [Named<'_>; 3] {
        [
            ("environment_map", (&self.image, &self.sampler).into()),
            ("sky_map", (self.sky.as_ref().unwrap_or(&self.image), &self.sampler).into()),
            ("environment_distribution", (&self.distribution).into()),
        ]
    }

    /// Whether this is the map of an environment.
    pub fn is_of(&self, environment: Option<&Environment>) -> bool {
        is_same_map(self.map.as_ref(), environment.and_then(|environment| environment.map.as_ref()))
    }

    /// For `FrameUniforms::background`.
    pub fn background(&self, scene: &Scene, pose: &Pose) -> Vec4 {
        match &pose.environment {
            Some(environment) => (environment.radiance * self.scale).extend(environment.rotation),
            None => scene.background.extend(0.0),
        }
    }
}

/// Whether two environments have one map, or none.
pub(crate) fn is_same_map(map: Option<&Arc<EnvironmentMap>>, other: Option<&Arc<EnvironmentMap>>) -> bool {
    map.map(Arc::as_ptr) == other.map(Arc::as_ptr)
}

/// Three mantissas of 9 bits and their exponent (Vulkan 1.3, 43.1.4, "Shared Exponent to RGB" reversed).
fn pack(colour: Vec3) -> u32 {
    let colour = colour.clamp(Vec3::ZERO, Vec3::splat(LARGEST));
    let exponent = colour.max_element().max(f32::MIN_POSITIVE).log2().floor().max(-16.0) as i32 + 1;
    let mantissas = |exponent: i32| colour * f32::exp2((9 - exponent) as f32) + 0.5;
    // Rounding may reach the next power of two.
    let exponent = exponent + i32::from(mantissas(exponent).max_element() >= 512.0);
    let [r, g, b] = mantissas(exponent).to_array().map(|mantissa| mantissa as u32);
    r | g << 9 | b << 18 | ((exponent + 15) as u32) << 27
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_survive_packing() {
        let unpack = |packed: u32| {
            let mantissas = [packed, packed >> 9, packed >> 18].map(|bits| (bits & 511) as f32);
            Vec3::from(mantissas) * f32::exp2((packed >> 27) as f32 - 24.0)
        };
        for colour in [
            Vec3::ZERO,
            Vec3::ONE,
            Vec3::new(0.9999, 0.5, 0.001),
            Vec3::new(65_408.0, 1.0, 300.0),
            Vec3::splat(3e-7),
            Vec3::new(1e9, 0.0, 0.0),
        ] {
            let most = colour.max_element().min(LARGEST);
            let error = (unpack(pack(colour)) - colour.min(Vec3::splat(LARGEST))).abs().max_element();
            assert!(error <= most / 512.0 + f32::exp2(-25.0), "{colour} became {}", unpack(pack(colour)));
        }
    }
}
