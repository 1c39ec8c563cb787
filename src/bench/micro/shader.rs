//! The shaders' tracers on a list of rays: device time of one dispatch, without the upload of the rays.

use std::sync::Arc;

use super::super::BenchError;
use super::contender::{Cast, Contender, Query};
use super::rays::{RayKind, RaySet};
use crate::bvh::TwoLevelBvh;
use crate::gpu_scene::tracer::RayTracer;
use crate::passes::cast_rays::RayCaster;
use crate::renderer::RenderError;
use crate::vulkan::{Device, VulkanError};

/// A tracer of the device.
pub struct ShaderTracer {
    name: &'static str,
    caster: RayCaster,
    /// Kind and number of the uploaded rays.
    uploaded: Option<(RayKind, usize)>,
}

impl ShaderTracer {
    /// Each tracer that the device supports, over `bvh`.
    ///
    /// # Errors
    /// If the device fails.
    pub fn all(device: &Arc<Device>, bvh: &TwoLevelBvh) -> Result<Vec<Self>, BenchError> {
        let tracer = |&kind: &RayTracer| {
            let name = match kind {
                RayTracer::Software => "glowworm, shader",
                RayTracer::Hardware => "ray queries",
            };
            let caster = RayCaster::new(device, kind, bvh).map_err(failed)?;
            Ok(Self { name, caster, uploaded: None })
        };
        RayTracer::offered(device).iter().map(tracer).collect()
    }

    fn cast(&mut self, set: &RaySet, query: Query) -> Result<Cast, VulkanError> {
        let wanted = Some((set.kind, set.rays.len()));
        if self.uploaded != wanted {
            self.uploaded = None;
            self.caster.upload(&set.rays)?;
            self.uploaded = wanted;
        }
        let count = set.rays.len() as u32;
        let milliseconds = match query {
            Query::Occluded => self.caster.cast_occluded(count)?,
            Query::Closest => self.caster.cast_closest(count)?,
        };
        Ok(Cast { seconds: milliseconds * 1e-3, answers: self.caster.answers()? })
    }
}

impl Contender for ShaderTracer {
    fn name(&self) -> &str {
        self.name
    }

    fn cast(&mut self, set: &RaySet, query: Query) -> Result<Cast, BenchError> {
        self.cast(set, query).map_err(failed)
    }
}

pub(super) fn failed(error: VulkanError) -> BenchError {
    RenderError::from(error).into()
}
