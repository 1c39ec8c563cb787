//! Frames in flight: command recording, uploads, pass timers, results.

use std::sync::Arc;

use ash::vk;
use bytemuck::Pod;
use gpu_allocator::MemoryLocation;

use super::access::{Access, Barrier};
use super::barrier::record_barriers;
use super::pipeline::Layout;
use super::upload::mapped;
use super::{Buffer, BufferSlice, ComputePipeline, Device, GraphicsPipeline, Image, Pass, VulkanError};

/// Frames that may be on their way at once: the CPU prepares one while the device does the other.
const IN_FLIGHT: usize = 2;
/// Timestamps a frame may write.
const MAX_TIMESTAMPS: u32 = 4096;
/// Smallest chunk of upload memory.
const MIN_CHUNK: u64 = 1 << 20;
/// Bytes that a frame may give back to the host.
const READBACK_SIZE: u64 = 256;

/// What a finished frame cost and gave back.
#[derive(Clone, Debug, Default)]
pub struct FrameTimes {
    /// Number of the frame, from 0.
    pub frame: u64,
    /// Device time of each pass in ms, in the order of recording; a name may occur several times.
    pub passes: Vec<(&'static str, f64)>,
    /// What [`Frame::read_back`] copied.
    pub readback: Vec<u8>,
}

/// Records and submits frames.
pub struct Frames {
    slots: Vec<Slot>,
    count: u64,
    device: Arc<Device>,
}

impl Frames {
    /// Makes command buffers, timers and upload memory.
    pub fn new(device: &Arc<Device>) -> Result<Self, VulkanError> {
        let slots = (0..IN_FLIGHT).map(|_| Slot::new(device)).collect::<Result<_, _>>()?;
        Ok(Self { slots, count: 0, device: Arc::clone(device) })
    }

    /// Starts the next frame, once the frame before the last one is done; gives that one's times.
    pub fn begin(&mut self) -> Result<(Frame<'_>, Option<FrameTimes>), VulkanError> {
        let index = usize::try_from(self.count).unwrap_or(0) % IN_FLIGHT;
        let slot = &mut self.slots[index];
        let times = slot.finish()?;
        slot.begin(self.count)?;
        self.count += 1;
        Ok((Frame { slot, device: &self.device }, times))
    }

    /// Waits for all frames and gives the times of those not given yet, in order.
    pub fn finish(&mut self) -> Result<Vec<FrameTimes>, VulkanError> {
        let mut times = Vec::new();
        for slot in &mut self.slots {
            times.extend(slot.finish()?);
        }
        times.sort_by_key(|times| times.frame);
        Ok(times)
    }
}

struct Slot {
    pool: vk::CommandPool,
    commands: vk::CommandBuffer,
    fence: vk::Fence,
    queries: vk::QueryPool,
    descriptors: Vec<vk::DescriptorPool>,
    descriptors_used: usize,
    chunks: Vec<Arc<Buffer>>,
    chunk_used: u64,
    readback: Buffer,
    timers: Vec<(&'static str, u32)>,
    submitted: Option<u64>,
    frame: u64,
    device: Arc<Device>,
}

impl Slot {
    fn new(device: &Arc<Device>) -> Result<Self, VulkanError> {
        let error = |result| VulkanError::call("creation", "frame")(result);
        let raw = device.raw();
        let pool_info = vk::CommandPoolCreateInfo::default().queue_family_index(device.queue_family());
        let query_info = vk::QueryPoolCreateInfo::default()
            .query_type(vk::QueryType::TIMESTAMP)
            .query_count(MAX_TIMESTAMPS);
        let readback = Buffer::in_memory(device, "frame readback", READBACK_SIZE, MemoryLocation::GpuToCpu)?;
        // SAFETY: the infos are complete; everything is destroyed in `drop`.
        unsafe {
            let pool = raw.create_command_pool(&pool_info, None).map_err(error)?;
            let info = vk::CommandBufferAllocateInfo::default().command_pool(pool).command_buffer_count(1);
            Ok(Self {
                pool,
                commands: raw.allocate_command_buffers(&info).map_err(error)?[0],
                fence: raw.create_fence(&vk::FenceCreateInfo::default(), None).map_err(error)?,
                queries: raw.create_query_pool(&query_info, None).map_err(error)?,
                descriptors: Vec::new(),
                descriptors_used: 0,
                chunks: Vec::new(),
                chunk_used: 0,
                readback,
                timers: Vec::new(),
                submitted: None,
                frame: 0,
                device: Arc::clone(device),
            })
        }
    }

    /// Waits for the slot's frame, if one is on its way, and reads its results.
    fn finish(&mut self) -> Result<Option<FrameTimes>, VulkanError> {
        let Some(frame) = self.submitted.take() else { return Ok(None) };
        let mut stamps = vec![0u64; self.timers.len() * 2];
        // SAFETY: the fence was submitted with the frame; the queries were written by it.
        unsafe {
            let raw = self.device.raw();
            let error = |result| VulkanError::call("waiting", "frame")(result);
            raw.wait_for_fences(&[self.fence], true, u64::MAX).map_err(error)?;
            if !stamps.is_empty() {
                raw.get_query_pool_results(
                    self.queries,
                    0,
                    &mut stamps,
                    vk::QueryResultFlags::TYPE_64 | vk::QueryResultFlags::WAIT,
                )
                .map_err(error)?;
            }
        }
        let ms_per_tick = f64::from(self.device.limits().timestamp_period) * 1e-6;
        let passes = self
            .timers
            .iter()
            .map(|&(name, first)| {
                let first = first as usize;
                let ticks = stamps[first + 1].saturating_sub(stamps[first]);
                (name, ticks as f64 * ms_per_tick)
            })
            .collect();
        Ok(Some(FrameTimes { frame, passes, readback: mapped(&self.readback).to_vec() }))
    }

    fn begin(&mut self, frame: u64) -> Result<(), VulkanError> {
        self.frame = frame;
        self.timers.clear();
        self.descriptors_used = 0;
        // One chunk that holds all of the last frame's uploads replaces several smaller ones.
        if self.chunks.len() > 1 {
            let size = self.chunks.iter().map(|chunk| chunk.size).sum();
            self.chunks = vec![Arc::new(self.new_chunk(size)?)];
        }
        self.chunk_used = 0;
        let info = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        // SAFETY: `finish` waited, so nothing of the slot is in use.
        unsafe {
            let raw = self.device.raw();
            let error = |result| VulkanError::call("beginning", "frame")(result);
            raw.reset_fences(&[self.fence]).map_err(error)?;
            raw.reset_command_pool(self.pool, vk::CommandPoolResetFlags::empty()).map_err(error)?;
            for pool in &self.descriptors {
                raw.reset_descriptor_pool(*pool, vk::DescriptorPoolResetFlags::empty()).map_err(error)?;
            }
            raw.begin_command_buffer(self.commands, &info).map_err(error)?;
        }
        Ok(())
    }

    fn new_chunk(&self, size: u64) -> Result<Buffer, VulkanError> {
        Buffer::storable(&self.device, "frame uploads", size, MemoryLocation::CpuToGpu)?.with_texels()
    }
}

impl Drop for Slot {
    fn drop(&mut self) {
        // SAFETY: waits for the slot's frame first.
        unsafe {
            let raw = self.device.raw();
            if self.submitted.is_some() {
                let _ = raw.wait_for_fences(&[self.fence], true, u64::MAX);
            }
            for pool in &self.descriptors {
                raw.destroy_descriptor_pool(*pool, None);
            }
            raw.destroy_query_pool(self.queries, None);
            raw.destroy_fence(self.fence, None);
            raw.destroy_command_pool(self.pool, None);
        }
    }
}

/// Data of this frame in memory that the device reads.
#[derive(Clone)]
pub struct Upload {
    buffer: Arc<Buffer>,
    offset: u64,
    size: u64,
}

impl Upload {
    /// Where it begins in the buffer that `utextureBuffer` shows.
    pub fn first_texel(&self) -> u32 {
        u32::try_from(self.offset / Buffer::TEXEL).unwrap_or(u32::MAX)
    }
}

impl<'a> From<&'a Upload> for BufferSlice<'a> {
    fn from(upload: &'a Upload) -> Self {
        upload.buffer.slice(upload.offset, upload.size)
    }
}

/// A frame being recorded.
pub struct Frame<'a> {
    slot: &'a mut Slot,
    device: &'a Arc<Device>,
}

impl Frame<'_> {
    /// Puts `data` into this frame's upload memory; empty data becomes 16 zero bytes.
    pub fn upload<T: Pod>(&mut self, data: &[T]) -> Result<Upload, VulkanError> {
        let bytes: &[u8] = bytemuck::cast_slice(data);
        let bytes = if bytes.is_empty() { &[0; 16] } else { bytes };
        let size = bytes.len() as u64;
        let limits = self.device.limits();
        let alignment = limits
            .min_storage_buffer_offset_alignment
            .max(limits.min_uniform_buffer_offset_alignment)
            .max(16);
        let mut offset = self.slot.chunk_used.next_multiple_of(alignment);
        let room = self.slot.chunks.last().map_or(0, |chunk| chunk.size);
        if offset + size > room {
            let chunk = self.slot.new_chunk(size.max(MIN_CHUNK))?;
            self.slot.chunks.push(Arc::new(chunk));
            offset = 0;
        }
        let buffer = Arc::clone(&self.slot.chunks[self.slot.chunks.len() - 1]);
        self.slot.chunk_used = offset + size;
        if let Some(target) = buffer.allocation.mapped_ptr() {
            // SAFETY: the chunk is mapped, holds `offset + size` bytes, and this range is handed out once
            // a frame, after the device is done with the slot's previous frame.
            unsafe {
                let target = target.as_ptr().cast::<u8>().add(usize::try_from(offset).unwrap_or(0));
                std::ptr::copy_nonoverlapping(bytes.as_ptr(), target, bytes.len());
            }
        }
        Ok(Upload { buffer, offset, size })
    }

    /// Copies `source` to `target` at `offset`.
    pub fn copy<'b>(&mut self, source: impl Into<BufferSlice<'b>>, target: &Buffer, offset: u64) {
        let source = source.into();
        assert!(offset + source.size <= target.size, "copy beyond the end of {}", target.name);
        let barriers = [
            source.buffer.tracker.use_buffer(Access::TransferRead),
            target.tracker.use_buffer(Access::TransferWrite),
        ];
        self.barriers(&[], &barriers.into_iter().flatten().collect::<Vec<_>>());
        let region = [vk::BufferCopy { src_offset: source.offset, dst_offset: offset, size: source.size }];
        // SAFETY: both ranges lie within their buffers; uploads were written before the submission.
        unsafe {
            self.device.raw().cmd_copy_buffer(self.slot.commands, source.buffer.raw, target.raw, &region);
        }
    }

    /// Sets all of `target` to zero.
    pub fn clear(&mut self, target: &Buffer) {
        let barriers = target.tracker.use_buffer(Access::TransferWrite);
        self.barriers(&[], &barriers.into_iter().collect::<Vec<_>>());
        // SAFETY: the buffer can be a transfer destination.
        unsafe {
            self.device.raw().cmd_fill_buffer(self.slot.commands, target.raw, 0, vk::WHOLE_SIZE, 0);
        }
    }

    /// Copies the first bytes of `source` to where [`FrameTimes::readback`] comes from.
    pub fn read_back(&mut self, source: &Buffer) {
        let size = source.size.min(READBACK_SIZE);
        let barriers = source.tracker.use_buffer(Access::TransferRead);
        self.barriers(&[], &barriers.into_iter().collect::<Vec<_>>());
        let region = [vk::BufferCopy::default().size(size)];
        // SAFETY: both buffers hold `size` bytes.
        unsafe {
            self.device.raw().cmd_copy_buffer(
                self.slot.commands,
                source.raw,
                self.slot.readback.raw,
                &region,
            );
        }
    }

    /// Starts recording a compute pass.
    pub fn pass<'f>(&'f mut self, name: &'static str, pipeline: &'f ComputePipeline) -> Pass<'f> {
        Pass::compute(self.recorder(), name, pipeline)
    }

    /// Starts recording a graphics pass.
    pub fn draw_pass<'f>(&'f mut self, name: &'static str, pipeline: &'f GraphicsPipeline) -> Pass<'f> {
        Pass::graphics(self.recorder(), name, pipeline)
    }

    /// Ends and submits the frame.
    pub fn submit(self) -> Result<(), VulkanError> {
        self.barriers(
            &[],
            &[Barrier {
                src_stage: vk::PipelineStageFlags2::ALL_COMMANDS,
                src_access: vk::AccessFlags2::MEMORY_WRITE,
                dst_stage: vk::PipelineStageFlags2::HOST,
                dst_access: vk::AccessFlags2::HOST_READ,
                old_layout: vk::ImageLayout::UNDEFINED,
                new_layout: vk::ImageLayout::UNDEFINED,
            }],
        );
        let buffers = [vk::CommandBufferSubmitInfo::default().command_buffer(self.slot.commands)];
        let submit = vk::SubmitInfo2::default().command_buffer_infos(&buffers);
        let error = |result| VulkanError::call("submission", "frame")(result);
        // SAFETY: recording is complete; what it uses is kept until the fence is signalled.
        unsafe {
            let raw = self.device.raw();
            raw.end_command_buffer(self.slot.commands).map_err(error)?;
            raw.queue_submit2(*self.device.queue(), &[submit], self.slot.fence).map_err(error)?;
        }
        self.slot.submitted = Some(self.slot.frame);
        Ok(())
    }

    fn barriers(&self, images: &[(&Image, Barrier)], buffers: &[Barrier]) {
        record_barriers(self.device, self.slot.commands, images, buffers);
    }

    pub(super) fn recorder(&mut self) -> Recorder<'_> {
        Recorder { slot: self.slot, device: self.device, open_timer: None }
    }
}

/// What a pass records with.
pub(super) struct Recorder<'f> {
    slot: &'f mut Slot,
    device: &'f Arc<Device>,
    /// The query that the open scope ends with.
    open_timer: Option<u32>,
}

impl Recorder<'_> {
    pub(super) fn device(&self) -> &Arc<Device> {
        self.device
    }

    pub(super) fn commands(&self) -> vk::CommandBuffer {
        self.slot.commands
    }

    pub(super) fn barriers(&self, images: &[(&Image, Barrier)], buffers: &[Barrier]) {
        record_barriers(self.device, self.slot.commands, images, buffers);
    }

    /// Opens the debug label and timer of a pass.
    pub(super) fn begin_scope(&mut self, name: &'static str) {
        if let (Some(debug), Ok(text)) = (self.device.debug(), std::ffi::CString::new(name)) {
            let label = vk::DebugUtilsLabelEXT::default().label_name(&text);
            // SAFETY: the command buffer is being recorded; `end_scope` closes the label.
            unsafe { debug.cmd_begin_debug_utils_label(self.slot.commands, &label) };
        }
        let first = u32::try_from(self.slot.timers.len() * 2).unwrap_or(MAX_TIMESTAMPS);
        // A set in very many chunks has more dispatches than there are queries: the rest goes untimed.
        self.open_timer = (first + 1 < MAX_TIMESTAMPS).then_some(first + 1);
        if self.open_timer.is_some() {
            self.slot.timers.push((name, first));
            // These two alone: validation layers keep what they know of each query beyond the pool's end.
            // SAFETY: passes open their scopes outside of rendering; the slot's last frame has been read.
            unsafe {
                self.device.raw().cmd_reset_query_pool(self.slot.commands, self.slot.queries, first, 2);
            }
            self.timestamp(first);
        }
    }

    /// Closes what `begin_scope` opened.
    pub(super) fn end_scope(&mut self) {
        if let Some(last) = self.open_timer.take() {
            self.timestamp(last);
        }
        if let Some(debug) = self.device.debug() {
            // SAFETY: `begin_scope` opened the label.
            unsafe { debug.cmd_end_debug_utils_label(self.slot.commands) };
        }
    }

    fn timestamp(&self, query: u32) {
        // SAFETY: `query` is below the pool's size and was reset when its scope began.
        unsafe {
            self.device.raw().cmd_write_timestamp2(
                self.slot.commands,
                vk::PipelineStageFlags2::ALL_COMMANDS,
                self.slot.queries,
                query,
            );
        }
    }

    /// A descriptor set for this frame.
    pub(super) fn descriptor_set(
        &mut self,
        layout: &Layout,
        name: &str,
    ) -> Result<vk::DescriptorSet, VulkanError> {
        loop {
            if self.slot.descriptors_used == self.slot.descriptors.len() {
                self.slot.descriptors.push(descriptor_pool(self.device)?);
            }
            let layouts = [layout.sets[super::pipeline::PASS_SET as usize]];
            let info = vk::DescriptorSetAllocateInfo::default()
                .descriptor_pool(self.slot.descriptors[self.slot.descriptors_used])
                .set_layouts(&layouts);
            // SAFETY: the pool belongs to this frame's slot and was reset when the frame began.
            match unsafe { self.device.raw().allocate_descriptor_sets(&info) } {
                Ok(sets) => return Ok(sets[0]),
                Err(vk::Result::ERROR_OUT_OF_POOL_MEMORY | vk::Result::ERROR_FRAGMENTED_POOL) => {
                    self.slot.descriptors_used += 1;
                }
                Err(result) => {
                    return Err(VulkanError::call("allocation", format!("descriptors of {name}"))(result));
                }
            }
        }
    }
}

fn descriptor_pool(device: &Device) -> Result<vk::DescriptorPool, VulkanError> {
    const SETS: u32 = 256;
    let mut types = vec![
        vk::DescriptorType::UNIFORM_BUFFER,
        vk::DescriptorType::STORAGE_BUFFER,
        vk::DescriptorType::UNIFORM_TEXEL_BUFFER,
        vk::DescriptorType::STORAGE_TEXEL_BUFFER,
        vk::DescriptorType::SAMPLED_IMAGE,
        vk::DescriptorType::STORAGE_IMAGE,
        vk::DescriptorType::COMBINED_IMAGE_SAMPLER,
    ];
    if device.ray_queries().is_some() {
        types.push(vk::DescriptorType::ACCELERATION_STRUCTURE_KHR);
    }
    let size = |ty| vk::DescriptorPoolSize { ty, descriptor_count: SETS * 8 };
    let sizes: Vec<_> = types.into_iter().map(size).collect();
    let info = vk::DescriptorPoolCreateInfo::default().max_sets(SETS).pool_sizes(&sizes);
    // SAFETY: `info` is complete; the slot destroys the pool.
    unsafe { device.raw().create_descriptor_pool(&info, None) }
        .map_err(VulkanError::call("creation", "descriptor pool"))
}
