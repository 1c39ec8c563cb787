//! `gbuffer`: view depth, normals, material, instance and motion of the nearest surface, by raster.

use std::mem::offset_of;
use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use glam::Mat4;

use crate::gpu_scene::clusters::visible;
use crate::gpu_scene::geometry::Vertex;
use crate::gpu_scene::scene_buffers::SceneBuffers;
use crate::gpu_scene::structs::InstanceData;
use crate::scene::Pose;
use crate::vulkan::{
    Device, Frame, GraphicsDescription, GraphicsPipeline, Image, ImageDescription, MaterialSets, SharedSet,
    Targets, Upload, VulkanError, shaders, vk,
};

/// Formats of the colour targets, in the order of the shader's outputs.
const FORMATS: [vk::Format; 6] = [
    vk::Format::R32_SFLOAT,
    vk::Format::R16G16B16A16_SFLOAT,
    vk::Format::R16G16B16A16_SFLOAT,
    vk::Format::R32G32_UINT,
    vk::Format::R32G32_UINT,
    vk::Format::R16G16_SFLOAT,
];

/// Formats and offsets of a vertex's attributes, by location.
const ATTRIBUTES: [(vk::Format, u32); 4] = [
    (vk::Format::R32G32B32_SFLOAT, offset_of!(Vertex, position) as u32),
    (vk::Format::R16G16_SNORM, offset_of!(Vertex, normal) as u32),
    (vk::Format::R32G32_SFLOAT, offset_of!(Vertex, uv) as u32),
    (vk::Format::R32_UINT, offset_of!(Vertex, tangent) as u32),
];

/// Bias of the depth, which is reversed, of backs that are dark behind fronts that emit, by its slope: where both meet at a silhouette,
/// raster rounds places, and a back that is met first would flash black.
const BEHIND: f32 = -1.0;

/// Outputs of the pass.
pub struct GBuffer {
    /// View depth, 0 where no surface is.
    pub depth: Image,
    /// xy: shading normal; zw: geometric normal; octahedral, both on the side that is seen.
    pub normal: Image,
    /// rgb: diffuse albedo towards the eye, linear; a: roughness.
    pub albedo: Image,
    /// x: instance + 1, 0 where no surface is; y: material, bit 31 set on front sides.
    pub instance: Image,
    /// x: base colour and metallic; y: emission; packed as in shaders/include/gbuffer.glsl.
    pub surface: Image,
    /// How far the surface has moved in the picture since the last frame, in pixels, right and down.
    pub motion: Image,
    /// Depth buffer of raster.
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
            surface: target("gbuffer_surface", FORMATS[4], color)?,
            motion: target("gbuffer_motion", FORMATS[5], color)?,
            nearest: target(
                "gbuffer_nearest",
                vk::Format::D32_SFLOAT,
                vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT,
            )?,
        })
    }
}

/// Inputs of the pass.
pub struct GBufferInputs<'a> {
    /// `FrameUniforms`.
    pub uniforms: &'a Upload,
    /// Set 1: the scene.
    pub scene: &'a SharedSet<'a>,
    /// The buffers that raster draws.
    pub buffers: &'a SceneBuffers,
    /// Where everything stands.
    pub pose: &'a Pose,
    /// World to clip space, as in the frame uniforms.
    pub view_projection: Mat4,
    /// World to clip space without jitter, now and one frame ago.
    pub unjittered: [Mat4; 2],
}

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Push {
    instance: u32,
    material: u32,
    flags: u32,
}

/// Bits of [`Push::flags`]. Twins: shaders/include/gbuffer_draw.glsl.
const FLIPS_WINDING: u32 = 1;
const MOVED: u32 = 2;

/// The pass.
pub struct GBufferPass {
    pipeline: GraphicsPipeline,
    materials: Arc<MaterialSets>,
    targets: GBuffer,
}

impl GBufferPass {
    /// Makes the pipeline and the images, of `extent` texels.
    pub fn new(device: &Arc<Device>, scene: &SceneBuffers, extent: [u32; 2]) -> Result<Self, VulkanError> {
        let pipeline = GraphicsPipeline::new(
            device,
            &GraphicsDescription {
                name: "gbuffer",
                vertex: shaders::GBUFFER_VERT,
                fragment: shaders::GBUFFER_FRAG,
                vertex_stride: size_of::<Vertex>() as u32,
                attributes: &ATTRIBUTES,
                colors: &FORMATS,
                blend: false,
                variants: &[0, 1, 2, 3],
            },
        )?;
        let materials = scene.material_sets(device, &pipeline)?;
        Ok(Self { pipeline, materials: Arc::new(materials), targets: GBuffer::new(device, extent)? })
    }

    /// This pass for pictures of `extent` texels.
    pub fn resized(&self, device: &Arc<Device>, extent: [u32; 2]) -> Result<Self, VulkanError> {
        Ok(Self {
            pipeline: self.pipeline.clone(),
            materials: Arc::clone(&self.materials),
            targets: GBuffer::new(device, extent)?,
        })
    }

    /// The G-buffer of the last frame.
    pub fn output(&self) -> &GBuffer {
        &self.targets
    }

    /// Draws the scene.
    pub fn record(&self, frame: &mut Frame<'_>, inputs: &GBufferInputs<'_>) -> Result<&GBuffer, VulkanError> {
        let GBuffer { depth, normal, albedo, instance, surface, motion, nearest } = &self.targets;
        let buffers = inputs.buffers;
        let [now, then] = inputs.unjittered;
        let draws = visible(&buffers.draws, inputs.pose, &inputs.view_projection);
        let instances = buffers.uploaded_instances();
        let flags = |data: &InstanceData| {
            let moved = now != then || data.object_to_world != data.previous_object_to_world;
            data.flips_winding * FLIPS_WINDING + u32::from(moved) * MOVED
        };
        let pass = frame
            .draw_pass("gbuffer", &self.pipeline)
            .read("frame_uniforms", inputs.uniforms)
            .shared(inputs.scene);
        let targets =
            Targets::Cleared { colors: &[depth, normal, albedo, instance, surface, motion], depth: nearest };
        pass.draw(&targets, |list| {
            list.geometry(&buffers.vertices, &buffers.indices);
            let mut bound = None;
            for draw in &draws {
                if bound != Some(draw.material) {
                    list.variant(buffers.variants[draw.material as usize]);
                    list.material(&self.materials, draw.material as usize);
                    bound = Some(draw.material);
                }
                let flags = flags(&instances[draw.instance as usize]);
                // Mirroring swaps the windings but not the sides.
                let mut sides = [vk::CullModeFlags::BACK, vk::CullModeFlags::FRONT];
                if flags & FLIPS_WINDING != 0 {
                    sides.reverse();
                }
                let [backs, fronts] = sides;
                let material = draw.material as usize;
                let draws: &[(vk::CullModeFlags, f32)] =
                    match (buffers.single_sided[material], buffers.dark_behind[material]) {
                        (true, _) => &[(backs, 0.0)],
                        (_, true) => &[(backs, 0.0), (fronts, BEHIND)],
                        _ => &[(vk::CullModeFlags::NONE, 0.0)],
                    };
                let push = Push { instance: draw.instance, material: draw.material, flags };
                for &(culled, bias) in draws {
                    list.cull(culled);
                    list.depth_bias(bias);
                    list.draw(&push, draw.first, draw.count);
                }
            }
        })?;
        Ok(&self.targets)
    }
}
