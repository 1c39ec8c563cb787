//! The spatial half of SVGF as a denoiser: for a signal that is a mean already, whose variance is known.

use std::sync::Arc;

use super::{Denoiser, DenoiserInputs, DenoiserPass, Use};
use crate::denoiser_pass;
use crate::passes::spatial_filter::{FilteredSignal, SpatialFilter, TOLERANCE};
use crate::vulkan::{Device, Frame, Image, VulkanError};

/// Only estimators know the variance of their signal.
pub(super) const PASS: DenoiserPass =
    denoiser_pass!("spatial_filter", [[158, 120, 180]; 3]).only_for(Use::Indirect);

/// The denoiser of one signal.
pub(super) struct Spatial(SpatialFilter);

impl Spatial {
    /// Makes the filter of a signal of `extent` texels.
    pub(super) fn new(device: &Arc<Device>, usage: Use, extent: [u32; 2]) -> Result<Self, VulkanError> {
        Ok(Self(SpatialFilter::new(device, PASS.name(usage), extent)?))
    }
}

impl Denoiser for Spatial {
    fn output<'a>(&'a self, _: &'a Image) -> &'a Image {
        self.0.output()
    }

    fn record(&mut self, frame: &mut Frame<'_>, inputs: &DenoiserInputs<'_>) -> Result<(), VulkanError> {
        // A frame without noise.
        let Some(variance) = inputs.variance else { return Ok(()) };
        self.0.record(
            frame,
            &FilteredSignal {
                uniforms: inputs.uniforms,
                depth: inputs.depth,
                normal: inputs.normal,
                noisy: inputs.noisy,
                variance,
                levels: 3,
                first_tolerance: TOLERANCE,
            },
        )
    }
}
