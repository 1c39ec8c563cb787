//! The descriptor set that all passes of a frame share: set 1, the scene.
//!
//! In: the declarations of shaders/include/scene_set.glsl and the resources of a frame. Out: one set, written once a frame. A
//! shader that uses set 1 declares all of it, so one layout serves every pipeline. A resource that no pass reads may be left out.

use std::collections::BTreeMap;

use ash::vk;

use super::descriptors::write_descriptors;
use super::reflect::{Binding, BindingKind};
use super::{Device, Reflection, Resource, VulkanError, shaders};

/// The layout of the shared set.
pub(super) struct SharedLayout {
    pub raw: vk::DescriptorSetLayout,
    pub bindings: BTreeMap<String, Binding>,
}

impl SharedLayout {
    /// Creates the layout; the device destroys it. Acceleration structures are in it where the device offers ray queries.
    pub fn new(device: &ash::Device, ray_queries: bool) -> Result<Self, VulkanError> {
        let shader = shaders::SCENE_SET_COMP;
        let mut bindings = Reflection::new("scene_set", shader.software)?.bindings;
        if ray_queries {
            bindings.extend(Reflection::new("scene_set", shader.hardware)?.bindings);
        }
        let stages =
            vk::ShaderStageFlags::COMPUTE | vk::ShaderStageFlags::VERTEX | vk::ShaderStageFlags::FRAGMENT;
        let descriptions: Vec<_> = bindings
            .values()
            .map(|binding| {
                vk::DescriptorSetLayoutBinding::default()
                    .binding(binding.binding)
                    .descriptor_type(binding.kind.descriptor_type())
                    .descriptor_count(1)
                    // Only compute shaders trace rays.
                    .stage_flags(match binding.kind {
                        BindingKind::AccelerationStructure => vk::ShaderStageFlags::COMPUTE,
                        _ => stages,
                    })
            })
            .collect();
        let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&descriptions);
        // SAFETY: `info` is complete; the device destroys the layout.
        let raw = unsafe { device.create_descriptor_set_layout(&info, None) }
            .map_err(VulkanError::call("creation", "layout of the scene set"))?;
        Ok(Self { raw, bindings })
    }

    /// Checks that a shader declares the set as all others do.
    pub fn check(&self, pass: &str, reflection: &Reflection) -> Result<(), VulkanError> {
        for (name, binding) in reflection.bindings.iter().filter(|(_, binding)| binding.set == SHARED_SET) {
            let same = self
                .bindings
                .get(name)
                .is_some_and(|known| (known.binding, known.kind) == (binding.binding, binding.kind));
            if !same {
                return Err(VulkanError::Binding {
                    pass: pass.to_owned(),
                    binding: name.clone(),
                    problem: "is not declared as in shaders/include/scene_set.glsl".to_owned(),
                });
            }
        }
        Ok(())
    }
}

/// Descriptor set that all passes of a frame share.
pub(super) const SHARED_SET: u32 = 1;

/// The shared set of one frame, with its resources by name.
pub struct SharedSet<'a> {
    pub(super) raw: vk::DescriptorSet,
    pub(super) resources: BTreeMap<&'static str, Resource<'a>>,
}

impl<'a> SharedSet<'a> {
    /// Writes `resources` into a set that was allocated for this frame.
    pub(super) fn new(
        device: &Device,
        raw: vk::DescriptorSet,
        resources: Vec<(&'static str, Resource<'a>)>,
    ) -> Result<Self, VulkanError> {
        let known = &device.shared_layout().bindings;
        let mut bound = Vec::new();
        for (name, resource) in &resources {
            let binding = known.get(*name).ok_or_else(|| VulkanError::Binding {
                pass: "scene set".to_owned(),
                binding: (*name).to_owned(),
                problem: "is not in shaders/include/scene_set.glsl".to_owned(),
            })?;
            bound.push((*binding, *resource));
        }
        // Not every driver bears a descriptor that was never written, even where no shader reads it: others of its kind stand in.
        for (_, binding) in known.iter().filter(|(name, _)| !resources.iter().any(|(given, _)| given == name))
        {
            let stands_in = |(_, resource): &&(&str, Resource<'_>)| resource.is_of(binding.kind);
            bound.extend(resources.iter().find(stands_in).map(|(_, resource)| (*binding, *resource)));
        }
        write_descriptors(device, raw, &bound);
        Ok(Self { raw, resources: resources.into_iter().collect() })
    }
}
