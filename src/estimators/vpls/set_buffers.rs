//! Renderings of the temporal sets: a buffer for each, and the camera, the light and the transforms of the
//! frame that rendered it. Written by `indirect_shading`, read by `indirect_reprojection`.
//!
//! Where the filter's window spans several pixels, set buffers have half the resolution in each direction. A texel then stands
//! for one pixel of four, and sets differ in which, so that together they have seen every pixel.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use glam::{Affine3A, Mat3A, Vec2, Vec3, Vec3A, Vec4};

use crate::bvh::gpu::rows;
use crate::gpu_scene::to_u32;
use crate::passes::frame_inputs::FrameInputs;
use crate::passes::storage_image_array;
use crate::scene::Camera;
use crate::settings::{MissingSets, SetResolution, Settings, VplSettings};
use crate::vulkan::{Buffer, Device, Frame, Image, Pass, VulkanError, vk};

/// A camera, as what its pixels see.
#[derive(Clone, Copy, Debug, PartialEq)]
struct SetView {
    eye: Vec3,
    /// Unit view direction.
    forward: Vec3,
    /// The last two of [`Camera::pixel_rays`].
    rays: [Vec3; 2],
    /// [`Camera::shift`].
    shift: Vec2,
}

impl SetView {
    fn new(camera: &Camera, size: [u32; 2]) -> Self {
        let [_, right, down] = camera.pixel_rays(size[0] as f32 / size[1] as f32);
        Self { eye: camera.eye, forward: camera.forward(), rays: [right, down], shift: camera.shift }
    }

    /// Rows of the matrix from an instance's object space to the camera's: x to the right, y down, z along the view, world
    /// units, sheared by the shift, so that a pixel lies where its middle is.
    fn rows(&self, object_to_world: &Affine3A) -> [Vec4; 3] {
        let [right, down] = self.rays;
        let sheared = |ray: Vec3, shift: f32| ray.normalize() - self.forward * (shift * ray.length());
        let (x, y) = (sheared(right, self.shift.x), sheared(down, self.shift.y));
        let [x, y, z] = [x, y, self.forward].map(Vec3A::from);
        let turned = Mat3A::from_cols(x, y, z).transpose();
        rows(&Affine3A {
            matrix3: turned * object_to_world.matrix3,
            translation: turned * (object_to_world.translation - Vec3A::from(self.eye)),
        })
    }
}

/// Parameters of a set that was rendered, a texel; `set_at` in shaders/estimators/vpls/set_buffers.glsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
struct SetParameters {
    /// Irradiance over what its buffer holds.
    scale: f32,
    /// Luminous flux.
    flux: f32,
    /// Tangent of half the vertical field of view of the camera that rendered it.
    tan_y: f32,
    /// Bits 0 and 1: offset of the representative; to bit 15 its layer; from bit 16 on the low bits of the frame that rendered it.
    offset_layer_frame: u32,
}

/// Constants of lookups in the sets; `SetPush` in shaders/estimators/vpls/set_buffers.glsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct SetPush {
    /// Width and height of the pictures of the sets, pixels.
    pub size: [u32; 2],
    /// Pixels from one texel to the next.
    pub set_step: u32,
    /// Instances of the scene, and the world itself as the last.
    pub instance_count: u32,
    /// Sets in all.
    pub set_count: u32,
    /// The set that a view shows.
    pub shown_set: u32,
    /// 1: sets that saw the surface make up for those that did not.
    pub scale_missing: u32,
    /// Luminous flux of all sets.
    pub total_flux: f32,
    /// Number of the view.
    pub view: u32,
    /// Number of this frame, for a view.
    pub frame: u32,
    /// Pixels from one texel of the set that this frame renders to the next, for a view.
    pub rendered_step: u32,
    /// For shaders/estimators/vpls/irradiance_upsampling.comp: which pixels it fills.
    pub fill_mode: FillMode,
}

/// Which pixels an upsampling fills; by default all, from neighbours where no set saw them.
#[repr(transparent)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct FillMode(u32);

impl FillMode {
    /// Leaves the pixels that no set saw to other sets.
    pub const LEAVE: Self = Self(1);
    /// Fills only the pixels that other sets have left.
    pub const FILL: Self = Self(2);
}

/// The set that a frame renders.
#[derive(Clone, Copy, Debug)]
pub struct RenderedSet {
    /// Index.
    pub set: u32,
    /// See [`SetBuffers::representative`].
    pub representative: [u32; 2],
    /// Its buffer holds irradiance times this.
    pub irradiance_scale: f32,
    /// Luminous flux.
    pub flux: f32,
}

/// The set buffers with all that it takes to bring them into another view.
pub struct SetBuffers {
    /// A layer a set, and one to write while another is read. See shaders/estimators/vpls/representative.glsl.
    buffers: Image,
    /// The layer that no set has.
    spare: u32,
    /// The layer of each set.
    layers: Vec<u32>,
    /// Width and height of the picture, pixels.
    size: [u32; 2],
    /// Pixels from one texel to the next: 1 or 2.
    step: u32,
    /// [`SetParameters`] of each set, zero before it was first rendered, and where its camera saw all instances, then the world:
    /// [`SetView::rows`].
    views: Buffer,
    /// Luminous flux of each set, none before it was first rendered.
    flux: Vec<Option<f32>>,
    /// Number of instances, with the world itself.
    instances: usize,
}

/// Pixels from one texel of the set buffers to the next. Unless asked for, a window of one pixel would lose what lies between, and a
/// single set has no one to share the pixels with.
pub fn set_step(settings: &VplSettings) -> u32 {
    match settings.set_resolution {
        SetResolution::Auto if settings.temporal_sets > 1 && settings.interleave > 1 => 2,
        SetResolution::Auto | SetResolution::Full => 1,
        SetResolution::Half => 2,
    }
}

/// Set buffers are made of this alone, for a number of instances.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SetLayout {
    /// Width and height of the picture, pixels.
    pub size: [u32; 2],
    /// Temporal sets.
    pub sets: u32,
    /// Pixels from one texel to the next: 1 or 2.
    pub step: u32,
}

impl SetLayout {
    /// The part of the settings that set buffers see.
    pub fn of(settings: &Settings) -> Self {
        Self { size: settings.size, sets: settings.vpl.temporal_sets, step: set_step(&settings.vpl) }
    }
}

impl SetBuffers {
    /// Makes set buffers, none of them rendered yet.
    pub fn new(device: &Arc<Device>, layout: &SetLayout, instances: usize) -> Result<Self, VulkanError> {
        let SetLayout { size, sets, step } = *layout;
        let format = vk::Format::R16G16B16A16_UINT;
        let instances = instances + 1;
        let texels = sets as usize * (1 + 3 * instances);
        Ok(Self {
            buffers: storage_image_array(
                device,
                "set_buffers",
                format,
                size.map(|side| side.div_ceil(step)),
                sets + 1,
            )?,
            spare: sets,
            layers: (0..sets).collect(),
            size,
            step,
            views: Buffer::with_data(device, "set_views", &vec![Vec4::ZERO; texels])?.with_texels()?,
            flux: vec![None; sets as usize],
            instances,
        })
    }

    /// The set buffers.
    pub fn buffers(&self) -> &Image {
        &self.buffers
    }

    /// The parameters of the sets, and the transforms from all instances to the view of each set's camera.
    pub fn views(&self) -> &Buffer {
        &self.views
    }

    /// Pixels from one texel to the next.
    pub fn step(&self) -> u32 {
        self.step
    }

    /// How many sets there are.
    pub fn count(&self) -> u32 {
        to_u32(self.flux.len())
    }

    /// Whether every set has been rendered.
    pub fn is_complete(&self) -> bool {
        self.flux.iter().all(Option::is_some)
    }

    /// The pixel that texels stand for in a [phase](crate::passes::clock::FrameClock::checkerboard_phase) of the checkerboard, counted from the first of
    /// theirs.
    pub fn representative(&self, phase: u32) -> [u32; 2] {
        const OFFSETS: [[u32; 2]; 4] = [[0, 0], [1, 1], [1, 0], [0, 1]];
        if self.step == 1 { [0, 0] } else { OFFSETS[phase as usize % 4] }
    }

    /// The layer that the set to be rendered next is written to.
    pub fn target(&self) -> u32 {
        self.spare
    }

    /// Records the view, flux and layer of the set that this frame has rendered into [`Self::target`].
    pub fn mark_rendered(
        &mut self,
        frame: &mut Frame<'_>,
        inputs: &FrameInputs<'_>,
        rendered: &RenderedSet,
    ) -> Result<(), VulkanError> {
        let (pose, number) = (inputs.pose, inputs.clock.frame as u32);
        let view = SetView::new(&pose.camera, self.size);
        let [x, y] = rendered.representative;
        let rendered_layer = std::mem::replace(&mut self.spare, self.layers[rendered.set as usize]);
        self.layers[rendered.set as usize] = rendered_layer;
        let parameters = SetParameters {
            scale: 1.0 / rendered.irradiance_scale,
            flux: rendered.flux,
            tan_y: view.rays[1].length(),
            offset_layer_frame: x | y << 1 | rendered_layer << 2 | number << 16,
        };
        self.flux[rendered.set as usize] = Some(rendered.flux);
        let all = pose.instances.iter().chain([&Affine3A::IDENTITY]);
        let rows = all.flat_map(|instance| view.rows(instance));
        let texels: Vec<Vec4> = std::iter::once(bytemuck::cast(parameters)).chain(rows).collect();
        let upload = frame.upload(&texels)?;
        frame.copy(&upload, &self.views, rendered.set as u64 * size_of_val(texels.as_slice()) as u64);
        Ok(())
    }

    /// Constants of lookups. `set_flux`: luminous flux of each set now, for those that were not rendered yet.
    pub fn push(&self, missing_sets: MissingSets, set_flux: &[f32]) -> SetPush {
        let flux = |(set, rendered): (usize, &Option<f32>)| {
            rendered.unwrap_or_else(|| set_flux.get(set).copied().unwrap_or(0.0))
        };
        SetPush {
            size: self.size,
            set_step: self.step,
            instance_count: to_u32(self.instances),
            set_count: self.count(),
            scale_missing: u32::from(missing_sets == MissingSets::Scale),
            total_flux: self.flux.iter().enumerate().map(flux).sum(),
            ..SetPush::default()
        }
    }

    /// Binds what shaders/estimators/vpls/set_buffers.glsl names.
    pub fn bind<'f>(&'f self, pass: Pass<'f>) -> Pass<'f> {
        pass.read("set_buffers", &self.buffers).read("set_views", &self.views)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu_scene::structs::tests::same_layout;
    use crate::vulkan::shaders;

    #[test]
    fn structs_have_the_layout_of_the_shaders() {
        same_layout!(
            shaders::IRRADIANCE_UPSAMPLING_COMP,
            SetPush,
            size,
            set_step,
            instance_count,
            set_count,
            shown_set,
            scale_missing,
            total_flux,
            view,
            frame,
            rendered_step,
            fill_mode
        );
    }
}
