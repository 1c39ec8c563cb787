//! `occlusion_rays`: given rays, over and over, to measure how fast a tracer is.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use glam::{Vec3, Vec4};

use super::tracer::Tracer;
use crate::bvh::{Ray, TwoLevelBvh};
use crate::vulkan::{Buffer, ComputePipeline, Device, Frames, VulkanError, shaders};

/// A segment between two surfaces; its ends do not count. 32 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct OcclusionRay {
    start: Vec4,
    end: Vec4,
}

impl OcclusionRay {
    /// From world-space point to world-space point.
    pub fn between(start: Vec3, end: Vec3) -> Self {
        Self { start: start.extend(0.0), end: end.extend(0.0) }
    }

    /// The same for the CPU.
    pub fn as_ray(&self) -> Ray {
        let [origin, end] = [self.start.truncate(), self.end.truncate()];
        Ray { origin, direction: end - origin, t_min: 0.001, t_max: 0.999 }
    }
}

/// A tracer with rays for it.
pub struct OcclusionRays {
    pipeline: ComputePipeline,
    tracer: Tracer,
    rays: Buffer,
    answers: Buffer,
    // Dropped last: it waits for its frames, which use the others.
    frames: Frames,
    device: Arc<Device>,
}

impl OcclusionRays {
    /// Uploads the rays.
    pub fn new(device: &Arc<Device>, tracer: Tracer, rays: &[OcclusionRay]) -> Result<Self, VulkanError> {
        let shader = tracer.kind().of(shaders::OCCLUSION_RAYS_COMP);
        Ok(Self {
            pipeline: ComputePipeline::new(device, "occlusion_rays", shader)?,
            tracer,
            rays: Buffer::with_data(device, "rays", rays)?,
            answers: Buffer::new(device, "answers", 4 * rays.len() as u64)?,
            frames: Frames::new(device)?,
            device: Arc::clone(device),
        })
    }

    /// Casts the first `count` rays, from the beginning again after the last. Waits, and gives the milliseconds that
    /// the device took.
    pub fn cast(&mut self, bvh: &TwoLevelBvh, count: u32) -> Result<f64, VulkanError> {
        let (mut frame, _) = self.frames.begin()?;
        self.tracer.update(&mut frame, bvh)?;
        let pass = frame
            .pass("occlusion_rays", &self.pipeline)
            .read("rays", &self.rays)
            .write("answers", &self.answers)
            .push(&count);
        self.tracer.bind(pass).dispatch_threads([count, 1, 1])?;
        frame.submit()?;
        let times = self.frames.finish()?;
        let passes = times.iter().flat_map(|times| &times.passes);
        Ok(passes.filter(|(name, _)| *name == "occlusion_rays").map(|(_, ms)| ms).sum())
    }

    /// Whether each ray was occluded when it was last cast.
    pub fn answers(&self) -> Result<Vec<bool>, VulkanError> {
        let words: Vec<u32> = bytemuck::pod_collect_to_vec(&self.answers.read(&self.device)?);
        Ok(words.into_iter().map(|word| word == 1).collect())
    }
}
