//! `direct_shadows`: a shadow map for each light, as tiles of one atlas. Drawn again when a light or (for directional lights)
//! the camera has moved; when an instance has, only where it casts its shadow, over what all others cast.

use std::mem::offset_of;
use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use glam::{Mat4, Vec3};

use super::clusters::{Draw, part_of_view, visible};
use super::scene_buffers::{Moved, SceneBuffers, Vertex};
use super::shadow_tiles::{ShadowPlan, View};
use super::still::Still;
use super::structs::ShadowTile;
use super::tracer::Tracer;
use crate::scene::Pose;
use crate::vulkan::{
    Area, Buffer, Device, Frame, GraphicsDescription, GraphicsPipeline, Image, ImageDescription, Targets,
    Upload, VulkanError, shaders, vk,
};

/// Slope-scaled bias: about the reach of the filter in texels. Negative, since depth is reversed.
const SLOPE_BIAS: f32 = -1.5;

/// What the pass reads.
pub struct ShadowInputs<'a> {
    /// Instances of this frame.
    pub instances: &'a Buffer,
    /// The scene.
    pub scene: &'a SceneBuffers,
    /// For its alpha masks.
    pub tracer: &'a Tracer,
    /// The instances that are not as in the frame before.
    pub moved: &'a [Moved],
    /// Lights, camera and transforms.
    pub pose: &'a Pose,
    /// World-space bounds of what casts shadows.
    pub bounds: (Vec3, Vec3),
    /// Picture size.
    pub size: [u32; 2],
}

/// What the pass gives.
pub struct Shadows<'a> {
    /// Depth of all tiles, reversed.
    pub atlas: &'a Image,
    /// `LightData` of this frame.
    pub lights: Upload,
    /// How many.
    pub light_count: usize,
    /// `ShadowTile`s of this frame.
    pub tiles: Upload,
    /// How many.
    pub tile_count: u32,
    /// How many are in a row.
    pub tile_columns: u32,
    /// Texels across each.
    pub tile_size: u32,
    /// How they differ from those of the frame before.
    pub change: Change,
}

/// How lights and shadow maps differ from those of the frame before.
pub enum Change {
    /// Not at all.
    Nothing,
    /// In a part of each tile: the first texel of each, counted from the tile's, and that behind the last.
    Parts(Vec<[u32; 4]>),
    /// Altogether.
    Everything,
}

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Push {
    view_projection: Mat4,
    instance: u32,
    mask: u32,
    pad: [u32; 2],
}

/// The pass.
pub struct DirectShadowsPass {
    pipeline: GraphicsPipeline,
    atlas: Image,
    /// What is in the atlas; none before the first frame.
    drawn: Option<ShadowPlan>,
    /// What stands still, as large as the atlas.
    still: Still<Image>,
    device: Arc<Device>,
}

impl DirectShadowsPass {
    /// Makes the pipeline.
    pub fn new(device: &Arc<Device>) -> Result<Self, VulkanError> {
        let pipeline = GraphicsPipeline::new(
            device,
            &GraphicsDescription {
                name: "direct_shadows",
                vertex: shaders::DIRECT_SHADOWS_VERT,
                fragment: shaders::DIRECT_SHADOWS_FRAG,
                vertex_stride: size_of::<Vertex>() as u32,
                attributes: &[
                    (vk::Format::R32G32B32_SFLOAT, offset_of!(Vertex, position) as u32),
                    (vk::Format::R32G32_SFLOAT, offset_of!(Vertex, uv) as u32),
                ],
                colors: &[],
                depth_bias: Some([0.0, SLOPE_BIAS]),
                blend: false,
                // Without and with an alpha mask.
                variants: &[0, 1],
            },
        )?;
        let atlas = atlas(device, "shadow_atlas", [1, 1])?;
        Ok(Self { pipeline, atlas, drawn: None, still: Still::default(), device: Arc::clone(device) })
    }

    /// Draws the tiles, or parts of tiles, that are out of date.
    pub fn record(
        &mut self,
        frame: &mut Frame<'_>,
        inputs: &ShadowInputs<'_>,
    ) -> Result<Shadows<'_>, VulkanError> {
        let view = View {
            bounds: inputs.bounds,
            size: inputs.size,
            max_extent: self.device.limits().max_image_dimension2_d,
        };
        let plan = ShadowPlan::new(inputs.pose, &view);
        let lights = frame.upload(&plan.lights)?;
        let light_count = plan.lights.len();
        let tiles = frame.upload(&plan.tiles)?;
        let (tile_count, tile_size) = (u32::try_from(plan.tiles.len()).unwrap_or(u32::MAX), plan.tile_size);
        let tile_columns = plan.extent[0] / tile_size;
        let last = self.drawn.take();
        let mut change = match &last {
            Some(last) if *last == plan => Change::Nothing,
            _ => Change::Everything,
        };
        if last.is_none_or(|last| last.tiles != plan.tiles) {
            self.still.forget();
            self.make_room(&plan)?;
            if !plan.tiles.is_empty() {
                let targets =
                    Targets::Depth { depth: &self.atlas, area: Area::whole(plan.extent), clear: true };
                self.draw(frame, inputs, &targets, &whole_tiles(&plan), |_| true)?;
            }
        } else if !inputs.moved.is_empty() && !plan.tiles.is_empty() {
            let parts = self.draw_moved(frame, inputs, &plan)?;
            if matches!(change, Change::Nothing) {
                change = Change::Parts(parts);
            }
        }
        self.drawn = Some(plan);
        Ok(Shadows {
            atlas: &self.atlas,
            lights,
            light_count,
            tiles,
            tile_count,
            tile_columns,
            tile_size,
            change,
        })
    }

    fn make_room(&mut self, plan: &ShadowPlan) -> Result<(), VulkanError> {
        let has = self.atlas.extent();
        if (0..2).any(|side| has[side] < plan.extent[side]) {
            // Frames on their way still read the old one.
            self.device.wait_idle()?;
            self.atlas = atlas(&self.device, "shadow_atlas", plan.room)?;
            self.still = Still::default();
        }
        Ok(())
    }

    /// Draws what moves over what stands still, where that has changed. Out: where, as in [`Change::Parts`].
    fn draw_moved(
        &mut self,
        frame: &mut Frame<'_>,
        inputs: &ShadowInputs<'_>,
        plan: &ShadowPlan,
    ) -> Result<Vec<[u32; 4]>, VulkanError> {
        let extent = [plan.tile_size; 2];
        let parts: Vec<TilePart<'_>> = whole_tiles(plan)
            .into_iter()
            .map(|part| TilePart {
                area: inputs.scene.area_of(inputs.moved, &part.tile.view_projection, extent),
                ..part
            })
            .collect();
        let touched: Vec<TilePart<'_>> = parts.iter().filter(|part| !part.area.is_empty()).copied().collect();
        if !touched.is_empty() {
            self.draw_parts(frame, inputs, plan, &touched)?;
        }
        let corners = |area: &Area| {
            let ([left, top], [right, bottom]) = (area.offset, area.end());
            [left, top, right, bottom]
        };
        Ok(parts.iter().map(|part| corners(&part.area)).collect())
    }

    fn draw_parts(
        &mut self,
        frame: &mut Frame<'_>,
        inputs: &ShadowInputs<'_>,
        plan: &ShadowPlan,
        parts: &[TilePart<'_>],
    ) -> Result<(), VulkanError> {
        let whole = Area::whole(plan.extent);
        self.still.note(inputs.moved, || atlas(&self.device, "still_shadow_atlas", self.atlas.extent()));
        let Some(still_atlas) = self.still.picture() else {
            // No memory for that: then all is drawn.
            let targets = Targets::Depth { depth: &self.atlas, area: whole, clear: true };
            return self.draw(frame, inputs, &targets, &whole_tiles(plan), |_| true);
        };
        if self.still.is_stale() {
            let targets = Targets::Depth { depth: still_atlas, area: whole, clear: true };
            let stands = |draw: &Draw| !self.still.lacks(draw.instance);
            self.draw(frame, inputs, &targets, &whole_tiles(plan), stands)?;
        }
        let areas: Vec<Area> = parts.iter().map(|part| part.area.moved(part.corner())).collect();
        frame.copy_areas("direct_shadows", still_atlas, &self.atlas, &areas);
        let area = areas.into_iter().fold(Area::default(), Area::union);
        let targets = Targets::Depth { depth: &self.atlas, area, clear: false };
        self.draw(frame, inputs, &targets, parts, |draw| self.still.lacks(draw.instance))
    }

    /// Draws what is `wanted` into parts of tiles.
    fn draw(
        &self,
        frame: &mut Frame<'_>,
        inputs: &ShadowInputs<'_>,
        targets: &Targets<'_>,
        parts: &[TilePart<'_>],
        wanted: impl Fn(&Draw) -> bool,
    ) -> Result<(), VulkanError> {
        let masks = &inputs.scene.masks;
        let mask = |draw: &Draw| masks[draw.material as usize];
        // Materials without a mask cast the same shadow, so one draw does for many.
        let joins = |last: &Draw, next: &Draw| mask(last) == mask(next);
        let pass = frame.draw_pass("direct_shadows", &self.pipeline).read("instances", inputs.instances);
        inputs.tracer.bind_masks(pass).draw(targets, |list| {
            list.geometry(&inputs.scene.vertices, &inputs.scene.indices);
            for part in parts {
                let TilePart { tile, area, extent } = *part;
                list.viewport(Area { offset: part.corner(), extent }, area.moved(part.corner()));
                let view = part_of_view(&tile.view_projection, area, extent);
                let draws = inputs.scene.shadow_draws.iter().filter(|draw| wanted(draw));
                for draw in &visible(draws, inputs.pose, &view, joins) {
                    list.variant(usize::from(mask(draw) != 0));
                    list.cull(inputs.scene.culled(draw.instance, inputs.pose, &tile.view_projection));
                    let push = Push {
                        view_projection: tile.view_projection,
                        instance: draw.instance,
                        mask: mask(draw),
                        pad: [0; 2],
                    };
                    list.draw(&push, draw.first, draw.count);
                }
            }
        })
    }
}

/// A part of a tile.
#[derive(Clone, Copy)]
struct TilePart<'a> {
    tile: &'a ShadowTile,
    /// Texels across all of it.
    extent: [u32; 2],
    /// The part, counted from the tile's first texel.
    area: Area,
}

impl TilePart<'_> {
    /// The tile's first texel in the atlas.
    fn corner(&self) -> [u32; 2] {
        [self.tile.rectangle.x as u32, self.tile.rectangle.y as u32]
    }
}

fn whole_tiles(plan: &ShadowPlan) -> Vec<TilePart<'_>> {
    let extent = [plan.tile_size; 2];
    plan.tiles.iter().map(|tile| TilePart { tile, extent, area: Area::whole(extent) }).collect()
}

fn atlas(device: &Arc<Device>, name: &str, extent: [u32; 2]) -> Result<Image, VulkanError> {
    Image::new(
        device,
        &ImageDescription {
            name,
            format: vk::Format::D32_SFLOAT,
            extent,
            layers: None,
            levels: 1,
            usage: vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT,
        },
    )
}
