//! Estimators compute indirect light; each method has a folder.
//!
//! In: the visible surfaces, the tracer and the world. Out: irradiance, W/m^2, without the albedo of the visible surface. An
//! estimator names its passes, its views and its counters; reports, the window and `--view` list what it names.

mod method;
pub mod none;
mod pass_list;
pub mod paths;
mod ray_counters;
pub mod vpls;

use std::any::Any;
use std::borrow::Cow;
use std::sync::Arc;

use indexmap::IndexMap;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

pub use crate::bvh::World;
use crate::gpu_scene::tracer::TracerVariant;
pub use crate::passes::hits::Hits;
pub use method::{Axis, CounterInfo, HalfResolution, Method, MethodPasses};
pub use pass_list::{is_part, passes, passes_with};

use crate::passes::buffer_view::{COMBINED, VIEWS, View};
use crate::passes::clock::FrameClock;
use crate::passes::effect_view;
use crate::passes::frame_inputs::FrameInputs;
use crate::passes::overlay::Line;
use crate::passes::still::SampledIrradiance;
use crate::report::Counters;
use crate::settings::{Registry, Settings};
use crate::vulkan::{Buffer, Device, Frame, Image, VulkanError};

/// An estimator is made with these.
#[derive(Clone)]
pub struct EstimatorContext<'a> {
    /// The device.
    pub device: &'a Arc<Device>,
    /// Its shaders are made for this variant.
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

/// A method of indirect light. One frame: [`Self::update`], then [`Self::record`].
pub trait Estimator: Any + Send {
    /// Frames after which it begins again, the first with frame 0; 1 where all frames are alike.
    fn cycle_length(&self) -> u32 {
        1
    }

    /// Whether the light that it samples next is that of a restart, were nothing to change.
    fn equals_restart(&self) -> bool {
        true
    }

    /// The work of a frame on the CPU, while the device draws the frame before. Samples of a still frame follow from the
    /// number of that alone. Gives the milliseconds of each CPU pass.
    fn update(&mut self, _world: World<'_>, _clock: &FrameClock) -> Vec<f64> {
        Vec::new()
    }

    /// The counts of [`Self::update`], by name; dots nest.
    fn counters(&self) -> Counters {
        Counters::default()
    }

    /// Records its passes, which write [`Self::signal`].
    ///
    /// # Errors
    /// Where the device fails.
    fn record(&mut self, frame: &mut Frame<'_>, inputs: &FrameInputs<'_>) -> Result<(), VulkanError>;

    /// The irradiance of the last frame before it is denoised.
    fn signal(&self) -> IrradianceSignal<'_>;

    /// The irradiance that the last frame has sampled, an unbiased estimate by itself, which no denoiser overwrites. In a still frame it
    /// depends on nothing before.
    fn sampled(&self) -> SampledIrradiance<'_> {
        SampledIrradiance { image: self.signal().noisy, scale: 1.0, checkerboard: None }
    }

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
    /// A method that does not says so by [`Method::lights_hits`].
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

    /// The counts of the device, which are read back and go to [`Self::add_device_counters`].
    fn device_counters(&self) -> Option<&Buffer> {
        None
    }

    /// Adds what the device counted in a finished frame.
    fn add_device_counters(&self, _counters: &mut Counters, _read_back: &[u8]) {}

    /// Goes on with other settings, another size or tracer. No frame is in flight.
    ///
    /// # Errors
    /// Where the device does not support them; it then goes on with the old ones.
    fn change(&mut self, context: &EstimatorContext<'_>) -> Result<(), VulkanError>;

    /// Goes on with a scene that [is built like](crate::scene::Scene::same_geometry_and_bindings) the last one, with other materials, lights or environment.
    /// No frame is in flight.
    fn change_scene(&mut self, _world: World<'_>) {}

    /// Shows `view` from the next frame on: makes what [`Self::shown_irradiance`], [`Self::draw_view`] and [`Self::lines`]
    /// need for it.
    ///
    /// # Errors
    /// Where the device fails.
    fn set_view(&mut self, _view: &DebugView) -> Result<(), VulkanError> {
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

    /// Draws one of the method's views over a black picture.
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

    /// Users should know these facts about its work on the scene, a sentence each.
    fn warnings(&self) -> Vec<String> {
        Vec::new()
    }
}

/// The view that a frame shows. The default is the picture, at no cost.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct DebugView {
    /// The name of one of [`views`], to be shown in place of the picture.
    pub buffer: Cow<'static, str>,
    /// Lines to draw over everything.
    pub lines: Vec<Line>,
    /// The options of the method's views by name; the method knows their type.
    #[serde(flatten)]
    pub options: Map<String, Value>,
}

impl DebugView {
    /// Whether the picture is shown, perhaps with lines over it.
    pub fn is_picture(&self) -> bool {
        self.buffer == COMBINED && self.options.is_empty()
    }

    /// The options of a method's views. Options that are not set have their defaults.
    pub fn options<Options: DeserializeOwned + Default>(&self) -> Options {
        serde_json::from_value(Value::Object(self.options.clone())).unwrap_or_default()
    }

    /// Replaces the options of the method's views.
    pub fn set_options<Options: Serialize>(&mut self, options: &Options) {
        self.options = match serde_json::to_value(options) {
            Ok(Value::Object(options)) => options,
            _ => Map::new(),
        };
    }

    /// The view with these options.
    #[must_use]
    pub fn with_options<Options: Serialize>(mut self, options: &Options) -> Self {
        self.set_options(options);
        self
    }

    /// Changes the options of a method's views.
    pub fn change_options<Options: Serialize + DeserializeOwned + Default>(
        &mut self,
        change: impl FnOnce(&mut Options),
    ) {
        let mut options = self.options();
        change(&mut options);
        self.set_options(&options);
    }
}

impl Default for DebugView {
    fn default() -> Self {
        Self { buffer: COMBINED.into(), lines: Vec::new(), options: Map::new() }
    }
}

/// A method's view reads and writes these.
pub struct ViewInputs<'a> {
    /// Inputs that the estimator's passes have read.
    pub frame: &'a FrameInputs<'a>,
    /// Factor of the picture's exposure.
    pub exposure: &'a Buffer,
    /// The shown picture, RGBA8.
    pub display: &'a Image,
}

/// One line a method. [`register`] adds those of other crates.
static METHODS: Registry<Method> = Registry::new(&[vpls::METHOD, paths::METHOD, vpls::TONNA, none::METHOD]);

/// All methods.
pub fn methods() -> &'static [Method] {
    METHODS.all()
}

/// Adds a method of another crate, such as a test's, before anything else uses the library.
pub fn register(method: Method) {
    method.indirect.add();
    METHODS.add(method);
}

/// The method that the settings name.
///
/// # Panics
/// If it was not registered: settings that were parsed name only methods that are.
pub fn method(settings: &Settings) -> &'static Method {
    let found = methods().iter().find(|method| method.indirect == settings.indirect);
    found.unwrap_or_else(|| panic!("--indirect {:?} is not registered", settings.indirect))
}

/// Makes the estimator that the settings name.
///
/// # Errors
/// Where the device does not support it.
pub fn make(context: &EstimatorContext<'_>) -> Result<Box<dyn Estimator>, VulkanError> {
    (method(context.settings).make)(context)
}

/// All counters of all methods, by name.
pub fn counters() -> impl Iterator<Item = &'static CounterInfo> {
    let all = methods().iter().flat_map(|method| method.counters);
    // Methods may share some.
    all.map(|counter| (counter.name, counter)).collect::<IndexMap<_, _>>().into_values()
}

/// All axes of all methods.
pub fn axes() -> impl Iterator<Item = &'static Axis> {
    let all = methods().iter().flat_map(|method| method.axes);
    all.map(|axis| (axis.setting, axis)).collect::<IndexMap<_, _>>().into_values()
}

/// The views of what all methods share, then those of methods and of effects.
pub fn views() -> impl Iterator<Item = &'static View> {
    VIEWS.iter().chain(methods().iter().flat_map(|method| method.views)).chain(&effect_view::VIEWS)
}
