//! The ray tracer of the shaders, behind `shaders/include/tracer.glsl`.

use std::sync::Arc;

use super::Named;
use super::tracer_hardware::HardwareTracer;
use super::tracer_software::SoftwareTracer;
use crate::bvh::TwoLevelBvh;
use crate::bvh::gpu::GpuAlphaMasks;
use crate::bvh::thin_surfaces::GpuThinSurfaces;
pub use crate::report::RayTracer;
use crate::vulkan::shaders::PerTracer;
use crate::vulkan::{Buffer, ComputePipeline, Device, Frame, VulkanError};

impl RayTracer {
    /// The tracers that a device supports.
    pub fn offered(device: &Device) -> &'static [Self] {
        if device.info().ray_query { &[Self::Software, Self::Hardware] } else { &[Self::Software] }
    }

    /// The shader that goes with it.
    pub fn of(self, shader: PerTracer) -> &'static [u8] {
        match self {
            Self::Software => shader.software,
            Self::Hardware => shader.hardware,
        }
    }
}

/// Variant of shaders that trace rays, or read the results.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TracerVariant {
    /// The tracer.
    pub tracer: RayTracer,
    /// Whether the scene has thin surfaces: `HAS_THIN_SURFACES` in shaders.
    pub thin_surfaces: bool,
}

impl TracerVariant {
    /// A pipeline of a shader that traces rays; `constants` are its own, from the specialisation constant 1 on.
    ///
    /// # Errors
    /// Where the device fails.
    pub fn pipeline(
        self,
        device: &Arc<Device>,
        name: &str,
        shader: PerTracer,
        constants: &[u32],
    ) -> Result<ComputePipeline, VulkanError> {
        let constants = [&[u32::from(self.thin_surfaces)], constants].concat();
        ComputePipeline::specialised(device, name, self.tracer.of(shader), &constants)
    }
}

/// A scene in device memory, as rays meet it.
pub struct Tracer {
    structure: Structure,
    triangle_uvs: Buffer,
    masks: Buffer,
    mask_texels: Buffer,
    thin_triangles: Buffer,
    thin_surfaces: Buffer,
    thin_texels: Buffer,
    has_thin_surfaces: bool,
}

enum Structure {
    Software(SoftwareTracer),
    Hardware(HardwareTracer),
}

impl Tracer {
    /// Uploads everything and, for the hardware tracer, builds what does not move.
    pub fn new(device: &Arc<Device>, tracer: RayTracer, bvh: &TwoLevelBvh) -> Result<Self, VulkanError> {
        let (structure, alpha, thin_surfaces) = match tracer {
            RayTracer::Software => {
                let layout = bvh.gpu_layout();
                (
                    Structure::Software(SoftwareTracer::new(device, bvh, &layout)?),
                    layout.alpha,
                    layout.thin_surfaces,
                )
            }
            RayTracer::Hardware => {
                let layout = bvh.hardware_layout();
                (
                    Structure::Hardware(HardwareTracer::new(device, bvh, &layout)?),
                    layout.alpha,
                    layout.thin_surfaces,
                )
            }
        };
        let GpuAlphaMasks { triangle_uvs, masks, mask_texels } = alpha;
        let GpuThinSurfaces { triangles: thin_triangles, thin_surfaces, texels } = &*thin_surfaces;
        Ok(Self {
            structure,
            triangle_uvs: Buffer::with_data(device, "bvh_triangle_uvs", &triangle_uvs)?,
            masks: Buffer::with_data(device, "bvh_masks", &masks)?,
            mask_texels: Buffer::with_data(device, "bvh_mask_texels", &mask_texels)?,
            thin_triangles: Buffer::with_data(device, "bvh_thin_triangles", thin_triangles)?,
            thin_surfaces: Buffer::with_data(device, "bvh_thin_surfaces", thin_surfaces)?,
            thin_texels: Buffer::with_data(device, "bvh_thin_texels", texels)?,
            has_thin_surfaces: bvh.has_thin_surfaces(),
        })
    }

    /// Uploads thin surfaces of other materials, for [`Self::replace_thin_surfaces`].
    pub(super) fn thin_surface_materials(
        &self,
        device: &Arc<Device>,
        thin_surfaces: &GpuThinSurfaces,
    ) -> Result<Buffer, VulkanError> {
        Buffer::with_data(device, "bvh_thin_surfaces", &thin_surfaces.thin_surfaces)
    }

    /// Goes on with thin surfaces of other materials. No frame is in flight.
    pub(super) fn replace_thin_surfaces(&mut self, thin_surfaces: Buffer) {
        self.thin_surfaces = thin_surfaces;
    }

    /// Which shaders it is for: pipelines must be made of them.
    pub fn variant(&self) -> TracerVariant {
        TracerVariant { tracer: self.kind(), thin_surfaces: self.has_thin_surfaces }
    }

    /// Which tracer it is.
    pub fn kind(&self) -> RayTracer {
        match self.structure {
            Structure::Software(_) => RayTracer::Software,
            Structure::Hardware(_) => RayTracer::Hardware,
        }
    }

    /// Brings it up to date after instances have moved; needed before the first use too.
    pub fn update(&mut self, frame: &mut Frame<'_>, bvh: &TwoLevelBvh) -> Result<(), VulkanError> {
        match &mut self.structure {
            Structure::Software(tracer) => tracer.update(frame, bvh),
            Structure::Hardware(tracer) => tracer.update(frame, bvh),
        }
    }

    /// Part of the scene set: all that shaders/include/tracer.glsl reads.
    pub fn resources(&self) -> Vec<Named<'_>> {
        let mut resources: Vec<Named<'_>> = vec![
            ("bvh_masks", (&self.masks).into()),
            ("bvh_mask_texels", (&self.mask_texels).into()),
            ("bvh_triangle_uvs", (&self.triangle_uvs).into()),
            ("bvh_thin_triangles", (&self.thin_triangles).into()),
            ("bvh_thin_surfaces", (&self.thin_surfaces).into()),
            ("bvh_thin_texels", (&self.thin_texels).into()),
        ];
        match &self.structure {
            Structure::Software(tracer) => resources.extend(tracer.resources()),
            Structure::Hardware(tracer) => resources.extend(tracer.resources()),
        }
        resources
    }
}
