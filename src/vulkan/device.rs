//! The logical device, its queue and allocator, and one-time submissions.

use std::mem::ManuallyDrop;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use ash::{ext, vk};
use gpu_allocator::vulkan::{Allocator, AllocatorCreateDesc};

use super::instance::creation_lock;
use super::loss::Loss;
use super::meter::MemoryMeter;
use super::physical::{DeviceInfo, choose, create_device, physical_devices, queue_family, why_no_window};
use super::pipeline::{Compute, ComputeKey, Graphics, GraphicsDescription, PipelineCache};
use super::raw_device::RawDevice;
use super::ray_query::RayQueries;
use super::shared_set::SharedLayout;
use super::{Instance, Surface, VulkanError};

/// A logical device with one queue for graphics, compute and transfers.
pub struct Device {
    raw: Arc<RawDevice>,
    debug: Option<ext::debug_utils::Device>,
    ray_queries: Option<RayQueries>,
    allocator: ManuallyDrop<Arc<Mutex<Allocator>>>,
    memory: MemoryMeter,
    compute_pipelines: PipelineCache<ComputeKey, Compute>,
    graphics_pipelines: PipelineCache<GraphicsDescription, Graphics>,
    shared_layout: SharedLayout,
    limits: vk::PhysicalDeviceLimits,
    physical: vk::PhysicalDevice,
    /// Queues need external synchronisation.
    queue: Mutex<vk::Queue>,
    queue_family: u32,
    info: DeviceInfo,
    loss: Loss,
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

    /// [`Self::open`] for a device that can present to `surface`.
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
        // Until all functions are loaded.
        let _guard = creation_lock();
        let raw = create_device(instance.raw(), physical, &info, queue_family, surface.is_some())?;
        let ray_queries = info.ray_query.then(|| RayQueries::new(instance.raw(), physical, &raw));
        let shared_layout = SharedLayout::new(&raw, info.ray_query)?;
        let allocator = Allocator::new(&AllocatorCreateDesc {
            instance: instance.raw().clone(),
            device: raw.clone(),
            physical_device: physical,
            debug_settings: gpu_allocator::AllocatorDebugSettings::default(),
            buffer_device_address: ray_queries.is_some(),
            allocation_sizes: gpu_allocator::AllocationSizes::default(),
        })
        .map_err(|error| VulkanError::NoDevice(format!("{}: {error}", info.name)))?;
        // SAFETY: the device was created with one queue of this family; `physical` is of `instance`.
        let (queue, properties) = unsafe {
            let queue = raw.get_device_queue(queue_family, 0);
            (queue, instance.raw().get_physical_device_properties(physical))
        };
        let debug = instance.has_debug_utils().then(|| ext::debug_utils::Device::new(instance.raw(), &raw));
        let raw = Arc::new(RawDevice { functions: raw, _instance: Arc::clone(instance) });
        Ok(Arc::new(Self {
            raw,
            debug,
            ray_queries,
            allocator: ManuallyDrop::new(Arc::new(Mutex::new(allocator))),
            memory: MemoryMeter::default(),
            compute_pipelines: PipelineCache::default(),
            graphics_pipelines: PipelineCache::default(),
            shared_layout,
            limits: properties.limits,
            physical,
            queue: Mutex::new(queue),
            queue_family,
            info,
            loss: Loss::default(),
            instance: Arc::clone(instance),
        }))
    }

    /// Name, driver and capabilities of the device.
    pub fn info(&self) -> &DeviceInfo {
        &self.info
    }

    /// Whether it is a CPU driver.
    pub fn is_cpu(&self) -> bool {
        self.info.is_cpu()
    }

    /// The device's limits.
    pub fn limits(&self) -> &vk::PhysicalDeviceLimits {
        &self.limits
    }

    /// Peak memory of buffers and images since [`Self::restart_memory_peak`] or creation, bytes; excludes swapchains.
    pub fn memory_peak(&self) -> u64 {
        self.memory.peak()
    }

    /// Resets [`Self::memory_peak`] to the current use.
    pub fn restart_memory_peak(&self) {
        self.memory.restart();
    }

    /// Messages of the validation layer so far.
    pub fn validation_messages(&self) -> Vec<String> {
        self.instance.validation_messages()
    }

    /// Waits until the device is idle.
    pub fn wait_idle(&self) -> Result<(), VulkanError> {
        let _queue = self.queue();
        // SAFETY: the lock keeps other threads off the queue.
        unsafe { self.raw.device_wait_idle() }.map_err(VulkanError::call("waiting", "device"))
    }

    /// Limits of optimally tiled 2D images of a format.
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

    /// For objects that the device itself keeps, which an `Arc<Device>` would keep alive for ever.
    pub(super) fn shared_raw(&self) -> Arc<RawDevice> {
        Arc::clone(&self.raw)
    }

    pub(super) fn instance(&self) -> &Arc<Instance> {
        &self.instance
    }

    pub(super) fn physical(&self) -> vk::PhysicalDevice {
        self.physical
    }

    /// Locks the queue for this thread.
    pub(super) fn queue(&self) -> MutexGuard<'_, vk::Queue> {
        self.queue.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(super) fn queue_family(&self) -> u32 {
        self.queue_family
    }

    pub(super) fn debug(&self) -> Option<&ext::debug_utils::Device> {
        self.debug.as_ref()
    }

    /// Acceleration structures; none where the device has no ray queries.
    pub(super) fn ray_queries(&self) -> Option<&RayQueries> {
        self.ray_queries.as_ref()
    }

    pub(super) fn allocator(&self) -> MutexGuard<'_, Allocator> {
        self.allocator.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(super) fn memory(&self) -> &MemoryMeter {
        &self.memory
    }

    pub(super) fn compute_pipelines(&self) -> &PipelineCache<ComputeKey, Compute> {
        &self.compute_pipelines
    }

    pub(super) fn graphics_pipelines(&self) -> &PipelineCache<GraphicsDescription, Graphics> {
        &self.graphics_pipelines
    }

    /// The layout of the set that all passes share.
    pub(super) fn shared_layout(&self) -> &SharedLayout {
        &self.shared_layout
    }

    /// The allocator, to be shared; owners must drop it before the device.
    pub(super) fn shared_allocator(&self) -> Arc<Mutex<Allocator>> {
        Arc::clone(&self.allocator)
    }

    /// Names `handle` for debuggers and validation messages.
    pub(super) fn set_name(&self, handle: impl vk::Handle, name: &str) {
        let Some(debug) = &self.debug else { return };
        let Ok(name) = std::ffi::CString::new(name) else { return };
        let info = vk::DebugUtilsObjectNameInfoEXT::default().object_handle(handle).object_name(&name);
        // SAFETY: `handle` is a live object of this device. A failed naming harms nothing.
        let _ = unsafe { debug.set_debug_utils_object_name(&info) };
    }

    /// Records commands with `record`, submits them and waits for completion.
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

    /// Submits recorded commands, after which `fence` is signalled.
    ///
    /// # Safety
    /// Resources that they use must live until then.
    pub(super) unsafe fn submit(
        &self,
        commands: vk::SubmitInfo2<'_>,
        fence: vk::Fence,
    ) -> Result<(), vk::Result> {
        if self.loss.strikes() {
            return Err(vk::Result::ERROR_DEVICE_LOST);
        }
        // SAFETY: the caller's; the lock keeps other threads off the queue.
        unsafe { self.raw.queue_submit2(*self.queue(), &[commands], fence) }
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
            let submitted = self.submit(submit, fence);
            // Wait for the fence, not the queue: other threads may submit meanwhile.
            let result = submitted.and_then(|()| self.raw.wait_for_fences(&[fence], true, u64::MAX));
            self.raw.destroy_fence(fence, None);
            result
        }
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        // SAFETY: every buffer and image holds an `Arc` of the device, so none is left; the allocator is dropped once, before
        // the raw device; pipelines may outlive the layout of a set.
        unsafe {
            let _ = self.raw.device_wait_idle();
            ManuallyDrop::drop(&mut self.allocator);
            self.raw.destroy_descriptor_set_layout(self.shared_layout.raw, None);
        }
    }
}
