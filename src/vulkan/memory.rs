//! Buffers and images with their memory.

use std::mem::ManuallyDrop;
use std::sync::Arc;

use ash::vk;
use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan::{Allocation, AllocationCreateDesc, AllocationScheme};

use super::access::Tracker;
use super::texels::TEXEL_SIZE;
use super::{Device, VulkanError};

/// A buffer with its memory.
pub struct Buffer {
    pub(super) raw: vk::Buffer,
    pub(super) tracker: Tracker,
    pub(super) allocation: ManuallyDrop<Allocation>,
    pub(super) size: u64,
    pub(super) name: String,
    /// Texel view of the whole buffer; null if it has none.
    pub(super) texels: vk::BufferView,
    pub(super) device: Arc<Device>,
}

impl Buffer {
    /// Allocates `size` bytes, at least 16, of device-local memory.
    pub fn new(device: &Arc<Device>, name: &str, size: u64) -> Result<Self, VulkanError> {
        Self::storable(device, name, size, MemoryLocation::GpuOnly)
    }

    /// A buffer within `maxStorageBufferRange`.
    pub(super) fn storable(
        device: &Arc<Device>,
        name: &str,
        size: u64,
        location: MemoryLocation,
    ) -> Result<Self, VulkanError> {
        let limit = u64::from(device.limits().max_storage_buffer_range);
        if size > limit {
            return Err(VulkanError::Limit { what: format!("buffer {name} of {size} bytes"), limit });
        }
        Self::in_memory(device, name, size, location)
    }

    pub(super) fn in_memory(
        device: &Arc<Device>,
        name: &str,
        size: u64,
        location: MemoryLocation,
    ) -> Result<Self, VulkanError> {
        let size = size.max(TEXEL_SIZE);
        let mut usage = vk::BufferUsageFlags::STORAGE_BUFFER
            | vk::BufferUsageFlags::UNIFORM_BUFFER
            | vk::BufferUsageFlags::UNIFORM_TEXEL_BUFFER
            | vk::BufferUsageFlags::VERTEX_BUFFER
            | vk::BufferUsageFlags::INDEX_BUFFER
            | vk::BufferUsageFlags::TRANSFER_SRC
            | vk::BufferUsageFlags::TRANSFER_DST;
        if device.ray_queries().is_some() {
            usage |= vk::BufferUsageFlags::SHADER_DEVICE_ADDRESS
                | vk::BufferUsageFlags::ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_KHR;
        }
        Self::with_usage(device, name, size, location, usage)
    }

    /// Memory for an acceleration structure or its scratch data. No shader binds it as a buffer.
    pub(super) fn for_structure(device: &Arc<Device>, name: &str, size: u64) -> Result<Self, VulkanError> {
        let usage = vk::BufferUsageFlags::ACCELERATION_STRUCTURE_STORAGE_KHR
            | vk::BufferUsageFlags::STORAGE_BUFFER
            | vk::BufferUsageFlags::SHADER_DEVICE_ADDRESS;
        Self::with_usage(device, name, size, MemoryLocation::GpuOnly, usage)
    }

    fn with_usage(
        device: &Arc<Device>,
        name: &str,
        size: u64,
        location: MemoryLocation,
        usage: vk::BufferUsageFlags,
    ) -> Result<Self, VulkanError> {
        let info =
            vk::BufferCreateInfo::default().size(size).usage(usage).sharing_mode(vk::SharingMode::EXCLUSIVE);
        // SAFETY: `info` is complete; the buffer is destroyed in `drop`.
        let (raw, requirements) = unsafe {
            let raw = device
                .raw()
                .create_buffer(&info, None)
                .map_err(VulkanError::call("creation", format!("buffer {name}")))?;
            (raw, device.raw().get_buffer_memory_requirements(raw))
        };
        let allocation =
            allocate(device, name, requirements, location, true, AllocationScheme::GpuAllocatorManaged)
                .inspect_err(|_| {
                    // SAFETY: the buffer was just made and nothing uses it.
                    unsafe { device.raw().destroy_buffer(raw, None) };
                })?;
        let buffer = Self {
            raw,
            tracker: Tracker::default(),
            allocation: ManuallyDrop::new(allocation),
            size,
            name: name.to_owned(),
            texels: vk::BufferView::null(),
            device: Arc::clone(device),
        };
        // SAFETY: the allocation was made for this buffer's requirements.
        unsafe {
            device.raw().bind_buffer_memory(raw, buffer.allocation.memory(), buffer.allocation.offset())
        }
        .map_err(VulkanError::call("binding memory", format!("buffer {name}")))?;
        device.set_name(raw, name);
        Ok(buffer)
    }

    /// Size in bytes.
    pub fn size(&self) -> u64 {
        self.size
    }

    /// A range of the buffer.
    pub fn slice(&self, offset: u64, size: u64) -> BufferSlice<'_> {
        assert!(offset + size <= self.size, "slice beyond the end of buffer {}", self.name);
        BufferSlice { buffer: self, offset, size }
    }
}

impl Drop for Buffer {
    fn drop(&mut self) {
        // SAFETY: the owner waits for the device before dropping what a submitted frame uses.
        unsafe {
            self.device.raw().destroy_buffer_view(self.texels, None);
            self.device.raw().destroy_buffer(self.raw, None);
            free(&self.device, ManuallyDrop::take(&mut self.allocation));
        }
    }
}

/// A range of a buffer, to be bound.
#[derive(Clone, Copy)]
pub struct BufferSlice<'a> {
    pub(super) buffer: &'a Buffer,
    pub(super) offset: u64,
    pub(super) size: u64,
}

impl<'a> From<&'a Buffer> for BufferSlice<'a> {
    fn from(buffer: &'a Buffer) -> Self {
        Self { buffer, offset: 0, size: buffer.size }
    }
}

/// Parameters of an [`Image`].
#[derive(Clone, Copy, Debug)]
pub struct ImageDescription<'a> {
    /// Name for debuggers and messages.
    pub name: &'a str,
    /// Texel format.
    pub format: vk::Format,
    /// Width and height in texels.
    pub extent: [u32; 2],
    /// Array layers; none: not an array.
    pub layers: Option<u32>,
    /// Mip levels.
    pub levels: u32,
    /// Usage besides sampling and transfers.
    pub usage: vk::ImageUsageFlags,
}

/// An image with its memory and one view of all of it.
pub struct Image {
    pub(super) raw: vk::Image,
    pub(super) view: vk::ImageView,
    pub(super) tracker: Tracker,
    pub(super) format: vk::Format,
    pub(super) name: String,
    extent: [u32; 2],
    layers: u32,
    levels: u32,
    allocation: ManuallyDrop<Allocation>,
    device: Arc<Device>,
}

impl Image {
    /// Creates an image with undefined content.
    pub fn new(device: &Arc<Device>, description: &ImageDescription<'_>) -> Result<Self, VulkanError> {
        let name = description.name;
        let usage = description.usage
            | vk::ImageUsageFlags::SAMPLED
            | vk::ImageUsageFlags::TRANSFER_SRC
            | vk::ImageUsageFlags::TRANSFER_DST;
        check_limits(device, description, usage)?;
        let info = vk::ImageCreateInfo::default()
            .image_type(vk::ImageType::TYPE_2D)
            .format(description.format)
            .extent(vk::Extent3D { width: description.extent[0], height: description.extent[1], depth: 1 })
            .mip_levels(description.levels)
            .array_layers(description.layers.unwrap_or(1))
            .samples(vk::SampleCountFlags::TYPE_1)
            .tiling(vk::ImageTiling::OPTIMAL)
            .usage(usage);
        // SAFETY: `info` is complete and within the limits; the image is destroyed in `drop`.
        let (raw, requirements) = unsafe {
            let raw = device
                .raw()
                .create_image(&info, None)
                .map_err(VulkanError::call("creation", format!("image {name}")))?;
            (raw, device.raw().get_image_memory_requirements(raw))
        };
        // Render targets are recreated on resize: dedicated allocations return their memory at once.
        let target = vk::ImageUsageFlags::STORAGE
            | vk::ImageUsageFlags::COLOR_ATTACHMENT
            | vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT;
        let scheme = if description.usage.intersects(target) {
            AllocationScheme::DedicatedImage(raw)
        } else {
            AllocationScheme::GpuAllocatorManaged
        };
        let allocation = allocate(device, name, requirements, MemoryLocation::GpuOnly, false, scheme)
            .inspect_err(|_| {
                // SAFETY: the image was just made and nothing uses it.
                unsafe { device.raw().destroy_image(raw, None) };
            })?;
        // Constructed before the view, so that an error frees image and memory.
        let mut image = Self {
            raw,
            view: vk::ImageView::null(),
            tracker: Tracker::default(),
            format: description.format,
            name: name.to_owned(),
            extent: description.extent,
            layers: description.layers.unwrap_or(1),
            levels: description.levels,
            allocation: ManuallyDrop::new(allocation),
            device: Arc::clone(device),
        };
        // SAFETY: the allocation was made for this image's requirements.
        unsafe { device.raw().bind_image_memory(raw, image.allocation.memory(), image.allocation.offset()) }
            .map_err(VulkanError::call("binding memory", format!("image {name}")))?;
        device.set_name(raw, name);
        image.view = image.create_view(description.layers.is_some())?;
        Ok(image)
    }

    /// Width and height in texels.
    pub fn extent(&self) -> [u32; 2] {
        self.extent
    }

    /// Number of array layers.
    pub fn layers(&self) -> u32 {
        self.layers
    }

    pub(super) fn range(&self) -> vk::ImageSubresourceRange {
        vk::ImageSubresourceRange {
            aspect_mask: self.aspect(),
            base_mip_level: 0,
            level_count: self.levels,
            base_array_layer: 0,
            layer_count: self.layers,
        }
    }

    pub(super) fn aspect(&self) -> vk::ImageAspectFlags {
        if self.format == vk::Format::D32_SFLOAT {
            vk::ImageAspectFlags::DEPTH
        } else {
            vk::ImageAspectFlags::COLOR
        }
    }

    fn create_view(&self, array: bool) -> Result<vk::ImageView, VulkanError> {
        let kind = if array { vk::ImageViewType::TYPE_2D_ARRAY } else { vk::ImageViewType::TYPE_2D };
        let info = vk::ImageViewCreateInfo::default()
            .image(self.raw)
            .view_type(kind)
            .format(self.format)
            .subresource_range(self.range());
        // SAFETY: the image has memory and the range lies within it.
        unsafe { self.device.raw().create_image_view(&info, None) }
            .map_err(VulkanError::call("creation", format!("view of image {}", self.name)))
    }
}

impl Drop for Image {
    fn drop(&mut self) {
        // SAFETY: the owner waits for the device before dropping what a submitted frame uses.
        unsafe {
            self.device.raw().destroy_image_view(self.view, None);
            self.device.raw().destroy_image(self.raw, None);
            free(&self.device, ManuallyDrop::take(&mut self.allocation));
        }
    }
}

fn check_limits(
    device: &Device,
    description: &ImageDescription<'_>,
    usage: vk::ImageUsageFlags,
) -> Result<(), VulkanError> {
    let ImageDescription { name, extent: [width, height], .. } = *description;
    let layers = description.layers.unwrap_or(1);
    let limits = device
        .image_limits(description.format, usage)
        .map_err(VulkanError::call("query of the format", format!("image {name}")))?;
    let side = limits.max_extent.width.min(limits.max_extent.height);
    // A lower bound: the driver's padding is known after the allocation only.
    let mebibytes = (u64::from(width) * u64::from(height) * u64::from(layers))
        .saturating_mul(texel_size(description.format))
        >> 20;
    for (what, wanted, limit) in [
        (format!("image {name} of {width}x{height}"), u64::from(width.max(height)), u64::from(side)),
        (format!("image {name} of {layers} layers"), layers.into(), limits.max_array_layers.into()),
        (format!("image {name} of {mebibytes} MiB"), mebibytes, limits.max_resource_size >> 20),
    ] {
        if wanted > limit {
            return Err(VulkanError::Limit { what, limit });
        }
    }
    Ok(())
}

/// Bytes per texel of the formats in use.
fn texel_size(format: vk::Format) -> u64 {
    match format {
        vk::Format::R32G32B32A32_SFLOAT => 16,
        vk::Format::R16G16B16A16_SFLOAT
        | vk::Format::R16G16B16A16_UINT
        | vk::Format::R32G32_UINT
        | vk::Format::R32G32_SFLOAT => 8,
        _ => 4,
    }
}

fn allocate(
    device: &Device,
    name: &str,
    requirements: vk::MemoryRequirements,
    location: MemoryLocation,
    linear: bool,
    allocation_scheme: AllocationScheme,
) -> Result<Allocation, VulkanError> {
    let description = AllocationCreateDesc { name, requirements, location, linear, allocation_scheme };
    let allocation = device.allocator().allocate(&description).map_err(|error| VulkanError::Memory {
        object: name.to_owned(),
        mebibytes: requirements.size >> 20,
        reason: error.to_string(),
    })?;
    device.memory().add(allocation.size());
    Ok(allocation)
}

fn free(device: &Device, allocation: Allocation) {
    device.memory().remove(allocation.size());
    let _ = device.allocator().free(allocation);
}
