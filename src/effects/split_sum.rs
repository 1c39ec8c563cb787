//! Light of the environment in what reflections hit, by the split sum (B. Karis, *Real Shading in Unreal Engine 4*, 2013).
//!
//! In: the environment's map. Out: its mean over the GGX lobe around each direction, by roughness, which
//! `shaders/include/split_sum.glsl` reads.

use std::sync::Arc;

use crate::gpu_scene::environment::is_same_map;
use crate::passes::storage_image;
use crate::scene::{Environment, EnvironmentMap};
use crate::vulkan::{ComputePipeline, Device, Frame, Image, SharedSet, Upload, VulkanError, shaders, vk};

/// Levels of roughness, this part of 1 apart. Twin: shaders/include/split_sum.glsl.
pub const LEVELS: u32 = 5;
/// Texels of a level. Twin: shaders/include/split_sum.glsl.
pub const LEVEL_SIZE: [u32; 2] = [128, 64];

/// The environment by roughness: 320 KiB.
pub struct SplitSum {
    prefilter: ComputePipeline,
    prefiltered: Image,
    /// The map that it is of.
    of: Option<Option<Arc<EnvironmentMap>>>,
}

impl SplitSum {
    /// Makes the pipeline and the image.
    ///
    /// # Errors
    /// Where the device fails.
    pub fn new(device: &Arc<Device>) -> Result<Self, VulkanError> {
        let [width, height] = LEVEL_SIZE;
        let format = vk::Format::R16G16B16A16_SFLOAT;
        Ok(Self {
            prefilter: ComputePipeline::new(
                device,
                "environment_prefilter",
                shaders::ENVIRONMENT_PREFILTER_COMP,
            )?,
            prefiltered: storage_image(device, "prefiltered_environment", format, [width, LEVELS * height])?,
            of: None,
        })
    }

    /// Levels below each other, from roughness `1 / LEVELS` to 1, RGBA16F; each is an equirectangular map as the scene's, which is
    /// neither turned nor scaled.
    pub fn image(&self) -> &Image {
        &self.prefiltered
    }

    /// Filters the map of the scene in `scene`, unless it was the last time.
    ///
    /// # Errors
    /// Where the device fails.
    pub fn follow(
        &mut self,
        frame: &mut Frame<'_>,
        (uniforms, scene): (&Upload, &SharedSet<'_>),
        environment: Option<&Environment>,
    ) -> Result<(), VulkanError> {
        let map = environment.and_then(|environment| environment.map.clone());
        if self.of.as_ref().is_some_and(|of| is_same_map(of.as_ref(), map.as_ref())) {
            return Ok(());
        }
        frame
            .pass("environment_prefilter", &self.prefilter)
            .read("frame_uniforms", uniforms)
            .shared(scene)
            .write("prefiltered_environment", &self.prefiltered)
            .dispatch_over(self.prefiltered.extent())?;
        self.of = Some(map);
        Ok(())
    }
}
