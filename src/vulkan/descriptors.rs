//! Resources into descriptor sets.

use ash::vk;

use super::reflect::{Binding, BindingKind};
use super::{Device, Image, Resource};

/// Writes resources into a set that was just allocated.
pub(super) fn write_descriptors(device: &Device, set: vk::DescriptorSet, bound: &[(Binding, Resource<'_>)]) {
    let bound: Vec<_> =
        bound.iter().map(|(binding, resource)| (binding, Descriptor::of(binding.kind, resource))).collect();
    // The writes point into these until the call.
    let mut structures: Vec<_> = bound.iter().map(|(_, descriptor)| descriptor.structures()).collect();
    let writes: Vec<_> = bound
        .iter()
        .zip(&mut structures)
        .map(|((binding, descriptor), structures)| {
            let write = vk::WriteDescriptorSet::default()
                .dst_set(set)
                .dst_binding(binding.binding)
                .descriptor_type(binding.kind.descriptor_type());
            match descriptor {
                Descriptor::Buffer(info) => write.buffer_info(info),
                Descriptor::Texels(view) => write.texel_buffer_view(view),
                Descriptor::Image(info) => write.image_info(info),
                Descriptor::Structure(_) => write.descriptor_count(1).push_next(structures),
            }
        })
        .collect();
    // SAFETY: the set was just allocated with these bindings; the resources outlive the frame.
    unsafe { device.raw().update_descriptor_sets(&writes, &[]) };
}

/// Descriptor info of a resource.
enum Descriptor {
    Buffer([vk::DescriptorBufferInfo; 1]),
    Texels([vk::BufferView; 1]),
    Image([vk::DescriptorImageInfo; 1]),
    Structure([vk::AccelerationStructureKHR; 1]),
}

impl Descriptor {
    fn of(kind: BindingKind, resource: &Resource<'_>) -> Self {
        match resource {
            Resource::Buffer(slice) if kind == BindingKind::TexelBuffer => {
                Self::Texels([slice.buffer.texels])
            }
            Resource::Buffer(slice) => Self::Buffer([vk::DescriptorBufferInfo {
                buffer: slice.buffer.raw,
                offset: slice.offset,
                range: slice.size,
            }]),
            Resource::Image(image) => Self::image(image, vk::Sampler::null()),
            Resource::Sampled(image, sampler) => Self::image(image, sampler.raw),
            Resource::TopLevel(structure) => Self::Structure([structure.raw]),
        }
    }

    fn image(image: &Image, sampler: vk::Sampler) -> Self {
        let (image_view, image_layout) = (image.view, image.tracker.layout());
        Self::Image([vk::DescriptorImageInfo { sampler, image_view, image_layout }])
    }

    fn structures(&self) -> vk::WriteDescriptorSetAccelerationStructureKHR<'_> {
        let info = vk::WriteDescriptorSetAccelerationStructureKHR::default();
        match self {
            Self::Structure(structures) => info.acceleration_structures(structures),
            _ => info,
        }
    }
}
