//! `effect_view`: shows one of the images that soft shadows and reflections go through in place of the picture.

use std::sync::Arc;

use super::buffer_view::View;
use crate::vulkan::{Buffer, ComputePipeline, Device, Frame, Image, Upload, VulkanError, shaders};

/// How an image is shown; twin: shaders/passes/effect_view.comp.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Visualization {
    /// rgb, from 0 to 1.
    Share,
    /// rgb, with the picture's exposure.
    Light,
    /// a, in grey.
    Deviation,
    /// b: frames; 32 are white.
    History,
    /// rgb, as on white surfaces, with the picture's exposure.
    Irradiance,
}

/// The views of soft shadows, then those of reflections; black where the effect is not in use.
pub const VIEWS: [View; 10] = [
    View {
        name: "shadow",
        label: "Soft shadows",
        about: "Light of all lights that arrives, over what would without shadows (--direct soft)",
    },
    View { name: "shadow-raw", label: "Soft shadows, raw", about: "The same as this frame's rays have it" },
    View {
        name: "shadow-temporal",
        label: "Soft shadows, history",
        about: "The same as it has accumulated over frames",
    },
    View {
        name: "shadow-variance",
        label: "Soft shadows, noise",
        about: "Standard deviation that the filter has left",
    },
    View {
        name: "shadow-history",
        label: "Soft shadows, frames",
        about: "Length of the history: black is none, white 32 frames and more",
    },
    View {
        name: "reflection",
        label: "Reflections",
        about: "Light that surfaces mirror, without their own colour (--reflections rays)",
    },
    View {
        name: "reflection-raw",
        label: "Reflections, raw",
        about: "The same as this frame's rays have it",
    },
    View {
        name: "reflection-temporal",
        label: "Reflections, history",
        about: "The same as it has accumulated over frames",
    },
    View {
        name: "reflection-variance",
        label: "Reflections, noise",
        about: "Standard deviation that the filter has left",
    },
    View {
        name: "reflection-history",
        label: "Reflections, frames",
        about: "Length of the history: black is none, white 32 frames and more",
    },
];

/// The pass.
pub struct EffectViewPass {
    pipeline: ComputePipeline,
}

impl EffectViewPass {
    /// Makes the pipeline.
    pub fn new(device: &Arc<Device>) -> Result<Self, VulkanError> {
        Ok(Self { pipeline: ComputePipeline::new(device, "effect_view", shaders::EFFECT_VIEW_COMP)? })
    }

    /// Writes an image over `display`, black where there is none.
    pub fn record(
        &self,
        frame: &mut Frame<'_>,
        uniforms: &Upload,
        image: Option<(&Image, Visualization)>,
        exposure: &Buffer,
        display: &Image,
    ) -> Result<(), VulkanError> {
        let Some((image, kind)) = image else {
            frame.clear_image(display, [0.0, 0.0, 0.0, 1.0]);
            return Ok(());
        };
        frame
            .pass("effect_view", &self.pipeline)
            .read("frame_uniforms", uniforms)
            .read("shown_image", image)
            .read("exposure", exposure)
            .write("display", display)
            .push(&(kind as u32))
            .dispatch_over(display.extent())
    }
}
