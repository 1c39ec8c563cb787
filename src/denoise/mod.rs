//! Denoisers: a noisy signal and what is known of the surfaces in, a clean signal out.
//!
//! None knows where its signal comes from. Each use has a denoiser of its own, which owns its history.

pub mod bmfr;
mod method;
mod none;
mod spatial;
pub mod svgf;

pub use method::{DenoiserDescription, DenoiserPass, DenoiserSettings, MakeDenoiser, Method, Use};

use std::sync::Arc;

use crate::passes::effect_view::Visualization;
use crate::passes::frame_inputs::FrameInputs;
use crate::report::PassInfo;
use crate::settings::{Denoise, Registry};
use crate::vulkan::{Device, Frame, Image, Pass, Upload, VulkanError};

/// Knowledge of a signal's noise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SignalNoise {
    /// There is none.
    None,
    /// Its variance: the signal is the mean of several independent estimates already. A frame without a variance has no noise.
    Variance,
    /// Nothing: each frame is an estimate of its own.
    Unknown,
}

/// Inputs of a denoiser for one frame.
pub struct DenoiserInputs<'a> {
    /// `FrameUniforms`.
    pub uniforms: &'a Upload,
    /// rgb: the signal, without the albedo of the surface, RGBA16F; a: how wide a blur is of use, 0: none, 1: as wide as
    /// [`crate::settings::SvgfSettings::filter_radius`]. A denoiser may overwrite it.
    pub noisy: &'a Image,
    /// Variance of its luminance, R32F, if it is known.
    pub variance: Option<&'a Image>,
    /// View depth of the surfaces, as in the G-buffer.
    pub depth: &'a Image,
    /// Shading and geometric normals, as in the G-buffer.
    pub normal: &'a Image,
    /// Packed surfaces: shaders/include/visible_surface.glsl.
    pub surface: &'a Image,
    /// rgb: diffuse albedo; a: roughness, as in the G-buffer.
    pub albedo: &'a Image,
    /// Where the signal was in the last frame: `Reprojection::reprojected`.
    pub reprojected: &'a Image,
    /// Whether the camera has moved since.
    pub camera_moves: bool,
    /// Whether a light is so wide that its shadows are mostly noise: more than 6 degrees to each side.
    pub light_is_wide: bool,
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
            albedo: &inputs.gbuffer.albedo,
            surface: inputs.reprojection.surface(),
            reprojected: &inputs.reprojection.reprojected,
            camera_moves: inputs.clock.camera_moves(),
            light_is_wide: false,
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
pub trait Denoiser: Send {
    /// Denoises one frame.
    ///
    /// # Errors
    /// Where the device fails.
    fn record(&mut self, frame: &mut Frame<'_>, inputs: &DenoiserInputs<'_>) -> Result<(), VulkanError>;

    /// The denoised signal of the last frame, given the noisy one.
    fn output<'a>(&'a self, noisy: &'a Image) -> &'a Image;

    /// The image that one of the use's views shows, by the end of the view's name, and how: the history (`temporal`), the noise
    /// that is left (`variance`), the length of the history (`history`). None where the denoiser has no such image. `signal`
    /// is how the signal itself is shown.
    fn debug_image(&self, _stage: &str, _signal: Visualization) -> Option<(&Image, Visualization)> {
        None
    }
}

/// One line a denoiser. [`register`] adds those of other crates.
static METHODS: Registry<Method> = Registry::new(&[svgf::METHOD, bmfr::METHOD, none::METHOD]);

/// Adds a denoiser of another crate, such as a test's, before anything else uses the library.
pub fn register(method: Method) {
    method.denoise.add();
    METHODS.add(method);
}

/// The denoiser of that name.
fn method(denoise: Denoise) -> &'static Method {
    let found = METHODS.all().iter().find(|method| method.denoise == denoise);
    found.unwrap_or_else(|| panic!("--denoise {denoise:?} is not registered"))
}

/// Whether the denoiser of a signal with this noise needs to know where surfaces were in the last frame.
pub fn follows_surfaces(noise: SignalNoise, denoise: Denoise) -> bool {
    match noise {
        SignalNoise::None => false,
        SignalNoise::Variance => method(denoise).follows_known_noise,
        SignalNoise::Unknown => true,
    }
}

/// Makes the denoiser that the settings name, and none for a signal without noise.
///
/// # Errors
/// Where the device does not support it.
///
/// # Panics
/// If it was not registered: settings that were parsed name only denoisers that are.
pub fn make(
    device: &Arc<Device>,
    description: &DenoiserDescription,
) -> Result<Box<dyn Denoiser>, VulkanError> {
    let has_noise = description.noise != SignalNoise::None;
    let method = if has_noise { method(description.settings.denoise) } else { &none::METHOD };
    (method.make)(device, description)
}

/// The passes of all denoisers for one use, in the order of the frame.
pub fn passes(usage: Use) -> impl Iterator<Item = &'static PassInfo> {
    METHODS.all().iter().flat_map(|method| method.passes).filter_map(move |pass| pass.info(usage))
}
