//! Extensions, features, functions and limits of ray queries. Optional.

use std::ffi::CStr;

use ash::{khr, vk};

/// Extensions that ray queries need; the last is a dependency of the first.
pub(super) const EXTENSIONS: [&CStr; 3] =
    [khr::acceleration_structure::NAME, khr::ray_query::NAME, khr::deferred_host_operations::NAME];

/// Device features that ray queries need.
#[derive(Default)]
pub(super) struct Features<'a> {
    pub addresses: vk::PhysicalDeviceBufferDeviceAddressFeatures<'a>,
    pub structures: vk::PhysicalDeviceAccelerationStructureFeaturesKHR<'a>,
    pub queries: vk::PhysicalDeviceRayQueryFeaturesKHR<'a>,
}

impl Features<'_> {
    /// All of them enabled.
    pub fn required() -> Self {
        Self {
            addresses: vk::PhysicalDeviceBufferDeviceAddressFeatures::default().buffer_device_address(true),
            structures: vk::PhysicalDeviceAccelerationStructureFeaturesKHR::default()
                .acceleration_structure(true),
            queries: vk::PhysicalDeviceRayQueryFeaturesKHR::default().ray_query(true),
        }
    }
}

/// Extensions and features for ray queries that a device of Vulkan `version` lacks; none if it offers all.
pub(super) fn missing_support(
    instance: &ash::Instance,
    device: vk::PhysicalDevice,
    version: u32,
) -> Option<String> {
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
    /// Limit of instances in a top level.
    pub max_instances: u64,
    /// Limit of triangles in a bottom level.
    pub max_triangles: u64,
}

impl RayQueries {
    /// `device` was created from `physical` with [`EXTENSIONS`] and [`Features::required`].
    pub fn new(instance: &ash::Instance, physical: vk::PhysicalDevice, device: &ash::Device) -> Self {
        let mut limits = vk::PhysicalDeviceAccelerationStructurePropertiesKHR::default();
        let mut properties = vk::PhysicalDeviceProperties2::default().push_next(&mut limits);
        // SAFETY: `physical` is of `instance` and knows the chained struct.
        unsafe { instance.get_physical_device_properties2(physical, &mut properties) };
        Self {
            functions: khr::acceleration_structure::Device::new(instance, device),
            scratch_alignment: u64::from(limits.min_acceleration_structure_scratch_offset_alignment).max(1),
            max_instances: limits.max_instance_count,
            max_triangles: limits.max_primitive_count,
        }
    }
}
