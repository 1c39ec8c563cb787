//! Reflections: one path a pixel through the GGX lobes of what it meets, denoised without the lobe's albedo.
//!
//! In: the visible surfaces, all that is known of what rays hit, and irradiance: that of what is on the screen, and for other hits
//! that of the estimator, which lights them between the two steps. Out: radiance over the directional albedo of the lobe.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};

use super::{EffectInputs, noise, svgf_settings};
use crate::denoise::svgf::{Svgf, SvgfInputs};
use crate::passes::hit_buffers::HitBuffers;
use crate::passes::scene_buffers::Instances;
use crate::passes::storage_image;
use crate::passes::tracer::TracerVariant;
use crate::scene::{Camera, Scene};
use crate::settings::{Noise, Reflections as Wanted, Settings};
use crate::vulkan::{Buffer, ComputePipeline, Device, Frame, Image, VulkanError, shaders, vk};

/// Where rays give way to irradiance. Twin: `MIRRORED_BLEND` in shaders/include/mirrored.glsl.
const MIRRORED_BLEND: f32 = 0.1;

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
    /// The camera.
    pub camera: &'a Camera,
}

/// `Push` in shaders/effects/reflections_trace.comp.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct TracePush {
    spread: f32,
    limit: f32,
    depth: u32,
}

/// The effect: 128 bytes a pixel.
pub struct Reflections {
    trace: ComputePipeline,
    hits: Arc<HitBuffers>,
    noise: Buffer,
    noisy: Image,
    hit_place: Image,
    hit_weight: Image,
    reprojected: Image,
    svgf: Svgf,
    limit: f32,
    depth: u32,
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
            reflects && smooth && !material.is_sheet()
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
            trace: tracer.pipeline(device, "reflections_trace", shader, &[white])?,
            hits,
            noise: noise::table(device)?,
            noisy: image("noisy reflection", halves)?,
            hit_place: image("hit_place", vk::Format::R32G32B32A32_UINT)?,
            hit_weight: image("hit_weight", halves)?,
            reprojected: image("reflection_reprojected", halves)?,
            svgf: Svgf::new(device, settings.size, &svgf_settings(settings))?,
            limit: settings.effects.reflection_roughness,
            depth: settings.effects.reflection_depth,
        })
    }

    /// Roughness up to which surfaces mirror.
    pub fn limit(&self) -> f32 {
        self.limit
    }

    /// rgb: radiance over the directional albedo of the lobe, RGBA16F.
    pub fn output(&self) -> &Image {
        self.svgf.output()
    }

    /// The same as the rays of the last frame have it; a: distance of the first hit. The estimator adds to it.
    pub fn noisy(&self) -> &Image {
        &self.noisy
    }

    /// The hits that the estimator is to light: see shaders/include/hit_record.glsl.
    pub fn hits(&self) -> [&Image; 2] {
        [&self.hit_place, &self.hit_weight]
    }

    /// Its denoiser.
    pub fn svgf(&self) -> &Svgf {
        &self.svgf
    }

    /// Casts the rays.
    pub fn trace(
        &self,
        frame: &mut Frame<'_>,
        inputs: &EffectInputs<'_>,
        scene: &ReflectionInputs<'_>,
    ) -> Result<(), VulkanError> {
        let gbuffer = inputs.gbuffer;
        let extent = self.noisy.extent();
        let spread = 2.0 * (scene.camera.vertical_fov * 0.5).tan() / extent[1] as f32;
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
            .read("last_surface", inputs.reprojection.last_surface())
            .read("reprojected", inputs.reprojection.reprojected())
            .write("reflection", &self.noisy)
            .write("hit_place", &self.hit_place)
            .write("hit_weight", &self.hit_weight)
            .write("reflection_reprojected", &self.reprojected)
            .push(&TracePush { spread, limit: self.limit, depth: self.depth });
        self.hits.bind(inputs.tracer.bind(pass), inputs.scene, scene.instances).dispatch_over(extent)
    }

    /// Denoises what the rays have brought.
    pub fn denoise(&mut self, frame: &mut Frame<'_>, inputs: &EffectInputs<'_>) -> Result<(), VulkanError> {
        let svgf = SvgfInputs { reprojected: &self.reprojected, ..inputs.svgf(&self.noisy) };
        self.svgf.record(frame, &svgf, inputs.rest)
    }
}
