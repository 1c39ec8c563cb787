//! What computes indirect light: one folder a method.
//!
//! In: the visible surfaces, the tracer and the world. Out: irradiance, W/m^2, without the albedo of the visible surface. An
//! estimator names its passes, its views and its counters; reports, the window and `--view` list what it names.

pub mod none;
pub mod vpls;

use std::any::Any;
use std::borrow::Cow;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

pub use crate::bvh::World;
pub use crate::denoise::SignalNoise;
use crate::gpu_scene::tracer::TracerVariant;
use crate::passes::buffer_view::{COMBINED, VIEWS, View};
use crate::passes::effect_view;
use crate::passes::frame_inputs::FrameInputs;
use crate::passes::overlay::Line;
use crate::report::{CPU_PASSES, Counters, LAST_PASSES, PassInfo, SHARED_PASSES};
use crate::settings::{Indirect, Settings};
use crate::vulkan::{Buffer, Device, Frame, Image, VulkanError};

/// What an estimator is made with.
#[derive(Clone)]
pub struct EstimatorContext<'a> {
    /// The device.
    pub device: &'a Arc<Device>,
    /// What its shaders are made for.
    pub tracer: TracerVariant,
    /// The settings, which were checked.
    pub settings: &'a Settings,
    /// The world as it stands now.
    pub world: World<'a>,
    /// Radius of the scene's bounding sphere, world units.
    pub scene_radius: f32,
}

/// Irradiance as the passes of an estimator have written it, to be denoised.
pub struct IrradianceSignal<'a> {
    /// W/m^2, without the albedo of the visible surface, RGBA16F.
    pub noisy: &'a Image,
    /// Variance of its luminance, R32F, if it is known.
    pub variance: Option<&'a Image>,
}

/// Surfaces that reflection rays have hit and that are not on the screen: shaders/include/hit_record.glsl.
pub struct Hits<'a> {
    /// Where they are: RGBA32UI.
    pub place: &'a Image,
    /// Weight of their irradiance in the reflection, and a random number from 0 to 1: RGBA16F.
    pub weight: &'a Image,
    /// The reflection, RGBA16F, to which their light is added.
    pub reflection: &'a Image,
}

/// The passes of a method, in the order of the frame.
#[derive(Clone, Copy, Debug)]
pub struct MethodPasses {
    /// On the CPU, while the device draws the frame before.
    pub cpu: &'static [PassInfo],
    /// On the device.
    pub device: &'static [PassInfo],
}

/// A method of indirect light. One frame: [`Self::update`], then [`Self::record`].
pub trait Estimator: Any + Send {
    /// What it names.
    fn method(&self) -> Method;

    /// Frames in which it draws everything once, by turns that begin with frame 0; 1 where there are no turns.
    fn cycle(&self) -> u32 {
        1
    }

    /// Frames after the last change until its light is what it would be after a fresh start.
    fn settles_in(&self) -> u32 {
        0
    }

    /// The work of a frame with this number on the CPU, while the device draws the frame before. Gives the milliseconds of each
    /// CPU pass.
    fn update(&mut self, _world: World<'_>, _frame: u64) -> Vec<f64> {
        Vec::new()
    }

    /// What it counted in [`Self::update`], by name; dots nest.
    fn counters(&self) -> Counters {
        Counters::default()
    }

    /// Records its passes, which write [`Self::signal`].
    ///
    /// # Errors
    /// Where the device fails.
    fn record(&mut self, frame: &mut Frame<'_>, inputs: &FrameInputs<'_>) -> Result<(), VulkanError>;

    /// What is known of the noise of its signal, whatever the frame.
    fn noise(&self) -> SignalNoise {
        SignalNoise::None
    }

    /// The irradiance of the last frame before it is denoised.
    fn signal(&self) -> IrradianceSignal<'_>;

    /// Records what makes irradiance of the denoised signal, for signals that are not of the picture's size.
    ///
    /// # Errors
    /// Where the device fails.
    fn resolve(
        &self,
        _frame: &mut Frame<'_>,
        _inputs: &FrameInputs<'_>,
        _denoised: &Image,
    ) -> Result<(), VulkanError> {
        Ok(())
    }

    /// Irradiance of the last frame, RGBA16F, of the picture's size; none: it is the denoised signal.
    fn resolved(&self) -> Option<&Image> {
        None
    }

    /// Lights surfaces that are not on the screen: adds weight times irradiance, an unbiased estimate, to the reflection.
    ///
    /// # Errors
    /// Where the device fails.
    fn light_hits(
        &mut self,
        _frame: &mut Frame<'_>,
        _inputs: &FrameInputs<'_>,
        _hits: &Hits<'_>,
    ) -> Result<(), VulkanError> {
        Ok(())
    }

    /// What the device counted in the frame, to be read back; it goes to [`Self::add_device_counters`].
    fn device_counters(&self) -> Option<&Buffer> {
        None
    }

    /// Adds what the device counted in a finished frame.
    fn add_device_counters(&self, _counters: &mut Counters, _read_back: &[u8]) {}

    /// Goes on with other settings, another size or tracer. No frame is on its way.
    ///
    /// # Errors
    /// Where the device cannot do with them; it then goes on with the old ones.
    fn change(&mut self, context: &EstimatorContext<'_>) -> Result<(), VulkanError>;

    /// Goes on with a scene that [is built like](crate::scene::Scene::same_geometry_and_bindings) the last one, with other materials, lights or environment.
    /// No frame is on its way.
    fn change_scene(&mut self, _world: World<'_>) {}

    /// Looks at `view` from the next frame on: makes what [`Self::shown_irradiance`], [`Self::draw_view`] and [`Self::lines`]
    /// need for it.
    ///
    /// # Errors
    /// Where the device fails.
    fn look_at(&mut self, _view: &DebugView) -> Result<(), VulkanError> {
        Ok(())
    }

    /// Irradiance to look at in place of the picture, if there is any. It may record passes.
    ///
    /// # Errors
    /// Where the device fails.
    fn shown_irradiance(
        &self,
        _frame: &mut Frame<'_>,
        _inputs: &FrameInputs<'_>,
    ) -> Result<Option<&Image>, VulkanError> {
        Ok(None)
    }

    /// Draws one of the method's views over the picture.
    ///
    /// # Errors
    /// Where the device fails.
    fn draw_view(
        &self,
        _frame: &mut Frame<'_>,
        _inputs: &ViewInputs<'_>,
        _view: &str,
    ) -> Result<(), VulkanError> {
        Ok(())
    }

    /// Lines to draw over the picture.
    fn lines(&self) -> Vec<Line> {
        Vec::new()
    }
}

/// What to show. The default is the picture, at no cost.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct DebugView {
    /// The name of one of [`views`], to be shown in place of the picture.
    pub buffer: Cow<'static, str>,
    /// Lines to draw over everything.
    pub lines: Vec<Line>,
    /// What to look at of `--indirect vpls`.
    #[serde(flatten)]
    pub vpl: vpls::VplLook,
}

impl Default for DebugView {
    fn default() -> Self {
        Self { buffer: COMBINED.into(), lines: Vec::new(), vpl: vpls::VplLook::default() }
    }
}

/// What a method's view reads and writes.
pub struct ViewInputs<'a> {
    /// What its passes have read.
    pub frame: &'a FrameInputs<'a>,
    /// Factor of the picture's exposure.
    pub exposure: &'a Buffer,
    /// What is shown, RGBA8.
    pub display: &'a Image,
}

/// Makes the estimator that the settings name.
///
/// # Errors
/// Where the device cannot do with it.
pub fn make(context: &EstimatorContext<'_>) -> Result<Box<dyn Estimator>, VulkanError> {
    Ok(match context.settings.indirect {
        Indirect::Vpls => Box::new(vpls::Vpls::new(context)?),
        Indirect::None => Box::new(none::NoIndirect::new(context)?),
    })
}

/// What a method names.
#[derive(Clone, Copy, Debug)]
pub struct Method {
    /// As in `--indirect`.
    pub name: &'static str,
    /// Its passes.
    pub passes: MethodPasses,
    /// Its views.
    pub views: &'static [View],
    /// Its counters.
    pub counters: &'static [&'static str],
}

/// All methods.
pub const METHODS: [Method; 2] = [vpls::METHOD, none::METHOD];

/// All passes in the order of the frame, each with the name of its method, or `shared` by all.
pub fn passes() -> impl Iterator<Item = (&'static str, &'static PassInfo)> {
    let shared = |passes: &'static [PassInfo]| passes.iter().map(|pass| ("shared", pass));
    let cpu = METHODS.iter().flat_map(|method| method.passes.cpu.iter().map(|pass| (method.name, pass)));
    let device =
        METHODS.iter().flat_map(|method| method.passes.device.iter().map(|pass| (method.name, pass)));
    shared(&CPU_PASSES).chain(cpu).chain(shared(&SHARED_PASSES)).chain(device).chain(shared(&LAST_PASSES))
}

/// The views of what all methods share, then those of methods and of effects.
pub fn views() -> impl Iterator<Item = &'static View> {
    VIEWS.iter().chain(METHODS.iter().flat_map(|method| method.views)).chain(&effect_view::VIEWS)
}
