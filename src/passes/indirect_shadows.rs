//! `indirect_shadows`: one occlusion ray for each pixel and VPL of its class (interleaved sampling), and the irradiance
//! from those VPLs that it sees.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};

use super::gbuffer::GBuffer;
use super::tracer::{RayTracer, Tracer};
use super::vpl_sets::UploadedSet;
use super::work::{Work, WorkQueue};
use crate::vulkan::{Buffer, ComputePipeline, Device, Frame, Texels, Upload, VulkanError, shaders};

/// Pixels of a thread on CPU devices: they run eight threads in step, and where each has a ray or none most of them wait.
const JOINED: u32 = 4;

/// VPLs of each class that one dispatch does at most: watchdogs of GPUs end long ones.
const MOST_VPLS: u32 = 32;

/// Rays of a thread in one dispatch at most: llvmpipe leaves a shader's loops for good after 65,535 turns in all.
const MOST_RAYS: u32 = 64;

/// Groups of threads that one thread casts the rays of at once, at most: few enough that the last to end is seldom late.
const MOST_GROUPS: u32 = 16;

/// Counters that workgroups share the rays out to.
const COUNTERS: usize = 4;
/// Counters' distance in 64-bit words: a cache line.
const COUNTER_STRIDE: usize = 8;

/// What one dispatch does: some VPLs of every class, in a band of the picture.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
struct Push {
    first_texel: u32,
    first_vpl: u32,
    vpls: u32,
    first_row: u32,
    stride: u32,
    first_pixel: u32,
    columns: u32,
    rows: u32,
    work: Work,
}

/// Rows of workgroups' blocks whose irradiance one storage buffer can show.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Band {
    /// Of blocks.
    first_row: u32,
    rows: u32,
    /// In the irradiance.
    first_pixel: u64,
    pixels: u64,
}

/// Blocks that follow one another side by side. Twin: `RUN` in shaders/indirect_shadows.comp.
const RUN: u32 = 4;

/// From one of `runs` to the next, so that all are met: llvmpipe gives each thread a part of the workgroups that follow one
/// another, and waits for the last; apart, they are a sample of the picture.
fn stride(runs: u32) -> u32 {
    // No picture has so many runs that all of these divide their number.
    [61, 59, 53, 47, 43].into_iter().find(|prime| !runs.is_multiple_of(*prime)).unwrap_or(1)
}

/// The picture in bands of at most `limit` bytes of irradiance, at least 2²⁷ as for every device. `block` is the height of a
/// block, a multiple of eight.
fn bands([width, height]: [u32; 2], block: u32, limit: u64) -> impl Iterator<Item = Band> {
    // So many begin where every device lets a storage buffer begin: at a multiple of 256 bytes.
    const ALIGNED: u64 = 4;
    let row = u64::from(block) * u64::from(width);
    let fitting = limit / (row * Texels::Rg32.size()) / ALIGNED * ALIGNED;
    let most = u32::try_from(fitting.max(ALIGNED)).unwrap_or(u32::MAX / 2);
    let rows = height.div_ceil(block);
    let picture = u64::from(width) * u64::from(height);
    (0..rows).step_by(most as usize).map(move |first_row| {
        let first_pixel = u64::from(first_row) * row;
        let rows = most.min(rows - first_row);
        Band { first_row, rows, first_pixel, pixels: (u64::from(rows) * row).min(picture - first_pixel) }
    })
}

/// What the pass reads.
pub struct IndirectShadowsInputs<'a> {
    /// Frame uniforms.
    pub frame: &'a Upload,
    /// The visible surfaces.
    pub gbuffer: &'a GBuffer,
    /// The VPLs.
    pub set: &'a UploadedSet,
    /// What casts the rays.
    pub tracer: &'a Tracer,
}

/// The pass.
pub struct IndirectShadowsPass {
    tracer: RayTracer,
    pipeline: Arc<ComputePipeline>,
    /// Of a thread. Twin: `PIXELS` in shaders/indirect_shadows.comp.
    pixels: u32,
    /// Whether runs of blocks that follow one another lie apart, on CPU devices: see [`stride`].
    scatters: bool,
    irradiance: Buffer,
    /// Bytes of it that a storage buffer shows at most.
    most_shown: u64,
    extent: [u32; 2],
    counters: Buffer,
    queue: WorkQueue,
    interleave: u32,
}

impl IndirectShadowsPass {
    /// Makes the pipelines for a tracer and the irradiance of `extent` texels.
    pub fn new(
        device: &Arc<Device>,
        tracer: RayTracer,
        extent: [u32; 2],
        interleave: u32,
    ) -> Result<Self, VulkanError> {
        let is_cpu = device.is_cpu();
        let pixels = if is_cpu { JOINED } else { 1 };
        let spirv = tracer.of(shaders::INDIRECT_SHADOWS_COMP);
        let pipeline =
            ComputePipeline::specialised(device, "indirect_shadows", spirv, &[interleave, pixels])?;
        Ok(Self {
            tracer,
            pipeline: Arc::new(pipeline),
            pixels,
            scatters: is_cpu,
            irradiance: irradiance(device, extent)?,
            most_shown: u64::from(device.limits().max_storage_buffer_range),
            extent,
            counters: Buffer::new(device, "ray_counters", (COUNTERS * COUNTER_STRIDE * 8) as u64)?,
            queue: WorkQueue::new(device)?,
            interleave,
        })
    }

    /// The same pass for pictures of `extent` texels.
    pub fn resized(&self, device: &Arc<Device>, extent: [u32; 2]) -> Result<Self, VulkanError> {
        Ok(Self {
            tracer: self.tracer,
            pipeline: Arc::clone(&self.pipeline),
            pixels: self.pixels,
            scatters: self.scatters,
            irradiance: irradiance(device, extent)?,
            most_shown: u64::from(device.limits().max_storage_buffer_range),
            extent,
            counters: Buffer::new(device, "ray_counters", (COUNTERS * COUNTER_STRIDE * 8) as u64)?,
            queue: WorkQueue::new(device)?,
            interleave: self.interleave,
        })
    }

    /// Which tracer it is for.
    pub fn tracer(&self) -> RayTracer {
        self.tracer
    }

    /// The rays of this frame, for [`Self::rays`].
    pub fn counters(&self) -> &Buffer {
        &self.counters
    }

    /// The number of rays from the content of [`Self::counters`].
    pub fn rays(counters: &[u8]) -> u64 {
        let word = |bytes: &[u8]| bytes.try_into().map_or(0, u64::from_le_bytes);
        counters.chunks_exact(8).step_by(COUNTER_STRIDE).take(COUNTERS).map(word).sum()
    }

    /// Casts the rays of the set. Out: a texel for each pixel, row by row: irradiance from the VPLs of its class; see
    /// shaders/include/packed_irradiance.glsl.
    pub fn record(
        &mut self,
        frame: &mut Frame<'_>,
        inputs: &IndirectShadowsInputs<'_>,
    ) -> Result<&Buffer, VulkanError> {
        frame.clear(&self.counters);
        let gbuffer = inputs.gbuffer;
        let set = inputs.set;
        let vpls = MOST_VPLS.min(MOST_RAYS / self.pixels);
        // At least one, so that an empty set gives black.
        let most_vpls = set.largest_class.max(1);
        let at_once = (MOST_RAYS / self.pixels / most_vpls).min(MOST_GROUPS);
        // Threads of shaders/indirect_shadows.comp: n^2 groups of 8x8 for each block of 8n x 8n pixels, times the pixels
        // of a thread downwards.
        const GROUP: u32 = 8;
        let n = self.interleave;
        let columns = self.extent[0].div_ceil(GROUP * n).next_multiple_of(RUN);
        for band in bands(self.extent, GROUP * n * self.pixels, self.most_shown) {
            let size = Texels::Rg32.size();
            let irradiance = self.irradiance.slice(band.first_pixel * size, band.pixels * size);
            for first_vpl in (0..most_vpls).step_by(vpls as usize) {
                let work = self.queue.share_out(frame, columns * n * n * band.rows, at_once);
                let pass = frame
                    .pass("indirect_shadows", &self.pipeline)
                    .read("frame_uniforms", inputs.frame)
                    .read("gbuffer_depth", &gbuffer.depth)
                    .read("gbuffer_normal", &gbuffer.normal)
                    .read("vpl_set", &*set.texels)
                    .write("class_irradiance", irradiance)
                    .write("counters", &self.counters)
                    .write("work_taken", self.queue.taken())
                    .push(&Push {
                        first_texel: set.first_texel,
                        first_vpl,
                        vpls,
                        first_row: band.first_row,
                        stride: if self.scatters { stride(columns * band.rows / RUN) } else { 1 },
                        first_pixel: u32::try_from(band.first_pixel).unwrap_or(u32::MAX),
                        columns,
                        rows: band.rows,
                        work,
                    });
                inputs.tracer.bind(pass).dispatch_threads(work.threads(columns * n * n))?;
            }
        }
        Ok(&self.irradiance)
    }
}

fn irradiance(device: &Arc<Device>, extent: [u32; 2]) -> Result<Buffer, VulkanError> {
    let pixels = u64::from(extent[0]) * u64::from(extent[1]);
    Buffer::of_texels(device, "class_irradiance", pixels, Texels::Rg32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_run_is_met() {
        for runs in [1, 2, 61, 64, 61 * 59, 61 * 59 * 53, 2_048 * 512] {
            let mut met: Vec<_> = (0..runs).map(|turn| turn * stride(runs) % runs).collect();
            met.sort_unstable();
            assert!(met.into_iter().eq(0..runs), "{runs}");
        }
    }

    #[test]
    fn bands_cover_the_picture_within_the_limit() {
        let limit = 1 << 27;
        for extent in [[1, 1], [512, 512], [1921, 1081], [7680, 4320], [16384, 16384], [16383, 16381]] {
            for block in [8, 32, 64, 256] {
                let bands: Vec<_> = bands(extent, block, limit).collect();
                let [mut row, mut pixel] = [0, 0];
                for band in &bands {
                    assert_eq!((u64::from(band.first_row), band.first_pixel), (row, pixel));
                    assert!(
                        band.pixels * 8 <= limit && band.first_pixel * 8 % 256 == 0,
                        "{extent:?} {band:?}"
                    );
                    row += u64::from(band.rows);
                    pixel += band.pixels;
                }
                assert_eq!(row, u64::from(extent[1].div_ceil(block)));
                assert_eq!(pixel, u64::from(extent[0]) * u64::from(extent[1]));
            }
        }
        assert_eq!(bands([512, 512], 128, limit).count(), 1);
    }
}
