//! Pipeline layouts from shader reflection.

use std::sync::Arc;

use ash::vk;

use super::raw_device::RawDevice;
use super::reflect::{Binding, BindingKind};
use super::shared_set::SHARED_SET;
use super::{Device, Reflection, VulkanError};

/// Descriptor set that a pass binds by name.
pub(super) const PASS_SET: u32 = 0;
/// Descriptor set that changes per draw.
pub(super) const MATERIAL_SET: u32 = 2;

impl BindingKind {
    pub(super) fn descriptor_type(self) -> vk::DescriptorType {
        match self {
            Self::UniformBuffer => vk::DescriptorType::UNIFORM_BUFFER,
            Self::StorageBuffer | Self::ReadOnlyStorageBuffer => vk::DescriptorType::STORAGE_BUFFER,
            Self::TexelBuffer => vk::DescriptorType::UNIFORM_TEXEL_BUFFER,
            Self::SampledImage => vk::DescriptorType::SAMPLED_IMAGE,
            Self::StorageImage => vk::DescriptorType::STORAGE_IMAGE,
            Self::CombinedImageSampler => vk::DescriptorType::COMBINED_IMAGE_SAMPLER,
            Self::AccelerationStructure => vk::DescriptorType::ACCELERATION_STRUCTURE_KHR,
        }
    }
}

/// Pipeline layout, descriptor set layouts and the reflection they come from.
pub(super) struct Layout {
    pub raw: vk::PipelineLayout,
    /// The layouts of sets 0 to 2; the device owns that of the shared one.
    pub sets: Vec<vk::DescriptorSetLayout>,
    /// Whether the shaders read the shared set.
    pub shares: bool,
    pub reflection: Reflection,
    pub stages: vk::ShaderStageFlags,
    pub device: Arc<RawDevice>,
}

impl Layout {
    pub(super) fn new(
        device: &Device,
        name: &str,
        reflection: Reflection,
        stages: vk::ShaderStageFlags,
    ) -> Result<Self, VulkanError> {
        let limit = device.limits().max_push_constants_size;
        if reflection.push_size > limit {
            let what = format!("pass {name} with {} bytes of push constants", reflection.push_size);
            return Err(VulkanError::Limit { what, limit: u64::from(limit) });
        }
        device.shared_layout().check(name, &reflection)?;
        let shares = reflection.bindings.values().any(|binding| binding.set == SHARED_SET && binding.used);
        let mut layout = Self {
            raw: vk::PipelineLayout::null(),
            sets: Vec::new(),
            shares,
            reflection,
            stages,
            device: device.shared_raw(),
        };
        for set in [PASS_SET, SHARED_SET, MATERIAL_SET] {
            if set == SHARED_SET {
                layout.sets.push(device.shared_layout().raw);
                continue;
            }
            let bindings: Vec<_> = layout
                .reflection
                .bindings
                .values()
                .filter(|binding| binding.set == set)
                .map(|binding| {
                    vk::DescriptorSetLayoutBinding::default()
                        .binding(binding.binding)
                        .descriptor_type(binding.kind.descriptor_type())
                        .descriptor_count(1)
                        .stage_flags(stages)
                })
                .collect();
            let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings);
            // SAFETY: `info` is complete; the layout is destroyed in `drop`.
            let raw = unsafe { device.raw().create_descriptor_set_layout(&info, None) }
                .map_err(VulkanError::call("creation", format!("set layout of {name}")))?;
            layout.sets.push(raw);
        }
        let push = [vk::PushConstantRange::default().stage_flags(stages).size(layout.reflection.push_size)];
        let mut info = vk::PipelineLayoutCreateInfo::default().set_layouts(&layout.sets);
        if layout.reflection.push_size > 0 {
            info = info.push_constant_ranges(&push);
        }
        // SAFETY: the set layouts live as long as the pipeline layout.
        layout.raw = unsafe { device.raw().create_pipeline_layout(&info, None) }
            .map_err(VulkanError::call("creation", format!("layout of {name}")))?;
        Ok(layout)
    }

    /// The bindings of the pass's set.
    pub(super) fn pass_bindings(&self) -> impl Iterator<Item = (&str, &Binding)> {
        self.bindings_of(PASS_SET)
    }

    /// The bindings of the shared set that the shaders use.
    pub(super) fn shared_bindings(&self) -> impl Iterator<Item = (&str, &Binding)> {
        self.bindings_of(SHARED_SET).filter(|(_, binding)| binding.used)
    }

    fn bindings_of(&self, set: u32) -> impl Iterator<Item = (&str, &Binding)> {
        let bindings = self.reflection.bindings.iter().filter(move |(_, binding)| binding.set == set);
        bindings.map(|(name, binding)| (name.as_str(), binding))
    }
}

impl Drop for Layout {
    fn drop(&mut self) {
        // SAFETY: the owner waits for the device before dropping a pipeline that a submitted frame uses.
        unsafe {
            self.device.destroy_pipeline_layout(self.raw, None);
            for (_, set) in self.sets.iter().enumerate().filter(|(set, _)| *set != SHARED_SET as usize) {
                self.device.destroy_descriptor_set_layout(*set, None);
            }
        }
    }
}
