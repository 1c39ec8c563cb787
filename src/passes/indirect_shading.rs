//! `indirect_shading`: the discontinuity filter, which joins the classes of each pixel's neighbourhood and writes the set
//! buffer. Which neighbours lie on a pixel's surface is worked out where the G-buffer has changed, and kept. So is what flux
//! their classes have, unless that of a class has just changed, as it does in every frame while VPLs are replaced.

use bytemuck::{Pod, Zeroable};

use std::sync::Arc;

use super::gbuffer::Surfaces;
use super::set_history::SetHistory;
use super::tile_list;
use super::vpl_sets::UploadedSet;
use crate::vulkan::{Area, Buffer, ComputePipeline, Device, Frame, Texels, Upload, VulkanError, shaders};

/// Pixels of a thread, one below the other. Twin: `ROWS` in shaders/include/window.glsl.
const ROWS: u32 = 4;
/// Pixels of a tile of the filter. Twin: `TILE` in shaders/include/filter_tiles.glsl.
const TILE: [u32; 2] = [8, 2 * ROWS];

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
    pipelines: Arc<Pipelines>,
    /// Depth and normal of each pixel, row by row; see shaders/include/packed_surface.glsl.
    packed_surfaces: Buffer,
    /// A bit for each pixel of a pixel's window; see shaders/include/window.glsl.
    discontinuities: Buffer,
    /// Luminous flux of the classes that a pixel's window brings together; see shaders/present_flux.comp.
    present_flux: Buffer,
    tiles: TileLists,
    extent: [u32; 2],
    interleave: u32,
    /// The flux of each class in the frame before.
    class_flux: Vec<f32>,
    /// Whether `present_flux` was worked out with that.
    weighed: bool,
    /// The cut-off that discontinuities and tiles were worked out with; none before the first frame.
    compared: Option<f32>,
}

/// The tiles of the picture by what the filter has to do with them; see shaders/filter_tiles.comp.
struct TileLists {
    /// All windows lie on one surface.
    whole: Buffer,
    /// Some do not.
    mixed: Buffer,
    /// Some are moved inside of the picture.
    edge: Buffer,
}

struct Pipelines {
    pack: ComputePipeline,
    compare: ComputePipeline,
    sort_tiles: ComputePipeline,
    weigh: ComputePipeline,
    filter_whole: ComputePipeline,
    /// With `present_flux` of an earlier frame.
    filter: Filters,
    /// Without.
    weighing_filter: Filters,
}

/// The filter where not all windows lie on one surface.
struct Filters {
    mixed: ComputePipeline,
    edge: ComputePipeline,
}

impl IndirectShadingPass {
    /// Makes the pipelines, and the discontinuity buffer of `extent` texels.
    pub fn new(device: &Arc<Device>, extent: [u32; 2], interleave: u32) -> Result<Self, VulkanError> {
        let pipeline = |name, spirv| ComputePipeline::specialised(device, name, spirv, &[interleave]);
        let filter = |weighs, inside| {
            let spirv = shaders::DISCONTINUITY_FILTER_COMP;
            ComputePipeline::specialised(device, "discontinuity_filter", spirv, &[interleave, weighs, inside])
        };
        let pipelines = Pipelines {
            pack: pipeline("packed_surfaces", shaders::PACKED_SURFACES_COMP)?,
            compare: pipeline("discontinuities", shaders::DISCONTINUITIES_COMP)?,
            sort_tiles: pipeline("filter_tiles", shaders::FILTER_TILES_COMP)?,
            weigh: pipeline("present_flux", shaders::PRESENT_FLUX_COMP)?,
            filter_whole: pipeline("whole_windows", shaders::WHOLE_WINDOWS_COMP)?,
            filter: Filters { mixed: filter(0, 1)?, edge: filter(0, 0)? },
            weighing_filter: Filters { mixed: filter(1, 1)?, edge: filter(1, 0)? },
        };
        Self::of(device, Arc::new(pipelines), extent, interleave)
    }

    /// The same pass for pictures of `extent` texels.
    pub fn resized(&self, device: &Arc<Device>, extent: [u32; 2]) -> Result<Self, VulkanError> {
        Self::of(device, Arc::clone(&self.pipelines), extent, self.interleave)
    }

    fn of(
        device: &Arc<Device>,
        pipelines: Arc<Pipelines>,
        extent: [u32; 2],
        interleave: u32,
    ) -> Result<Self, VulkanError> {
        let pixels = u64::from(extent[0]) * u64::from(extent[1]);
        Ok(Self {
            pipelines,
            packed_surfaces: Buffer::of_texels(device, "packed_surfaces", pixels, Texels::R32)?,
            discontinuities: texels_of_threads(device, "discontinuities", extent, words(interleave))?,
            present_flux: texels_of_threads(device, "present_flux", extent, 1)?,
            tiles: TileLists {
                whole: tile_list(device, "whole_tiles", tiles_of(extent))?,
                mixed: tile_list(device, "mixed_tiles", tiles_of(extent))?,
                edge: tile_list(device, "edge_tiles", tiles_of(extent))?,
            },
            extent,
            interleave,
            class_flux: Vec::new(),
            weighed: false,
            compared: None,
        })
    }

    /// Works out which pixels lie on one surface where surfaces have changed. Out: the threads whose pixels it may concern.
    fn compare(
        &mut self,
        frame: &mut Frame<'_>,
        inputs: &IndirectShadingInputs<'_>,
    ) -> Result<Area, VulkanError> {
        let compared = self.compared.replace(inputs.position_cutoff);
        let changed = if compared == Some(inputs.position_cutoff) {
            inputs.surfaces.changed
        } else {
            Area::whole(self.extent)
        };
        // Windows reach as far as n texels beyond their pixels, those at the borders included.
        let touched = threads_of(changed.grown(self.interleave, self.extent));
        if changed.is_empty() {
            return Ok(touched);
        }
        let Pipelines { pack, compare, sort_tiles, .. } = &*self.pipelines;
        let normal = &inputs.surfaces.gbuffer.normal;
        frame
            .pass("indirect_shading", pack)
            .read("frame_uniforms", inputs.frame)
            .read("gbuffer_depth", &inputs.surfaces.gbuffer.depth)
            .read("gbuffer_normal", normal)
            .write("packed_surfaces", &self.packed_surfaces)
            .push(&changed.offset)
            .dispatch_over(changed.extent)?;
        frame
            .pass("indirect_shading", compare)
            .read("frame_uniforms", inputs.frame)
            .read("gbuffer_normal", normal)
            .read("packed_surfaces", &self.packed_surfaces)
            .write("discontinuities", &self.discontinuities)
            .push(&touched.offset)
            .dispatch_over(touched.extent)?;
        let TileLists { whole, mixed, edge } = &self.tiles;
        for list in [whole, mixed, edge] {
            frame.clear(list);
        }
        frame
            .pass("indirect_shading", sort_tiles)
            .read("frame_uniforms", inputs.frame)
            .read("discontinuities", &self.discontinuities)
            .write("whole_tiles", whole)
            .write("mixed_tiles", mixed)
            .write("edge_tiles", edge)
            .dispatch_threads([tiles_of(self.extent), 1, 1])?;
        Ok(touched)
    }

    /// Filters into the spare layer of the set buffers.
    pub fn record(
        &mut self,
        frame: &mut Frame<'_>,
        inputs: &IndirectShadingInputs<'_>,
        sets: &SetHistory,
    ) -> Result<(), VulkanError> {
        let touched = self.compare(frame, inputs)?;
        let first_texel = inputs.vpls.first_texel;
        // What only this frame needs, the filter works out itself.
        let stays = self.class_flux == inputs.class_flux;
        let weighed = match (stays, self.weighed) {
            (true, true) => touched,
            (true, false) => Area::whole([self.extent[0], self.extent[1].div_ceil(ROWS)]),
            (false, _) => Area::default(),
        };
        self.class_flux.clear();
        self.class_flux.extend_from_slice(inputs.class_flux);
        self.weighed = stays;
        let Pipelines { weigh, filter_whole, filter, weighing_filter, .. } = &*self.pipelines;
        if !weighed.is_empty() {
            frame
                .pass("indirect_shading", weigh)
                .read("frame_uniforms", inputs.frame)
                .read("vpl_set", &*inputs.vpls.texels)
                .read("discontinuities", &self.discontinuities)
                .write("present_flux", &self.present_flux)
                .push(&WeighPush { first: weighed.offset, first_texel, pad: 0 })
                .dispatch_over(weighed.extent)?;
        }
        let layer = sets.spare_layer();
        frame
            .pass("indirect_shading", filter_whole)
            .read("frame_uniforms", inputs.frame)
            .read("class_irradiance", inputs.class_irradiance)
            .read("packed_surfaces", &self.packed_surfaces)
            .read("filter_tiles", &self.tiles.whole)
            .write("set_buffers", sets.buffers())
            .push(&layer)
            .dispatch_indirect(&self.tiles.whole)?;
        let filter = if stays { filter } else { weighing_filter };
        for (pipeline, tiles) in [(&filter.mixed, &self.tiles.mixed), (&filter.edge, &self.tiles.edge)] {
            frame
                .pass("indirect_shading", pipeline)
                .read("frame_uniforms", inputs.frame)
                .read("gbuffer_normal", &inputs.surfaces.gbuffer.normal)
                .read("class_irradiance", inputs.class_irradiance)
                .read("packed_surfaces", &self.packed_surfaces)
                .read("discontinuities", &self.discontinuities)
                .read("present_flux", &self.present_flux)
                .read("vpl_set", &*inputs.vpls.texels)
                .read("filter_tiles", tiles)
                .write("set_buffers", sets.buffers())
                .push(&Push { total_flux: inputs.vpls.total_flux, layer, first_texel })
                .dispatch_indirect(tiles)?;
        }
        Ok(())
    }
}

/// The threads, of [`ROWS`] pixels each, that take care of the pixels of an area.
fn threads_of(area: Area) -> Area {
    let [x, y] = area.offset;
    let rows = if area.is_empty() { 0 } else { area.end()[1].div_ceil(ROWS) - y / ROWS };
    Area { offset: [x, y / ROWS], extent: [area.extent[0], rows] }
}

/// How many tiles of the filter a picture has.
fn tiles_of(extent: [u32; 2]) -> u32 {
    extent[0].div_ceil(TILE[0]) * extent[1].div_ceil(TILE[1])
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
