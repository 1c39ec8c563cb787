//! Frames in flight: command buffer, fence, timers, descriptor pools and upload memory of one frame.
//!
//! In: the commands of [`super::Frame`]. Out: a submission, and its times once the device has finished it.

use std::sync::Arc;

use ash::vk;
use gpu_allocator::MemoryLocation;

use super::upload::mapped;
use super::{Buffer, Device, VulkanError};

/// Most timestamps of a frame.
const MAX_TIMESTAMPS: u32 = 4096;
/// Minimum size of a chunk of upload memory, bytes.
const MIN_CHUNK: u64 = 1 << 20;
/// Most bytes that a frame reads back.
pub(super) const READBACK_SIZE: u64 = 512;

/// Timings and readback of a finished frame.
#[derive(Clone, Debug, Default)]
pub struct FrameTimes {
    /// Number of the frame, from 0.
    pub frame: u64,
    /// Device time of each pass up to the start of the next, ms, in the order of recording; a name may occur several
    /// times.
    pub passes: Vec<(&'static str, f64)>,
    /// What [`Frame::read_back`](super::Frame::read_back) copied.
    pub readback: Vec<u8>,
}

/// Resources of one frame in flight.
pub(super) struct Slot {
    pool: vk::CommandPool,
    /// The frame's command buffer.
    pub(super) commands: vk::CommandBuffer,
    fence: vk::Fence,
    queries: vk::QueryPool,
    descriptors: Vec<vk::DescriptorPool>,
    descriptors_used: usize,
    chunks: Vec<Arc<Buffer>>,
    chunk_used: u64,
    /// Source of [`FrameTimes::readback`].
    pub(super) readback: Buffer,
    /// Names of the timed intervals: timestamp i starts interval i and ends the one before.
    intervals: Vec<&'static str>,
    submitted: Option<u64>,
    frame: u64,
    device: Arc<Device>,
}

impl Slot {
    /// Creates command buffer, timers and readback memory.
    pub(super) fn new(device: &Arc<Device>) -> Result<Self, VulkanError> {
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
                intervals: Vec::new(),
                submitted: None,
                frame: 0,
                device: Arc::clone(device),
            })
        }
    }

    /// Waits for the slot's frame, if one was submitted, and reads its results.
    pub(super) fn finish(&mut self) -> Result<Option<FrameTimes>, VulkanError> {
        let Some(frame) = self.submitted.take() else { return Ok(None) };
        let mut stamps = match self.intervals.len() {
            0 => Vec::new(),
            intervals => vec![0u64; intervals + 1],
        };
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
        let ticks = stamps.windows(2).map(|ends| ends[1].saturating_sub(ends[0]));
        let names = self.intervals.iter().copied();
        let passes = names.zip(ticks.map(|ticks| ticks as f64 * ms_per_tick)).collect();
        Ok(Some(FrameTimes { frame, passes, readback: mapped(&self.readback).to_vec() }))
    }

    /// Starts recording frame number `frame`; the slot's last one must be finished.
    pub(super) fn begin(&mut self, frame: u64) -> Result<(), VulkanError> {
        self.frame = frame;
        self.intervals.clear();
        self.descriptors_used = 0;
        // Merge the chunks of the last frame into one of their total size.
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

    /// Copies `bytes` to upload memory, valid until the frame is done; returns buffer and offset.
    pub(super) fn push_upload(&mut self, bytes: &[u8]) -> Result<(Arc<Buffer>, u64), VulkanError> {
        let size = bytes.len() as u64;
        let limits = self.device.limits();
        let alignment = limits
            .min_storage_buffer_offset_alignment
            .max(limits.min_uniform_buffer_offset_alignment)
            .max(16);
        let mut offset = self.chunk_used.next_multiple_of(alignment);
        let room = self.chunks.last().map_or(0, |chunk| chunk.size);
        if offset + size > room {
            let chunk = self.new_chunk(size.max(MIN_CHUNK))?;
            self.chunks.push(Arc::new(chunk));
            offset = 0;
        }
        let buffer = Arc::clone(&self.chunks[self.chunks.len() - 1]);
        self.chunk_used = offset + size;
        if let Some(target) = buffer.allocation.mapped_ptr() {
            // SAFETY: the chunk is mapped, holds `offset + size` bytes, and this range is used once
            // per frame, after the device has finished the slot's previous frame.
            unsafe {
                let target = target.as_ptr().cast::<u8>().add(usize::try_from(offset).unwrap_or(0));
                std::ptr::copy_nonoverlapping(bytes.as_ptr(), target, bytes.len());
            }
        }
        Ok((buffer, offset))
    }

    fn new_chunk(&self, size: u64) -> Result<Buffer, VulkanError> {
        Buffer::storable(&self.device, "frame uploads", size, MemoryLocation::CpuToGpu)
    }

    /// Ends the current timed interval and starts `name`.
    ///
    /// One timestamp both ends and starts an interval; none is written between passes of the same name.
    pub(super) fn time(&mut self, name: &'static str) {
        // Keep one query for `submit`, which ends the last interval.
        let room = self.intervals.len() + 1 < MAX_TIMESTAMPS as usize;
        if self.intervals.last() != Some(&name) && room {
            self.timestamp();
            self.intervals.push(name);
        }
    }

    /// Writes a timestamp after all recorded commands.
    fn timestamp(&self) {
        let query = u32::try_from(self.intervals.len()).unwrap_or(MAX_TIMESTAMPS - 1);
        // SAFETY: the query is below the pool's size; passes are timed from outside of rendering; the slot's last frame has
        // been read. Only this query is reset: validation layers keep what they know of each beyond the pool's end.
        unsafe {
            let raw = self.device.raw();
            raw.cmd_reset_query_pool(self.commands, self.queries, query, 1);
            raw.cmd_write_timestamp2(
                self.commands,
                vk::PipelineStageFlags2::ALL_COMMANDS,
                self.queries,
                query,
            );
        }
    }

    /// Allocates a descriptor set for the frame being recorded.
    pub(super) fn descriptor_set(
        &mut self,
        layout: vk::DescriptorSetLayout,
        name: &str,
    ) -> Result<vk::DescriptorSet, VulkanError> {
        loop {
            if self.descriptors_used == self.descriptors.len() {
                self.descriptors.push(descriptor_pool(&self.device)?);
            }
            let layouts = [layout];
            let info = vk::DescriptorSetAllocateInfo::default()
                .descriptor_pool(self.descriptors[self.descriptors_used])
                .set_layouts(&layouts);
            // SAFETY: the pool is the slot's own and was reset when the frame began.
            match unsafe { self.device.raw().allocate_descriptor_sets(&info) } {
                Ok(sets) => return Ok(sets[0]),
                Err(vk::Result::ERROR_OUT_OF_POOL_MEMORY | vk::Result::ERROR_FRAGMENTED_POOL) => {
                    self.descriptors_used += 1;
                }
                Err(result) => {
                    return Err(VulkanError::call("allocation", format!("descriptors of {name}"))(result));
                }
            }
        }
    }

    /// Ends the command buffer and submits it.
    pub(super) fn submit(&mut self) -> Result<(), VulkanError> {
        if !self.intervals.is_empty() {
            self.timestamp();
        }
        let buffers = [vk::CommandBufferSubmitInfo::default().command_buffer(self.commands)];
        let submit = vk::SubmitInfo2::default().command_buffer_infos(&buffers);
        let error = |result| VulkanError::call("submission", "frame")(result);
        // SAFETY: recording is complete; what it uses is kept until the fence is signalled.
        unsafe {
            let raw = self.device.raw();
            raw.end_command_buffer(self.commands).map_err(error)?;
            self.device.submit(submit, self.fence).map_err(error)?;
        }
        self.submitted = Some(self.frame);
        Ok(())
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
