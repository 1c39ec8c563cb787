//! The device's half of the estimator: its passes and set buffers.

use std::sync::Arc;

use super::indirect_reprojection::IndirectReprojectionPass;
use super::indirect_shading::{IndirectShadingPass, filter_constants};
use super::indirect_shadows::IndirectShadowsPass;
use super::set_buffers::{FillMode, SetBuffers, SetLayout, SetPush};
use super::vpl_buffer::{UploadedSet, VplBuffer, VplRoom};
use crate::gpu_scene::tracer::TracerVariant;
use crate::passes::frame_inputs::FrameInputs;
use crate::settings::{MissingSets, Settings};
use crate::vulkan::{Device, Frame, Image, VulkanError};

/// The passes and what the temporal sets hold on the device.
pub(super) struct Passes {
    pub vpls: VplBuffer,
    pub indirect_shadows: IndirectShadowsPass,
    pub indirect_shading: IndirectShadingPass,
    pub indirect_reprojection: IndirectReprojectionPass,
    /// The sets that this frame and the next ones render.
    pub sets: SetBuffers,
    /// The sets from before a change of settings. They are shown, where they saw anything, until all of `sets` have been rendered.
    pub previous_sets: Option<SetBuffers>,
}

impl Passes {
    /// The sets that the picture is made of.
    pub fn shown(&self) -> &SetBuffers {
        self.previous_sets.as_ref().unwrap_or(&self.sets)
    }

    /// Gives every pixel its irradiance from the sets that are shown; `light`: the treatment of missing sets, and the flux of all.
    pub fn upsample(
        &self,
        frame: &mut Frame<'_>,
        inputs: &FrameInputs<'_>,
        uploaded: &UploadedSet,
        light: (MissingSets, &[f32]),
        denoised: &Image,
    ) -> Result<(), VulkanError> {
        let pass = &self.indirect_reprojection;
        let push = |sets: &SetBuffers, fill_mode| SetPush { fill_mode, ..sets.push(light.0, light.1) };
        let Some(previous) = &self.previous_sets else {
            let push = push(&self.sets, FillMode::default());
            return pass.upsample(frame, inputs, uploaded, (&self.sets, &push), denoised);
        };
        // Old sets know nothing of what comes into view.
        pass.upsample(frame, inputs, uploaded, (previous, &push(previous, FillMode::LEAVE)), denoised)?;
        pass.upsample(frame, inputs, uploaded, (&self.sets, &push(&self.sets, FillMode::FILL)), denoised)
    }

    /// Makes the passes and empty set buffers.
    pub fn new(
        device: &Arc<Device>,
        tracer: TracerVariant,
        settings: &Settings,
        instances: usize,
    ) -> Result<Self, VulkanError> {
        let Settings { size, ref vpl, .. } = *settings;
        Ok(Self {
            vpls: VplBuffer::new(device, &VplRoom::of(vpl))?,
            indirect_shadows: IndirectShadowsPass::new(device, tracer, size, vpl)?,
            indirect_shading: IndirectShadingPass::new(device, &filter_constants(vpl))?,
            indirect_reprojection: IndirectReprojectionPass::new(device, size)?,
            sets: SetBuffers::new(device, &SetLayout::of(settings), instances)?,
            previous_sets: None,
        })
    }
}
