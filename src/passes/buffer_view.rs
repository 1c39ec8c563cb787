//! `buffer_view`: shows one of the images that a frame goes through in place of the picture.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use glam::{Vec3, Vec4};
use serde::{Deserialize, Serialize};

use super::direct_shadows::Shadows;
use super::gbuffer::GBuffer;
use super::set_history::{SetHistory, upload_parameters};
use super::to_u32;
use crate::scene::{Camera, Pose};
use crate::vulkan::{Buffer, ComputePipeline, Device, Frame, Image, Upload, VulkanError, shaders};

/// What to show. Light is tone-mapped with the picture's exposure, all else shown as plain display values;
/// black where no surface is. Twin of the constants in shaders/buffer_view.comp.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum BufferView {
    /// The picture: direct and indirect light.
    #[default]
    Combined,
    /// Light straight from point, spot and directional lights, and what surfaces emit.
    Direct,
    /// Indirect light that surfaces send to the eye: albedo/pi times irradiance.
    Indirect,
    /// Indirect irradiance, as on white surfaces.
    Irradiance,
    /// What this frame gathered before the filter: each pixel has the VPLs of its own class only.
    Unfiltered,
    /// The set buffer of this frame: what it gathered, after the filter.
    Filtered,
    /// The buffer of a set as it was drawn, by the camera of that time.
    SetBuffer,
    /// The buffer of a set brought into the current view; magenta where it has not seen the surface.
    SetReprojected,
    /// How many of the sets have seen each pixel's surface: from black (none) over blue and green to yellow (all).
    SetCount,
    /// Which pixels the single VPL sees: white.
    VplVisibility,
    /// The shadow maps of all lights; nearer is lighter.
    ShadowMaps,
    /// World position within the bounds of the scene: x red, y green, z blue.
    Position,
    /// View depth: what may be nearest is white, farthest black.
    Depth,
    /// Shading normals: x red, y green, z blue; 0 is half.
    Normal,
    /// Normals of the flat triangles, likewise.
    GeometricNormal,
    /// Diffuse reflectance Kd.
    Albedo,
    /// Specular reflectance Ks.
    Specular,
    /// Exponent Ns of the highlight: log2(Ns + 1) / 10.
    Shininess,
    /// A colour for each instance.
    Instance,
    /// A colour for each material.
    Material,
    /// Movement since the last frame: right red, down green, half is none; the root of pixels, 16 are full.
    Motion,
}

impl BufferView {
    /// All views, in the order in which they are offered.
    pub const ALL: [Self; 21] = [
        Self::Combined,
        Self::Direct,
        Self::Indirect,
        Self::Irradiance,
        Self::Unfiltered,
        Self::Filtered,
        Self::SetBuffer,
        Self::SetReprojected,
        Self::SetCount,
        Self::VplVisibility,
        Self::ShadowMaps,
        Self::Position,
        Self::Depth,
        Self::Normal,
        Self::GeometricNormal,
        Self::Albedo,
        Self::Specular,
        Self::Shininess,
        Self::Instance,
        Self::Material,
        Self::Motion,
    ];

    /// A short name for people.
    pub fn label(self) -> &'static str {
        match self {
            Self::Combined => "Combined",
            Self::Direct => "Direct light",
            Self::Indirect => "Indirect light",
            Self::Irradiance => "Indirect irradiance",
            Self::Unfiltered => "This set, before the filter",
            Self::Filtered => "This set, after the filter",
            Self::SetBuffer => "Set buffer as drawn",
            Self::SetReprojected => "Set buffer reprojected",
            Self::SetCount => "Valid sets per pixel",
            Self::VplVisibility => "Visibility of a VPL",
            Self::ShadowMaps => "Shadow maps",
            Self::Position => "Position",
            Self::Depth => "Depth",
            Self::Normal => "Normal",
            Self::GeometricNormal => "Geometric normal",
            Self::Albedo => "Albedo",
            Self::Specular => "Specular",
            Self::Shininess => "Shininess",
            Self::Instance => "Instance",
            Self::Material => "Material",
            Self::Motion => "Motion",
        }
    }
}

/// What the pass reads and writes.
pub struct BufferViewInputs<'a> {
    /// Frame uniforms.
    pub frame: &'a Upload,
    /// The visible surfaces.
    pub gbuffer: &'a GBuffer,
    /// Materials of the scene.
    pub materials: &'a Buffer,
    /// Shadow maps.
    pub shadows: &'a Shadows<'a>,
    /// Direct radiance.
    pub direct: &'a Image,
    /// Indirect irradiance, or that of one VPL.
    pub irradiance: &'a Image,
    /// Whether it is that of one VPL.
    pub one_vpl: bool,
    /// Irradiance before the filter.
    pub class_irradiance: &'a Buffer,
    /// What the sets have drawn.
    pub sets: &'a SetHistory,
    /// Which of them to show.
    pub set: u32,
    /// Interleave n.
    pub interleave: u32,
    /// Instances of this frame.
    pub instances: &'a Buffer,
    /// Where everything stands.
    pub pose: &'a Pose,
    /// World-space bounds of all that is visible.
    pub bounds: (Vec3, Vec3),
    /// Factor of the picture's exposure.
    pub exposure: &'a Buffer,
}

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Push {
    low: Vec4,
    extent: Vec4,
    set_size: [u32; 2],
    view: u32,
    set_count: u32,
    set_drawn: u32,
    instance_count: u32,
    tile_size: u32,
    tile_count: u32,
    tile_columns: u32,
    unfiltered: f32,
    one_vpl: u32,
    first_texel: u32,
}

/// The pass.
pub struct BufferViewPass {
    pipeline: ComputePipeline,
}

impl BufferViewPass {
    /// Makes the pipeline.
    pub fn new(device: &Arc<Device>) -> Result<Self, VulkanError> {
        Ok(Self { pipeline: ComputePipeline::new(device, "buffer_view", shaders::BUFFER_VIEW_COMP)? })
    }

    /// Writes `view` over `display`.
    pub fn record(
        &self,
        frame: &mut Frame<'_>,
        view: BufferView,
        inputs: &BufferViewInputs<'_>,
        display: &Image,
    ) -> Result<(), VulkanError> {
        let BufferViewInputs { gbuffer, shadows, sets, .. } = inputs;
        let set = sets.parameters().get(inputs.set as usize).copied().flatten();
        let parameters = upload_parameters(frame, set)?;
        frame
            .pass("buffer_view", &self.pipeline)
            .read("frame_uniforms", inputs.frame)
            .read("gbuffer_depth", &gbuffer.depth)
            .read("gbuffer_normal", &gbuffer.normal)
            .read("gbuffer_albedo", &gbuffer.albedo)
            .read("materials", inputs.materials)
            .read("gbuffer_instance", &gbuffer.instance)
            .read("direct", inputs.direct)
            .read("irradiance", inputs.irradiance)
            .read("class_irradiance", inputs.class_irradiance)
            .read("set_buffers", sets.buffers())
            .read("drawn_sets", &parameters)
            .read("view_history", sets.views())
            .read("instances", inputs.instances)
            .read("shadow_atlas", shadows.atlas)
            .read("shadow_tiles", &shadows.tiles)
            .read("exposure", inputs.exposure)
            .write("display", display)
            .push(&Push { first_texel: parameters.first_texel(), ..push(view, inputs, set.is_some()) })
            .dispatch_over(display.extent())
    }
}

fn push(view: BufferView, inputs: &BufferViewInputs<'_>, set_drawn: bool) -> Push {
    let (low, high) = inputs.bounds;
    let (nearest, farthest) = depths(&inputs.pose.camera, inputs.bounds);
    let set_count = to_u32(inputs.sets.parameters().len());
    Push {
        low: low.extend(nearest),
        extent: (high - low).max(Vec3::splat(f32::MIN_POSITIVE)).extend(farthest),
        set_size: inputs.sets.extent(),
        // What this frame drew is one of the sets.
        view: if view == BufferView::Filtered { BufferView::SetBuffer } else { view } as u32,
        set_count,
        set_drawn: u32::from(set_drawn),
        instance_count: to_u32(inputs.pose.instances.len()),
        tile_size: inputs.shadows.tile_size,
        tile_count: inputs.shadows.tile_count,
        tile_columns: inputs.shadows.tile_columns,
        unfiltered: (set_count * inputs.interleave * inputs.interleave) as f32,
        one_vpl: u32::from(inputs.one_vpl),
        first_texel: 0,
    }
}

/// The depths between which everything within the bounds lies, in front of the camera.
fn depths(camera: &Camera, (low, high): (Vec3, Vec3)) -> (f32, f32) {
    let (middle, half) = ((low + high) * 0.5, (high - low) * 0.5);
    let forward = camera.forward();
    let (depth, reach) = ((middle - camera.eye).dot(forward), half.dot(forward.abs()));
    let nearest = (depth - reach).max(camera.near);
    (nearest, (depth + reach).max(nearest * 1.001))
}
