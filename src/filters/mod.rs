//! Path-space filters (Meijer 2019): they share the light of paths among vertices that lie near each other, on screen or in cells of space.
//!
//! In: irradiance of the visible surfaces by paths, and the vertices of these. Out: irradiance. They know nothing of how paths are traced.

mod cell_map;
mod cell_view;
mod cells;
mod window;

use std::sync::Arc;

pub use cell_view::{RAW, VIEWS};
pub use cells::{COUNTER_WORDS, COUNTERS, FIRST_KEPT, KEPT, PASSES as CELL_PASSES};

use crate::passes::frame_inputs::FrameInputs;
use crate::passes::hits::Hits;
use crate::passes::{storage_image, storage_image_array};
use crate::report::PassInfo;
use crate::settings::{PathFilter, Settings};
use crate::vulkan::{Buffer, Device, Frame, Image, VulkanError, vk};
use cells::CellFilter;
use window::WindowFilter;

/// The pass of the filter in screen space.
pub const WINDOW_PASS: PassInfo = PassInfo::new("sspsf", [120, 170, 110]);

/// Layers of vertices that a path leaves at most: the visible surface, two behind it, and where the last ray ends.
const MOST_VERTICES: u32 = 4;
/// Layers behind those: the vertex that a path of earlier frames goes on from, and the one that it meets.
const CONTINUED: u32 = 2;

/// The vertices of the paths of a frame: shaders/include/path_vertices.glsl.
pub struct PathVertices {
    /// RGBA32UI.
    pub places: Image,
    /// RG32UI.
    pub lights: Image,
    /// Number in its path, from 1, of the vertex that the next frame goes on from; 0: the path begins anew. R32UI.
    pub depths: Image,
}

impl PathVertices {
    /// Makes the images, if the filter of these settings reads them: 24 bytes for each pixel, path and vertex, and 52 a pixel for a path
    /// that frames go on with.
    pub fn new(device: &Arc<Device>, settings: &Settings) -> Result<Self, VulkanError> {
        let continues = settings.paths.filter.continues();
        let layers = vertices(settings) * settings.paths.samples + if continues { CONTINUED } else { 0 };
        // Without a filter that reads them, one is bound and not written.
        let (extent, layers) = if layers > 0 { (settings.size, layers) } else { ([1, 1], 1) };
        let image = |name, format| storage_image_array(device, name, format, extent, layers);
        Ok(Self {
            places: image("path_places", vk::Format::R32G32B32A32_UINT)?,
            lights: image("path_lights", vk::Format::R32G32_UINT)?,
            depths: storage_image(
                device,
                "path_depths",
                vk::Format::R32_UINT,
                if continues { settings.size } else { [1, 1] },
            )?,
        })
    }
}

/// Layers of the vertices of one path that the filter of these settings asks for.
pub fn vertices(settings: &Settings) -> u32 {
    match settings.paths.filter {
        PathFilter::None | PathFilter::Sspsf | PathFilter::Hpsf => 0,
        PathFilter::Nhpsf | PathFilter::ANhpsf | PathFilter::Cache => {
            (settings.bounces + 2).min(MOST_VERTICES)
        }
    }
}

/// Inputs of a filter for one frame.
pub struct FilterInputs<'a> {
    /// Irradiance of the visible surfaces by their own paths, RGBA16F.
    pub irradiance: &'a Image,
    /// The vertices of the paths, which the filter may overwrite.
    pub vertices: &'a PathVertices,
    /// The counters of rays, with [`COUNTER_WORDS`] for those of cells behind them.
    pub counters: &'a Buffer,
}

/// A filter.
pub enum Filter {
    /// In screen space.
    Window(WindowFilter),
    /// In cells of space.
    Cells(Box<CellFilter>),
}

impl Filter {
    /// Makes the filter that the settings name, if any.
    ///
    /// # Errors
    /// Where the device lacks memory.
    pub fn new(device: &Arc<Device>, settings: &Settings) -> Result<Option<Self>, VulkanError> {
        Ok(match settings.paths.filter {
            PathFilter::None => None,
            PathFilter::Sspsf => Some(Self::Window(WindowFilter::new(device, settings.size)?)),
            _ => Some(Self::Cells(Box::new(CellFilter::new(device, settings)?))),
        })
    }

    /// Filters the irradiance of a frame.
    ///
    /// # Errors
    /// Where the device fails.
    pub fn record(
        &mut self,
        frame: &mut Frame<'_>,
        inputs: &FrameInputs<'_>,
        filter: &FilterInputs<'_>,
    ) -> Result<(), VulkanError> {
        match self {
            Self::Window(window) => window.record(frame, inputs, filter.irradiance),
            Self::Cells(cells) => cells.record(frame, inputs, filter),
        }
    }

    /// Lights what reflection rays have hit by the light that it holds, direct light included; hits that are lit have no weight any more.
    ///
    /// # Errors
    /// Where the device fails.
    pub fn light_hits(
        &self,
        frame: &mut Frame<'_>,
        inputs: &FrameInputs<'_>,
        hits: &Hits<'_>,
    ) -> Result<(), VulkanError> {
        match self {
            Self::Window(_) => Ok(()),
            Self::Cells(cells) => cells.light_hits(frame, inputs, hits),
        }
    }

    /// Forgets the light of earlier frames as after a change of lights: materials have changed.
    pub fn forget(&mut self) {
        if let Self::Cells(cells) = self {
            cells.forget();
        }
    }

    /// Makes what [`Self::draw_view`] needs.
    ///
    /// # Errors
    /// Where the device fails.
    pub fn prepare_views(&mut self, device: &Arc<Device>) -> Result<(), VulkanError> {
        match self {
            Self::Window(_) => Ok(()),
            Self::Cells(cells) => cells.prepare_views(device),
        }
    }

    /// Writes one of [`VIEWS`] over `display`, where there are cells.
    ///
    /// # Errors
    /// Where the device fails.
    pub fn draw_view(
        &self,
        frame: &mut Frame<'_>,
        inputs: &FrameInputs<'_>,
        display: &Image,
        view: &str,
    ) -> Result<(), VulkanError> {
        match self {
            Self::Window(_) => Ok(()),
            Self::Cells(cells) => cells.draw_view(frame, inputs, display, view),
        }
    }

    /// The filtered irradiance of the last frame, RGBA16F.
    pub fn output(&self) -> &Image {
        match self {
            Self::Window(window) => window.output(),
            Self::Cells(cells) => cells.output(),
        }
    }
}

/// Width of a pixel at a distance of 1.
fn pixel_spread(inputs: &FrameInputs<'_>, extent: [u32; 2]) -> f32 {
    2.0 * (inputs.pose.camera.vertical_fov * 0.5).tan() / extent[1] as f32
}
