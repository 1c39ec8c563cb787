//! Descriptor sets of materials, which change per draw.

use std::sync::Arc;

use ash::vk;

use super::layout::MATERIAL_SET;
use super::{Device, GraphicsPipeline, Image, Sampler, VulkanError};

/// One descriptor set per material: its textures.
pub struct MaterialSets {
    pool: vk::DescriptorPool,
    pub(super) sets: Vec<vk::DescriptorSet>,
    device: Arc<Device>,
}

impl MaterialSets {
    /// Creates one set for each of `images` for `pipeline`, whose set 2 has `N` combined image samplers.
    pub fn new<const N: usize>(
        device: &Arc<Device>,
        pipeline: &GraphicsPipeline,
        images: &[[(&Image, &Sampler); N]],
    ) -> Result<Self, VulkanError> {
        let count = u32::try_from(images.len()).unwrap_or(u32::MAX).max(1);
        let sizes = [vk::DescriptorPoolSize {
            ty: vk::DescriptorType::COMBINED_IMAGE_SAMPLER,
            descriptor_count: count * N as u32,
        }];
        let info = vk::DescriptorPoolCreateInfo::default().max_sets(count).pool_sizes(&sizes);
        // SAFETY: `info` is complete; the pool is destroyed in `drop`.
        let pool = unsafe { device.raw().create_descriptor_pool(&info, None) }
            .map_err(VulkanError::call("creation", "material descriptors"))?;
        let mut made = Self { pool, sets: Vec::new(), device: Arc::clone(device) };
        let layout = pipeline.0.layout.sets[MATERIAL_SET as usize];
        for textures in images {
            let layouts = [layout];
            let info = vk::DescriptorSetAllocateInfo::default().descriptor_pool(pool).set_layouts(&layouts);
            let image_infos = textures.map(|(image, sampler)| {
                [vk::DescriptorImageInfo {
                    sampler: sampler.raw,
                    image_view: image.view,
                    image_layout: vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL,
                }]
            });
            // SAFETY: the pool was sized for these sets; images and samplers outlive their use.
            unsafe {
                let set = device
                    .raw()
                    .allocate_descriptor_sets(&info)
                    .map_err(VulkanError::call("allocation", "material descriptors"))?[0];
                let writes: [_; N] = std::array::from_fn(|binding| {
                    vk::WriteDescriptorSet::default()
                        .dst_set(set)
                        .dst_binding(binding as u32)
                        .descriptor_type(vk::DescriptorType::COMBINED_IMAGE_SAMPLER)
                        .image_info(&image_infos[binding])
                });
                device.raw().update_descriptor_sets(&writes, &[]);
                made.sets.push(set);
            }
        }
        Ok(made)
    }
}

impl Drop for MaterialSets {
    fn drop(&mut self) {
        // SAFETY: the owner waits for the device before dropping what a submitted frame uses.
        unsafe { self.device.raw().destroy_descriptor_pool(self.pool, None) };
    }
}
