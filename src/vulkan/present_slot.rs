//! One presented frame in flight: copies the panes to the swapchain's image, draws the interface and submits both.

use std::sync::Arc;

use ash::vk;

use super::access::Access;
use super::barrier::barrier_for_image;
use super::swapchain::{Swapchain, SwapchainImage, WHOLE};
use super::{Device, Image, VulkanError};

/// Timestamps: before the picture, before and after the interface.
const TIMESTAMPS: u32 = 3;

/// The rectangle of the window that shows pictures, pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Viewport {
    /// Top left corner.
    pub corner: [u32; 2],
    /// Width and height.
    pub size: [u32; 2],
}

/// A picture in a range of the viewport's columns, each shown where the whole picture would have it.
#[derive(Clone, Copy)]
pub struct Pane<'a> {
    /// sRGB-encoded; scaled to the viewport.
    pub picture: &'a Image,
    /// From this share of the width to that, 0 to 1.
    pub columns: [f32; 2],
}

impl Viewport {
    /// The part of it that lies in a window of `extent` pixels, which may have been resized meanwhile.
    pub(super) fn within(self, extent: [u32; 2]) -> Self {
        let corner = [0, 1].map(|axis| self.corner[axis].min(extent[axis]));
        Self { corner, size: [0, 1].map(|axis| self.size[axis].min(extent[axis] - corner[axis])) }
    }
}

/// Resources of one frame in flight.
pub(super) struct Slot {
    pool: vk::CommandPool,
    commands: vk::CommandBuffer,
    fence: vk::Fence,
    /// The swapchain signals it when it has acquired the frame's image.
    pub acquired: vk::Semaphore,
    queries: vk::QueryPool,
    submitted: bool,
    device: Arc<Device>,
}

impl Slot {
    pub fn new(device: &Arc<Device>) -> Result<Self, VulkanError> {
        let error = |result| VulkanError::call("creation", "presentation")(result);
        let raw = device.raw();
        let pool_info = vk::CommandPoolCreateInfo::default().queue_family_index(device.queue_family());
        let query_info =
            vk::QueryPoolCreateInfo::default().query_type(vk::QueryType::TIMESTAMP).query_count(TIMESTAMPS);
        // SAFETY: the infos are complete; everything is destroyed in `drop`.
        unsafe {
            let pool = raw.create_command_pool(&pool_info, None).map_err(error)?;
            let info = vk::CommandBufferAllocateInfo::default().command_pool(pool).command_buffer_count(1);
            Ok(Self {
                pool,
                commands: raw.allocate_command_buffers(&info).map_err(error)?[0],
                fence: raw.create_fence(&vk::FenceCreateInfo::default(), None).map_err(error)?,
                acquired: raw.create_semaphore(&vk::SemaphoreCreateInfo::default(), None).map_err(error)?,
                queries: raw.create_query_pool(&query_info, None).map_err(error)?,
                submitted: false,
                device: Arc::clone(device),
            })
        }
    }

    /// Waits for the slot's frame, if one was submitted; returns the device time of its interface, ms.
    pub fn finish(&mut self) -> Result<Option<f64>, VulkanError> {
        if !std::mem::take(&mut self.submitted) {
            return Ok(None);
        }
        let mut stamps = [0u64; TIMESTAMPS as usize];
        let flags = vk::QueryResultFlags::TYPE_64 | vk::QueryResultFlags::WAIT;
        // SAFETY: the fence was submitted with the frame; the queries were written by it.
        unsafe {
            let raw = self.device.raw();
            let error = |result| VulkanError::call("waiting", "presentation")(result);
            raw.wait_for_fences(&[self.fence], true, u64::MAX).map_err(error)?;
            raw.get_query_pool_results(self.queries, 0, &mut stamps, flags).map_err(error)?;
        }
        let ticks = stamps[2].saturating_sub(stamps[1]) as f64;
        Ok(Some(ticks * f64::from(self.device.limits().timestamp_period) * 1e-6))
    }

    pub fn begin(&mut self) -> Result<(), VulkanError> {
        let info = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        let error = |result| VulkanError::call("beginning", "presentation")(result);
        // SAFETY: `finish` waited, so nothing of the slot is in use.
        unsafe {
            let raw = self.device.raw();
            raw.reset_fences(&[self.fence]).map_err(error)?;
            raw.reset_command_pool(self.pool, vk::CommandPoolResetFlags::empty()).map_err(error)?;
            raw.begin_command_buffer(self.commands, &info).map_err(error)?;
            raw.cmd_reset_query_pool(self.commands, self.queries, 0, TIMESTAMPS);
        }
        Ok(())
    }

    pub fn record(
        &self,
        (swapchain, image): (&Swapchain, &SwapchainImage),
        panes: &[Pane<'_>],
        viewport: Viewport,
        draw_ui: impl FnOnce(vk::CommandBuffer) -> Result<(), VulkanError>,
    ) -> Result<(), VulkanError> {
        use vk::{AccessFlags2 as A, ImageLayout as L, PipelineStageFlags2 as S};
        let written = (S::ALL_TRANSFER, A::TRANSFER_WRITE, L::TRANSFER_DST_OPTIMAL);
        let target = (
            S::COLOR_ATTACHMENT_OUTPUT,
            A::COLOR_ATTACHMENT_READ | A::COLOR_ATTACHMENT_WRITE,
            L::COLOR_ATTACHMENT_OPTIMAL,
        );
        let shown = (S::NONE, A::NONE, L::PRESENT_SRC_KHR);
        self.write_timestamp(0);
        // The acquire semaphore blocks these stages; the barrier chains after them.
        self.barrier(image.raw, (S::ALL_TRANSFER, A::NONE, L::UNDEFINED), written);
        let is_covered = viewport.size == [swapchain.extent.width, swapchain.extent.height];
        if panes.is_empty() || !is_covered {
            self.clear(image.raw);
            self.barrier(image.raw, written, written);
        }
        for (index, pane) in panes.iter().enumerate() {
            if index > 0 {
                // Panes of pictures of different sizes overlap: see `spans`.
                self.barrier(image.raw, written, written);
            }
            self.copy(pane, image.raw, viewport);
        }
        self.barrier(image.raw, written, target);
        self.write_timestamp(1);
        let colors = [vk::RenderingAttachmentInfo::default()
            .image_view(image.view)
            .image_layout(L::COLOR_ATTACHMENT_OPTIMAL)
            .load_op(vk::AttachmentLoadOp::LOAD)
            .store_op(vk::AttachmentStoreOp::STORE)];
        let info = vk::RenderingInfo::default()
            .render_area(swapchain.extent.into())
            .layer_count(1)
            .color_attachments(&colors);
        // SAFETY: the image is in attachment layout; rendering is ended below even after an error.
        unsafe { self.device.raw().cmd_begin_rendering(self.commands, &info) };
        let drawn = draw_ui(self.commands);
        // SAFETY: closes what was begun above.
        unsafe { self.device.raw().cmd_end_rendering(self.commands) };
        self.write_timestamp(2);
        self.barrier(image.raw, target, shown);
        drawn
    }

    /// Clears `target` to black.
    fn clear(&self, target: vk::Image) {
        let black = vk::ClearColorValue { float32: [0.0, 0.0, 0.0, 1.0] };
        let layout = vk::ImageLayout::TRANSFER_DST_OPTIMAL;
        // SAFETY: the image is in this layout and can be a transfer destination.
        unsafe {
            self.device.raw().cmd_clear_color_image(self.commands, target, layout, &black, &[WHOLE]);
        }
    }

    /// Blits a pane to its columns of `viewport` in `target`, scaled if the sizes differ.
    fn copy(&self, pane: &Pane<'_>, target: vk::Image, viewport: Viewport) {
        let picture = pane.picture;
        let layers = vk::ImageSubresourceLayers {
            aspect_mask: vk::ImageAspectFlags::COLOR,
            mip_level: 0,
            base_array_layer: 0,
            layer_count: 1,
        };
        let size = picture.extent();
        let [columns, shown] = spans(pane.columns, size[0], viewport.size[0]);
        if columns[0] >= columns[1] || shown[0] >= shown[1] || viewport.size[1] == 0 {
            return;
        }
        barrier_for_image(&self.device, self.commands, picture, Access::TransferRead);
        let corners = |corner: [u32; 2], [left, right]: [f32; 2], height: u32| {
            let [x, y] = corner.map(u32::cast_signed);
            let end = vk::Offset3D { x: x + right as i32, y: y + height.cast_signed(), z: 1 };
            [vk::Offset3D { x: x + left as i32, y, z: 0 }, end]
        };
        let filter = if size == viewport.size { vk::Filter::NEAREST } else { vk::Filter::LINEAR };
        let region = [vk::ImageBlit::default()
            .src_subresource(layers)
            .src_offsets(corners([0, 0], columns, size[1]))
            .dst_subresource(layers)
            .dst_offsets(corners(viewport.corner, shown, viewport.size[1]))];
        // SAFETY: both images are in these layouts; the picture lives until the frame is done.
        unsafe {
            self.device.raw().cmd_blit_image(
                self.commands,
                picture.raw,
                vk::ImageLayout::TRANSFER_SRC_OPTIMAL,
                target,
                vk::ImageLayout::TRANSFER_DST_OPTIMAL,
                &region,
                filter,
            );
        }
    }

    fn barrier(&self, image: vk::Image, from: Usage, to: Usage) {
        let barrier = [vk::ImageMemoryBarrier2::default()
            .src_stage_mask(from.0)
            .src_access_mask(from.1)
            .old_layout(from.2)
            .dst_stage_mask(to.0)
            .dst_access_mask(to.1)
            .new_layout(to.2)
            .image(image)
            .subresource_range(WHOLE)];
        let info = vk::DependencyInfo::default().image_memory_barriers(&barrier);
        // SAFETY: the image is a live one of the swapchain; no rendering is open.
        unsafe { self.device.raw().cmd_pipeline_barrier2(self.commands, &info) };
    }

    fn write_timestamp(&self, query: u32) {
        let stage = vk::PipelineStageFlags2::ALL_COMMANDS;
        // SAFETY: the query was reset when recording began.
        unsafe { self.device.raw().cmd_write_timestamp2(self.commands, stage, self.queries, query) };
    }

    pub fn submit(&mut self, drawn: vk::Semaphore) -> Result<(), VulkanError> {
        let buffers = [vk::CommandBufferSubmitInfo::default().command_buffer(self.commands)];
        let waits = [vk::SemaphoreSubmitInfo::default()
            .semaphore(self.acquired)
            .stage_mask(vk::PipelineStageFlags2::ALL_TRANSFER)];
        let signals = [vk::SemaphoreSubmitInfo::default()
            .semaphore(drawn)
            .stage_mask(vk::PipelineStageFlags2::ALL_COMMANDS)];
        let submit = vk::SubmitInfo2::default()
            .command_buffer_infos(&buffers)
            .wait_semaphore_infos(&waits)
            .signal_semaphore_infos(&signals);
        let error = |result| VulkanError::call("submission", "presentation")(result);
        // SAFETY: recording is complete; what it uses is kept until the fence is signalled.
        unsafe {
            let raw = self.device.raw();
            raw.end_command_buffer(self.commands).map_err(error)?;
            self.device.submit(submit, self.fence).map_err(error)?;
        }
        self.submitted = true;
        Ok(())
    }
}

/// The columns of a picture of `width` columns in the range `shares` of its width, 0 to 1, and those of a viewport of
/// `viewport` columns that show them. Blits copy whole columns: the range is rounded outwards, so that adjacent panes
/// leave no column out.
fn spans(shares: [f32; 2], width: u32, viewport: u32) -> [[f32; 2]; 2] {
    let columns = [(shares[0] * width as f32).floor(), (shares[1] * width as f32).ceil()];
    [columns, columns.map(|column| (column / width as f32 * viewport as f32).round())]
}

/// Stage, access and layout of a use.
type Usage = (vk::PipelineStageFlags2, vk::AccessFlags2, vk::ImageLayout);

impl Drop for Slot {
    fn drop(&mut self) {
        // SAFETY: the presenter waited for the device.
        unsafe {
            let raw = self.device.raw();
            raw.destroy_query_pool(self.queries, None);
            raw.destroy_semaphore(self.acquired, None);
            raw.destroy_fence(self.fence, None);
            raw.destroy_command_pool(self.pool, None);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn panes_of_different_pictures_cover_the_viewport() {
        for (left, right, viewport) in [(640, 640, 640), (320, 640, 640), (411, 97, 640), (1280, 333, 901)] {
            for divider in (0..=1000).map(|step| step as f32 / 1000.0) {
                let [columns, before] = spans([0.0, divider], left, viewport);
                let [_, after] = spans([divider, 1.0], right, viewport);
                assert!(columns[1] <= left as f32, "{columns:?} of {left}");
                assert!(before[1] >= after[0], "{divider}: a gap from {} to {}", before[1], after[0]);
                let overlap = viewport as f32 * (1.0 / left as f32 + 1.0 / right as f32);
                assert!(before[1] - after[0] <= overlap + 1.0, "{divider}: {before:?} and {after:?}");
                assert_eq!([before[0], after[1]], [0.0, viewport as f32]);
            }
        }
    }
}
