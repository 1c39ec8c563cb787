//! Physical device choice, the logical device, its queue and allocator, and one-time submissions.

use std::mem::ManuallyDrop;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use ash::{ext, khr, vk};
use gpu_allocator::vulkan::{Allocator, AllocatorCreateDesc};
use serde::Serialize;

use super::meter::MemoryMeter;
use super::{Instance, Surface, VulkanError};

/// What a physical device is and whether glowworm can use it.
#[derive(Clone, Debug, Serialize)]
pub struct DeviceInfo {
    /// Place in the list, for `--device`.
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
    /// Why glowworm cannot use it; none if it can.
    pub unusable: Option<String>,
}

/// A logical device with one queue that can do graphics, compute and transfers.
pub struct Device {
    raw: ash::Device,
    debug: Option<ext::debug_utils::Device>,
    allocator: ManuallyDrop<Arc<Mutex<Allocator>>>,
    memory: MemoryMeter,
    limits: vk::PhysicalDeviceLimits,
    physical: vk::PhysicalDevice,
    /// Vulkan wants one thread at a time at a queue.
    queue: Mutex<vk::Queue>,
    queue_family: u32,
    info: DeviceInfo,
    instance: Arc<Instance>,
}

impl Device {
    /// All devices, best first: discrete before integrated before virtual before CPU.
    pub fn list(instance: &Instance) -> Result<Vec<DeviceInfo>, VulkanError> {
        Ok(physical_devices(instance)?.into_iter().map(|(_, info)| info).collect())
    }

    /// Opens the device that `wanted` names (an index of [`Self::list`] or a part of a name), or the
    /// first usable one.
    pub fn open(instance: &Arc<Instance>, wanted: Option<&str>) -> Result<Arc<Self>, VulkanError> {
        Self::open_for(instance, wanted, None)
    }

    /// [`Self::open`], where the device must be able to show pictures on `surface`.
    pub fn open_for(
        instance: &Arc<Instance>,
        wanted: Option<&str>,
        surface: Option<&Surface>,
    ) -> Result<Arc<Self>, VulkanError> {
        let mut devices = physical_devices(instance)?;
        if let Some(surface) = surface {
            for (physical, info) in &mut devices {
                if info.unusable.is_none() {
                    info.unusable = why_no_window(instance.raw(), *physical, surface);
                }
            }
        }
        let (physical, info) = choose(devices, wanted)?;
        let queue_family = queue_family(instance.raw(), physical)
            .ok_or_else(|| VulkanError::NoDevice(format!("{} has no graphics queue", info.name)))?;
        let raw = create_device(instance.raw(), physical, queue_family, surface.is_some())?;
        let allocator = Allocator::new(&AllocatorCreateDesc {
            instance: instance.raw().clone(),
            device: raw.clone(),
            physical_device: physical,
            debug_settings: gpu_allocator::AllocatorDebugSettings::default(),
            buffer_device_address: false,
            allocation_sizes: gpu_allocator::AllocationSizes::default(),
        })
        .map_err(|error| VulkanError::NoDevice(format!("{}: {error}", info.name)))?;
        // SAFETY: the device was created with one queue of this family; `physical` is of `instance`.
        let (queue, properties) = unsafe {
            let queue = raw.get_device_queue(queue_family, 0);
            (queue, instance.raw().get_physical_device_properties(physical))
        };
        let debug = instance.has_debug_utils().then(|| ext::debug_utils::Device::new(instance.raw(), &raw));
        Ok(Arc::new(Self {
            raw,
            debug,
            allocator: ManuallyDrop::new(Arc::new(Mutex::new(allocator))),
            memory: MemoryMeter::default(),
            limits: properties.limits,
            physical,
            queue: Mutex::new(queue),
            queue_family,
            info,
            instance: Arc::clone(instance),
        }))
    }

    /// What the device is.
    pub fn info(&self) -> &DeviceInfo {
        &self.info
    }

    /// The device's limits.
    pub fn limits(&self) -> &vk::PhysicalDeviceLimits {
        &self.limits
    }

    /// The most bytes that buffers and images have taken at once since [`Self::restart_memory_peak`], or ever;
    /// without what windows use.
    pub fn memory_peak(&self) -> u64 {
        self.memory.peak()
    }

    /// Begins a new [`Self::memory_peak`].
    pub fn restart_memory_peak(&self) {
        self.memory.restart();
    }

    /// What the validation layer has said so far.
    pub fn validation_messages(&self) -> Vec<String> {
        self.instance.validation_messages()
    }

    /// Waits until the device has done all that was submitted.
    pub fn wait_idle(&self) -> Result<(), VulkanError> {
        let _queue = self.queue();
        // SAFETY: the lock keeps other threads off the queue.
        unsafe { self.raw.device_wait_idle() }.map_err(VulkanError::call("waiting", "device"))
    }

    /// How large optimally tiled 2D images of a format may be.
    pub(super) fn image_limits(
        &self,
        format: vk::Format,
        usage: vk::ImageUsageFlags,
    ) -> Result<vk::ImageFormatProperties, vk::Result> {
        // SAFETY: the physical device is of the instance.
        unsafe {
            self.instance.raw().get_physical_device_image_format_properties(
                self.physical,
                format,
                vk::ImageType::TYPE_2D,
                vk::ImageTiling::OPTIMAL,
                usage,
                vk::ImageCreateFlags::empty(),
            )
        }
    }

    pub(super) fn raw(&self) -> &ash::Device {
        &self.raw
    }

    pub(super) fn instance(&self) -> &Arc<Instance> {
        &self.instance
    }

    pub(super) fn physical(&self) -> vk::PhysicalDevice {
        self.physical
    }

    /// The queue, for this thread alone until the guard goes.
    pub(super) fn queue(&self) -> MutexGuard<'_, vk::Queue> {
        self.queue.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(super) fn queue_family(&self) -> u32 {
        self.queue_family
    }

    pub(super) fn debug(&self) -> Option<&ext::debug_utils::Device> {
        self.debug.as_ref()
    }

    pub(super) fn allocator(&self) -> MutexGuard<'_, Allocator> {
        self.allocator.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(super) fn memory(&self) -> &MemoryMeter {
        &self.memory
    }

    /// The allocator for those who keep it; they must let go of it before the device goes.
    pub(super) fn shared_allocator(&self) -> Arc<Mutex<Allocator>> {
        Arc::clone(&self.allocator)
    }

    /// Gives `handle` a name that debuggers and validation messages show.
    pub(super) fn set_name(&self, handle: impl vk::Handle, name: &str) {
        let Some(debug) = &self.debug else { return };
        let Ok(name) = std::ffi::CString::new(name) else { return };
        let info = vk::DebugUtilsObjectNameInfoEXT::default().object_handle(handle).object_name(&name);
        // SAFETY: `handle` is a live object of this device. A failed naming harms nothing.
        let _ = unsafe { debug.set_debug_utils_object_name(&info) };
    }

    /// Records commands with `record`, submits them and waits until they are done.
    pub(super) fn run_once(&self, record: impl FnOnce(vk::CommandBuffer)) -> Result<(), VulkanError> {
        let pool_info = vk::CommandPoolCreateInfo::default().queue_family_index(self.queue_family);
        // SAFETY: pool and buffer are used here only and freed after the wait.
        unsafe {
            let error = |result| VulkanError::call("one-time submission", "commands")(result);
            let pool = self.raw.create_command_pool(&pool_info, None).map_err(error)?;
            let result = self.run_in_pool(pool, record);
            self.raw.destroy_command_pool(pool, None);
            result.map_err(error)
        }
    }

    fn run_in_pool(
        &self,
        pool: vk::CommandPool,
        record: impl FnOnce(vk::CommandBuffer),
    ) -> Result<(), vk::Result> {
        let info = vk::CommandBufferAllocateInfo::default().command_pool(pool).command_buffer_count(1);
        let begin = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        // SAFETY: the command buffer comes from `pool`, is submitted once and waited for.
        unsafe {
            let commands = self.raw.allocate_command_buffers(&info)?[0];
            self.raw.begin_command_buffer(commands, &begin)?;
            record(commands);
            self.raw.end_command_buffer(commands)?;
            let buffers = [vk::CommandBufferSubmitInfo::default().command_buffer(commands)];
            let submit = vk::SubmitInfo2::default().command_buffer_infos(&buffers);
            let fence = self.raw.create_fence(&vk::FenceCreateInfo::default(), None)?;
            let submitted = self.raw.queue_submit2(*self.queue(), &[submit], fence);
            // Not the queue: another thread may go on submitting frames while this one waits.
            let result = submitted.and_then(|()| self.raw.wait_for_fences(&[fence], true, u64::MAX));
            self.raw.destroy_fence(fence, None);
            result
        }
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        // SAFETY: every object of the device holds an `Arc` of it, so none is left; the allocator frees
        // its memory before the device goes.
        unsafe {
            let _ = self.raw.device_wait_idle();
            ManuallyDrop::drop(&mut self.allocator);
            self.raw.destroy_device(None);
        }
    }
}

fn physical_devices(instance: &Instance) -> Result<Vec<(vk::PhysicalDevice, DeviceInfo)>, VulkanError> {
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
    // SAFETY: `device` is of `instance`; the chained structs are part of Vulkan 1.2.
    let extensions = unsafe {
        instance.get_physical_device_properties2(device, &mut properties);
        instance.enumerate_device_extension_properties(device).unwrap_or_default()
    };
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
        ray_query: extensions
            .iter()
            .any(|extension| extension.extension_name_as_c_str() == Ok(ash::khr::ray_query::NAME)),
        unusable: why_unusable(instance, device, &core),
    };
    (rank, info)
}

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
        return Some("it draws into fewer than 6 colour attachments at once".to_owned());
    }
    if queue_family(instance, device).is_none() {
        return Some("it has no queue for graphics and compute".to_owned());
    }
    None
}

/// Why the device cannot show pictures on `surface`; none if it can.
fn why_no_window(instance: &ash::Instance, device: vk::PhysicalDevice, surface: &Surface) -> Option<String> {
    // SAFETY: `device` is of `instance`.
    let extensions = unsafe { instance.enumerate_device_extension_properties(device) }.unwrap_or_default();
    if !extensions.iter().any(|extension| extension.extension_name_as_c_str() == Ok(khr::swapchain::NAME)) {
        return Some("it cannot show pictures in windows".to_owned());
    }
    let presents = queue_family(instance, device).is_some_and(|family| surface.supports(device, family));
    (!presents).then(|| "it cannot show pictures on this display".to_owned())
}

fn choose(
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
            "no driver offers any (Debian/Ubuntu: apt install mesa-vulkan-drivers)".to_owned(),
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

fn queue_family(instance: &ash::Instance, device: vk::PhysicalDevice) -> Option<u32> {
    let needed = vk::QueueFlags::GRAPHICS | vk::QueueFlags::COMPUTE;
    // SAFETY: `device` is of `instance`.
    let families = unsafe { instance.get_physical_device_queue_family_properties(device) };
    let index = families
        .iter()
        .position(|family| family.queue_flags.contains(needed) && family.timestamp_valid_bits > 0)?;
    u32::try_from(index).ok()
}

fn create_device(
    instance: &ash::Instance,
    physical: vk::PhysicalDevice,
    queue_family: u32,
    window: bool,
) -> Result<ash::Device, VulkanError> {
    let queues =
        [vk::DeviceQueueCreateInfo::default().queue_family_index(queue_family).queue_priorities(&[1.0])];
    let mut features13 =
        vk::PhysicalDeviceVulkan13Features::default().dynamic_rendering(true).synchronization2(true);
    let extensions = [khr::swapchain::NAME.as_ptr()];
    let info = vk::DeviceCreateInfo::default()
        .queue_create_infos(&queues)
        .enabled_extension_names(if window { &extensions } else { &[] })
        .push_next(&mut features13);
    // SAFETY: every pointer in `info` outlives the call; the features were checked.
    unsafe { instance.create_device(physical, &info, None) }.map_err(VulkanError::call("creation", "device"))
}
