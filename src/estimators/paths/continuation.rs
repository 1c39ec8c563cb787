//! `paths_continue`: each frame goes on with paths of earlier frames, by two more rays a pixel (Meijer 2019, A-nHPSF).
//!
//! In: the vertices of this frame's paths. Out: in two layers behind them the vertex that is lit, and the one that the next frame goes on
//! from.

use glam::Affine3A;

use super::{PathPush, shared_constants};
use crate::estimators::EstimatorContext;
use crate::filters::{self, PathVertices};
use crate::passes::frame_inputs::FrameInputs;
use crate::vulkan::{Buffer, ComputePipeline, Frame, VulkanError, shaders};

pub struct Continuation {
    pipeline: ComputePipeline,
    /// Where objects stood in the last frame, if there was one.
    instances: Option<Vec<Affine3A>>,
}

impl Continuation {
    /// Makes the pipeline, if the filter of the settings asks for it.
    pub fn new(context: &EstimatorContext<'_>) -> Result<Option<Self>, VulkanError> {
        let EstimatorContext { device, tracer, settings, .. } = *context;
        if !settings.paths.filter.continues() {
            return Ok(None);
        }
        let [white_noise, _] = shared_constants(settings);
        let constants = [
            white_noise,
            // One vertex is lit.
            0,
            settings.paths.samples,
            filters::vertices(settings),
            settings.cells.depth,
        ];
        let pipeline = tracer.pipeline(device, "paths_continue", shaders::PATHS_CONTINUE_COMP, &constants)?;
        Ok(Some(Self { pipeline, instances: None }))
    }

    pub fn record(
        &mut self,
        frame: &mut Frame<'_>,
        inputs: &FrameInputs<'_>,
        vertices: &PathVertices,
        ray_counters: &Buffer,
    ) -> Result<(), VulkanError> {
        let extent = vertices.depths.extent();
        // Vertices of an object that has moved lie where it was.
        let keeps = self.instances.as_ref() == Some(&inputs.pose.instances);
        if !keeps {
            self.instances = Some(inputs.pose.instances.clone());
        }
        inputs
            .bind(frame.pass("paths_continue", &self.pipeline))
            .write("path_places", &vertices.places)
            .write("path_lights", &vertices.lights)
            .write("path_depths", &vertices.depths)
            .write("ray_counters", ray_counters)
            .push(&PathPush { keeps: u32::from(keeps), ..PathPush::new(inputs, extent) })
            .dispatch_over(extent)
    }
}
