//! `indirect_shadows`: one occlusion ray for each pixel and VPL of its class (interleaved sampling), and the irradiance
//! from those VPLs that it sees.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};

use super::gbuffer::GBuffer;
use super::tracer::{RayTracer, Tracer};
use crate::vpl::SetVpls;
use crate::vulkan::{Buffer, ComputePipeline, Device, Frame, Texels, Upload, VulkanError, shaders};

/// VPLs of each class that one dispatch does: llvmpipe leaves a shader's loops for good after 65,535 turns in all, and
/// watchdogs of GPUs end long dispatches.
const WORD: u32 = 32;

/// Pixels of a thread that takes care of several. Twin: `PIXELS` in shaders/indirect_shadows.comp.
const JOINED: u32 = 4;

/// Up to this many VPLs of a class that pays.
const FEW: u32 = 8;

/// Counters that workgroups share the rays out to.
const COUNTERS: usize = 4;
/// Counters' distance in 64-bit words: a cache line.
const COUNTER_STRIDE: usize = 8;

/// The VPLs of the frame's set, uploaded.
pub struct UploadedSet {
    /// A [`ClassTexel`] for each class, then the [`GpuVpl`]s, class by class.
    pub texels: Upload,
    /// Luminous flux of all classes over all sets.
    pub total_flux: f32,
    /// VPLs of the largest class.
    largest_class: u32,
}

/// What shaders/include/vpl_set.glsl has to know of a class.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct ClassTexel {
    first: u32,
    end: u32,
    /// Luminous, over all sets.
    flux: f32,
    pad: u32,
}

impl UploadedSet {
    /// Uploads a set, and the luminous flux of each class over all sets.
    pub fn new(frame: &mut Frame<'_>, set: &SetVpls, class_flux: &[f32]) -> Result<Self, VulkanError> {
        let ranges = || set.class_starts.windows(2).map(|pair| (pair[0], pair[1]));
        let classes: Vec<_> = ranges()
            .zip(class_flux)
            .map(|((first, end), &flux)| ClassTexel { first, end, flux, pad: 0 })
            .collect();
        let bytes = [bytemuck::cast_slice::<_, u8>(&classes), bytemuck::cast_slice(&set.vpls)].concat();
        Ok(Self {
            texels: frame.upload(&bytes)?,
            total_flux: class_flux.iter().sum(),
            largest_class: ranges().map(|(first, end)| end - first).max().unwrap_or(0),
        })
    }

    /// Where in the texels' buffer the set begins.
    pub fn first_texel(&self) -> u32 {
        self.texels.first_texel()
    }
}

/// What one dispatch does: a word of every class.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
struct Push {
    first_texel: u32,
    word: u32,
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
    /// With one pixel a thread.
    single: Arc<ComputePipeline>,
    /// With [`JOINED`] pixels a thread, on CPU devices: they run eight threads in step, and where each has hardly a ray most
    /// of them wait.
    joined: Option<Arc<ComputePipeline>>,
    irradiance: Buffer,
    extent: [u32; 2],
    counters: Buffer,
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
        let pipeline = |pixels| {
            let spirv = tracer.of(shaders::INDIRECT_SHADOWS_COMP);
            ComputePipeline::specialised(device, "indirect_shadows", spirv, &[interleave, pixels])
                .map(Arc::new)
        };
        let is_cpu = device.info().kind == "cpu";
        Ok(Self {
            tracer,
            single: pipeline(1)?,
            joined: is_cpu.then(|| pipeline(JOINED)).transpose()?,
            irradiance: irradiance(device, extent)?,
            extent,
            counters: Buffer::new(device, "ray_counters", (COUNTERS * COUNTER_STRIDE * 8) as u64)?,
            interleave,
        })
    }

    /// The same pass for pictures of `extent` texels.
    pub fn resized(&self, device: &Arc<Device>, extent: [u32; 2]) -> Result<Self, VulkanError> {
        Ok(Self {
            tracer: self.tracer,
            single: Arc::clone(&self.single),
            joined: self.joined.clone(),
            irradiance: irradiance(device, extent)?,
            extent,
            counters: Buffer::new(device, "ray_counters", (COUNTERS * COUNTER_STRIDE * 8) as u64)?,
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
        let joined = self.joined.as_ref().filter(|_| set.largest_class <= FEW);
        let (pipeline, pixels) = joined.map_or((&self.single, 1), |joined| (joined, JOINED));
        // At least one, so that an empty set gives black.
        for word in 0..set.largest_class.div_ceil(WORD).max(1) {
            let pass = frame
                .pass("indirect_shadows", pipeline)
                .read("frame_uniforms", inputs.frame)
                .read("gbuffer_position", &gbuffer.position)
                .read("gbuffer_normal", &gbuffer.normal)
                .read("vpl_set", &set.texels)
                .write("class_irradiance", &self.irradiance)
                .write("counters", &self.counters)
                .push(&Push { first_texel: set.first_texel(), word });
            inputs.tracer.bind(pass).dispatch_threads(self.threads(pixels))?;
        }
        Ok(&self.irradiance)
    }

    /// Threads of shaders/indirect_shadows.comp: a row of n^2 groups of 8x8 for each block of 8n x 8n pixels, times
    /// the pixels of a thread downwards.
    fn threads(&self, pixels: u32) -> [u32; 3] {
        const GROUP: u32 = 8;
        let [width, height] = self.extent;
        let columns = width.div_ceil(GROUP * self.interleave);
        let rows = height.div_ceil(GROUP * self.interleave * pixels);
        [columns * self.interleave * self.interleave * GROUP, rows * GROUP, 1]
    }
}

fn irradiance(device: &Arc<Device>, extent: [u32; 2]) -> Result<Buffer, VulkanError> {
    let pixels = u64::from(extent[0]) * u64::from(extent[1]);
    Buffer::of_texels(device, "class_irradiance", pixels, Texels::Rg32)
}
