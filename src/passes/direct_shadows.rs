//! `direct_shadows`: a shadow map for each light, as tiles of one atlas. Drawn again only when a light,
//! an instance or (for directional lights) the camera has moved.

use std::mem::offset_of;
use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use glam::{Affine3A, Mat4, Vec3};

use super::clusters::{Draw, visible};
use super::scene_buffers::{SceneBuffers, Vertex};
use super::shadow_tiles::{ShadowPlan, View};
use super::tracer::Tracer;
use crate::scene::Pose;
use crate::vulkan::{
    Area, Device, Frame, GraphicsDescription, GraphicsPipeline, Image, ImageDescription, Targets, Upload,
    VulkanError, shaders, vk,
};

/// Slope-scaled bias: about the reach of the filter in texels. Negative, since depth is reversed.
const SLOPE_BIAS: f32 = -1.5;

/// What the pass reads.
pub struct ShadowInputs<'a> {
    /// Instances of this frame.
    pub instances: &'a Upload,
    /// The scene.
    pub scene: &'a SceneBuffers,
    /// For its alpha masks.
    pub tracer: &'a Tracer,
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
    /// `ShadowTile`s of this frame.
    pub tiles: Upload,
    /// How many.
    pub tile_count: u32,
    /// How many are in a row.
    pub tile_columns: u32,
    /// Texels across each.
    pub tile_size: u32,
    /// Whether lights and maps are those of the frame before.
    pub unchanged: bool,
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
    /// What the last frame saw, which is what is in the atlas; none before the first.
    last: Option<(ShadowPlan, Vec<Affine3A>)>,
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
                variants: &[0, 1],
            },
        )?;
        let atlas = atlas(device, [1, 1])?;
        Ok(Self { pipeline, atlas, last: None, device: Arc::clone(device) })
    }

    /// Draws the tiles that are out of date.
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
        let tiles = frame.upload(&plan.tiles)?;
        let (tile_count, tile_size) = (u32::try_from(plan.tiles.len()).unwrap_or(u32::MAX), plan.tile_size);
        let tile_columns = plan.extent[0] / tile_size;
        let current = plan.tiles.is_empty()
            || self.last.as_ref().is_some_and(|(last, instances)| {
                last.tiles == plan.tiles && *instances == inputs.pose.instances
            });
        let unchanged = current && self.last.as_ref().is_some_and(|(last, _)| *last == plan);
        if !current {
            let has = self.atlas.extent();
            if (0..2).any(|side| has[side] < plan.extent[side]) {
                // Frames on their way still read the old one.
                self.device.wait_idle()?;
                self.atlas = atlas(&self.device, plan.room)?;
            }
            self.draw(frame, inputs, &plan)?;
        }
        if !unchanged {
            self.last = Some((plan, inputs.pose.instances.clone()));
        }
        Ok(Shadows { atlas: &self.atlas, lights, tiles, tile_count, tile_columns, tile_size, unchanged })
    }

    fn draw(
        &self,
        frame: &mut Frame<'_>,
        inputs: &ShadowInputs<'_>,
        plan: &ShadowPlan,
    ) -> Result<(), VulkanError> {
        let pass = frame.draw_pass("direct_shadows", &self.pipeline).read("instances", inputs.instances);
        inputs.tracer.bind_masks(pass).draw(&Targets::Depth(&self.atlas, Area::whole(plan.extent)), |list| {
            list.geometry(&inputs.scene.vertices, &inputs.scene.indices);
            for tile in &plan.tiles {
                let corner = [tile.rectangle.x as u32, tile.rectangle.y as u32];
                let rectangle = Area { offset: corner, extent: [plan.tile_size; 2] };
                list.viewport(rectangle, rectangle);
                let masks = &inputs.scene.masks;
                let mask = |draw: &Draw| masks[draw.material as usize];
                // Materials without a mask cast the same shadow, so one draw does for many.
                let joins = |last: &Draw, next: &Draw| mask(last) == mask(next);
                let view = &tile.view_projection;
                for draw in &visible(&inputs.scene.shadow_draws, inputs.pose, view, joins) {
                    list.variant(usize::from(mask(draw) != 0));
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

fn atlas(device: &Arc<Device>, extent: [u32; 2]) -> Result<Image, VulkanError> {
    Image::new(
        device,
        &ImageDescription {
            name: "shadow_atlas",
            format: vk::Format::D32_SFLOAT,
            extent,
            layers: None,
            levels: 1,
            usage: vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT,
        },
    )
}
