//! The software tracer: the two-level BVH in storage buffers, for `shaders/include/tracer_software.glsl`.

use std::sync::Arc;

use super::Named;
use crate::bvh::TwoLevelBvh;
use crate::bvh::gpu::{GpuBvh, GpuBvhUpdate};
use crate::vulkan::{Buffer, Device, Frame, VulkanError};

/// The two-level BVH in device memory.
pub(super) struct SoftwareTracer {
    nodes: Buffer,
    triangles: Buffer,
    instances: Buffer,
    roots: Buffer,
    static_builds: u32,
    dynamic_builds: u32,
}

impl SoftwareTracer {
    /// Uploads the whole structure.
    pub fn new(device: &Arc<Device>, bvh: &TwoLevelBvh, layout: &GpuBvh) -> Result<Self, VulkanError> {
        Ok(Self {
            nodes: Buffer::with_data(device, "bvh_nodes", &layout.nodes)?.with_texels()?,
            triangles: Buffer::with_data(device, "bvh_triangles", &layout.triangles)?.with_texels()?,
            instances: Buffer::with_data(device, "bvh_instances", &layout.instances)?.with_texels()?,
            roots: Buffer::with_data(device, "bvh_roots", &[layout.roots])?,
            static_builds: bvh.static_builds(),
            dynamic_builds: bvh.dynamic_builds(),
        })
    }

    /// Copies those top levels that were built again.
    pub fn update(&mut self, frame: &mut Frame<'_>, bvh: &TwoLevelBvh) -> Result<(), VulkanError> {
        if self.static_builds != bvh.static_builds() {
            self.static_builds = bvh.static_builds();
            self.apply(frame, &bvh.static_gpu_layout())?;
        }
        if self.dynamic_builds != bvh.dynamic_builds() {
            self.dynamic_builds = bvh.dynamic_builds();
            self.apply(frame, &bvh.dynamic_gpu_layout())?;
        }
        Ok(())
    }

    fn apply(&self, frame: &mut Frame<'_>, update: &GpuBvhUpdate) -> Result<(), VulkanError> {
        if !update.nodes.is_empty() {
            let nodes = frame.upload(&update.nodes)?;
            let offset = u64::from(update.node_offset) * size_of_val(&update.nodes[0]) as u64;
            frame.copy(&nodes, &self.nodes, offset);
            let instances = frame.upload(&update.instances)?;
            let offset = u64::from(update.instance_offset) * size_of_val(&update.instances[0]) as u64;
            frame.copy(&instances, &self.instances, offset);
        }
        // Where nothing of a level is left to be hit, its root goes.
        let roots = frame.upload(&[update.roots])?;
        frame.copy(&roots, &self.roots, 0);
        Ok(())
    }

    /// Part of the scene set.
    pub fn resources(&self) -> [Named<'_>; 4] {
        [
            ("bvh_nodes", (&self.nodes).into()),
            ("bvh_triangles", (&self.triangles).into()),
            ("bvh_instances", (&self.instances).into()),
            ("bvh_roots", (&self.roots).into()),
        ]
    }
}
