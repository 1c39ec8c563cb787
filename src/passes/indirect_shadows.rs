//! `indirect_shadows`: one occlusion ray for each pixel and VPL of its class (interleaved sampling).

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};

use super::gbuffer::GBuffer;
use super::tracer::{RayTracer, Tracer};
use crate::vpl::SetVpls;
use crate::vulkan::{Buffer, ComputePipeline, Device, Frame, Upload, VulkanError, shaders};

/// Most bytes of visibility bits that are kept at a time; a set whose VPLs need more goes in chunks.
const MAX_VISIBILITY_BYTES: u64 = 64 << 20;

/// Most words of 32 VPLs that one dispatch does: llvmpipe leaves a shader's loops for good after 65,535 turns in all, and
/// watchdogs of GPUs end long dispatches.
const WORDS_AT_ONCE: u32 = 2;

/// Counters that workgroups share the rays out to.
const COUNTERS: usize = 4;
/// Counters' distance in 64-bit words: a cache line.
const COUNTER_STRIDE: usize = 8;

/// The VPLs of the frame's set, uploaded.
pub struct UploadedSet {
    /// `GpuVpl`s, class by class.
    pub vpls: Upload,
    /// First VPL of each class, and the end.
    pub class_starts: Upload,
    /// Luminous flux of each class over all sets.
    pub class_flux: Upload,
    /// Their sum.
    pub total_flux: f32,
    /// Words of 32 visibility bits that the largest class needs.
    pub words: u32,
}

impl UploadedSet {
    /// Uploads a set, and the luminous flux of each class over all sets.
    pub fn new(frame: &mut Frame<'_>, set: &SetVpls, class_flux: &[f32]) -> Result<Self, VulkanError> {
        let largest = set.class_starts.windows(2).map(|pair| pair[1] - pair[0]).max().unwrap_or(0);
        Ok(Self {
            vpls: frame.upload(&set.vpls)?,
            class_starts: frame.upload(&set.class_starts)?,
            class_flux: frame.upload(class_flux)?,
            total_flux: class_flux.iter().sum(),
            words: largest.div_ceil(32),
        })
    }
}

/// A run of words of every class, done in one go.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct Chunk {
    /// First word.
    pub first_word: u32,
    /// Number of words.
    pub word_count: u32,
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
    pipeline: Arc<ComputePipeline>,
    tracer: RayTracer,
    visibility: Buffer,
    counters: Buffer,
    words: u32,
    extent: [u32; 2],
    interleave: u32,
}

impl IndirectShadowsPass {
    /// Makes the pipeline and visibility memory for sets of `set_size` slots.
    pub fn new(
        device: &Arc<Device>,
        tracer: RayTracer,
        extent: [u32; 2],
        interleave: u32,
        set_size: u32,
    ) -> Result<Self, VulkanError> {
        let pipeline = ComputePipeline::specialised(
            device,
            "indirect_shadows",
            tracer.of(shaders::INDIRECT_SHADOWS_COMP),
            &[interleave],
        )?;
        Self::with_pipeline(device, (tracer, Arc::new(pipeline)), extent, interleave, set_size)
    }

    /// The same pass for pictures of `extent` texels and sets of `set_size` slots.
    pub fn resized(
        &self,
        device: &Arc<Device>,
        extent: [u32; 2],
        set_size: u32,
    ) -> Result<Self, VulkanError> {
        let pipeline = (self.tracer, Arc::clone(&self.pipeline));
        Self::with_pipeline(device, pipeline, extent, self.interleave, set_size)
    }

    fn with_pipeline(
        device: &Arc<Device>,
        (tracer, pipeline): (RayTracer, Arc<ComputePipeline>),
        extent: [u32; 2],
        interleave: u32,
        set_size: u32,
    ) -> Result<Self, VulkanError> {
        let plane = u64::from(extent[0]) * u64::from(extent[1]) * 4;
        let needed = set_size.div_ceil(interleave * interleave).div_ceil(32).max(1);
        let fitting = u32::try_from((MAX_VISIBILITY_BYTES / plane).max(1)).unwrap_or(1);
        let words = needed.min(fitting).min(WORDS_AT_ONCE);
        Ok(Self {
            pipeline,
            tracer,
            visibility: Buffer::new(device, "visibility", plane * u64::from(words))?,
            counters: Buffer::new(device, "ray_counters", (COUNTERS * COUNTER_STRIDE * 8) as u64)?,
            words,
            extent,
            interleave,
        })
    }

    /// Which tracer it is for.
    pub fn tracer(&self) -> RayTracer {
        self.tracer
    }

    /// The chunks that a set's VPLs are done in; at least one, so that an empty set gives black.
    pub fn chunks(&self, set: &UploadedSet) -> Vec<Chunk> {
        (0..set.words.max(1))
            .step_by(self.words as usize)
            .map(|first_word| Chunk {
                first_word,
                word_count: self.words.min(set.words - first_word.min(set.words)),
            })
            .collect()
    }

    /// The rays of this frame, for [`Self::rays`]; cleared by [`Self::start`].
    pub fn counters(&self) -> &Buffer {
        &self.counters
    }

    /// The number of rays from the content of [`Self::counters`].
    pub fn rays(counters: &[u8]) -> u64 {
        let word = |bytes: &[u8]| bytes.try_into().map_or(0, u64::from_le_bytes);
        counters.chunks_exact(8).step_by(COUNTER_STRIDE).take(COUNTERS).map(word).sum()
    }

    /// One bit a pixel and VPL of the chunk.
    pub fn visibility(&self) -> &Buffer {
        &self.visibility
    }

    /// Forgets the rays of the last frame.
    pub fn start(&self, frame: &mut Frame<'_>) {
        frame.clear(&self.counters);
    }

    /// Casts the rays of one chunk.
    pub fn record(
        &self,
        frame: &mut Frame<'_>,
        inputs: &IndirectShadowsInputs<'_>,
        chunk: &Chunk,
    ) -> Result<&Buffer, VulkanError> {
        let pass = frame
            .pass("indirect_shadows", &self.pipeline)
            .read("frame", inputs.frame)
            .read("gbuffer_position", &inputs.gbuffer.position)
            .read("gbuffer_normal", &inputs.gbuffer.normal)
            .read("vpls", &inputs.set.vpls)
            .read("class_starts", &inputs.set.class_starts)
            .write("visibility", &self.visibility)
            .write("counters", &self.counters)
            .push(chunk);
        inputs.tracer.bind(pass).dispatch_threads(class_grid(self.extent, self.interleave))?;
        Ok(&self.visibility)
    }
}

/// Threads of shaders/indirect_shadows.comp: a row of n^2 groups of 8x8 for each block
/// of 8n x 8n pixels.
fn class_grid(extent: [u32; 2], interleave: u32) -> [u32; 3] {
    const GROUP: u32 = 8;
    let blocks = extent.map(|side| side.div_ceil(GROUP * interleave));
    [blocks[0] * interleave * interleave * GROUP, blocks[1] * GROUP, 1]
}
