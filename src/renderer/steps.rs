//! Steps of a frame that join several passes.

use super::{RenderError, Renderer};
use crate::denoise::{Denoiser, DenoiserInputs};
use crate::effects::reflections::Reflections;
use crate::estimators::{Estimator, Hits, Method};
use crate::passes::combine::{CombineInputs, CombinePass};
use crate::passes::frame_inputs::FrameInputs;
use crate::passes::still::{SampledIrradiance, StillInputs, StillPass};
use crate::passes::taa::TaaPass;
use crate::passes::thin_surfaces::ThinSurfacesPass;
use crate::vulkan::{Frame, Image};

/// Direct radiance, reflection and irradiance as the rays of one frame have them.
type Sampled<'a> = (&'a Image, Option<&'a Image>, SampledIrradiance<'a>);

/// Estimates indirect light, denoises it, and brings it to the picture's size.
pub(super) fn record_indirect(
    frame: &mut Frame<'_>,
    estimator: &mut dyn Estimator,
    denoiser: &mut dyn Denoiser,
    inputs: &FrameInputs<'_>,
) -> Result<(), RenderError> {
    estimator.record(frame, inputs)?;
    let signal = estimator.signal();
    denoiser.record(frame, &DenoiserInputs::of(inputs, signal.noisy, signal.variance))?;
    let noisy = estimator.signal().noisy;
    let denoised = denoiser.output(noisy);
    Ok(estimator.resolve(frame, inputs, denoised)?)
}

/// Irradiance of the visible surfaces in the last frame.
pub(super) fn irradiance<'a>(estimator: &'a dyn Estimator, denoiser: &'a dyn Denoiser) -> &'a Image {
    estimator.resolved().unwrap_or_else(|| denoiser.output(estimator.signal().noisy))
}

/// Traces reflection rays, has the estimator light what they hit off the screen, and denoises. Irradiance on the screen is of the past,
/// so in a still frame an estimator that can lights all hits.
pub(super) fn record_reflections(
    frame: &mut Frame<'_>,
    (reflections, thin_surfaces): (&mut Reflections, Option<&ThinSurfacesPass>),
    (estimator, method): (&mut dyn Estimator, &Method),
    denoiser: &dyn Denoiser,
    inputs: &FrameInputs<'_>,
) -> Result<(), RenderError> {
    let sees_screen = inputs.clock.averaged().is_none() || !method.lights_hits;
    let irradiance = (irradiance(estimator, denoiser), sees_screen);
    reflections.trace(frame, inputs, irradiance, thin_surfaces.map(ThinSurfacesPass::output))?;
    let [place, weight] = reflections.hits();
    estimator.light_hits(frame, inputs, &Hits { place, weight, reflection: reflections.noisy() })?;
    Ok(reflections.denoise(frame, inputs)?)
}

/// Joins all light, smooths edges, fades to the mean of still frames, and tone maps.
pub(super) fn post_process<'a>(
    frame: &mut Frame<'_>,
    (combine, mut taa, still): (&'a CombinePass, Option<&mut TaaPass>, Option<&mut StillPass>),
    (joined, (direct, reflection, irradiance)): (&CombineInputs<'_>, Sampled<'_>),
    inputs: &FrameInputs<'_>,
    exposure: Option<f32>,
) -> Result<&'a Image, RenderError> {
    combine.record(frame, joined)?;
    if let Some(taa) = taa.as_deref_mut() {
        taa.record(frame, inputs, combine.radiance())?;
    }
    let antialiased = taa.map(|taa| taa.output());
    let mut picture = antialiased.unwrap_or(combine.radiance());
    if let Some(still) = still.filter(|_| inputs.clock.still_frames() > 0) {
        let (raw, exposure) = (&CombineInputs { direct, reflection, ..*joined }, combine.exposure());
        still.record(
            frame,
            inputs,
            &StillInputs { raw, irradiance, antialiased, exposure },
            combine.radiance(),
        )?;
        picture = combine.radiance();
    }
    if inputs.clock.progress() >= 1.0 {
        // A frozen picture has the exposure that it asks for.
        combine.pace.set(1.0);
    }
    Ok(combine.tone_map(frame, inputs.uniforms, picture, exposure)?)
}

impl Renderer {
    /// Irradiance of the visible surfaces in the last frame, RGBA16F.
    pub(super) fn irradiance(&self) -> &Image {
        irradiance(&*self.estimator, &*self.indirect_denoiser)
    }
}
