//! `indirect_shading`: the discontinuity filter, which joins the classes of each pixel's neighbourhood and writes the set
//! buffer. Which neighbours lie on a pixel's surface is worked out where the G-buffer has changed, and kept. So is what flux
//! their classes have, unless that of a class has just changed, as it does in every frame while VPLs are replaced.

use bytemuck::{Pod, Zeroable};

use std::sync::Arc;

use super::gbuffer::Surfaces;
use super::indirect_shadows::UploadedSet;
use super::set_history::SetHistory;
use crate::vulkan::{Area, Buffer, ComputePipeline, Device, Frame, Texels, Upload, VulkanError, shaders};

/// Pixels of a thread, one below the other. Twin: `ROWS` in shaders/include/window.glsl.
const ROWS: u32 = 4;
/// Columns of pixels of a thread of the filter. Twin: `COLUMNS` in shaders/discontinuity_filter.comp.
const COLUMNS: u32 = 2;

/// What the pass reads.
pub struct IndirectShadingInputs<'a> {
    /// Frame uniforms.
    pub frame: &'a Upload,
    /// The visible surfaces.
    pub surfaces: Surfaces<'a>,
    /// What each pixel has got from its class; see `IndirectShadowsPass::record`.
    pub class_irradiance: &'a Buffer,
    /// The VPLs of the set.
    pub vpls: &'a UploadedSet,
    /// Luminous flux of each class over all sets.
    pub class_flux: &'a [f32],
    /// Fraction of view depth.
    pub position_cutoff: f32,
}

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Push {
    total_flux: f32,
    layer: u32,
    first_texel: u32,
}

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct WeighPush {
    first: [u32; 2],
    first_texel: u32,
    pad: u32,
}

/// The pass.
pub struct IndirectShadingPass {
    pack: Arc<ComputePipeline>,
    compare: Arc<ComputePipeline>,
    weigh: Arc<ComputePipeline>,
    filter: Arc<ComputePipeline>,
    /// The same, which needs no `present_flux`.
    weighing_filter: Arc<ComputePipeline>,
    /// Depth and normal of each pixel, row by row; see shaders/include/packed_surface.glsl.
    packed_surfaces: Buffer,
    /// A bit for each pixel of a pixel's window; see shaders/include/window.glsl.
    discontinuities: Buffer,
    /// Luminous flux of the classes that a pixel's window brings together; see shaders/present_flux.comp.
    present_flux: Buffer,
    extent: [u32; 2],
    interleave: u32,
    /// The flux of each class in the frame before.
    class_flux: Vec<f32>,
    /// Whether `present_flux` was worked out with that.
    weighed: bool,
    /// The cut-off that they were worked out with; none before the first frame.
    compared: Option<f32>,
}

impl IndirectShadingPass {
    /// Makes the pipelines, and the discontinuity buffer of `extent` texels.
    pub fn new(device: &Arc<Device>, extent: [u32; 2], interleave: u32) -> Result<Self, VulkanError> {
        let pipeline =
            |name, spirv| ComputePipeline::specialised(device, name, spirv, &[interleave]).map(Arc::new);
        let filter = |weighs| {
            let spirv = shaders::DISCONTINUITY_FILTER_COMP;
            let constants = [interleave, weighs];
            ComputePipeline::specialised(device, "discontinuity_filter", spirv, &constants).map(Arc::new)
        };
        Ok(Self {
            pack: pipeline("packed_surfaces", shaders::PACKED_SURFACES_COMP)?,
            compare: pipeline("discontinuities", shaders::DISCONTINUITIES_COMP)?,
            weigh: pipeline("present_flux", shaders::PRESENT_FLUX_COMP)?,
            filter: filter(0)?,
            weighing_filter: filter(1)?,
            packed_surfaces: packed_surfaces(device, extent)?,
            discontinuities: discontinuities(device, extent, interleave)?,
            present_flux: texels_of_threads(device, "present_flux", extent, 1)?,
            class_flux: Vec::new(),
            weighed: false,
            extent,
            interleave,
            compared: None,
        })
    }

    /// The same pass for pictures of `extent` texels.
    pub fn resized(&self, device: &Arc<Device>, extent: [u32; 2]) -> Result<Self, VulkanError> {
        Ok(Self {
            pack: Arc::clone(&self.pack),
            compare: Arc::clone(&self.compare),
            weigh: Arc::clone(&self.weigh),
            filter: Arc::clone(&self.filter),
            weighing_filter: Arc::clone(&self.weighing_filter),
            packed_surfaces: packed_surfaces(device, extent)?,
            discontinuities: discontinuities(device, extent, self.interleave)?,
            present_flux: texels_of_threads(device, "present_flux", extent, 1)?,
            class_flux: Vec::new(),
            weighed: false,
            extent,
            interleave: self.interleave,
            compared: None,
        })
    }

    /// Filters into the spare layer of the set buffers.
    pub fn record(
        &mut self,
        frame: &mut Frame<'_>,
        inputs: &IndirectShadingInputs<'_>,
        sets: &SetHistory,
    ) -> Result<(), VulkanError> {
        let [width, height] = self.extent;
        let threads = [width, height.div_ceil(ROWS)];
        let normal = &inputs.surfaces.gbuffer.normal;
        let first_texel = inputs.vpls.first_texel();
        let compared = self.compared.replace(inputs.position_cutoff);
        let changed = if compared == Some(inputs.position_cutoff) {
            inputs.surfaces.changed
        } else {
            Area::whole(self.extent)
        };
        // Windows reach as far as n texels beyond their pixels, those at the borders included.
        let touched = threads_of(changed.grown(self.interleave, self.extent));
        if !changed.is_empty() {
            frame
                .pass("indirect_shading", &self.pack)
                .read("frame_uniforms", inputs.frame)
                .read("gbuffer_depth", &inputs.surfaces.gbuffer.depth)
                .read("gbuffer_normal", normal)
                .write("packed_surfaces", &self.packed_surfaces)
                .push(&changed.offset)
                .dispatch_over(changed.extent)?;
            frame
                .pass("indirect_shading", &self.compare)
                .read("frame_uniforms", inputs.frame)
                .read("gbuffer_normal", normal)
                .read("packed_surfaces", &self.packed_surfaces)
                .write("discontinuities", &self.discontinuities)
                .push(&touched.offset)
                .dispatch_over(touched.extent)?;
        }
        // What only this frame needs, the filter works out itself.
        let stays = self.class_flux == inputs.class_flux;
        let weighed = match (stays, self.weighed) {
            (true, true) => touched,
            (true, false) => Area::whole(threads),
            (false, _) => Area::default(),
        };
        self.class_flux.clear();
        self.class_flux.extend_from_slice(inputs.class_flux);
        self.weighed = stays;
        if !weighed.is_empty() {
            frame
                .pass("indirect_shading", &self.weigh)
                .read("frame_uniforms", inputs.frame)
                .read("vpl_set", &inputs.vpls.texels)
                .read("discontinuities", &self.discontinuities)
                .write("present_flux", &self.present_flux)
                .push(&WeighPush { first: weighed.offset, first_texel, pad: 0 })
                .dispatch_over(weighed.extent)?;
        }
        let push = Push { total_flux: inputs.vpls.total_flux, layer: sets.spare_layer(), first_texel };
        frame
            .pass("indirect_shading", if stays { &self.filter } else { &self.weighing_filter })
            .read("frame_uniforms", inputs.frame)
            .read("gbuffer_normal", normal)
            .read("class_irradiance", inputs.class_irradiance)
            .read("packed_surfaces", &self.packed_surfaces)
            .read("discontinuities", &self.discontinuities)
            .read("present_flux", &self.present_flux)
            .read("vpl_set", &inputs.vpls.texels)
            .write("set_buffers", sets.buffers())
            .push(&push)
            .dispatch_over([width.div_ceil(COLUMNS), threads[1]])
    }
}

/// The threads, of [`ROWS`] pixels each, that take care of the pixels of an area.
fn threads_of(area: Area) -> Area {
    let [x, y] = area.offset;
    let rows = if area.is_empty() { 0 } else { area.end()[1].div_ceil(ROWS) - y / ROWS };
    Area { offset: [x, y / ROWS], extent: [area.extent[0], rows] }
}

fn packed_surfaces(device: &Arc<Device>, [width, height]: [u32; 2]) -> Result<Buffer, VulkanError> {
    Buffer::of_texels(device, "packed_surfaces", u64::from(width) * u64::from(height), Texels::R32)
}

fn discontinuities(device: &Arc<Device>, extent: [u32; 2], interleave: u32) -> Result<Buffer, VulkanError> {
    texels_of_threads(device, "discontinuities", extent, words(interleave))
}

/// Texels of which each has a word for each pixel of a thread.
fn texels_of_threads(
    device: &Arc<Device>,
    name: &str,
    [width, height]: [u32; 2],
    texels: u32,
) -> Result<Buffer, VulkanError> {
    let threads = u64::from(width) * u64::from(height.div_ceil(ROWS));
    Buffer::of_texels(device, name, threads * u64::from(texels), Texels::Rgba32)
}

/// Words of 32 bits that hold the window's rows, each whole. Twin: `WORDS` in shaders/include/window.glsl.
fn words(interleave: u32) -> u32 {
    let width = if interleave.is_multiple_of(2) { interleave + 1 } else { interleave };
    width.div_ceil(32 / width)
}
