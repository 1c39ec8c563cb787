//! `cell_view`: shows the cells of the visible surfaces, or the whole hash map, in place of the picture.

use std::sync::Arc;

use super::cell_map::{CellBuffers, CellPush};
use crate::passes::buffer_view::View;
use crate::passes::frame_inputs::FrameInputs;
use crate::vulkan::{ComputePipeline, Device, Frame, Image, VulkanError, shaders};

/// The view of what filters are given, which estimators draw.
pub const RAW: &str = "paths-raw";

/// The views of cells, and [`RAW`]. A view's place in the list is its number in shaders/filters/cell_view.comp.
pub const VIEWS: [View; 7] = [
    View {
        name: "cells",
        label: "Cells",
        about: "A colour for each cell that the visible surfaces read (--filter)",
    },
    View { name: "cell-lod", label: "Cells: level of detail", about: "A colour for each size of cells" },
    View {
        name: "cell-samples",
        label: "Cells: samples",
        about: "Samples in the mean, by their logarithm, from black over blue and green to yellow (65,536); magenta: no cell",
    },
    View {
        name: "cell-age",
        label: "Cells: age",
        about: "Frames without samples: black is none, yellow evicts; magenta: no cell",
    },
    View {
        name: "cell-probes",
        label: "Cells: probes",
        about: "Slots that are passed before the cell is found: black is none, yellow all that are allowed; magenta: no cell",
    },
    View {
        name: "cell-occupancy",
        label: "Cells: occupancy",
        about: "The slots of the hash map in rows: black is free, yellow holds cells",
    },
    View {
        name: RAW,
        label: "Paths, raw",
        about: "Indirect irradiance by each pixel's own paths, before filters and denoisers",
    },
];

/// The pass.
pub struct CellViewPass {
    pipeline: ComputePipeline,
}

impl CellViewPass {
    /// Makes the pipeline for a filter with these constants of shaders/filters/cell_filter.glsl.
    pub fn new(device: &Arc<Device>, constants: &[u32]) -> Result<Self, VulkanError> {
        let pipeline = ComputePipeline::specialised(device, "cell_view", shaders::CELL_VIEW_COMP, constants)?;
        Ok(Self { pipeline })
    }

    /// Writes one of [`VIEWS`] over `display`.
    pub fn record(
        &self,
        frame: &mut Frame<'_>,
        inputs: &FrameInputs<'_>,
        (map, push): (&CellBuffers, CellPush),
        display: &Image,
        view: &str,
    ) -> Result<(), VulkanError> {
        let Some(number) = VIEWS.iter().position(|known| known.name == view) else { return Ok(()) };
        let pass = frame
            .pass("cell_view", &self.pipeline)
            .read("frame_uniforms", inputs.uniforms)
            .read("gbuffer_depth", &inputs.gbuffer.depth)
            .read("gbuffer_normal", &inputs.gbuffer.normal)
            .read("cell_ages", map.ages())
            .write("display", display)
            .push(&push.for_view(number as u32));
        map.bind(pass).dispatch_over(display.extent())
    }
}
