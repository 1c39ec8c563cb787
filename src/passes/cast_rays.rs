//! `cast_rays`: a list of rays by themselves, to measure how fast a tracer is and to compare what it answers.

use std::sync::Arc;

use crate::bvh::{Ray, TwoLevelBvh};
use crate::gpu_scene::environment::EnvironmentTexture;
pub use crate::gpu_scene::structs::GpuRay;
use crate::gpu_scene::tracer::{RayTracer, Tracer};
use crate::vulkan::{Buffer, ComputePipeline, Device, Frames, VulkanError, shaders};

/// Threads in a row of the dispatch. Twin: `ROW` in shaders/passes/cast_rays.comp.
const ROW: u32 = 1 << 20;

/// A tracer and rays for it, outside of any renderer's frames.
pub struct RayCaster {
    // Dropped first: it waits for its frames, which use the others.
    frames: Frames,
    /// For the closest hit, and for any. Made when first used, since drivers take long to compile them.
    pipelines: [Option<ComputePipeline>; 2],
    tracer: Tracer,
    /// None: it completes the scene set.
    environment: EnvironmentTexture,
    rays: Option<UploadedRays>,
    device: Arc<Device>,
}

/// Rays on the device, and room for their answers.
struct UploadedRays {
    count: usize,
    rays: Buffer,
    answers: Buffer,
}

impl RayCaster {
    /// A tracer over `bvh` as it stands now, and no rays.
    ///
    /// # Errors
    /// Where the device fails.
    pub fn new(device: &Arc<Device>, tracer: RayTracer, bvh: &TwoLevelBvh) -> Result<Self, VulkanError> {
        let mut tracer = Tracer::new(device, tracer, bvh)?;
        let mut frames = Frames::new(device)?;
        let (mut frame, _) = frames.begin()?;
        tracer.update(&mut frame, bvh)?;
        frame.submit()?;
        frames.finish()?;
        let environment = EnvironmentTexture::new(device, None)?;
        Ok(Self {
            frames,
            pipelines: [None, None],
            tracer,
            environment,
            rays: None,
            device: Arc::clone(device),
        })
    }

    /// Uploads rays in place of those that are there.
    ///
    /// # Errors
    /// Where the device fails or cannot hold so many.
    pub fn upload(&mut self, rays: &[Ray]) -> Result<(), VulkanError> {
        let gpu_rays: Vec<GpuRay> = rays.iter().map(GpuRay::from).collect();
        self.rays = Some(UploadedRays {
            count: rays.len(),
            rays: Buffer::with_data(&self.device, "rays", &gpu_rays)?,
            answers: Buffer::new(&self.device, "answers", 4 * rays.len() as u64)?,
        });
        Ok(())
    }

    /// Asks whether rays meet anything: the first `count`, from the beginning again after the last. Waits, and gives the
    /// milliseconds that the device took.
    ///
    /// # Errors
    /// Where the device fails or does not support so many.
    pub fn cast_occluded(&mut self, count: u32) -> Result<f64, VulkanError> {
        self.cast(true, count)
    }

    /// Asks what rays meet first, else as [`Self::cast_occluded`].
    ///
    /// # Errors
    /// Where the device fails or does not support so many.
    pub fn cast_closest(&mut self, count: u32) -> Result<f64, VulkanError> {
        self.cast(false, count)
    }

    fn cast(&mut self, any_hit: bool, count: u32) -> Result<f64, VulkanError> {
        let Some(UploadedRays { rays, answers, count: 1.. }) = &self.rays else { return Ok(0.0) };
        let pipeline = match &mut self.pipelines[usize::from(any_hit)] {
            Some(pipeline) => pipeline,
            missing => {
                let (shader, constants) = (shaders::CAST_RAYS_COMP, [u32::from(any_hit)]);
                missing.insert(self.tracer.variant().pipeline(
                    &self.device,
                    "cast_rays",
                    shader,
                    &constants,
                )?)
            }
        };
        let (mut frame, _) = self.frames.begin()?;
        let mut resources = self.tracer.resources();
        resources.extend(self.environment.resources());
        let scene = frame.shared_set(resources)?;
        frame
            .pass("cast_rays", pipeline)
            .shared(&scene)
            .read("rays", rays)
            .write("answers", answers)
            .push(&count)
            .dispatch_threads([count.min(ROW), count.div_ceil(ROW), 1])?;
        frame.submit()?;
        let times = self.frames.finish()?;
        Ok(times.iter().flat_map(|times| &times.passes).map(|(_, ms)| ms).sum())
    }

    /// A number for each ray, as it was last cast: negative where it meets nothing, else t of the closest hit, or 0
    /// where any would do.
    ///
    /// # Errors
    /// Where the device fails.
    pub fn answers(&self) -> Result<Vec<f32>, VulkanError> {
        let Some(rays) = &self.rays else { return Ok(Vec::new()) };
        let mut answers: Vec<f32> = bytemuck::pod_collect_to_vec(&rays.answers.read(&self.device)?);
        // Buffers are never smaller than four numbers.
        answers.truncate(rays.count);
        Ok(answers)
    }
}
