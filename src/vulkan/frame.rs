//! Frames in flight: command recording, uploads, pass timers, results.

use std::sync::Arc;

use ash::vk;
use bytemuck::Pod;

use super::access::{Access, Barrier};
use super::barrier::record_barriers;
use super::frame_slot::{FrameTimes, READBACK_SIZE, Slot};
use super::{
    Buffer, BufferSlice, ComputePipeline, Device, GraphicsPipeline, Image, Pass, Resource, SharedSet,
    VulkanError,
};

/// Frames in flight: the CPU records one while the device executes the other.
const IN_FLIGHT: usize = 2;

/// Records and submits frames.
pub struct Frames {
    slots: Vec<Slot>,
    count: u64,
    device: Arc<Device>,
}

impl Frames {
    /// Creates command buffers, timers and upload memory.
    pub fn new(device: &Arc<Device>) -> Result<Self, VulkanError> {
        let slots = (0..IN_FLIGHT).map(|_| Slot::new(device)).collect::<Result<_, _>>()?;
        Ok(Self { slots, count: 0, device: Arc::clone(device) })
    }

    /// Waits for the frame before the last, then starts the next; returns the times of the one waited for.
    pub fn begin(&mut self) -> Result<(Frame<'_>, Option<FrameTimes>), VulkanError> {
        let index = usize::try_from(self.count).unwrap_or(0) % IN_FLIGHT;
        let slot = &mut self.slots[index];
        let times = slot.finish()?;
        slot.begin(self.count)?;
        self.count += 1;
        Ok((Frame { slot, device: &self.device }, times))
    }

    /// Waits for all frames; returns the times not returned yet, in order.
    pub fn finish(&mut self) -> Result<Vec<FrameTimes>, VulkanError> {
        let mut times = Vec::new();
        for slot in &mut self.slots {
            times.extend(slot.finish()?);
        }
        times.sort_by_key(|times| times.frame);
        Ok(times)
    }
}

/// Data in this frame's upload memory.
#[derive(Clone)]
pub struct Upload {
    buffer: Arc<Buffer>,
    offset: u64,
    size: u64,
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
    /// Copies `data` to this frame's upload memory; empty data becomes 16 zero bytes.
    pub fn upload<T: Pod>(&mut self, data: &[T]) -> Result<Upload, VulkanError> {
        let bytes: &[u8] = bytemuck::cast_slice(data);
        let bytes = if bytes.is_empty() { &[0; 16] } else { bytes };
        let (buffer, offset) = self.slot.push_upload(bytes)?;
        Ok(Upload { buffer, offset, size: bytes.len() as u64 })
    }

    /// Copies `source` to `target` at `offset`.
    pub fn copy<'b>(&mut self, source: impl Into<BufferSlice<'b>>, target: &Buffer, offset: u64) {
        let source = source.into();
        assert!(offset + source.size <= target.size, "copy beyond the end of {}", target.name);
        let region = vk::BufferCopy { src_offset: source.offset, dst_offset: offset, size: source.size };
        self.copy_regions(source.buffer, target, &[region]);
    }

    /// Scatters `source` to the byte ranges `runs` of `target`, each (start, end).
    pub fn copy_runs(&mut self, source: &Upload, target: &Buffer, runs: &[(usize, usize)]) {
        let end = runs.iter().map(|run| run.1 as u64).max().unwrap_or(0);
        assert!(end <= target.size, "copy beyond the end of {}", target.name);
        let mut src_offset = source.offset;
        let region = |&(first, end): &(usize, usize)| {
            let region = vk::BufferCopy { src_offset, dst_offset: first as u64, size: (end - first) as u64 };
            src_offset += region.size;
            region
        };
        let regions: Vec<vk::BufferCopy> = runs.iter().map(region).collect();
        assert!(
            src_offset <= source.offset + source.size,
            "copy of more than was uploaded for {}",
            target.name
        );
        self.copy_regions(&source.buffer, target, &regions);
    }

    fn copy_regions(&mut self, source: &Buffer, target: &Buffer, regions: &[vk::BufferCopy]) {
        let barriers = [
            source.tracker.use_buffer(Access::TransferRead),
            target.tracker.use_buffer(Access::TransferWrite),
        ];
        self.barriers(&[], &barriers.into_iter().flatten().collect::<Vec<_>>());
        // SAFETY: all ranges lie within their buffers; uploads were written before the submission.
        unsafe {
            self.device.raw().cmd_copy_buffer(self.slot.commands, source.raw, target.raw, regions);
        }
    }

    /// Clears `target` to zero.
    pub fn clear(&mut self, target: &Buffer) {
        let barriers = target.tracker.use_buffer(Access::TransferWrite);
        self.barriers(&[], &barriers.into_iter().collect::<Vec<_>>());
        // SAFETY: the buffer can be a transfer destination.
        unsafe {
            self.device.raw().cmd_fill_buffer(self.slot.commands, target.raw, 0, vk::WHOLE_SIZE, 0);
        }
    }

    /// Clears a colour image to `value`.
    pub fn clear_image(&mut self, target: &Image, value: [f32; 4]) {
        let barrier = target.tracker.use_image(Access::TransferWrite, false).map(|barrier| (target, barrier));
        self.barriers(&barrier.into_iter().collect::<Vec<_>>(), &[]);
        let value = vk::ClearColorValue { float32: value };
        let layout = vk::ImageLayout::TRANSFER_DST_OPTIMAL;
        // SAFETY: the image can be a transfer destination, and is in the layout for that.
        unsafe {
            let raw = self.device.raw();
            raw.cmd_clear_color_image(self.slot.commands, target.raw, layout, &value, &[target.range()]);
        }
    }

    /// Copies the first bytes of `source` to the readback buffer, see [`FrameTimes::readback`].
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

    /// Writes the set that the passes of this frame share; see [`Pass::shared`].
    ///
    /// # Errors
    /// If a resource is not in shaders/include/scene_set.glsl, or the device has no memory.
    pub fn shared_set<'s>(
        &mut self,
        resources: Vec<(&'static str, Resource<'s>)>,
    ) -> Result<SharedSet<'s>, VulkanError> {
        let raw = self.slot.descriptor_set(self.device.shared_layout().raw, "the scene set")?;
        SharedSet::new(self.device, raw, resources)
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
        self.slot.submit()
    }

    fn barriers(&self, images: &[(&Image, Barrier)], buffers: &[Barrier]) {
        record_barriers(self.device, self.slot.commands, images, buffers);
    }

    pub(super) fn recorder(&mut self) -> Recorder<'_> {
        Recorder { slot: self.slot, device: self.device }
    }
}

/// Command recording of a pass.
pub(super) struct Recorder<'f> {
    slot: &'f mut Slot,
    device: &'f Arc<Device>,
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

    /// Opens the debug label of a pass and starts its timer.
    pub(super) fn begin_scope(&mut self, name: &'static str) {
        if let (Some(debug), Ok(text)) = (self.device.debug(), std::ffi::CString::new(name)) {
            let label = vk::DebugUtilsLabelEXT::default().label_name(&text);
            // SAFETY: the command buffer is being recorded; `end_scope` closes the label.
            unsafe { debug.cmd_begin_debug_utils_label(self.slot.commands, &label) };
        }
        self.slot.time(name);
    }

    /// Closes the debug label; the timer runs until the next pass.
    pub(super) fn end_scope(&mut self) {
        if let Some(debug) = self.device.debug() {
            // SAFETY: `begin_scope` opened the label.
            unsafe { debug.cmd_end_debug_utils_label(self.slot.commands) };
        }
    }

    /// Allocates a descriptor set for this frame.
    pub(super) fn descriptor_set(
        &mut self,
        layout: vk::DescriptorSetLayout,
        name: &str,
    ) -> Result<vk::DescriptorSet, VulkanError> {
        self.slot.descriptor_set(layout, name)
    }
}
