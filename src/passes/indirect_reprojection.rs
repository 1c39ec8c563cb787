//! `indirect_reprojection`: all set buffers into the current view, each by the camera and the instance
//! transforms of the frame that drew it (algorithm 4 of Tonna 2019).

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use glam::Vec4;

use super::gbuffer::GBuffer;
use super::scene_buffers::transform_rows;
use super::storage_image;
use super::structs::SetParameters;
use crate::scene::{Camera, Pose};
use crate::vulkan::{Buffer, ComputePipeline, Device, Frame, Image, Upload, VulkanError, shaders, vk};

/// Room for sets in the shader's uniform block: the most temporal sets that settings allow.
const MAX_SETS: usize = 64;

/// What the pass reads.
pub struct ReprojectionInputs<'a> {
    /// Frame uniforms.
    pub frame: &'a Upload,
    /// The visible surfaces.
    pub gbuffer: &'a GBuffer,
    /// One layer a set.
    pub set_buffers: &'a Image,
    /// Instances of this frame.
    pub instances: &'a Upload,
    /// Where everything stands.
    pub pose: &'a Pose,
    /// What this frame drew.
    pub drawn: DrawnSet,
    /// Scale up what is there by total flux over present flux.
    pub scale_missing: bool,
    /// Luminous flux of each set now, for those that have never been drawn.
    pub set_flux: &'a [f32],
}

/// The set that this frame drew.
#[derive(Clone, Copy, Debug)]
pub struct DrawnSet {
    /// Its index.
    pub set: u32,
    /// What its buffer's irradiance is multiplied by.
    pub irradiance_scale: f32,
}

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Push {
    instance_count: u32,
    scale_missing: u32,
    total_flux: f32,
    drawn_count: u32,
    same_view_count: u32,
}

/// The pass.
pub struct IndirectReprojectionPass {
    pipeline: ComputePipeline,
    irradiance: Image,
    history: Buffer,
    /// One for each set, none before it was first drawn.
    parameters: Vec<Option<SetParameters>>,
}

impl IndirectReprojectionPass {
    /// Makes the pipeline, its image of `extent` texels and the history of `sets` frames.
    pub fn new(
        device: &Arc<Device>,
        extent: [u32; 2],
        sets: u32,
        instances: usize,
    ) -> Result<Self, VulkanError> {
        let history = u64::from(sets) * instances as u64 * size_of::<[Vec4; 3]>() as u64;
        Ok(Self {
            pipeline: ComputePipeline::new(
                device,
                "indirect_reprojection",
                shaders::INDIRECT_REPROJECTION_COMP,
            )?,
            irradiance: storage_image(device, "irradiance", vk::Format::R32G32B32A32_SFLOAT, extent)?,
            history: Buffer::new(device, "instance_history", history)?,
            parameters: vec![None; sets as usize],
        })
    }

    /// Indirect irradiance of the last frame; a: how many sets had seen the pixel's surface.
    pub fn output(&self) -> &Image {
        &self.irradiance
    }

    /// Notes what this frame drew, then brings all sets together.
    pub fn record(
        &mut self,
        frame: &mut Frame<'_>,
        inputs: &ReprojectionInputs<'_>,
    ) -> Result<&Image, VulkanError> {
        let set = inputs.drawn.set as usize;
        let extent = self.irradiance.extent();
        let now = parameters(&inputs.pose.camera, extent, &inputs.drawn, inputs.set_flux[set]);
        self.parameters[set] = Some(now);
        let rows = transform_rows(inputs.pose);
        if !rows.is_empty() {
            let upload = frame.upload(&rows)?;
            let offset = set * size_of_val(rows.as_slice());
            frame.copy(&upload, &self.history, offset as u64);
        }
        let flux = |(drawn, now): (&Option<SetParameters>, &f32)| drawn.map_or(*now, |set| set.ray.w);
        let total_flux = self.parameters.iter().zip(inputs.set_flux).map(flux).sum();
        let (same_view, other): (Vec<SetParameters>, Vec<SetParameters>) =
            self.parameters.iter().flatten().partition(|set| set.same_view(&now));
        let push = Push {
            instance_count: to_u32(rows.len()),
            scale_missing: u32::from(inputs.scale_missing),
            total_flux,
            drawn_count: to_u32(same_view.len() + other.len()),
            same_view_count: to_u32(same_view.len()),
        };
        let mut all = [SetParameters::default(); MAX_SETS];
        for (target, set) in all.iter_mut().zip(same_view.into_iter().chain(other)) {
            *target = set;
        }
        let parameters = frame.upload(&all)?;
        frame
            .pass("indirect_reprojection", &self.pipeline)
            .read("frame", inputs.frame)
            .read("gbuffer_position", &inputs.gbuffer.position)
            .read("gbuffer_normal", &inputs.gbuffer.normal)
            .read("gbuffer_instance", &inputs.gbuffer.instance)
            .read("set_buffers", inputs.set_buffers)
            .read("set_parameters", &parameters)
            .read("instances", inputs.instances)
            .read("instance_history", &self.history)
            .write("irradiance", &self.irradiance)
            .push(&push)
            .dispatch_over(extent)?;
        Ok(&self.irradiance)
    }
}

fn parameters(camera: &Camera, extent: [u32; 2], drawn: &DrawnSet, flux: f32) -> SetParameters {
    let [ray, ray_x, ray_y] = camera.pixel_rays(extent[0] as f32 / extent[1] as f32);
    SetParameters {
        eye: camera.eye.extend(1.0 / drawn.irradiance_scale),
        ray: ray.extend(flux),
        ray_x: ray_x.extend(1.0 / ray_x.length_squared()),
        ray_y: ray_y.extend(1.0 / ray_y.length_squared()),
        layer: drawn.set,
        ..SetParameters::default()
    }
}

fn to_u32(count: usize) -> u32 {
    u32::try_from(count).unwrap_or(u32::MAX)
}
