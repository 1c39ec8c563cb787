//! What the temporal sets have drawn: a buffer for each, and the camera, the light and the transforms of the
//! frame that drew it. Written by `indirect_shading`, read by `indirect_reprojection`.

use std::sync::Arc;

use glam::Vec4;

use super::scene_buffers::transform_rows;
use super::structs::SetParameters;
use crate::scene::{Camera, Pose};
use crate::vulkan::{Buffer, Device, Frame, Image, ImageDescription, Upload, VulkanError, vk};

/// Room for sets in the shaders' uniform block: the most temporal sets that settings allow.
const MAX_SETS: usize = 64;

/// The set that this frame drew.
#[derive(Clone, Copy, Debug)]
pub struct DrawnSet {
    /// Its index.
    pub set: u32,
    /// What its buffer's irradiance is multiplied by.
    pub irradiance_scale: f32,
}

/// The set buffers with all that it takes to bring them into another view.
pub struct SetHistory {
    /// One layer a set: rgb: scaled irradiance; a: scaled view depth.
    buffers: Image,
    /// Rows of the transforms of all instances, set by set.
    transforms: Buffer,
    /// One for each set, none before it was first drawn.
    parameters: Vec<Option<SetParameters>>,
}

impl SetHistory {
    /// Makes `sets` set buffers of `extent` texels, none of them drawn yet.
    pub fn new(
        device: &Arc<Device>,
        extent: [u32; 2],
        sets: u32,
        instances: usize,
    ) -> Result<Self, VulkanError> {
        let transforms = u64::from(sets) * instances as u64 * size_of::<[Vec4; 3]>() as u64;
        Ok(Self {
            buffers: Image::new(
                device,
                &ImageDescription {
                    name: "set_buffers",
                    format: vk::Format::R16G16B16A16_SFLOAT,
                    extent,
                    layers: Some(sets),
                    levels: 1,
                    usage: vk::ImageUsageFlags::STORAGE,
                },
            )?,
            transforms: Buffer::new(device, "instance_history", transforms)?,
            parameters: vec![None; sets as usize],
        })
    }

    /// The set buffers.
    pub fn buffers(&self) -> &Image {
        &self.buffers
    }

    /// The transforms.
    pub fn transforms(&self) -> &Buffer {
        &self.transforms
    }

    /// What is known of each set; none before it was first drawn.
    pub fn parameters(&self) -> &[Option<SetParameters>] {
        &self.parameters
    }

    /// Whether every set has been drawn.
    pub fn is_complete(&self) -> bool {
        self.parameters.iter().all(Option::is_some)
    }

    /// Notes that this frame draws a set of luminous flux `flux` with everything standing as in `pose`.
    pub fn note(
        &mut self,
        frame: &mut Frame<'_>,
        pose: &Pose,
        drawn: &DrawnSet,
        flux: f32,
    ) -> Result<(), VulkanError> {
        let set = drawn.set as usize;
        self.parameters[set] = Some(parameters(&pose.camera, self.buffers.extent(), drawn, flux));
        let rows = transform_rows(pose);
        if !rows.is_empty() {
            let upload = frame.upload(&rows)?;
            let offset = set * size_of_val(rows.as_slice());
            frame.copy(&upload, &self.transforms, offset as u64);
        }
        Ok(())
    }
}

/// Uploads what is known of `sets`, at most as many as settings allow.
pub fn upload_parameters(
    frame: &mut Frame<'_>,
    sets: impl IntoIterator<Item = SetParameters>,
) -> Result<Upload, VulkanError> {
    let mut all = [SetParameters::default(); MAX_SETS];
    for (target, set) in all.iter_mut().zip(sets) {
        *target = set;
    }
    frame.upload(&all)
}

/// What a set drawn by `camera` is looked up with.
pub fn parameters(camera: &Camera, extent: [u32; 2], drawn: &DrawnSet, flux: f32) -> SetParameters {
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
