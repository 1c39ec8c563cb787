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

/// A set that has just been drawn again.
#[derive(Clone, Copy, Debug)]
pub struct Redrawn {
    /// What was known of it before; its layer is still there.
    pub before: SetParameters,
    /// What is known of it now.
    pub now: SetParameters,
}

/// The set buffers with all that it takes to bring them into another view.
pub struct SetHistory {
    /// One layer a set, and a spare one, so that what a set was before it was drawn last is still there. rgb: scaled
    /// irradiance; a: scaled view depth.
    buffers: Image,
    /// Rows of the transforms of all instances, layer by layer.
    transforms: Buffer,
    /// One for each set, none before it was first drawn.
    parameters: Vec<Option<SetParameters>>,
    /// The layer that the next set goes to.
    spare: u32,
    redrawn: Option<Redrawn>,
    /// How many times a set was drawn.
    draws: u64,
    /// Tells it from any other.
    identity: Arc<()>,
}

impl SetHistory {
    /// Makes `sets` set buffers of `extent` texels, none of them drawn yet.
    pub fn new(
        device: &Arc<Device>,
        extent: [u32; 2],
        sets: u32,
        instances: usize,
    ) -> Result<Self, VulkanError> {
        let layers = sets + 1;
        let transforms = u64::from(layers) * instances as u64 * size_of::<[Vec4; 3]>() as u64;
        Ok(Self {
            buffers: Image::new(
                device,
                &ImageDescription {
                    name: "set_buffers",
                    format: vk::Format::R16G16B16A16_SFLOAT,
                    extent,
                    layers: Some(layers),
                    levels: 1,
                    usage: vk::ImageUsageFlags::STORAGE,
                },
            )?,
            transforms: Buffer::new(device, "instance_history", transforms)?,
            parameters: vec![None; sets as usize],
            spare: 0,
            redrawn: None,
            draws: 0,
            identity: Arc::new(()),
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

    /// The layer that the next set goes to.
    pub fn spare_layer(&self) -> u32 {
        self.spare
    }

    /// What the set that was drawn last was before and is now; none if it was its first time.
    pub fn redrawn(&self) -> Option<&Redrawn> {
        self.redrawn.as_ref()
    }

    /// How many times a set was drawn.
    pub fn draws(&self) -> u64 {
        self.draws
    }

    /// The same for as long as the sets are, and for no others.
    pub fn identity(&self) -> &Arc<()> {
        &self.identity
    }

    /// Whether every set has been drawn.
    pub fn is_complete(&self) -> bool {
        self.parameters.iter().all(Option::is_some)
    }

    /// Notes that this frame draws a set of luminous flux `flux` into the spare layer with everything standing as
    /// in `pose`.
    pub fn note(
        &mut self,
        frame: &mut Frame<'_>,
        pose: &Pose,
        drawn: &DrawnSet,
        flux: f32,
    ) -> Result<(), VulkanError> {
        let layer = self.spare;
        let now = SetParameters { layer, ..parameters(&pose.camera, self.buffers.extent(), drawn, flux) };
        let drawn_sets = self.parameters.iter().flatten().count();
        let before = self.parameters[drawn.set as usize].replace(now);
        // Layers that no set has had yet are taken in order.
        self.spare = before.map_or(to_u32(drawn_sets) + 1, |before| before.layer);
        self.redrawn = before.map(|before| Redrawn { before, now });
        self.draws += 1;
        let rows = transform_rows(pose);
        if !rows.is_empty() {
            let upload = frame.upload(&rows)?;
            let offset = layer as usize * size_of_val(rows.as_slice());
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
        ..SetParameters::default()
    }
}

fn to_u32(count: usize) -> u32 {
    u32::try_from(count).unwrap_or(u32::MAX)
}
