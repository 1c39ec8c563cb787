//! No indirect light: irradiance is 0.

use std::sync::Arc;

use super::{Estimator, EstimatorContext, IrradianceSignal, Method};
use crate::passes::frame_inputs::FrameInputs;
use crate::passes::storage_image;
use crate::settings::Indirect;
use crate::vulkan::{Device, Frame, Image, VulkanError, vk};

/// Its light is zero everywhere, so hits need no more.
pub const METHOD: Method = Method {
    rays: |_| 0,
    lights_hits: true,
    gives_light: false,
    ..Method::new(Indirect::NONE, "no indirect light", |context| Ok(Box::new(NoIndirect::new(context)?)))
};

/// The estimator.
pub struct NoIndirect {
    irradiance: Image,
    is_clear: bool,
    device: Arc<Device>,
}

impl NoIndirect {
    /// Makes the image.
    ///
    /// # Errors
    /// Where the device has no memory for it.
    pub fn new(context: &EstimatorContext<'_>) -> Result<Self, VulkanError> {
        let device = Arc::clone(context.device);
        let irradiance = black(&device, context.settings.size)?;
        Ok(Self { irradiance, is_clear: false, device })
    }
}

impl Estimator for NoIndirect {
    fn record(&mut self, frame: &mut Frame<'_>, _: &FrameInputs<'_>) -> Result<(), VulkanError> {
        if !std::mem::replace(&mut self.is_clear, true) {
            frame.clear_image(&self.irradiance, [0.0; 4]);
        }
        Ok(())
    }

    fn signal(&self) -> IrradianceSignal<'_> {
        IrradianceSignal { noisy: &self.irradiance, variance: None }
    }

    fn change(&mut self, context: &EstimatorContext<'_>) -> Result<(), VulkanError> {
        if context.settings.size != self.irradiance.extent() {
            self.irradiance = black(&self.device, context.settings.size)?;
            self.is_clear = false;
        }
        Ok(())
    }
}

fn black(device: &Arc<Device>, extent: [u32; 2]) -> Result<Image, VulkanError> {
    storage_image(device, "irradiance", vk::Format::R16G16B16A16_SFLOAT, extent)
}
