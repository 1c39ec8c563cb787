//! `direct_shadows`: a shadow map for each light, as tiles of one atlas. Drawn again when a light or (for directional lights)
//! the camera has moved; when an instance has, only where it casts its shadow, over what all others cast.

use std::mem::offset_of;
use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use glam::{Mat4, Vec3};

use super::clusters::{Draw, part_of_view, visible};
use super::outlines::CELLS;
use super::scene_buffers::{Moved, SceneBuffers, Vertex};
use super::shadow_tiles::{ShadowPlan, View};
use super::still::Still;
use super::structs::{ChangedPart, ShadowTile};
use super::to_u32;
use super::tracer::Tracer;
use crate::scene::Pose;
use crate::vulkan::{
    Area, Buffer, Device, Frame, GraphicsDescription, GraphicsPipeline, Image, ImageDescription, Targets,
    Upload, VulkanError, shaders, vk,
};

/// Slope-scaled bias: about the reach of the filter in texels. Negative, since depth is reversed.
const SLOPE_BIAS: f32 = -1.5;

/// Texels that a lookup may be away from where its surface is: how far receivers are moved, and the filter. Twin: `REACH` in
/// shaders/changed_tiles.comp.
const REACH: f32 = 5.0;

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
    /// In a part of each tile.
    Parts(ChangedParts),
    /// Altogether.
    Everything,
}

/// The shadow maps of a frame before what moves is in them.
pub struct Prepared {
    plan: ShadowPlan,
    change: Change,
    missing: Missing,
}

/// What has yet to be drawn into the atlas.
enum Missing {
    Nothing,
    Everything,
    /// What moves, in a part of each tile.
    Moved(Vec<Area>),
}

/// Where shadow maps differ from those of the frame before.
#[derive(Default)]
pub struct ChangedParts {
    /// By tile.
    pub parts: Vec<ChangedPart>,
    /// What [`super::outlines::ChangedCells::within_reach`] gives, tile after tile.
    pub cells: Vec<[u32; 4]>,
}

impl ChangedParts {
    fn new(inputs: &ShadowInputs<'_>, plan: &ShadowPlan, areas: &[Area]) -> Self {
        let reach = (REACH * CELLS as f32 / plan.tile_size as f32).ceil() as usize;
        let known = inputs.scene.changed_cells(inputs.moved, &plan.tiles, plan.tile_size);
        let mut changed = Self::default();
        for ((tile, area), known) in plan.tiles.iter().zip(areas).zip(known) {
            let mut part = ChangedPart {
                first: area.offset,
                end: area.end(),
                // Where nothing is known of cells, anything in the area may be lit otherwise.
                nearest: f32::INFINITY,
                farthest: f32::NEG_INFINITY,
                ..ChangedPart::default()
            };
            if let Some(known) = known {
                part.nearest = known.nearest + tile.depth_of_offset(known.nearest);
                part.farthest = known.farthest - tile.depth_of_offset(known.farthest);
                part.first_row = to_u32(changed.cells.len());
                changed.cells.extend(known.within_reach(reach));
            }
            changed.parts.push(part);
        }
        changed
    }
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

    /// Plans the shadow maps, and copies what stands still to where they have changed. What is drawn between this and
    /// [`Self::record`] need not be waited for: raster of both goes on at once.
    pub fn prepare(
        &mut self,
        frame: &mut Frame<'_>,
        inputs: &ShadowInputs<'_>,
    ) -> Result<Prepared, VulkanError> {
        let view = View {
            bounds: inputs.bounds,
            size: inputs.size,
            max_extent: self.device.limits().max_image_dimension2_d,
        };
        let plan = ShadowPlan::new(inputs.pose, &view);
        let last = self.drawn.take();
        let mut change = match &last {
            Some(last) if *last == plan => Change::Nothing,
            _ => Change::Everything,
        };
        let mut missing = Missing::Nothing;
        if last.is_none_or(|last| last.tiles != plan.tiles) {
            self.still.forget();
            self.make_room(&plan)?;
            if !plan.tiles.is_empty() {
                missing = Missing::Everything;
            }
        } else if !inputs.moved.is_empty() && !plan.tiles.is_empty() {
            let areas = changed_areas(inputs, &plan);
            if areas.iter().any(|area| !area.is_empty()) {
                missing = self.copy_still(frame, inputs, &plan, &areas)?;
            }
            if matches!(change, Change::Nothing) {
                change = Change::Parts(ChangedParts::new(inputs, &plan, &areas));
            }
        }
        if !matches!(missing, Missing::Nothing) {
            frame.ready_depth(&self.atlas);
        }
        Ok(Prepared { plan, change, missing })
    }

    /// Draws the tiles, or parts of tiles, that are out of date.
    pub fn record(
        &mut self,
        frame: &mut Frame<'_>,
        inputs: &ShadowInputs<'_>,
        prepared: Prepared,
    ) -> Result<Shadows<'_>, VulkanError> {
        let Prepared { plan, change, missing } = prepared;
        match missing {
            Missing::Nothing => {}
            Missing::Everything => {
                let targets =
                    Targets::Depth { depth: &self.atlas, area: Area::whole(plan.extent), clear: true };
                self.draw(frame, inputs, &targets, &whole_tiles(&plan), |_| true)?;
            }
            Missing::Moved(areas) => {
                let parts = parts_of_tiles(&plan, &areas);
                let area = parts.iter().map(TilePart::in_atlas).fold(Area::default(), Area::union);
                let targets = Targets::Depth { depth: &self.atlas, area, clear: false };
                self.draw(frame, inputs, &targets, &parts, |draw| self.still.lacks(draw.instance))?;
            }
        }
        let shadows = Shadows {
            atlas: &self.atlas,
            lights: frame.upload(&plan.lights)?,
            light_count: plan.lights.len(),
            tiles: frame.upload(&plan.tiles)?,
            tile_count: to_u32(plan.tiles.len()),
            tile_columns: plan.extent[0] / plan.tile_size,
            tile_size: plan.tile_size,
            change,
        };
        self.drawn = Some(plan);
        Ok(shadows)
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

    /// Copies what stands still to where tiles have changed, one area each; tells what is missing then.
    fn copy_still(
        &mut self,
        frame: &mut Frame<'_>,
        inputs: &ShadowInputs<'_>,
        plan: &ShadowPlan,
        changed: &[Area],
    ) -> Result<Missing, VulkanError> {
        self.still.note(inputs.moved, || atlas(&self.device, "still_shadow_atlas", self.atlas.extent()));
        let Some(still_atlas) = self.still.picture() else {
            // No memory for that: then all is drawn.
            return Ok(Missing::Everything);
        };
        if self.still.is_stale() {
            let targets = Targets::Depth { depth: still_atlas, area: Area::whole(plan.extent), clear: true };
            let stands = |draw: &Draw| !self.still.lacks(draw.instance);
            self.draw(frame, inputs, &targets, &whole_tiles(plan), stands)?;
        }
        let areas: Vec<Area> = parts_of_tiles(plan, changed).iter().map(TilePart::in_atlas).collect();
        frame.copy_areas("direct_shadows", still_atlas, &self.atlas, &areas);
        Ok(Missing::Moved(changed.to_vec()))
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
                list.viewport(Area { offset: part.corner(), extent }, part.in_atlas());
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

    /// The part, counted from the atlas' first texel.
    fn in_atlas(&self) -> Area {
        self.area.moved(self.corner())
    }
}

fn whole_tiles(plan: &ShadowPlan) -> Vec<TilePart<'_>> {
    parts_of_tiles(plan, &vec![Area::whole([plan.tile_size; 2]); plan.tiles.len()])
}

/// A part of each tile, but for those that are empty.
fn parts_of_tiles<'a>(plan: &'a ShadowPlan, areas: &[Area]) -> Vec<TilePart<'a>> {
    let extent = [plan.tile_size; 2];
    let parts = plan.tiles.iter().zip(areas).map(|(tile, &area)| TilePart { tile, extent, area });
    parts.filter(|part| !part.area.is_empty()).collect()
}

/// Where instances cast other shadows than in the frame before: the part of each tile.
fn changed_areas(inputs: &ShadowInputs<'_>, plan: &ShadowPlan) -> Vec<Area> {
    let extent = [plan.tile_size; 2];
    let area = |tile: &ShadowTile| inputs.scene.area_of(inputs.moved, &tile.view_projection, extent);
    plan.tiles.iter().map(area).collect()
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
