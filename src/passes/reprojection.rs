//! `reprojection`: where each visible surface was in the last frame, and which texels there showed it.

use std::sync::Arc;

use super::gbuffer::GBuffer;
use super::history::History;
use super::storage_image;
use crate::vulkan::{ComputePipeline, Device, Frame, Image, SharedSet, Upload, VulkanError, shaders, vk};

/// Inputs of the pass.
pub struct ReprojectionInputs<'a> {
    /// `FrameUniforms`.
    pub uniforms: &'a Upload,
    /// Set 1: the scene, for transforms of this frame and the last one.
    pub scene: &'a SharedSet<'a>,
    /// View depth in the G-buffer.
    pub depth: &'a Image,
    /// Shading and geometric normals in the G-buffer.
    pub normal: &'a Image,
    /// Instances plus one, in the G-buffer.
    pub instance: &'a Image,
    /// Motion in the G-buffer, pixels.
    pub motion: &'a Image,
}

impl<'a> ReprojectionInputs<'a> {
    /// The inputs for the visible surfaces of a frame.
    pub fn of(uniforms: &'a Upload, scene: &'a SharedSet<'a>, gbuffer: &'a GBuffer) -> Self {
        let GBuffer { depth, normal, instance, motion, .. } = gbuffer;
        Self { uniforms, scene, depth, normal, instance, motion }
    }
}

/// Outputs of the pass. 32 bytes a pixel.
pub struct Reprojection {
    surfaces: History<Image>,
    /// The instances of the surfaces, plus one.
    instances: History<Image>,
    /// xy: motion, pixels; z and w: which texels of the last frame show the surface, as in shaders/passes/reprojection.comp.
    pub reprojected: Image,
}

impl Reprojection {
    /// Surfaces of this frame: depth and normal, packed as in shaders/include/visible_surface.glsl.
    pub fn surface(&self) -> &Image {
        self.surfaces.last()
    }
}

/// The pass.
pub struct ReprojectionPass {
    pipeline: ComputePipeline,
    output: Reprojection,
}

impl ReprojectionPass {
    /// Makes the pipeline, with the `tests` of [`crate::settings::EffectSettings::reprojection_tests`], and the images of `extent` texels.
    ///
    /// # Errors
    /// Where the device lacks memory.
    pub fn new(device: &Arc<Device>, extent: [u32; 2], tests: u32) -> Result<Self, VulkanError> {
        let shader = shaders::REPROJECTION_COMP;
        let history = |name, format| History::new(|_| storage_image(device, name, format, extent));
        Ok(Self {
            pipeline: ComputePipeline::specialised(device, "reprojection", shader, &[tests])?,
            output: Reprojection {
                surfaces: history("surface", vk::Format::R16G16B16A16_UINT)?,
                instances: history("instance", vk::Format::R32_UINT)?,
                reprojected: storage_image(device, "reprojected", vk::Format::R16G16B16A16_SFLOAT, extent)?,
            },
        })
    }

    /// The outputs of the last frame.
    pub fn output(&self) -> &Reprojection {
        &self.output
    }

    /// Looks for every pixel.
    ///
    /// # Errors
    /// Where the device fails.
    pub fn record(
        &mut self,
        frame: &mut Frame<'_>,
        inputs: &ReprojectionInputs<'_>,
    ) -> Result<(), VulkanError> {
        let Reprojection { surfaces, instances, reprojected } = &mut self.output;
        let reprojected = &*reprojected;
        frame
            .pass("reprojection", &self.pipeline)
            .read("frame_uniforms", inputs.uniforms)
            .shared(inputs.scene)
            .read("gbuffer_depth", inputs.depth)
            .read("gbuffer_normal", inputs.normal)
            .read("gbuffer_instance", inputs.instance)
            .read("gbuffer_motion", inputs.motion)
            .read("last_surface", surfaces.last())
            .write("surface", surfaces.next())
            .read("last_instance", instances.last())
            .write("instance", instances.next())
            .write("reprojected", reprojected)
            .push(&u32::from(surfaces.is_valid()))
            .dispatch_over(reprojected.extent())?;
        surfaces.advance();
        instances.advance();
        Ok(())
    }
}
