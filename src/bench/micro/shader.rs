//! The shaders' tracer on a list of rays: device time of one dispatch, without what brings the rays there.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};

use super::super::BenchError;
use super::contender::{Cast, Contender, Query};
use super::rays::{RayKind, RaySet};
use crate::bvh::TwoLevelBvh;
use crate::passes::tracer::{RayTracer, Tracer};
use crate::renderer::RenderError;
use crate::vulkan::{Buffer, ComputePipeline, Device, Frames, VulkanError, shaders};

/// Twin of `CastRay` in shaders/cast_rays.comp.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct DeviceRay {
    origin: [f32; 3],
    t_min: f32,
    direction: [f32; 3],
    t_max: f32,
}

/// A tracer of the device.
pub struct ShaderTracer {
    name: String,
    occluded: ComputePipeline,
    closest: ComputePipeline,
    tracer: Tracer,
    /// The rays that were cast last, on the device.
    uploaded: Option<(RayKind, Buffer, Buffer)>,
    // Dropped last: it waits for its frames, which use the others.
    frames: Frames,
    device: Arc<Device>,
}

impl ShaderTracer {
    /// Each tracer that the device can do with, over `bvh`.
    ///
    /// # Errors
    /// Where the device fails.
    pub fn all(device: &Arc<Device>, bvh: &TwoLevelBvh) -> Result<Vec<Self>, BenchError> {
        let tracer = |&kind: &RayTracer| Self::new(device, kind, bvh).map_err(failed);
        RayTracer::offered(device).iter().map(tracer).collect()
    }

    fn new(device: &Arc<Device>, kind: RayTracer, bvh: &TwoLevelBvh) -> Result<Self, VulkanError> {
        let name = match kind {
            RayTracer::Software => "glowworm, shader",
            RayTracer::Hardware => "ray queries",
        };
        let shader = kind.of(shaders::CAST_RAYS_COMP);
        let mut tracer = Tracer::new(device, kind, bvh)?;
        let mut frames = Frames::new(device)?;
        let (mut frame, _) = frames.begin()?;
        tracer.update(&mut frame, bvh)?;
        frame.submit()?;
        frames.finish()?;
        let pipeline = |any_hit| ComputePipeline::specialised(device, "cast_rays", shader, &[any_hit]);
        Ok(Self {
            name: name.to_owned(),
            occluded: pipeline(1)?,
            closest: pipeline(0)?,
            tracer,
            uploaded: None,
            frames,
            device: Arc::clone(device),
        })
    }

    fn dispatch(&mut self, set: &RaySet, query: Query) -> Result<Cast, VulkanError> {
        let (_, rays, answers) = match self.uploaded.take() {
            Some(uploaded) if uploaded.0 == set.kind && uploaded.2.size() == 4 * set.rays.len() as u64 => {
                self.uploaded.insert(uploaded)
            }
            _ => self.uploaded.insert(upload(&self.device, set)?),
        };
        let pipeline = if query == Query::Occluded { &self.occluded } else { &self.closest };
        let (mut frame, _) = self.frames.begin()?;
        let pass = frame.pass("cast_rays", pipeline).read("rays", &*rays).write("answers", &*answers);
        self.tracer.bind(pass).dispatch_threads([set.rays.len() as u32, 1, 1])?;
        frame.submit()?;
        let times = self.frames.finish()?;
        let milliseconds: f64 = times.iter().flat_map(|times| &times.passes).map(|(_, ms)| ms).sum();
        let answers = bytemuck::pod_collect_to_vec(&answers.read(&self.device)?);
        Ok(Cast { seconds: milliseconds * 1e-3, answers })
    }
}

/// A set's rays on the device, and room for the answers.
fn upload(device: &Arc<Device>, set: &RaySet) -> Result<(RayKind, Buffer, Buffer), VulkanError> {
    let rays: Vec<DeviceRay> = set
        .rays
        .iter()
        .map(|ray| DeviceRay {
            origin: ray.origin.to_array(),
            t_min: ray.t_min,
            direction: ray.direction.to_array(),
            t_max: ray.t_max,
        })
        .collect();
    let answers = Buffer::new(device, "answers", 4 * rays.len() as u64)?;
    Ok((set.kind, Buffer::with_data(device, "rays", &rays)?, answers))
}

impl Contender for ShaderTracer {
    fn name(&self) -> &str {
        &self.name
    }

    fn cast(&mut self, set: &RaySet, query: Query) -> Result<Cast, BenchError> {
        if set.rays.is_empty() {
            return Ok(Cast::default());
        }
        self.dispatch(set, query).map_err(failed)
    }
}

impl Drop for ShaderTracer {
    fn drop(&mut self) {
        // What the passes own may still be in use by a frame on its way.
        let _ = self.device.wait_idle();
    }
}

pub(super) fn failed(error: VulkanError) -> BenchError {
    RenderError::from(error).into()
}
