//! `buffer_view`: shows one of the images that every method's frame goes through in place of the picture.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use glam::{Vec3, Vec4};

use super::frame_inputs::FrameInputs;
use crate::scene::Camera;
use crate::vulkan::{Buffer, ComputePipeline, Device, Frame, Image, VulkanError, shaders};

/// A way to look at what a frame goes through. Light is tone-mapped with the picture's exposure, all else shown as plain
/// display values; black where no surface is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct View {
    /// As in `--view`.
    pub name: &'static str,
    /// A short name for people.
    pub label: &'static str,
    /// Description of the view.
    pub about: &'static str,
}

/// The picture itself.
pub const COMBINED: &str = "combined";

/// The views of what all methods share. A view's place in the list is its number in shaders/passes/buffer_view.comp.
pub const VIEWS: [View; 18] = [
    View { name: COMBINED, label: "Combined", about: "The picture: direct and indirect light" },
    View {
        name: "direct",
        label: "Direct light",
        about: "Light straight from point, spot and directional lights, and what surfaces emit",
    },
    View {
        name: "indirect",
        label: "Indirect light",
        about: "Indirect light that surfaces send to the eye: albedo/pi times irradiance",
    },
    View {
        name: "irradiance",
        label: "Indirect irradiance",
        about: "Indirect irradiance, as on white surfaces",
    },
    View {
        name: "direct-shadows",
        label: "Direct shadows",
        about: "What arrives of the lights at each pixel, on average: white sees all, thin surfaces tint",
    },
    View {
        name: "position",
        label: "Position",
        about: "World position within the bounds of the scene: x red, y green, z blue",
    },
    View { name: "depth", label: "Depth", about: "View depth: what may be nearest is white, farthest black" },
    View { name: "normal", label: "Normal", about: "Shading normals: x red, y green, z blue; 0 is half" },
    View {
        name: "geometric-normal",
        label: "Geometric normal",
        about: "Normals of the flat triangles, likewise",
    },
    View { name: "albedo", label: "Albedo", about: "Diffuse reflectance towards the eye" },
    View {
        name: "reflectance",
        label: "Reflectance",
        about: "What the smooth or rough coat reflects at normal incidence, F0",
    },
    View { name: "roughness", label: "Roughness", about: "Perceptual roughness: black is a mirror" },
    View { name: "base-colour", label: "Base colour", about: "Base colour of the material" },
    View { name: "metallic", label: "Metallic", about: "Share of metal: white is all" },
    View { name: "emission", label: "Emission", about: "Light that surfaces emit towards the eye" },
    View { name: "instance", label: "Instance", about: "A colour for each instance" },
    View { name: "material", label: "Material", about: "A colour for each material" },
    View {
        name: "motion",
        label: "Motion",
        about: "Movement since the last frame: right red, down green, half is none; the root of pixels, 16 are full",
    },
];

/// The number of one of [`VIEWS`].
pub fn number_of(name: &str) -> Option<u32> {
    VIEWS.iter().zip(0..).find(|(view, _)| view.name == name).map(|(_, number)| number)
}

/// Inputs and outputs of the pass.
pub struct BufferViewInputs<'a> {
    /// The frame's inputs.
    pub frame: &'a FrameInputs<'a>,
    /// Share of each light that reaches each pixel.
    pub direct_shadows: &'a Image,
    /// Direct radiance.
    pub direct: &'a Image,
    /// Indirect irradiance.
    pub irradiance: &'a Image,
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
    view: u32,
    pad: [u32; 3],
}

/// The pass.
pub struct BufferViewPass {
    pipeline: ComputePipeline,
}

impl BufferViewPass {
    /// Makes the pipeline, for a scene with thin surfaces or without.
    pub fn new(device: &Arc<Device>, thin_surfaces: bool) -> Result<Self, VulkanError> {
        let (shader, constants) = (shaders::BUFFER_VIEW_COMP, [u32::from(thin_surfaces)]);
        Ok(Self { pipeline: ComputePipeline::specialised(device, "buffer_view", shader, &constants)? })
    }

    /// Writes the view with this number over `display`.
    pub fn record(
        &self,
        frame: &mut Frame<'_>,
        view: u32,
        inputs: &BufferViewInputs<'_>,
        display: &Image,
    ) -> Result<(), VulkanError> {
        let gbuffer = inputs.frame.gbuffer;
        let (low, high) = inputs.bounds;
        let (nearest, farthest) = depths(&inputs.frame.pose.camera, inputs.bounds);
        let push = Push {
            low: low.extend(nearest),
            extent: (high - low).max(Vec3::splat(f32::MIN_POSITIVE)).extend(farthest),
            view,
            pad: [0; 3],
        };
        inputs
            .frame
            .bind(frame.pass("buffer_view", &self.pipeline))
            .read("gbuffer_albedo", &gbuffer.albedo)
            .read("gbuffer_instance", &gbuffer.instance)
            .read("gbuffer_surface", &gbuffer.surface)
            .read("gbuffer_motion", &gbuffer.motion)
            .read("direct_shadows", inputs.direct_shadows)
            .read("direct", inputs.direct)
            .read("irradiance", inputs.irradiance)
            .read("exposure", inputs.exposure)
            .write("display", display)
            .push(&push)
            .dispatch_over(display.extent())
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
