//! `direct_shadows`: what arrives of each light at each pixel, by one ray for each light that it faces.
//!
//! In: the visible surfaces and the lights. Out: a bit for each light or, in scenes with thin sheets, the colour that these let pass. Exact where shadow maps would need a bias: neither leaks
//! through walls without thickness nor loses shadows under a grazing light.

use std::sync::Arc;

use super::gbuffer::GBuffer;
use super::skip::{LastInputs, Version};
use super::storage_image_array;
use super::structs::LightData;
use super::to_u32;
use super::tracer::{Tracer, TracerVariant};
use crate::scene::{Light, LightKind, Pose};
use crate::vulkan::{ComputePipeline, Device, Frame, Image, Upload, VulkanError, shaders, vk};

/// Lights of which a texel of one layer tells. Twin: `LIGHTS_PER_LAYER` in shaders/include/lights.glsl.
fn lights_per_layer(sheets: bool) -> usize {
    if sheets { 1 } else { 32 }
}

/// What the pass reads.
pub struct DirectShadowsInputs<'a> {
    /// Frame uniforms.
    pub frame: &'a Upload,
    /// The visible surfaces.
    pub gbuffer: &'a GBuffer,
    /// What casts the rays.
    pub tracer: &'a Tracer,
    /// Of the instances, which cast the shadows.
    pub instances: Version,
    /// The lights.
    pub lights: &'a [LightData],
    /// The same on the device.
    pub uploaded_lights: &'a Upload,
}

/// What the output depends on.
#[derive(PartialEq)]
struct Key {
    gbuffer: Version,
    instances: Version,
    lights: Vec<LightData>,
}

/// The pass.
pub struct DirectShadowsPass {
    tracer: TracerVariant,
    pipeline: ComputePipeline,
    /// Bit i of layer l: whether the pixel sees light 32 l + i; with sheets, layer i: what arrives of light i, packed.
    visibility: Image,
    last: LastInputs<Key>,
    device: Arc<Device>,
}

impl DirectShadowsPass {
    /// Makes the pipeline for a tracer, and the image of `extent` texels.
    pub fn new(device: &Arc<Device>, tracer: TracerVariant, extent: [u32; 2]) -> Result<Self, VulkanError> {
        let pipeline = tracer.pipeline(device, "direct_shadows", shaders::DIRECT_SHADOWS_COMP, &[])?;
        Ok(Self {
            tracer,
            pipeline,
            visibility: visibility(device, extent, 1)?,
            last: LastInputs::default(),
            device: Arc::clone(device),
        })
    }

    /// What the last frame wrote.
    pub fn output(&self) -> &Image {
        &self.visibility
    }

    /// Of the output.
    pub fn version(&self) -> Version {
        self.last.version()
    }

    /// Casts the rays.
    pub fn record(
        &mut self,
        frame: &mut Frame<'_>,
        inputs: &DirectShadowsInputs<'_>,
    ) -> Result<&Image, VulkanError> {
        self.make_room(inputs.lights.len())?;
        let gbuffer = inputs.gbuffer;
        let key =
            Key { gbuffer: gbuffer.version(), instances: inputs.instances, lights: inputs.lights.to_vec() };
        if self.last.differ(key) && !inputs.lights.is_empty() {
            let pass = frame
                .pass("direct_shadows", &self.pipeline)
                .read("frame_uniforms", inputs.frame)
                .read("gbuffer_depth", &gbuffer.depth)
                .read("gbuffer_normal", &gbuffer.normal)
                .read("lights", inputs.uploaded_lights)
                .write("direct_shadows", &self.visibility);
            inputs.tracer.bind(pass).dispatch_over(self.visibility.extent())?;
        }
        Ok(&self.visibility)
    }

    fn make_room(&mut self, lights: usize) -> Result<(), VulkanError> {
        let layers = to_u32(lights.div_ceil(lights_per_layer(self.tracer.sheets)));
        if layers > self.visibility.layers() {
            // Frames on their way still read the old image.
            self.device.wait_idle()?;
            self.visibility = visibility(&self.device, self.visibility.extent(), layers)?;
        }
        Ok(())
    }
}

fn visibility(device: &Arc<Device>, extent: [u32; 2], layers: u32) -> Result<Image, VulkanError> {
    storage_image_array(device, "direct_shadows", vk::Format::R32_UINT, extent, layers)
}

/// The lights of a pose that have no area, in the scene's order; with their extent where shadows are soft.
pub fn lights_of(pose: &Pose, soft: bool) -> Vec<LightData> {
    let extent =
        |light: LightData| if soft { light } else { LightData { radius: 0.0, half_angle: 0.0, ..light } };
    pose.lights.iter().filter_map(light_data).map(extent).collect()
}

fn light_data(light: &Light) -> Option<LightData> {
    let (kind, power, inner, outer) = match light.kind {
        LightKind::Point { intensity } => (0, intensity, 0.0, 0.0),
        LightKind::Spot { intensity, inner_angle, outer_angle } => {
            (1, intensity, inner_angle.cos(), outer_angle.cos())
        }
        LightKind::Directional { irradiance } => (2, irradiance, 0.0, 0.0),
        LightKind::Area { .. } => return None,
    };
    Some(LightData {
        position: light.position.extend(inner),
        direction: light.direction.extend(outer),
        power: power.extend(0.0),
        kind,
        radius: light.radius,
        half_angle: light.half_angle,
        ..LightData::default()
    })
}
