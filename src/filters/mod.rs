//! Path-space filters (Meijer 2019): they share the light of paths among vertices that lie near each other, on screen or in cells of space.
//!
//! In: irradiance of the visible surfaces by paths, and the vertices of these. Out: irradiance. They know nothing of how paths are traced.

mod cells;
mod window;

use std::sync::Arc;

pub use cells::{COUNTER_WORDS, COUNTERS, PASSES as CELL_PASSES};

use crate::passes::frame_inputs::FrameInputs;
use crate::passes::storage_image_array;
use crate::report::PassInfo;
use crate::settings::{PathFilter, Settings};
use crate::vulkan::{Buffer, Device, Frame, Image, VulkanError, vk};
use cells::CellFilter;
use window::WindowFilter;

/// The pass of the filter in screen space.
pub const WINDOW_PASS: PassInfo = PassInfo::new("sspsf", [120, 170, 110]);

/// Layers of vertices that a path leaves at most: the visible surface, two behind it, and where the last ray ends.
const MOST_VERTICES: u32 = 4;

/// The vertices of the paths of a frame: shaders/include/path_vertices.glsl.
pub struct PathVertices {
    /// RGBA32UI.
    pub places: Image,
    /// RG32UI.
    pub lights: Image,
}

impl PathVertices {
    /// Makes the images, if the filter of these settings reads them: 24 bytes for each pixel, path and vertex.
    pub fn new(device: &Arc<Device>, settings: &Settings) -> Result<Self, VulkanError> {
        let layers = vertices(settings) * settings.paths.samples;
        // Without a filter that reads them, one is bound and not written.
        let (extent, layers) = if layers > 0 { (settings.size, layers) } else { ([1, 1], 1) };
        let image = |name, format| storage_image_array(device, name, format, extent, layers);
        Ok(Self {
            places: image("path_places", vk::Format::R32G32B32A32_UINT)?,
            lights: image("path_lights", vk::Format::R32G32_UINT)?,
        })
    }
}

/// Layers of the vertices of one path that the filter of these settings asks for.
pub fn vertices(settings: &Settings) -> u32 {
    match settings.paths.filter {
        PathFilter::None | PathFilter::Sspsf | PathFilter::Hpsf => 0,
        PathFilter::Nhpsf | PathFilter::Cache => (settings.bounces + 2).min(MOST_VERTICES),
    }
}

/// What a filter reads of a frame.
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

    /// Forgets the light of earlier frames as after a change of lights: materials have changed.
    pub fn forget(&mut self) {
        if let Self::Cells(cells) = self {
            cells.forget();
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

/// What a pixel spreads to over a distance of 1.
fn pixel_spread(inputs: &FrameInputs<'_>, extent: [u32; 2]) -> f32 {
    2.0 * (inputs.pose.camera.vertical_fov * 0.5).tan() / extent[1] as f32
}
