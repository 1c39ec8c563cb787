//! Adds a method of indirect light, the same irradiance everywhere, and renders with it: `cargo run --release --example estimator`.

use std::error::Error;
use std::path::Path;
use std::sync::Arc;

use glowworm::estimators::{self, Estimator, EstimatorContext, IrradianceSignal, Method};
use glowworm::formats::load_scene;
use glowworm::output::PictureTarget;
use glowworm::passes::frame_inputs::FrameInputs;
use glowworm::renderer::Renderer;
use glowworm::settings::{Indirect, Settings};
use glowworm::vulkan::{Device, Frame, Image, ImageDescription, Instance, InstanceOptions, VulkanError, vk};

/// The description of the method, by which command line, reports and window know it: `--indirect ambient`.
const AMBIENT: Method =
    Method::new(Indirect::new("ambient", "The same irradiance everywhere"), "ambient light", |context| {
        Ok(Box::new(Ambient::new(context)?))
    });

/// Irradiance, W/m^2.
const IRRADIANCE: [f32; 4] = [0.5, 0.6, 0.8, 0.0];

struct Ambient {
    irradiance: Image,
}

impl Ambient {
    fn new(context: &EstimatorContext<'_>) -> Result<Self, VulkanError> {
        let irradiance = Image::new(
            context.device,
            &ImageDescription {
                name: "irradiance",
                format: vk::Format::R16G16B16A16_SFLOAT,
                extent: context.settings.size,
                layers: None,
                levels: 1,
                usage: vk::ImageUsageFlags::STORAGE,
            },
        )?;
        Ok(Self { irradiance })
    }
}

impl Estimator for Ambient {
    // A method that computes something records passes here, by the surfaces and the scene in `inputs`.
    fn record(&mut self, frame: &mut Frame<'_>, _inputs: &FrameInputs<'_>) -> Result<(), VulkanError> {
        frame.clear_image(&self.irradiance, IRRADIANCE);
        Ok(())
    }

    fn signal(&self) -> IrradianceSignal<'_> {
        IrradianceSignal { noisy: &self.irradiance, variance: None }
    }

    fn change(&mut self, context: &EstimatorContext<'_>) -> Result<(), VulkanError> {
        *self = Self::new(context)?;
        Ok(())
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    // Before anything else uses the library.
    estimators::register(AMBIENT);
    let instance = Instance::new(InstanceOptions::default())?;
    let device = Device::open(&instance, None)?;
    let scene = Arc::new(load_scene("cornell-box", None)?);
    let settings =
        Settings { indirect: AMBIENT.indirect, size: [320, 240], still_frames: 16, ..Settings::default() };
    let pose = scene.pose(0.0);
    let mut renderer = Renderer::new(&device, &scene, &settings, &pose)?;
    while !renderer.is_frozen() {
        renderer.render(&pose)?;
    }
    let path =
        PictureTarget::new(Path::new("ambient.png"), false)?.write(&renderer.read_picture(false)?, 0)?;
    println!("{}", path.display());
    Ok(())
}
