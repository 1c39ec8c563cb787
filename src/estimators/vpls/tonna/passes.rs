//! The device's half of the method as published: gather a set's VPLs by classes of pixels, filter them together, and add up all sets in
//! the current view.

use std::sync::Arc;

use super::super::set_buffers::{SetBuffers, SetPush};
use super::super::vpl_buffer::UploadedSet;
use crate::gpu_scene::tracer::TracerVariant;
use crate::passes::frame_inputs::FrameInputs;
use crate::passes::storage_image;
use crate::settings::{MissingSets, Settings};
use crate::vulkan::{ComputePipeline, Device, Frame, Image, VulkanError, shaders, vk};

/// Rays of a pixel in one dispatch, at most: watchdogs of GPUs end long ones.
const MOST_RAYS: u32 = 32;

/// The passes.
pub(super) struct TonnaPasses {
    gather: ComputePipeline,
    filter: ComputePipeline,
    reproject: ComputePipeline,
    classes: u32,
    gathered: Image,
    irradiance: Image,
}

impl TonnaPasses {
    /// Makes the pipelines for a tracer, and the images.
    pub fn new(
        device: &Arc<Device>,
        tracer: TracerVariant,
        settings: &Settings,
    ) -> Result<Self, VulkanError> {
        let interleave = settings.vpl.interleave;
        let image = |name, format| storage_image(device, name, format, settings.size);
        let gather = shaders::CLASS_GATHERING_COMP;
        let filter = shaders::CLASS_FILTER_COMP;
        Ok(Self {
            gather: tracer.pipeline(device, "class_gathering", gather, &[interleave])?,
            filter: ComputePipeline::specialised(device, "class_filter", filter, &[interleave])?,
            reproject: ComputePipeline::new(
                device,
                "camera_reprojection",
                shaders::CAMERA_REPROJECTION_COMP,
            )?,
            classes: interleave.pow(2),
            // 32 bits: many dispatches may add to it.
            gathered: image("gathered_irradiance", vk::Format::R32G32B32A32_SFLOAT)?,
            irradiance: image("irradiance", vk::Format::R16G16B16A16_SFLOAT)?,
        })
    }

    /// rgb: scaled irradiance of each pixel by the VPLs of its class; a: view depth.
    pub fn gathered(&self) -> &Image {
        &self.gathered
    }

    /// The sum of all sets.
    pub fn irradiance(&self) -> &Image {
        &self.irradiance
    }

    /// Renders a set into its layer of the set buffers.
    pub fn render_set(
        &self,
        frame: &mut Frame<'_>,
        inputs: &FrameInputs<'_>,
        set: &UploadedSet,
        sets: &SetBuffers,
    ) -> Result<(), VulkanError> {
        let extent = self.gathered.extent();
        // At least one dispatch, so that an empty set is black.
        for first in (0..set.count.div_ceil(self.classes).max(1)).step_by(MOST_RAYS as usize) {
            let pass = inputs
                .bind(frame.pass("class_gathering", &self.gather))
                .write("gathered_irradiance", &self.gathered)
                .write("ray_counters", set.ray_counters.buffer())
                .push(&[first, MOST_RAYS]);
            set.bind(pass).dispatch_over(extent)?;
        }
        let pass = inputs
            .bind(frame.pass("class_filter", &self.filter))
            .read("gathered_irradiance", &self.gathered)
            .write("set_buffers", sets.buffers())
            .read("set_views", sets.views())
            .push(&sets.push(MissingSets::Dark, &[]));
        set.bind(pass).dispatch_over(extent)
    }

    /// Adds up all sets.
    pub fn add_up(
        &self,
        frame: &mut Frame<'_>,
        inputs: &FrameInputs<'_>,
        set: &UploadedSet,
        (sets, push): (&SetBuffers, &SetPush),
    ) -> Result<(), VulkanError> {
        let pass = inputs
            .bind(frame.pass("camera_reprojection", &self.reproject))
            .write("irradiance", &self.irradiance)
            .push(push);
        sets.bind(set.bind(pass)).dispatch_over(self.irradiance.extent())
    }
}
