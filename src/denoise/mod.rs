//! Denoisers: a noisy signal and what is known of the surfaces in, a clean signal out.
//!
//! None knows where its signal comes from. Each use has a denoiser of its own, which owns its history and forgets it when told.

mod spatial;
pub mod svgf;

use std::sync::Arc;

use crate::passes::clock::StaticFrame;
use crate::passes::effect_view::Visualization;
use crate::passes::frame_inputs::FrameInputs;
use crate::settings::{Denoise, Settings};
use crate::vulkan::{Device, Frame, Image, Pass, Upload, VulkanError};
use spatial::Spatial;
use svgf::Svgf;

/// What a denoiser is used for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Use {
    /// Indirect irradiance of an estimator.
    Indirect,
    /// Visibility of lights with an extent.
    SoftShadows,
    /// Radiance along reflection rays.
    Reflections,
}

/// The names of a use's passes: its own in front of those of the denoiser.
#[derive(Clone, Copy, Debug)]
pub struct PassNames {
    /// SVGF's temporal accumulation.
    pub svgf_temporal: &'static str,
    /// SVGF's spatial estimate of the variance.
    pub svgf_variance: &'static str,
    /// SVGF's a-trous filter.
    pub svgf_atrous: &'static str,
    /// The filter of a signal whose variance is known.
    pub spatial: &'static str,
}

macro_rules! pass_names {
    ($prefix:literal) => {
        PassNames {
            svgf_temporal: concat!($prefix, "_svgf_temporal"),
            svgf_variance: concat!($prefix, "_svgf_variance"),
            svgf_atrous: concat!($prefix, "_svgf_atrous"),
            spatial: concat!($prefix, "_spatial_filter"),
        }
    };
}

impl Use {
    /// The names of its passes.
    pub const fn names(self) -> PassNames {
        match self {
            Self::Indirect => pass_names!("indirect"),
            Self::SoftShadows => pass_names!("soft_shadows"),
            Self::Reflections => pass_names!("reflections"),
        }
    }
}

/// What is known of a signal's noise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SignalNoise {
    /// There is none.
    None,
    /// Its variance: the signal is the mean of several independent estimates already.
    Variance,
    /// Nothing: each frame is an estimate of its own.
    Unknown,
}

/// What a denoiser reads of one frame.
pub struct DenoiserInputs<'a> {
    /// `FrameUniforms`.
    pub uniforms: &'a Upload,
    /// rgb: the signal, without the albedo of the surface, RGBA16F; a: how wide a blur is of use, 0: none, 1: as wide as
    /// [`crate::settings::SvgfSettings::reach`]. A denoiser may overwrite it.
    pub noisy: &'a Image,
    /// Variance of its luminance, R32F, if it is known.
    pub variance: Option<&'a Image>,
    /// View depth of the surfaces, as in the G-buffer.
    pub depth: &'a Image,
    /// Shading and geometric normals, as in the G-buffer.
    pub normal: &'a Image,
    /// Packed surfaces: shaders/include/visible_surface.glsl.
    pub surface: &'a Image,
    /// Where the signal was in the last frame: `Reprojection::reprojected`.
    pub reprojected: &'a Image,
    /// The frame's place in a static scene; none while anything changes.
    pub static_frame: Option<StaticFrame>,
}

impl<'a> DenoiserInputs<'a> {
    /// The inputs for a signal that moves as the visible surfaces do.
    pub fn of(inputs: &FrameInputs<'a>, noisy: &'a Image, variance: Option<&'a Image>) -> Self {
        Self {
            uniforms: inputs.uniforms,
            noisy,
            variance,
            depth: &inputs.gbuffer.depth,
            normal: &inputs.gbuffer.normal,
            surface: inputs.reprojection.surface(),
            reprojected: &inputs.reprojection.reprojected,
            static_frame: inputs.clock.static_frame(),
        }
    }

    /// Binds the signal's surfaces.
    fn bind<'f>(&'f self, pass: Pass<'f>) -> Pass<'f> {
        pass.read("frame_uniforms", self.uniforms)
            .read("gbuffer_depth", self.depth)
            .read("gbuffer_normal", self.normal)
    }
}

/// A denoiser of one use.
pub enum Denoiser {
    /// The signal stays as it is, at no cost.
    None,
    /// An a-trous filter over a signal whose variance is known.
    Spatial(Spatial),
    /// SVGF.
    Svgf(Box<Svgf>),
}

impl Denoiser {
    /// Makes the denoiser that the settings name, for a signal of `extent` texels.
    ///
    /// # Errors
    /// Where the device lacks memory.
    pub fn new(
        device: &Arc<Device>,
        usage: Use,
        noise: SignalNoise,
        extent: [u32; 2],
        settings: &Settings,
    ) -> Result<Self, VulkanError> {
        Ok(match (settings.effects.denoise, noise) {
            (Denoise::None, _) | (_, SignalNoise::None) => Self::None,
            (Denoise::Svgf, SignalNoise::Variance) => Self::Spatial(Spatial::new(device, usage, extent)?),
            (Denoise::Svgf, SignalNoise::Unknown) => {
                Self::Svgf(Box::new(Svgf::new(device, usage, extent, &settings.svgf)?))
            }
        })
    }

    /// Denoises one frame.
    ///
    /// # Errors
    /// Where the device fails.
    pub fn record(&mut self, frame: &mut Frame<'_>, inputs: &DenoiserInputs<'_>) -> Result<(), VulkanError> {
        match self {
            Self::None => Ok(()),
            Self::Spatial(spatial) => spatial.record(frame, inputs),
            Self::Svgf(svgf) => svgf.record(frame, inputs),
        }
    }

    /// The denoised signal of the last frame, given the noisy one.
    pub fn output<'a>(&'a self, noisy: &'a Image) -> &'a Image {
        match self {
            Self::None => noisy,
            Self::Spatial(spatial) => spatial.output(),
            Self::Svgf(svgf) => svgf.output(),
        }
    }

    /// Whether frames of a static scene are accumulated, so that noise averages out before the picture freezes.
    pub fn accumulates(&self) -> bool {
        matches!(self, Self::Svgf(_))
    }

    /// Forgets all frames so far.
    pub fn forget(&mut self) {
        if let Self::Svgf(svgf) = self {
            svgf.forget();
        }
    }

    /// The image that one of the use's views shows, by the end of the view's name, and how: the result, the noisy signal, the
    /// history, the noise that is left, the length of the history. None where the denoiser has no such image.
    pub fn debug_image<'a>(
        &'a self,
        stage: &str,
        noisy: &'a Image,
        signal: Visualization,
    ) -> Option<(&'a Image, Visualization)> {
        Some(match (stage, self) {
            ("", _) => (self.output(noisy), signal),
            ("raw", _) => (noisy, signal),
            ("temporal", Self::Svgf(svgf)) => (svgf.history(), signal),
            ("variance", Self::Svgf(svgf)) => (svgf.output(), Visualization::Deviation),
            ("history", Self::Svgf(svgf)) => (svgf.moments(), Visualization::History),
            _ => return None,
        })
    }
}
