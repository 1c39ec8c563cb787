//! Recording the barriers that the access trackers plan.

use ash::vk;

use super::access::{Access, Barrier};
use super::{Device, Image};

/// Records barriers for images, and global ones for buffers.
pub(super) fn record_barriers(
    device: &Device,
    commands: vk::CommandBuffer,
    images: &[(&Image, Barrier)],
    buffers: &[Barrier],
) {
    if images.is_empty() && buffers.is_empty() {
        return;
    }
    let images: Vec<_> = images
        .iter()
        .map(|(image, barrier)| {
            vk::ImageMemoryBarrier2::default()
                .src_stage_mask(barrier.src_stage)
                .src_access_mask(barrier.src_access)
                .dst_stage_mask(barrier.dst_stage)
                .dst_access_mask(barrier.dst_access)
                .old_layout(barrier.old_layout)
                .new_layout(barrier.new_layout)
                .image(image.raw)
                .subresource_range(image.range())
        })
        .collect();
    // Buffers have no layout, so a global memory barrier is as good as a buffer barrier.
    let memory: Vec<_> = buffers
        .iter()
        .map(|barrier| {
            vk::MemoryBarrier2::default()
                .src_stage_mask(barrier.src_stage)
                .src_access_mask(barrier.src_access)
                .dst_stage_mask(barrier.dst_stage)
                .dst_access_mask(barrier.dst_access)
        })
        .collect();
    let info = vk::DependencyInfo::default().image_memory_barriers(&images).memory_barriers(&memory);
    // SAFETY: the images are live objects of the device; no render pass is open.
    unsafe { device.raw().cmd_pipeline_barrier2(commands, &info) };
}

/// Records a use of `image` outside of passes, with its barrier.
pub(super) fn barrier_for_image(device: &Device, commands: vk::CommandBuffer, image: &Image, access: Access) {
    if let Some(barrier) = image.tracker.use_image(access, false) {
        record_barriers(device, commands, &[(image, barrier)], &[]);
    }
}
