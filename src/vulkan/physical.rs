//! Enumeration and selection of physical devices.

use std::ffi::CStr;

use ash::{khr, vk};
use serde::Serialize;

use super::{Instance, Surface, VulkanError, ray_query};

/// A physical device, and whether glowworm can use it.
#[derive(Clone, Debug, Default, Serialize)]
pub struct DeviceInfo {
    /// Index in the list, for `--device`.
    pub index: usize,
    /// Marketing name.
    pub name: String,
    /// discrete, integrated, virtual, cpu or other.
    pub kind: String,
    /// Driver name and version.
    pub driver: String,
    /// Vulkan version, major.minor.patch.
    pub vulkan: String,
    /// Whether the device offers ray queries (the hardware tracer).
    pub ray_query: bool,
    /// Missing extensions or features for ray queries; none if it offers them.
    pub ray_query_lacks: Option<String>,
    /// Why glowworm cannot use it; none if usable.
    pub unusable: Option<String>,
}

impl DeviceInfo {
    /// Whether it is a CPU driver.
    pub fn is_cpu(&self) -> bool {
        self.kind == "cpu"
    }
}

pub(super) fn physical_devices(
    instance: &Instance,
) -> Result<Vec<(vk::PhysicalDevice, DeviceInfo)>, VulkanError> {
    // SAFETY: plain query.
    let raw = unsafe { instance.raw().enumerate_physical_devices() }
        .map_err(VulkanError::call("enumeration", "devices"))?;
    let mut devices: Vec<_> =
        raw.into_iter().map(|device| (device, rank_and_info(instance.raw(), device))).collect();
    devices.sort_by_key(|(_, (rank, _))| *rank);
    Ok(devices
        .into_iter()
        .enumerate()
        .map(|(index, (device, (_, info)))| (device, DeviceInfo { index, ..info }))
        .collect())
}

fn rank_and_info(instance: &ash::Instance, device: vk::PhysicalDevice) -> (u32, DeviceInfo) {
    let mut driver = vk::PhysicalDeviceDriverProperties::default();
    let mut properties = vk::PhysicalDeviceProperties2::default().push_next(&mut driver);
    // SAFETY: `device` is of `instance`; the chained struct is part of Vulkan 1.2.
    unsafe { instance.get_physical_device_properties2(device, &mut properties) };
    let core = properties.properties;
    let version = core.api_version;
    let (rank, kind) = match core.device_type {
        vk::PhysicalDeviceType::DISCRETE_GPU => (0, "discrete"),
        vk::PhysicalDeviceType::INTEGRATED_GPU => (1, "integrated"),
        vk::PhysicalDeviceType::VIRTUAL_GPU => (2, "virtual"),
        vk::PhysicalDeviceType::CPU => (3, "cpu"),
        _ => (4, "other"),
    };
    let text = |name: Result<&std::ffi::CStr, _>| {
        name.map_or_else(|_| String::new(), |name| name.to_string_lossy().into_owned())
    };
    let ray_query_lacks = ray_query::missing_support(instance, device, version);
    let info = DeviceInfo {
        index: 0,
        name: text(core.device_name_as_c_str()),
        kind: kind.to_owned(),
        driver: format!("{} {}", text(driver.driver_name_as_c_str()), text(driver.driver_info_as_c_str())),
        vulkan: format!(
            "{}.{}.{}",
            vk::api_version_major(version),
            vk::api_version_minor(version),
            vk::api_version_patch(version)
        ),
        ray_query: ray_query_lacks.is_none(),
        ray_query_lacks,
        unusable: why_unusable(instance, device, &core),
    };
    (rank, info)
}

/// Storage buffers that a shader stage binds at most: 20 of the scene set, and the pass's own.
const STORAGE_BUFFERS: u32 = 25;

fn why_unusable(
    instance: &ash::Instance,
    device: vk::PhysicalDevice,
    core: &vk::PhysicalDeviceProperties,
) -> Option<String> {
    if core.api_version < vk::API_VERSION_1_3 {
        return Some("it does not offer Vulkan 1.3".to_owned());
    }
    let mut features13 = vk::PhysicalDeviceVulkan13Features::default();
    let mut features = vk::PhysicalDeviceFeatures2::default().push_next(&mut features13);
    // SAFETY: the device offers 1.3, so the chained struct is known to it.
    unsafe { instance.get_physical_device_features2(device, &mut features) };
    if features13.dynamic_rendering == vk::FALSE || features13.synchronization2 == vk::FALSE {
        return Some("it lacks dynamic rendering or synchronization2".to_owned());
    }
    if core.limits.timestamp_compute_and_graphics == vk::FALSE {
        return Some("it has no timestamps".to_owned());
    }
    if core.limits.max_color_attachments < 6 {
        return Some("it supports fewer than 6 colour attachments".to_owned());
    }
    if core.limits.max_per_stage_descriptor_storage_buffers < STORAGE_BUFFERS {
        return Some(format!("its shaders read fewer than {STORAGE_BUFFERS} storage buffers"));
    }
    let mut subgroups = vk::PhysicalDeviceSubgroupProperties::default();
    let mut properties = vk::PhysicalDeviceProperties2::default().push_next(&mut subgroups);
    // SAFETY: the device offers 1.3, so the chained struct is known to it.
    unsafe { instance.get_physical_device_properties2(device, &mut properties) };
    let in_compute = subgroups.supported_stages.contains(vk::ShaderStageFlags::COMPUTE);
    if !in_compute || !subgroups.supported_operations.contains(vk::SubgroupFeatureFlags::ARITHMETIC) {
        return Some("its compute shaders lack sums over subgroups".to_owned());
    }
    if queue_family(instance, device).is_none() {
        return Some("it has no queue for graphics and compute".to_owned());
    }
    None
}

/// Why the device cannot present to `surface`; none if it can.
pub(super) fn why_no_window(
    instance: &ash::Instance,
    device: vk::PhysicalDevice,
    surface: &Surface,
) -> Option<String> {
    // SAFETY: `device` is of `instance`.
    let extensions = unsafe { instance.enumerate_device_extension_properties(device) }.unwrap_or_default();
    if !extensions.iter().any(|extension| extension.extension_name_as_c_str() == Ok(khr::swapchain::NAME)) {
        return Some("it has no swapchains".to_owned());
    }
    let presents = queue_family(instance, device).is_some_and(|family| surface.supports(device, family));
    (!presents).then(|| "it cannot present to this display".to_owned())
}

pub(super) fn choose(
    devices: Vec<(vk::PhysicalDevice, DeviceInfo)>,
    wanted: Option<&str>,
) -> Result<(vk::PhysicalDevice, DeviceInfo), VulkanError> {
    let available = devices
        .iter()
        .map(|(_, info)| format!("{} {}", info.index, info.name))
        .collect::<Vec<_>>()
        .join(", ");
    if devices.is_empty() {
        return Err(VulkanError::NoDevice(
            "no driver offers one (Debian/Ubuntu: apt install mesa-vulkan-drivers)".to_owned(),
        ));
    }
    let Some(wanted) = wanted else {
        let reasons: Vec<String> = devices
            .iter()
            .filter_map(|(_, info)| Some(format!("{}: {}", info.name, info.unusable.as_ref()?)))
            .collect();
        return devices
            .into_iter()
            .find(|(_, info)| info.unusable.is_none())
            .ok_or_else(|| VulkanError::NoDevice(reasons.join("; ")));
    };
    let matches = |info: &DeviceInfo| match wanted.parse::<usize>() {
        Ok(index) => info.index == index,
        Err(_) => info.name.to_lowercase().contains(&wanted.to_lowercase()),
    };
    let found = devices
        .into_iter()
        .find(|(_, info)| matches(info))
        .ok_or(VulkanError::UnknownDevice { wanted: wanted.to_owned(), available })?;
    match &found.1.unusable {
        Some(reason) => Err(VulkanError::NoDevice(format!("{}: {reason}", found.1.name))),
        None => Ok(found),
    }
}

pub(super) fn queue_family(instance: &ash::Instance, device: vk::PhysicalDevice) -> Option<u32> {
    let needed = vk::QueueFlags::GRAPHICS | vk::QueueFlags::COMPUTE;
    // SAFETY: `device` is of `instance`.
    let families = unsafe { instance.get_physical_device_queue_family_properties(device) };
    let index = families
        .iter()
        .position(|family| family.queue_flags.contains(needed) && family.timestamp_valid_bits > 0)?;
    u32::try_from(index).ok()
}

/// Extension of drivers that are not fully Vulkan, such as MoltenVK.
const PORTABILITY_SUBSET: &CStr = c"VK_KHR_portability_subset";

pub(super) fn create_device(
    instance: &ash::Instance,
    physical: vk::PhysicalDevice,
    info: &DeviceInfo,
    queue_family: u32,
    window: bool,
) -> Result<ash::Device, VulkanError> {
    let queues =
        [vk::DeviceQueueCreateInfo::default().queue_family_index(queue_family).queue_priorities(&[1.0])];
    let mut extensions = Vec::new();
    if window {
        extensions.push(khr::swapchain::NAME.as_ptr());
    }
    if info.ray_query {
        extensions.extend(ray_query::EXTENSIONS.map(CStr::as_ptr));
    }
    // A driver that lacks parts of Vulkan has to be told that this is known.
    // SAFETY: `physical` is of `instance`.
    let offered = unsafe { instance.enumerate_device_extension_properties(physical) }.unwrap_or_default();
    if offered.iter().any(|one| one.extension_name_as_c_str() == Ok(PORTABILITY_SUBSET)) {
        extensions.push(PORTABILITY_SUBSET.as_ptr());
    }
    let mut features13 =
        vk::PhysicalDeviceVulkan13Features::default().dynamic_rendering(true).synchronization2(true);
    let mut ray_query = ray_query::Features::required();
    let mut create = vk::DeviceCreateInfo::default()
        .queue_create_infos(&queues)
        .enabled_extension_names(&extensions)
        .push_next(&mut features13);
    if info.ray_query {
        create = create
            .push_next(&mut ray_query.addresses)
            .push_next(&mut ray_query.structures)
            .push_next(&mut ray_query.queries);
    }
    // SAFETY: every pointer in `create` outlives the call; extensions and features were checked.
    unsafe { instance.create_device(physical, &create, None) }
        .map_err(VulkanError::call("creation", "device"))
}
