//! `hit_light`: lights what reflection rays have hit, by one VPL of the frame's set a hit.

use std::sync::Arc;

use super::indirect_shadows::SamplingPush;
use super::vpl_buffer::UploadedSet;
use crate::estimators::Hits;
use crate::gpu_scene::tracer::TracerVariant;
use crate::passes::frame_inputs::FrameInputs;
use crate::vulkan::{ComputePipeline, Device, Frame, VulkanError, shaders};

/// The pass.
pub struct HitLightPass {
    pipeline: ComputePipeline,
}

impl HitLightPass {
    /// Makes the pipeline for a tracer.
    pub fn new(device: &Arc<Device>, tracer: TracerVariant) -> Result<Self, VulkanError> {
        Ok(Self { pipeline: tracer.pipeline(device, "hit_light", shaders::HIT_LIGHT_COMP, &[])? })
    }

    /// Adds the light of the set, which holds this share of all light.
    pub fn record(
        &self,
        frame: &mut Frame<'_>,
        inputs: &FrameInputs<'_>,
        hits: &Hits<'_>,
        set: &UploadedSet,
        set_share: f32,
    ) -> Result<(), VulkanError> {
        let pass = inputs
            .bind(frame.pass("hit_light", &self.pipeline))
            .read("vpl_clusters", &*set.clusters)
            .read("hit_place", hits.place)
            .read("hit_weight", hits.weight)
            .write("reflection", hits.reflection)
            .write("ray_counters", set.ray_counters.buffer())
            .push(&SamplingPush::of_share(set_share));
        set.bind(pass).dispatch_over(hits.reflection.extent())
    }
}
