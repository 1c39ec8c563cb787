//! The ray tracer of the shaders: what `shaders/include/tracer.glsl` traces rays with.

use std::sync::Arc;

use super::tracer_hardware::HardwareTracer;
use super::tracer_software::SoftwareTracer;
use crate::bvh::TwoLevelBvh;
use crate::bvh::gpu::GpuAlphaMasks;
use crate::bvh::sheets::GpuSheets;
pub use crate::report::RayTracer;
use crate::vulkan::shaders::PerTracer;
use crate::vulkan::{Buffer, ComputePipeline, Device, Frame, Pass, VulkanError};

impl RayTracer {
    /// The tracers that a device can do with.
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

/// What shaders that trace rays, or read what these found, are made for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TracerVariant {
    /// What traces the rays.
    pub tracer: RayTracer,
    /// Whether the scene has thin sheets: `HAS_SHEETS` in shaders.
    pub sheets: bool,
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
        let constants = [&[u32::from(self.sheets)], constants].concat();
        ComputePipeline::specialised(device, name, self.tracer.of(shader), &constants)
    }
}

/// A scene in device memory, as rays meet it.
pub struct Tracer {
    structure: Structure,
    triangle_uvs: Buffer,
    masks: Buffer,
    mask_bits: Buffer,
    sheet_triangles: Buffer,
    sheets: Buffer,
    sheet_texels: Buffer,
    has_sheets: bool,
}

enum Structure {
    Software(SoftwareTracer),
    Hardware(HardwareTracer),
}

impl Tracer {
    /// Uploads everything and, for the hardware tracer, builds what does not move.
    pub fn new(device: &Arc<Device>, tracer: RayTracer, bvh: &TwoLevelBvh) -> Result<Self, VulkanError> {
        let (structure, alpha, sheets) = match tracer {
            RayTracer::Software => {
                let layout = bvh.gpu_layout();
                (Structure::Software(SoftwareTracer::new(device, bvh, &layout)?), layout.alpha, layout.sheets)
            }
            RayTracer::Hardware => {
                let layout = bvh.hardware_layout();
                (Structure::Hardware(HardwareTracer::new(device, bvh, &layout)?), layout.alpha, layout.sheets)
            }
        };
        let GpuAlphaMasks { triangle_uvs, masks, mask_bits } = alpha;
        let GpuSheets { triangles: sheet_triangles, sheets, texels } = &*sheets;
        Ok(Self {
            structure,
            triangle_uvs: Buffer::with_data(device, "bvh_triangle_uvs", &triangle_uvs)?,
            masks: Buffer::with_data(device, "bvh_masks", &masks)?,
            mask_bits: Buffer::with_data(device, "bvh_mask_bits", &mask_bits)?,
            sheet_triangles: Buffer::with_data(device, "bvh_sheet_triangles", sheet_triangles)?,
            sheets: Buffer::with_data(device, "bvh_sheets", sheets)?,
            sheet_texels: Buffer::with_data(device, "bvh_sheet_texels", texels)?,
            has_sheets: bvh.has_sheets(),
        })
    }

    /// Goes on with sheets of other materials. No frame is on its way.
    pub fn replace_sheets(&mut self, device: &Arc<Device>, sheets: &GpuSheets) -> Result<(), VulkanError> {
        self.sheets = Buffer::with_data(device, "bvh_sheets", &sheets.sheets)?;
        Ok(())
    }

    /// Which shaders it is for: pipelines must be made of them.
    pub fn variant(&self) -> TracerVariant {
        TracerVariant { tracer: self.kind(), sheets: self.has_sheets }
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

    /// Binds everything that the include names.
    pub fn bind<'f>(&'f self, pass: Pass<'f>) -> Pass<'f> {
        let pass = self
            .bind_masks(pass)
            .read("bvh_triangle_uvs", &self.triangle_uvs)
            .read("bvh_sheet_triangles", &self.sheet_triangles)
            .read("bvh_sheets", &self.sheets)
            .read("bvh_sheet_texels", &self.sheet_texels);
        match &self.structure {
            Structure::Software(tracer) => tracer.bind(pass),
            Structure::Hardware(tracer) => tracer.bind(pass),
        }
    }

    /// Binds the alpha masks only, for raster passes.
    pub fn bind_masks<'f>(&'f self, pass: Pass<'f>) -> Pass<'f> {
        pass.read("bvh_masks", &self.masks).read("bvh_mask_bits", &self.mask_bits)
    }
}
