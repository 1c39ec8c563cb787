//! Reflections: one path a pixel through the GGX lobes of what it meets, denoised without the lobe's albedo.
//!
//! In: the visible surfaces, all that is known of what rays hit, and irradiance: that of what is on the screen, and for other hits
//! that of the estimator, which lights them between the two steps. Out: radiance over the directional albedo of the lobe.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};

use super::{EffectInputs, Stages, noise, svgf_settings};
use crate::denoise::svgf::{Svgf, SvgfInputs};
use crate::passes::hit_buffers::HitBuffers;
use crate::passes::scene_buffers::Instances;
use crate::passes::storage_image;
use crate::passes::tracer::TracerVariant;
use crate::scene::{Pose, Scene};
use crate::settings::{Noise, Reflections as Wanted, Settings};
use crate::vulkan::{Buffer, ComputePipeline, Device, Frame, Image, VulkanError, shaders, vk};

/// Where rays give way to irradiance. Twin: `MIRRORED_BLEND` in shaders/include/mirrored.glsl.
const MIRRORED_BLEND: f32 = 0.1;
/// The limit of the shaders where all surfaces mirror.
const ALL_MIRROR: f32 = 2.0;

/// How much of the GGX lobe's light comes from reflection rays. Twin: shaders/include/mirrored.glsl.
pub fn mirrored_share(roughness: f32, limit: f32) -> f32 {
    if limit >= 1.0 {
        return 1.0;
    }
    let t = ((roughness - limit + MIRRORED_BLEND) / (2.0 * MIRRORED_BLEND)).clamp(0.0, 1.0);
    1.0 - t * t * (3.0 - 2.0 * t)
}

/// What the trace reads besides what all effects do.
pub struct ReflectionInputs<'a> {
    /// Instances of this frame.
    pub instances: &'a Instances,
    /// Irradiance of the visible surfaces, RGBA32F.
    pub irradiance: &'a Image,
    /// Where everything stands.
    pub pose: &'a Pose,
}

/// `Push` in shaders/effects/reflections_trace.comp.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct TracePush {
    spread: f32,
    has_history: u32,
    has_environment: u32,
}

/// The effect: 164 bytes a pixel.
pub struct Reflections {
    trace: ComputePipeline,
    hits: Arc<HitBuffers>,
    noise: Buffer,
    noisy: Image,
    hit_place: Image,
    hit_weight: Image,
    image: MirrorImage,
    svgf: Svgf,
    limit: f32,
}

/// What is seen in reflections: in smooth surfaces the mirror image of what is hit, elsewhere the surface itself.
struct MirrorImage {
    /// As those of the G-buffer.
    depth: Image,
    /// As those of the G-buffer.
    normal: Image,
    /// As `ReprojectionPass::surface`, of this frame and the last one, in turns.
    surfaces: [Image; 2],
    /// As `ReprojectionPass::reprojected`.
    reprojected: Image,
    /// Which of `surfaces` is the last frame's; none before the first.
    last: Option<usize>,
}

/// Whether reflections are traced: with `auto`, in scenes where a surface that raster draws may be glossy enough.
pub fn is_mirrored(scene: &Scene, settings: &Settings) -> bool {
    let limit = settings.effects.reflection_roughness;
    match settings.reflections {
        Wanted::None => false,
        Wanted::Rays => true,
        Wanted::Auto => scene.materials.iter().any(|material| {
            let reflects = material.metallic > 0.0 || material.f90 > 0.0 || material.f0.max_element() > 0.0;
            let smooth = limit >= 1.0
                || material.roughness < limit + MIRRORED_BLEND
                || material.metallic_roughness_texture.is_some();
            reflects && smooth && !material.is_thin_surface()
        }),
    }
}

impl Reflections {
    /// Makes the pipelines for a tracer, and the images.
    pub fn new(
        device: &Arc<Device>,
        tracer: TracerVariant,
        hits: Arc<HitBuffers>,
        settings: &Settings,
    ) -> Result<Self, VulkanError> {
        let white = u32::from(settings.effects.noise == Noise::White);
        let shader = shaders::REFLECTIONS_TRACE_COMP;
        let image = |name, format| storage_image(device, name, format, settings.size);
        let halves = vk::Format::R16G16B16A16_SFLOAT;
        Ok(Self {
            trace: tracer.pipeline(
                device,
                "reflections_trace",
                shader,
                &[white, settings.effects.reflection_depth],
            )?,
            hits,
            noise: noise::table(device)?,
            noisy: image("noisy reflection", halves)?,
            hit_place: image("hit_place", vk::Format::R32G32B32A32_UINT)?,
            hit_weight: image("hit_weight", halves)?,
            image: MirrorImage {
                depth: image("image_depth", vk::Format::R32_SFLOAT)?,
                normal: image("image_normal", halves)?,
                surfaces: [
                    image("image_surface 0", vk::Format::R16G16B16A16_UINT)?,
                    image("image_surface 1", vk::Format::R16G16B16A16_UINT)?,
                ],
                reprojected: image("image_reprojected", halves)?,
                last: None,
            },
            svgf: Svgf::new(device, settings.size, &svgf_settings(settings))?,
            limit: settings.effects.reflection_roughness,
        })
    }

    /// Roughness up to which surfaces mirror, as the shaders blend it: see shaders/include/mirrored.glsl.
    pub fn limit(&self) -> f32 {
        if self.limit >= 1.0 { ALL_MIRROR } else { self.limit }
    }

    /// rgb: radiance over the directional albedo of the lobe, RGBA16F.
    pub fn output(&self) -> &Image {
        self.svgf.output()
    }

    /// The same as the rays of the last frame have it; a: how wide a blur is of use. The estimator adds to it.
    pub fn noisy(&self) -> &Image {
        &self.noisy
    }

    /// The hits that the estimator is to light: see shaders/include/hit_record.glsl.
    pub fn hits(&self) -> [&Image; 2] {
        [&self.hit_place, &self.hit_weight]
    }

    /// What it goes through.
    pub fn stages(&self) -> Stages<'_> {
        Stages { raw: &self.noisy, svgf: &self.svgf }
    }

    /// Casts the rays.
    pub fn trace(
        &mut self,
        frame: &mut Frame<'_>,
        inputs: &EffectInputs<'_>,
        scene: &ReflectionInputs<'_>,
    ) -> Result<(), VulkanError> {
        let gbuffer = inputs.gbuffer;
        let extent = self.noisy.extent();
        let spread = 2.0 * (scene.pose.camera.vertical_fov * 0.5).tan() / extent[1] as f32;
        let last = self.image.last.unwrap_or_default();
        let has_history = u32::from(self.image.last.is_some());
        let has_environment = u32::from(scene.pose.environment.is_some());
        let push = TracePush { spread, has_history, has_environment };
        let pass = frame
            .pass("reflections_trace", &self.trace)
            .read("frame_uniforms", inputs.frame)
            .read("gbuffer_depth", &gbuffer.depth)
            .read("gbuffer_normal", &gbuffer.normal)
            .read("gbuffer_albedo", &gbuffer.albedo)
            .read("gbuffer_instance", &gbuffer.instance)
            .read("gbuffer_surface", &gbuffer.surface)
            .read("lights", inputs.lights)
            .read("area_lights", &inputs.area_lights.lights)
            .read("emitters", &inputs.area_lights.emitters)
            .read("environment_map", &inputs.scene.environment.image)
            .read("blue_noise", &self.noise)
            .read("irradiance", scene.irradiance)
            .read("reprojected", inputs.reprojection.reprojected())
            .write("reflection", &self.noisy)
            .write("hit_place", &self.hit_place)
            .write("hit_weight", &self.hit_weight)
            .read("last_image_surface", &self.image.surfaces[last])
            .write("image_depth", &self.image.depth)
            .write("image_normal", &self.image.normal)
            .write("image_surface", &self.image.surfaces[1 - last])
            .write("image_reprojected", &self.image.reprojected)
            .push(&push);
        self.hits.bind(inputs.tracer.bind(pass), inputs.scene, scene.instances).dispatch_over(extent)?;
        self.image.last = Some(1 - last);
        Ok(())
    }

    /// Denoises what the rays have brought.
    pub fn denoise(&mut self, frame: &mut Frame<'_>, inputs: &EffectInputs<'_>) -> Result<(), VulkanError> {
        let image = &self.image;
        let svgf = SvgfInputs {
            frame: inputs.frame,
            noisy: &self.noisy,
            depth: &image.depth,
            normal: &image.normal,
            surface: &image.surfaces[image.last.unwrap_or_default()],
            reprojected: &image.reprojected,
        };
        self.svgf.record(frame, &svgf, inputs.rest)
    }
}
