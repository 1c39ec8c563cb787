//! Reflections: one path a pixel through the GGX lobes of what it meets, denoised without the lobe's albedo.
//!
//! In: the visible surfaces, all that is known of what rays hit, and irradiance: that of what is on the screen, and for other hits
//! that of the estimator, which lights them between the two steps. Out: radiance over the directional albedo of the lobe.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};

use super::split_sum::SplitSum;
use super::{DebugImages, EffectDescription};
use crate::denoise::{Denoiser, DenoiserInputs};
use crate::gpu_scene::tracer::TracerVariant;
use crate::passes::effect_view::Visualization;
use crate::passes::frame_inputs::FrameInputs;
use crate::passes::history::History;
use crate::passes::storage_image;
use crate::passes::thin_surfaces::ThinSurfaceImages;
use crate::scene::Scene;
use crate::settings::{Noise, Reflections as Wanted, SecondReflections, Settings};
use crate::vulkan::{ComputePipeline, Device, Frame, Image, VulkanError, shaders, vk};

/// Where rays give way to irradiance. Twin: `REFLECTION_BLEND` in shaders/include/reflection_weight.glsl.
const REFLECTION_BLEND: f32 = 0.1;
/// The limit of the shaders where all surfaces mirror.
const ALL_MIRROR: f32 = 2.0;

/// How much of the GGX lobe's light comes from reflection rays. Twin: shaders/include/reflection_weight.glsl.
pub fn reflection_weight(roughness: f32, limit: f32) -> f32 {
    if limit >= 1.0 {
        return 1.0;
    }
    let t = ((roughness - limit + REFLECTION_BLEND) / (2.0 * REFLECTION_BLEND)).clamp(0.0, 1.0);
    1.0 - t * t * (3.0 - 2.0 * t)
}

/// `Push` in shaders/effects/reflections_trace.comp.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct TracePush {
    spread: f32,
    has_history: u32,
    has_environment: u32,
    sees_screen: u32,
    near: f32,
}

/// The effect: 140 bytes a pixel.
pub struct Reflections {
    trace: ComputePipeline,
    /// The split sum, where hits mirror the environment alone.
    split_sum: Option<SplitSum>,
    noisy: Image,
    hit_place: Image,
    hit_weight: Image,
    image: MirrorImage,
    denoiser: Box<dyn Denoiser>,
    limit: f32,
}

/// The surface seen in reflections: in smooth surfaces the mirror image of the hit, elsewhere the surface itself.
struct MirrorImage {
    /// View depth, as that of the G-buffer.
    depth: Image,
    /// Normals, as those of the G-buffer.
    normal: Image,
    /// Surfaces, as `Reprojection::surface`.
    surfaces: History<Image>,
    /// The instances of what is seen, plus one.
    instances: History<Image>,
    /// Where they were, as `Reprojection::reprojected`.
    reprojected: Image,
}

/// Whether reflections are traced: with `auto`, in scenes where a surface may be glossy enough.
pub fn traces_reflections(scene: &Scene, settings: &Settings) -> bool {
    let limit = settings.reflection_roughness();
    match settings.reflections {
        Wanted::None => false,
        Wanted::Rays => true,
        Wanted::Auto => scene.materials.iter().any(|material| {
            let reflects = material.metallic > 0.0 || material.f90 > 0.0 || material.f0.max_element() > 0.0;
            let smooth = limit >= 1.0
                || material.roughness < limit + REFLECTION_BLEND
                || material.metallic_roughness_texture.is_some();
            reflects && smooth
        }),
    }
}

impl Reflections {
    /// Makes the pipelines for a tracer, and the images.
    pub fn new(
        device: &Arc<Device>,
        tracer: TracerVariant,
        description: &EffectDescription,
    ) -> Result<Self, VulkanError> {
        let effects = &description.settings;
        let white = u32::from(effects.noise == Noise::White);
        let sums = effects.second_reflections == SecondReflections::SplitSum;
        let shader = shaders::REFLECTIONS_TRACE_COMP;
        let image = |name, format| storage_image(device, name, format, description.size);
        let halves = vk::Format::R16G16B16A16_SFLOAT;
        Ok(Self {
            trace: tracer.pipeline(
                device,
                "reflections_trace",
                shader,
                &[white, effects.reflection_depth, effects.reprojection_tests(), u32::from(sums)],
            )?,
            split_sum: sums.then(|| SplitSum::new(device)).transpose()?,
            noisy: image("noisy reflection", halves)?,
            hit_place: image("hit_place", vk::Format::R32G32B32A32_UINT)?,
            hit_weight: image("hit_weight", halves)?,
            image: MirrorImage {
                depth: image("image_depth", vk::Format::R32_SFLOAT)?,
                normal: image("image_normal", halves)?,
                surfaces: History::new(|_| image("image_surface", vk::Format::R16G16B16A16_UINT))?,
                instances: History::new(|_| image("image_instance", vk::Format::R32_UINT))?,
                reprojected: image("image_reprojected", halves)?,
            },
            denoiser: description.make_denoiser(device)?,
            limit: description.reflection_roughness,
        })
    }

    /// Roughness up to which surfaces mirror, as the shaders blend it: see shaders/include/reflection_weight.glsl.
    pub fn limit(&self) -> f32 {
        if self.limit >= 1.0 { ALL_MIRROR } else { self.limit }
    }

    /// rgb: radiance over the directional albedo of the lobe, RGBA16F.
    pub fn output(&self) -> &Image {
        self.denoiser.output(&self.noisy)
    }

    /// The signal of the last frame's rays; a: how wide a blur is of use. The estimator adds to it.
    pub fn noisy(&self) -> &Image {
        &self.noisy
    }

    /// The hits that the estimator is to light: see shaders/include/hit_record.glsl.
    pub fn hits(&self) -> [&Image; 2] {
        [&self.hit_place, &self.hit_weight]
    }

    /// The images that it goes through.
    pub fn debug_images(&self) -> DebugImages<'_> {
        DebugImages { noisy: &self.noisy, denoiser: &*self.denoiser, signal: Visualization::Light }
    }

    /// Casts the rays. `irradiance`: that of the visible surfaces, RGBA16F, and whether hits on the screen take it from there. Otherwise
    /// the estimator is to light all. `thin_surfaces`: those before the visible surfaces, in scenes that have any.
    ///
    /// # Errors
    /// Where the device fails.
    pub fn trace(
        &mut self,
        frame: &mut Frame<'_>,
        inputs: &FrameInputs<'_>,
        (irradiance, sees_screen): (&Image, bool),
        thin_surfaces: Option<&ThinSurfaceImages>,
    ) -> Result<(), VulkanError> {
        let (gbuffer, image) = (inputs.gbuffer, &mut self.image);
        let extent = self.noisy.extent();
        let spread = 2.0 * (inputs.pose.camera.vertical_fov * 0.5).tan() / extent[1] as f32;
        let has_history = u32::from(image.surfaces.is_valid());
        let has_environment = u32::from(inputs.pose.environment.is_some());
        let sees_screen = u32::from(sees_screen);
        let near = inputs.pose.camera.near;
        if let Some(split_sum) = &mut self.split_sum {
            split_sum.follow(frame, (inputs.uniforms, inputs.scene), inputs.pose.environment.as_ref())?;
        }
        // Without thin surfaces an image of the same format is bound, and not read.
        let unread = &gbuffer.albedo;
        let [mirrored, transmittance] =
            thin_surfaces.map_or([unread, unread], |thin| [&thin.mirrored, &thin.transmittance]);
        let prefiltered = self.split_sum.as_ref().map_or(unread, SplitSum::image);
        inputs
            .bind(frame.pass("reflections_trace", &self.trace))
            .read("gbuffer_albedo", &gbuffer.albedo)
            .read("gbuffer_instance", &gbuffer.instance)
            .read("gbuffer_surface", &gbuffer.surface)
            .read("irradiance", irradiance)
            .read("reprojected", &inputs.reprojection.reprojected)
            .read("thin_mirrored", mirrored)
            .read("thin_transmittance", transmittance)
            .read("prefiltered_environment", prefiltered)
            .write("reflection", &self.noisy)
            .write("hit_place", &self.hit_place)
            .write("hit_weight", &self.hit_weight)
            .read("last_image_surface", image.surfaces.last())
            .write("image_depth", &image.depth)
            .write("image_normal", &image.normal)
            .write("image_surface", image.surfaces.next())
            .read("last_image_instance", image.instances.last())
            .write("image_instance", image.instances.next())
            .write("image_reprojected", &image.reprojected)
            .push(&TracePush { spread, has_history, has_environment, sees_screen, near })
            .dispatch_over(extent)?;
        image.surfaces.advance();
        image.instances.advance();
        Ok(())
    }

    /// Denoises what the rays have brought.
    ///
    /// # Errors
    /// Where the device fails.
    pub fn denoise(&mut self, frame: &mut Frame<'_>, inputs: &FrameInputs<'_>) -> Result<(), VulkanError> {
        let MirrorImage { depth, normal, surfaces, reprojected, .. } = &self.image;
        let surface = surfaces.last();
        let inputs = DenoiserInputs {
            depth,
            normal,
            surface,
            reprojected,
            ..DenoiserInputs::of(inputs, &self.noisy, None)
        };
        self.denoiser.record(frame, &inputs)
    }
}
