//! `direct_shading`: what point, spot and directional lights send straight to the surface, diffuse and
//! specular; what surfaces emit; the background. Where neither surfaces nor shadows have changed, what was there stands.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};

use super::direct_shadows::{Change, ChangedParts, Shadows};
use super::gbuffer::Surfaces;
use super::scene_buffers::SceneBuffers;
use super::{rows_of_thread, storage_image, tile_list, to_u32};
use crate::vulkan::{
    Area, Buffer, ComputePipeline, Device, Frame, Image, Pass, Upload, VulkanError, shaders, vk,
};

/// What the pass reads.
pub struct DirectShadingInputs<'a> {
    /// Frame uniforms.
    pub frame: &'a Upload,
    /// The visible surfaces.
    pub surfaces: Surfaces<'a>,
    /// Lights and their shadow maps.
    pub shadows: &'a Shadows<'a>,
    /// For what materials emit.
    pub scene: &'a SceneBuffers,
    /// Instances of this frame, for the same.
    pub instances: &'a Buffer,
}

/// Pixels across a tile of the picture. Twin: `PICTURE_TILE` in shaders/include/picture_tiles.glsl.
const TILE: u32 = 8;

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct ChangedPush {
    changed_first: [u32; 2],
    changed_end: [u32; 2],
    anew_first: [u32; 2],
    anew_end: [u32; 2],
    shadow_tile_count: u32,
    first_texel: u32,
}

/// The pass.
pub struct DirectShadingPass {
    pipelines: Arc<Pipelines>,
    direct: Image,
    /// Tiles of the picture: see shaders/include/tile_list.glsl.
    changed_tiles: Buffer,
    /// Whether anything is in `direct`.
    shaded: bool,
}

struct Pipelines {
    find_changed: ComputePipeline,
    /// For all of the picture, one for each of [`ONES`].
    shade_all: Vec<ComputePipeline>,
    /// For the tiles of a list, likewise.
    shade_listed: Vec<ComputePipeline>,
}

/// Whether there is but one light, and whether but one shadow tile: CPU devices load that faster.
const ONES: [[u32; 2]; 3] = [[0, 0], [1, 0], [1, 1]];

/// Which of [`ONES`] it is.
fn ones(shadows: &Shadows<'_>) -> usize {
    match (shadows.light_count, shadows.tile_count) {
        (1, 1) => 2,
        (1, _) => 1,
        _ => 0,
    }
}

impl DirectShadingPass {
    /// Makes the pipelines and the image, of `extent` texels.
    pub fn new(device: &Arc<Device>, extent: [u32; 2]) -> Result<Self, VulkanError> {
        // Of most listed tiles only some rows are lit again. A workgroup takes as many tiles as its threads have rows.
        let rows = rows_of_thread(device);
        let shade = |listed| {
            let spirv = shaders::DIRECT_SHADING_COMP;
            let pipeline = |[one_light, one_tile]: [u32; 2]| {
                let constants = [listed, one_light, one_tile, rows];
                ComputePipeline::specialised(device, "direct_shading", spirv, &constants)
            };
            ONES.into_iter().map(pipeline).collect::<Result<Vec<_>, _>>()
        };
        let find_changed =
            ComputePipeline::specialised(device, "changed_tiles", shaders::CHANGED_TILES_COMP, &[rows])?;
        let pipelines = Pipelines { find_changed, shade_all: shade(0)?, shade_listed: shade(1)? };
        Self::of(device, Arc::new(pipelines), extent)
    }

    /// The same pass for pictures of `extent` texels.
    pub fn resized(&self, device: &Arc<Device>, extent: [u32; 2]) -> Result<Self, VulkanError> {
        Self::of(device, Arc::clone(&self.pipelines), extent)
    }

    fn of(device: &Arc<Device>, pipelines: Arc<Pipelines>, extent: [u32; 2]) -> Result<Self, VulkanError> {
        Ok(Self {
            pipelines,
            direct: storage_image(device, "direct", vk::Format::R32G32B32A32_SFLOAT, extent)?,
            changed_tiles: tile_list(device, "changed_tiles", tiles_of(extent))?,
            shaded: false,
        })
    }

    /// Radiance of the last frame; a: 0 where no surface is, 1 where one stands still, 2 where it may move.
    pub fn output(&self) -> &Image {
        &self.direct
    }

    /// Shades every pixel whose surface, lights or shadows may have changed.
    pub fn record(
        &mut self,
        frame: &mut Frame<'_>,
        inputs: &DirectShadingInputs<'_>,
    ) -> Result<&Image, VulkanError> {
        let changed = inputs.surfaces.changed;
        let whole = Area::whole(self.direct.extent());
        let first = !std::mem::replace(&mut self.shaded, true);
        match &inputs.shadows.change {
            Change::Nothing if changed.is_empty() && !first => {}
            Change::Nothing if changed != whole && !first => {
                self.shade_changed(frame, inputs, &ChangedParts::default())?;
            }
            Change::Parts(parts) if changed != whole && !first => self.shade_changed(frame, inputs, parts)?,
            _ => self.bind(frame, &self.pipelines.shade_all, inputs).dispatch_over(whole.extent)?,
        }
        Ok(&self.direct)
    }

    fn shade_changed(
        &self,
        frame: &mut Frame<'_>,
        inputs: &DirectShadingInputs<'_>,
        shadows: &ChangedParts,
    ) -> Result<(), VulkanError> {
        let Surfaces { gbuffer, changed, anew, .. } = inputs.surfaces;
        let parts = frame.upload(&shadows.parts)?;
        let cells = frame.upload(&shadows.cells)?;
        let push = ChangedPush {
            changed_first: changed.offset,
            changed_end: changed.end(),
            anew_first: anew.offset,
            anew_end: anew.end(),
            shadow_tile_count: to_u32(shadows.parts.len()),
            first_texel: cells.first_texel(),
        };
        frame.clear(&self.changed_tiles);
        frame
            .pass("direct_shading", &self.pipelines.find_changed)
            .read("frame_uniforms", inputs.frame)
            .read("gbuffer_depth", &gbuffer.depth)
            .read("gbuffer_instance", &gbuffer.instance)
            .read("shadow_tiles", &inputs.shadows.tiles)
            .read("changed_parts", &parts)
            .read("changed_cells", &cells)
            .read("direct", &self.direct)
            .write("tile_list", &self.changed_tiles)
            .push(&push)
            .dispatch_threads([tiles_of(self.direct.extent()), 1, 1])?;
        self.bind(frame, &self.pipelines.shade_listed, inputs).dispatch_indirect(&self.changed_tiles)
    }

    fn bind<'f>(
        &'f self,
        frame: &'f mut Frame<'_>,
        pipelines: &'f [ComputePipeline],
        inputs: &'f DirectShadingInputs<'_>,
    ) -> Pass<'f> {
        let gbuffer = inputs.surfaces.gbuffer;
        frame
            .pass("direct_shading", &pipelines[ones(inputs.shadows)])
            .read("frame_uniforms", inputs.frame)
            .read("gbuffer_depth", &gbuffer.depth)
            .read("gbuffer_normal", &gbuffer.normal)
            .read("gbuffer_albedo", &gbuffer.albedo)
            .read("gbuffer_instance", &gbuffer.instance)
            .read("shadow_atlas", inputs.shadows.atlas)
            .read("lights", &inputs.shadows.lights)
            .read("shadow_tiles", &inputs.shadows.tiles)
            .read("tile_list", &self.changed_tiles)
            .read("materials", &inputs.scene.materials)
            .read("instances", inputs.instances)
            .write("direct", &self.direct)
    }
}

/// How many tiles a picture has.
fn tiles_of(extent: [u32; 2]) -> u32 {
    let [across, down] = extent.map(|side| side.div_ceil(TILE));
    across * down
}
