//! What the temporal sets have drawn: a buffer for each, and the camera, the light and the transforms of the
//! frame that drew it. Written by `indirect_shading`, read by `indirect_reprojection`.

use std::sync::Arc;

use glam::{Affine3A, Mat3A, Vec3, Vec3A, Vec4};

use super::to_u32;
use crate::bvh::gpu::rows;
use crate::scene::{Camera, Pose};
use crate::vulkan::{Buffer, Device, Frame, Image, ImageDescription, Texels, Upload, VulkanError, vk};

/// The set that this frame drew.
#[derive(Clone, Copy, Debug)]
pub struct DrawnSet {
    /// Its index.
    pub set: u32,
    /// What its buffer's irradiance is multiplied by.
    pub irradiance_scale: f32,
}

/// A camera, as what its pixels see.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SetView {
    eye: Vec3,
    /// [`Camera::pixel_rays`].
    rays: [Vec3; 3],
}

impl SetView {
    /// That of a picture of `extent` texels.
    pub fn new(camera: &Camera, extent: [u32; 2]) -> Self {
        Self { eye: camera.eye, rays: camera.pixel_rays(extent[0] as f32 / extent[1] as f32) }
    }

    /// Rows of what leads from an instance's object space to where the camera sees it: x to the right, y down, z along the
    /// view, world units.
    fn rows(&self, object_to_world: &Affine3A) -> [Vec4; 3] {
        let [z, x, y] = self.rays.map(|ray| Vec3A::from(ray.normalize()));
        let turned = Mat3A::from_cols(x, y, z).transpose();
        rows(&Affine3A {
            matrix3: turned * object_to_world.matrix3,
            translation: turned * (object_to_world.translation - Vec3A::from(self.eye)),
        })
    }
}

/// What is known of a set that was drawn.
#[derive(Clone, Copy, Debug)]
pub struct SetParameters {
    /// The camera that drew it.
    pub view: SetView,
    /// Irradiance over what its buffer holds.
    pub scale: f32,
    /// Luminous flux.
    pub flux: f32,
    /// Layer of the set buffers.
    pub layer: u32,
}

impl SetParameters {
    /// Twin: `SetParameters` in shaders/include/drawn_sets.glsl.
    fn texel(&self) -> [u32; 4] {
        [self.scale.to_bits(), self.flux.to_bits(), self.view.rays[2].length().to_bits(), self.layer]
    }
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
    /// Of a set buffer, texels.
    extent: [u32; 2],
    /// Where the camera saw all instances, layer by layer, in texels: [`SetView::rows`].
    views: Buffer,
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
        let rows = u64::from(layers) * instances.max(1) as u64 * 3;
        // With a row of texels that nothing lies in, if there may be one more: where a layer's size is a power of two, a pixel's
        // texels of all sets would share one set of each cache.
        let layer_extent = [extent[0], (extent[1] + 1).min(device.limits().max_image_dimension2_d)];
        Ok(Self {
            buffers: Image::new(
                device,
                &ImageDescription {
                    name: "set_buffers",
                    format: vk::Format::R16G16B16A16_SFLOAT,
                    extent: layer_extent,
                    layers: Some(layers),
                    levels: 1,
                    usage: vk::ImageUsageFlags::STORAGE,
                },
            )?,
            extent,
            views: Buffer::of_texels(device, "view_history", rows, Texels::Rgba32)?,
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

    /// Texels of a set buffer.
    pub fn extent(&self) -> [u32; 2] {
        self.extent
    }

    /// Where the camera of each layer saw all instances: see `seen_by` in shaders/include/reprojection.glsl.
    pub fn views(&self) -> &Buffer {
        &self.views
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
        let view = SetView::new(&pose.camera, self.extent);
        let now = SetParameters { view, scale: 1.0 / drawn.irradiance_scale, flux, layer };
        let drawn_sets = self.parameters.iter().flatten().count();
        let before = self.parameters[drawn.set as usize].replace(now);
        // Layers that no set has had yet are taken in order.
        self.spare = before.map_or(to_u32(drawn_sets) + 1, |before| before.layer);
        self.redrawn = before.map(|before| Redrawn { before, now });
        self.draws += 1;
        let rows: Vec<[Vec4; 3]> = pose.instances.iter().map(|instance| view.rows(instance)).collect();
        if !rows.is_empty() {
            let upload = frame.upload(&rows)?;
            let offset = layer as usize * size_of_val(rows.as_slice());
            frame.copy(&upload, &self.views, offset as u64);
        }
        Ok(())
    }
}

/// Uploads what is known of `sets`, as texels.
pub fn upload_parameters(
    frame: &mut Frame<'_>,
    sets: impl IntoIterator<Item = SetParameters>,
) -> Result<Upload, VulkanError> {
    let texels: Vec<[u32; 4]> = sets.into_iter().map(|set| set.texel()).collect();
    frame.upload(&texels)
}
