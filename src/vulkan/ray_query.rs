//! What ray queries take: extensions, features, functions and limits. Never required.

use std::ffi::CStr;

use ash::{khr, vk};

/// Extensions that ray queries need; the last is one that the first cannot do without.
pub(super) const EXTENSIONS: [&CStr; 3] =
    [khr::acceleration_structure::NAME, khr::ray_query::NAME, khr::deferred_host_operations::NAME];

/// The features of a device that ray queries need.
#[derive(Default)]
pub(super) struct Features<'a> {
    pub addresses: vk::PhysicalDeviceBufferDeviceAddressFeatures<'a>,
    pub structures: vk::PhysicalDeviceAccelerationStructureFeaturesKHR<'a>,
    pub queries: vk::PhysicalDeviceRayQueryFeaturesKHR<'a>,
}

impl Features<'_> {
    /// All of them and no others.
    pub fn wanted() -> Self {
        Self {
            addresses: vk::PhysicalDeviceBufferDeviceAddressFeatures::default().buffer_device_address(true),
            structures: vk::PhysicalDeviceAccelerationStructureFeaturesKHR::default()
                .acceleration_structure(true),
            queries: vk::PhysicalDeviceRayQueryFeaturesKHR::default().ray_query(true),
        }
    }
}

/// What a device of Vulkan `version` would need for ray queries and does not offer; none if it offers all.
pub(super) fn lacks(instance: &ash::Instance, device: vk::PhysicalDevice, version: u32) -> Option<String> {
    // SAFETY: `device` is of `instance`.
    let offered = unsafe { instance.enumerate_device_extension_properties(device) }.unwrap_or_default();
    let offers = |name: &CStr| offered.iter().any(|one| one.extension_name_as_c_str() == Ok(name));
    let mut missing: Vec<String> = EXTENSIONS
        .into_iter()
        .filter(|name| !offers(name))
        .map(|name| name.to_string_lossy().into_owned())
        .collect();
    if missing.is_empty() && version >= vk::API_VERSION_1_2 {
        let mut found = Features::default();
        let mut features = vk::PhysicalDeviceFeatures2::default()
            .push_next(&mut found.addresses)
            .push_next(&mut found.structures)
            .push_next(&mut found.queries);
        // SAFETY: the device knows the chained structs, since it offers their extensions and Vulkan 1.2.
        unsafe { instance.get_physical_device_features2(device, &mut features) };
        let needed = [
            ("bufferDeviceAddress", found.addresses.buffer_device_address),
            ("accelerationStructure", found.structures.acceleration_structure),
            ("rayQuery", found.queries.ray_query),
        ];
        let absent = needed.into_iter().filter(|(_, offered)| *offered == vk::FALSE);
        missing.extend(absent.map(|(feature, _)| format!("the feature {feature}")));
    }
    (!missing.is_empty()).then(|| missing.join(", "))
}

/// Functions and limits of acceleration structures on a device that offers ray queries.
pub(super) struct RayQueries {
    pub functions: khr::acceleration_structure::Device,
    /// Alignment of scratch memory.
    pub scratch_alignment: u64,
    /// Most instances of a top level.
    pub most_instances: u64,
    /// Most triangles of a bottom level.
    pub most_triangles: u64,
}

impl RayQueries {
    /// `device` was made of `physical` with [`EXTENSIONS`] and [`Features::wanted`].
    pub fn new(instance: &ash::Instance, physical: vk::PhysicalDevice, device: &ash::Device) -> Self {
        let mut limits = vk::PhysicalDeviceAccelerationStructurePropertiesKHR::default();
        let mut properties = vk::PhysicalDeviceProperties2::default().push_next(&mut limits);
        // SAFETY: `physical` is of `instance` and knows the chained struct.
        unsafe { instance.get_physical_device_properties2(physical, &mut properties) };
        Self {
            functions: khr::acceleration_structure::Device::new(instance, device),
            scratch_alignment: u64::from(limits.min_acceleration_structure_scratch_offset_alignment).max(1),
            most_instances: limits.max_instance_count,
            most_triangles: limits.max_primitive_count,
        }
    }
}
