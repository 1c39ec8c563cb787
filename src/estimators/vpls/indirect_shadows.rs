//! `indirect_shadows`: one occlusion ray for each pixel and VPL of its class (interleaved sampling), and the irradiance
//! from those VPLs that it sees.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};

use super::vpl_buffer::UploadedSet;
use crate::estimators::EstimatorInputs;
use crate::passes::storage_image;
use crate::passes::tracer::RayTracer;
use crate::vulkan::{ComputePipeline, Device, Frame, Image, VulkanError, shaders, vk};

/// VPLs of each class that one dispatch does at most: watchdogs of GPUs end long ones.
const MOST_VPLS: u32 = 32;
/// Threads of a workgroup, in each direction.
const GROUP: u32 = 8;

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Push {
    first: u32,
    count: u32,
}

/// The pass.
pub struct IndirectShadowsPass {
    pipeline: Arc<ComputePipeline>,
    interleave: u32,
    /// Scaled irradiance of each pixel from the VPLs of its class.
    irradiance: Image,
}

impl IndirectShadowsPass {
    /// Makes the pipeline for a tracer, and the image of `extent` texels.
    pub fn new(
        device: &Arc<Device>,
        tracer: RayTracer,
        extent: [u32; 2],
        interleave: u32,
    ) -> Result<Self, VulkanError> {
        let spirv = tracer.of(shaders::INDIRECT_SHADOWS_COMP);
        let pipeline = ComputePipeline::specialised(device, "indirect_shadows", spirv, &[interleave])?;
        Ok(Self { pipeline: Arc::new(pipeline), interleave, irradiance: irradiance(device, extent)? })
    }

    /// The same pass for pictures of `extent` texels.
    pub fn resized(&self, device: &Arc<Device>, extent: [u32; 2]) -> Result<Self, VulkanError> {
        Ok(Self { pipeline: Arc::clone(&self.pipeline), irradiance: irradiance(device, extent)?, ..*self })
    }

    /// What the last frame wrote.
    pub fn output(&self) -> &Image {
        &self.irradiance
    }

    /// Casts the rays of the set, and counts them.
    pub fn record(
        &self,
        frame: &mut Frame<'_>,
        inputs: &EstimatorInputs<'_>,
        set: &UploadedSet,
    ) -> Result<&Image, VulkanError> {
        let n = self.interleave;
        let [columns, rows] = self.irradiance.extent().map(|side| side.div_ceil(GROUP * n));
        // At least one dispatch, so that an empty set gives black.
        for first in (0..set.largest_class.max(1)).step_by(MOST_VPLS as usize) {
            let pass = frame
                .pass("indirect_shadows", &self.pipeline)
                .read("frame_uniforms", inputs.frame)
                .read("gbuffer_depth", &inputs.gbuffer.depth)
                .read("gbuffer_normal", &inputs.gbuffer.normal)
                .write("class_irradiance", &self.irradiance)
                .write("ray_counters", &*set.ray_counters)
                .push(&Push { first, count: MOST_VPLS });
            let pass = set.bind_classes(inputs.tracer.bind(pass));
            pass.dispatch_threads([columns * n * n * GROUP, rows * GROUP, 1])?;
        }
        Ok(&self.irradiance)
    }
}

fn irradiance(device: &Arc<Device>, extent: [u32; 2]) -> Result<Image, VulkanError> {
    // 32 bits: many dispatches may add to it.
    storage_image(device, "class_irradiance", vk::Format::R32G32B32A32_SFLOAT, extent)
}
