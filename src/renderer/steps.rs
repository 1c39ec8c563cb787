//! Steps of a frame that join several passes.

use super::RenderError;
use super::rest::FrameClock;
use crate::effects::EffectInputs;
use crate::effects::reflections::{ReflectionInputs, Reflections};
use crate::estimators::{Estimator, EstimatorInputs, Hits};
use crate::passes::area_lights::UploadedAreaLights;
use crate::passes::combine::{CombineInputs, CombinePass};
use crate::passes::gbuffer::GBuffer;
use crate::passes::reprojection::{ReprojectionInputs, ReprojectionPass};
use crate::passes::scene_buffers::SceneBuffers;
use crate::passes::taa::{TaaInputs, TaaPass};
use crate::vulkan::{Frame, Image};

/// Looks where the surfaces were in the last frame, for the effects. None where no effect is in use, or nothing random is drawn
/// any more.
pub(super) fn begin_effects<'a>(
    frame: &mut Frame<'_>,
    reprojection: Option<&'a mut ReprojectionPass>,
    inputs: &EstimatorInputs<'a>,
    (scene, area_lights): (&'a SceneBuffers, &'a UploadedAreaLights),
    clock: &FrameClock,
) -> Result<Option<EffectInputs<'a>>, RenderError> {
    let Some(pass) = reprojection.filter(|_| !clock.is_frozen()) else { return Ok(None) };
    let &EstimatorInputs { frame: uniforms, gbuffer, instances, tracer, lights, .. } = inputs;
    pass.record(frame, &ReprojectionInputs::of(uniforms, gbuffer, &instances.data))?;
    let (reprojection, rest) = (&*pass, clock.rest());
    Ok(Some(EffectInputs {
        frame: uniforms,
        gbuffer,
        reprojection,
        tracer,
        lights,
        area_lights,
        scene,
        rest,
    }))
}

/// Traces what surfaces mirror, has the estimator light what is hit off the screen, and denoises.
pub(super) fn mirror(
    frame: &mut Frame<'_>,
    reflections: &mut Reflections,
    estimator: &mut dyn Estimator,
    inputs: &EstimatorInputs<'_>,
    effects: &EffectInputs<'_>,
) -> Result<(), RenderError> {
    let EstimatorInputs { instances, pose, .. } = *inputs;
    let irradiance = estimator.irradiance();
    reflections.trace(frame, effects, &ReflectionInputs { instances, irradiance, pose })?;
    let [place, weight] = reflections.hits();
    estimator.light_hits(frame, inputs, &Hits { place, weight, reflection: reflections.noisy() })?;
    Ok(reflections.denoise(frame, effects)?)
}

/// Joins all light, smooths edges, and shows the picture.
pub(super) fn show<'a>(
    frame: &mut Frame<'_>,
    (combine, mut taa): (&'a CombinePass, Option<&mut TaaPass>),
    inputs: &CombineInputs<'_>,
    gbuffer: &GBuffer,
    (clock, exposure): (&FrameClock, Option<f32>),
) -> Result<&'a Image, RenderError> {
    combine.record(frame, inputs)?;
    if let Some(taa) = taa.as_deref_mut().filter(|_| !clock.is_frozen()) {
        let taa_inputs = TaaInputs {
            frame: inputs.frame,
            radiance: combine.radiance(),
            depth: &gbuffer.depth,
            motion: &gbuffer.motion,
            averaged: clock.averaged(),
        };
        taa.record(frame, &taa_inputs)?;
    }
    let picture = taa.map_or(combine.radiance(), |taa| taa.output());
    Ok(combine.show(frame, inputs.frame, picture, exposure)?)
}
