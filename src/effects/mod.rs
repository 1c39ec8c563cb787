//! What rays from the visible surfaces add, noisy and then denoised: soft shadows, reflections.

pub mod noise;
pub mod reflections;
pub mod soft_shadows;

use crate::denoise::RestFrame;
use crate::denoise::svgf::{Svgf, SvgfInputs};
use crate::passes::area_lights::UploadedAreaLights;
use crate::passes::effect_view::Kind;
use crate::passes::gbuffer::GBuffer;
use crate::passes::reprojection::ReprojectionPass;
use crate::passes::scene_buffers::SceneBuffers;
use crate::passes::tracer::Tracer;
use crate::settings::{Denoise, Settings, SvgfSettings};
use crate::vulkan::{Image, Upload};

/// What effects read.
pub struct EffectInputs<'a> {
    /// Frame uniforms.
    pub frame: &'a Upload,
    /// The visible surfaces.
    pub gbuffer: &'a GBuffer,
    /// Where they were in the last frame.
    pub reprojection: &'a ReprojectionPass,
    /// What casts rays.
    pub tracer: &'a Tracer,
    /// Point, spot and directional lights.
    pub lights: &'a Upload,
    /// Area lights.
    pub area_lights: &'a UploadedAreaLights,
    /// The scene.
    pub scene: &'a SceneBuffers,
    /// The frame's place in a still scene; none while anything changes.
    pub rest: Option<RestFrame>,
}

impl<'a> EffectInputs<'a> {
    /// What a denoiser reads for a noisy image that moves as the surfaces do.
    fn svgf(&self, noisy: &'a Image) -> SvgfInputs<'a> {
        SvgfInputs {
            frame: self.frame,
            noisy,
            depth: &self.gbuffer.depth,
            normal: &self.gbuffer.normal,
            surface: self.reprojection.surface(),
            reprojected: self.reprojection.reprojected(),
        }
    }
}

/// How an effect is denoised. Without a denoiser each frame is shown as it is, and a still scene as the mean of its frames.
fn svgf_settings(settings: &Settings) -> SvgfSettings {
    match settings.effects.denoise {
        Denoise::Svgf => settings.svgf,
        Denoise::None => SvgfSettings {
            alpha: 1.0,
            moments_alpha: 1.0,
            levels: 0,
            clamp: 0.0,
            firefly: 0.0,
            ..settings.svgf
        },
    }
}

/// What an effect goes through, by the ends of the names of its views, or by those of its layers.
pub struct Stages<'a> {
    /// As the rays of the last frame have it.
    pub raw: &'a Image,
    /// Its denoiser.
    pub svgf: &'a Svgf,
}

impl<'a> Stages<'a> {
    /// The image that one of the views shows; `light`: how the signal itself is shown.
    pub fn shown(&self, stage: &str, light: Kind) -> Option<(&'a Image, Kind)> {
        Some(match stage {
            "" => (self.svgf.output(), light),
            "raw" => (self.raw, light),
            "temporal" => (self.svgf.history(), light),
            "variance" => (self.svgf.output(), Kind::Deviation),
            "history" => (self.svgf.moments(), Kind::History),
            _ => return None,
        })
    }
}
