//! `gbuffer`: view depth, normal, albedo and instance of the nearest surface, by raster. What was drawn last stands
//! for as long as the camera does, but for the part of the picture where something has moved: there, that is drawn over what
//! stands still.

use std::mem::offset_of;

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use glam::Mat4;

use super::clusters::{Draw, part_of_view, visible};
use super::scene_buffers::{Instances, SceneBuffers, Vertex};
use super::still::Still;
use super::tracer::Tracer;
use crate::scene::Pose;
use crate::vulkan::{
    Area, Device, Frame, GraphicsDescription, GraphicsPipeline, Image, ImageDescription, MaterialSets,
    Targets, Upload, VulkanError, shaders, vk,
};

/// Formats of the colour targets, in the order of the shader's outputs.
const FORMATS: [vk::Format; 4] = [
    vk::Format::R32_SFLOAT,
    vk::Format::R16G16B16A16_SFLOAT,
    vk::Format::R16G16B16A16_SFLOAT,
    vk::Format::R32G32_UINT,
];

/// What the pass writes.
pub struct GBuffer {
    /// View depth, 0 where no surface is.
    pub depth: Image,
    /// xy: shading normal; zw: geometric normal; octahedral, both on the side that is seen.
    pub normal: Image,
    /// rgb: diffuse albedo, linear.
    pub albedo: Image,
    /// x: instance + 1, 0 where no surface is; y: material, bit 31 set on front sides, bit 30 where it may move.
    pub instance: Image,
    /// What raster compares by.
    nearest: Image,
}

impl GBuffer {
    fn new(device: &Arc<Device>, extent: [u32; 2]) -> Result<Self, VulkanError> {
        let target = |name: &str, format, usage| {
            Image::new(device, &ImageDescription { name, format, extent, layers: None, levels: 1, usage })
        };
        let color = vk::ImageUsageFlags::COLOR_ATTACHMENT;
        let stored = color | vk::ImageUsageFlags::STORAGE;
        Ok(Self {
            depth: target("gbuffer_depth", FORMATS[0], stored)?,
            normal: target("gbuffer_normal", FORMATS[1], stored)?,
            albedo: target("gbuffer_albedo", FORMATS[2], stored)?,
            instance: target("gbuffer_instance", FORMATS[3], color)?,
            nearest: target(
                "gbuffer_nearest",
                vk::Format::D32_SFLOAT,
                vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT,
            )?,
        })
    }

    fn images(&self) -> [&Image; 5] {
        [&self.depth, &self.normal, &self.albedo, &self.instance, &self.nearest]
    }
}

/// The visible surfaces of a frame.
#[derive(Clone, Copy)]
pub struct Surfaces<'a> {
    /// Their images.
    pub gbuffer: &'a GBuffer,
    /// Where they may not be those of the frame before.
    pub changed: Area,
    /// Where they may not though neither these nor those are of instances that may move.
    pub anew: Area,
    /// Where they may be of instances that may move.
    pub movers: Area,
}

/// What the pass reads.
pub struct GBufferInputs<'a> {
    /// Frame uniforms.
    pub frame: &'a Upload,
    /// Instances of this frame.
    pub instances: &'a Instances,
    /// The scene.
    pub scene: &'a SceneBuffers,
    /// For its alpha masks.
    pub tracer: &'a Tracer,
    /// Where everything stands.
    pub pose: &'a Pose,
    /// World to clip space, as in the frame uniforms.
    pub view_projection: Mat4,
}

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Push {
    instance: u32,
    material: u32,
}

/// A part of targets, and whether what is there goes first.
struct DrawnInto<'a> {
    targets: &'a GBuffer,
    area: Area,
    clear: bool,
}

/// The pass.
pub struct GBufferPass {
    pipeline: Arc<GraphicsPipeline>,
    materials: Arc<MaterialSets>,
    targets: GBuffer,
    /// The view that the targets show; none before the first frame.
    drawn: Option<Mat4>,
    /// The same view of what stands still.
    still: Still<GBuffer>,
    device: Arc<Device>,
}

impl GBufferPass {
    /// Makes the pipeline and the images, of `extent` texels.
    pub fn new(device: &Arc<Device>, scene: &SceneBuffers, extent: [u32; 2]) -> Result<Self, VulkanError> {
        let attributes = [
            (vk::Format::R32G32B32_SFLOAT, offset_of!(Vertex, position) as u32),
            (vk::Format::R32G32B32_SFLOAT, offset_of!(Vertex, normal) as u32),
            (vk::Format::R32G32_SFLOAT, offset_of!(Vertex, uv) as u32),
        ];
        let pipeline = GraphicsPipeline::new(
            device,
            &GraphicsDescription {
                name: "gbuffer",
                vertex: shaders::GBUFFER_VERT,
                fragment: shaders::GBUFFER_FRAG,
                vertex_stride: size_of::<Vertex>() as u32,
                attributes: &attributes,
                colors: &FORMATS,
                depth_bias: None,
                blend: false,
                // Without and with an alpha mask.
                variants: &[0, 1],
            },
        )?;
        let images: Vec<&Image> =
            scene.material_textures.iter().map(|&texture| &scene.textures[texture]).collect();
        let materials = MaterialSets::new(device, &pipeline, &images, &scene.sampler)?;
        Ok(Self {
            pipeline: Arc::new(pipeline),
            materials: Arc::new(materials),
            targets: GBuffer::new(device, extent)?,
            drawn: None,
            still: Still::default(),
            device: Arc::clone(device),
        })
    }

    /// The same pass for pictures of `extent` texels.
    pub fn resized(&self, device: &Arc<Device>, extent: [u32; 2]) -> Result<Self, VulkanError> {
        Ok(Self {
            pipeline: Arc::clone(&self.pipeline),
            materials: Arc::clone(&self.materials),
            targets: GBuffer::new(device, extent)?,
            drawn: None,
            still: Still::default(),
            device: Arc::clone(device),
        })
    }

    /// What the last frame wrote.
    pub fn output(&self) -> &GBuffer {
        &self.targets
    }

    /// Draws the scene where what was drawn last does not stand.
    pub fn record(
        &mut self,
        frame: &mut Frame<'_>,
        inputs: &GBufferInputs<'_>,
    ) -> Result<Surfaces<'_>, VulkanError> {
        let extent = self.targets.depth.extent();
        let whole = Area::whole(extent);
        let moved = &inputs.instances.moved;
        let (changed, anew) = if self.drawn.take() == Some(inputs.view_projection) {
            let changed = inputs.scene.area_of(moved, &inputs.view_projection, extent);
            if !changed.is_empty() {
                self.draw_moved(frame, inputs, changed)?;
            }
            let new = moved.iter().filter(|moved| !moved.could_move);
            (changed, inputs.scene.area_of(new, &inputs.view_projection, extent))
        } else {
            self.still.forget();
            let into = DrawnInto { targets: &self.targets, area: whole, clear: true };
            self.draw(frame, inputs, &into, |_| true)?;
            (whole, whole)
        };
        self.drawn = Some(inputs.view_projection);
        let movers = inputs.instances.movers.iter().copied();
        let movers = inputs.scene.area_of_places(movers, &inputs.view_projection, extent);
        Ok(Surfaces { gbuffer: &self.targets, changed, anew, movers })
    }

    /// Draws what moves over what stands still, in a part of the picture.
    fn draw_moved(
        &mut self,
        frame: &mut Frame<'_>,
        inputs: &GBufferInputs<'_>,
        area: Area,
    ) -> Result<(), VulkanError> {
        let extent = self.targets.depth.extent();
        self.still.note(&inputs.instances.moved, || GBuffer::new(&self.device, extent));
        let Some(still_targets) = self.still.picture() else {
            // No memory for that: then all is drawn, still only here.
            let into = DrawnInto { targets: &self.targets, area, clear: true };
            return self.draw(frame, inputs, &into, |_| true);
        };
        if self.still.is_stale() {
            let into = DrawnInto { targets: still_targets, area: Area::whole(extent), clear: true };
            self.draw(frame, inputs, &into, |draw| !self.still.lacks(draw.instance))?;
        }
        for (source, target) in still_targets.images().into_iter().zip(self.targets.images()) {
            frame.copy_areas("gbuffer", source, target, &[area]);
        }
        let into = DrawnInto { targets: &self.targets, area, clear: false };
        self.draw(frame, inputs, &into, |draw| self.still.lacks(draw.instance))
    }

    /// Draws what is `wanted`.
    fn draw(
        &self,
        frame: &mut Frame<'_>,
        inputs: &GBufferInputs<'_>,
        into: &DrawnInto<'_>,
        wanted: impl Fn(&Draw) -> bool,
    ) -> Result<(), VulkanError> {
        let DrawnInto { targets, area, clear } = *into;
        let part = part_of_view(&inputs.view_projection, area, targets.depth.extent());
        let draws = inputs.scene.draws.iter().filter(|draw| wanted(draw));
        let draws = visible(draws, inputs.pose, &part, |last, next| last.material == next.material);
        let colors = [&targets.depth, &targets.normal, &targets.albedo, &targets.instance];
        let pass = frame
            .draw_pass("gbuffer", &self.pipeline)
            .read("frame_uniforms", inputs.frame)
            .read("instances", &*inputs.instances.data)
            .read("materials", &inputs.scene.materials);
        inputs.tracer.bind_masks(pass).draw(
            &Targets::Surfaces { colors: &colors, depth: &targets.nearest, area, clear },
            |list| {
                list.geometry(&inputs.scene.vertices, &inputs.scene.indices);
                let mut bound = None;
                for draw in &draws {
                    if bound != Some(draw.material) {
                        list.variant(usize::from(inputs.scene.masks[draw.material as usize] != 0));
                        list.material(&self.materials, draw.material as usize);
                        bound = Some(draw.material);
                    }
                    list.cull(inputs.scene.culled(draw.instance, inputs.pose, &inputs.view_projection));
                    let push = Push { instance: draw.instance, material: draw.material };
                    list.draw(&push, draw.first, draw.count);
                }
            },
        )
    }
}
