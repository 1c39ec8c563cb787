//! The ray tracer of the shaders: what shaders/include/tracer.glsl traverses.

use std::sync::Arc;

use crate::bvh::TwoLevelBvh;
use crate::bvh::gpu::GpuBvhUpdate;
use crate::vulkan::{Buffer, Device, Frame, Pass, VulkanError};

/// The two-level BVH in device memory (the software tracer).
pub struct Tracer {
    nodes: Buffer,
    triangles: Buffer,
    triangle_uvs: Buffer,
    masks: Buffer,
    mask_bits: Buffer,
    instances: Buffer,
    roots: Buffer,
    static_builds: u32,
    dynamic_builds: u32,
}

impl Tracer {
    /// Uploads the whole structure.
    pub fn new(device: &Arc<Device>, bvh: &TwoLevelBvh) -> Result<Self, VulkanError> {
        let layout = bvh.gpu_layout();
        Ok(Self {
            nodes: Buffer::with_data(device, "bvh_nodes", &layout.nodes)?,
            triangles: Buffer::with_data(device, "bvh_triangles", &layout.triangles)?,
            triangle_uvs: Buffer::with_data(device, "bvh_triangle_uvs", &layout.triangle_uvs)?,
            masks: Buffer::with_data(device, "bvh_masks", &layout.masks)?,
            mask_bits: Buffer::with_data(device, "bvh_mask_bits", &layout.mask_bits)?,
            instances: Buffer::with_data(device, "bvh_instances", &layout.instances)?,
            roots: Buffer::with_data(device, "bvh_roots", &[layout.roots])?,
            static_builds: bvh.static_builds(),
            dynamic_builds: bvh.dynamic_builds(),
        })
    }

    /// Brings the top levels up to date after instances have moved.
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
        if update.nodes.is_empty() {
            return Ok(());
        }
        let nodes = frame.upload(&update.nodes)?;
        frame.copy(&nodes, &self.nodes, u64::from(update.node_offset) * size_of_val(&update.nodes[0]) as u64);
        let instances = frame.upload(&update.instances)?;
        let offset = u64::from(update.instance_offset) * size_of_val(&update.instances[0]) as u64;
        frame.copy(&instances, &self.instances, offset);
        let roots = frame.upload(&[update.roots])?;
        frame.copy(&roots, &self.roots, 0);
        Ok(())
    }

    /// Binds everything that the include names.
    pub fn bind<'f>(&'f self, pass: Pass<'f>) -> Pass<'f> {
        self.bind_masks(pass)
            .read("bvh_nodes", &self.nodes)
            .read("bvh_triangles", &self.triangles)
            .read("bvh_triangle_uvs", &self.triangle_uvs)
            .read("bvh_instances", &self.instances)
            .read("bvh_roots", &self.roots)
    }

    /// Binds the alpha masks only, for raster passes.
    pub fn bind_masks<'f>(&'f self, pass: Pass<'f>) -> Pass<'f> {
        pass.read("bvh_masks", &self.masks).read("bvh_mask_bits", &self.mask_bits)
    }
}
