//! Filters in cells of space: a hash map on the device holds the mean irradiance of the vertices in each cell (Meijer 2019; HPSF and
//! nHPSF), also as a radiance cache that is read behind the visible surface alone.
//!
//! In: vertices of paths. Out: irradiance. The map's memory is 56 bytes a slot; shaders/include/cell_map.glsl has its layout.

use std::sync::Arc;

use glam::Affine3A;

use super::cell_map::{CellBuffers, CellPush};
use super::cell_view::CellViewPass;
use super::{FilterInputs, pixel_spread, vertices};
use crate::passes::frame_inputs::FrameInputs;
use crate::passes::hits::Hits;
use crate::passes::storage_image;
use crate::report::PassInfo;
use crate::scene::{Environment, Light, Pose};
use crate::settings::{CellSettings, PathFilter, Settings};
use crate::vulkan::{ComputePipeline, Device, Frame, Image, VulkanError, shaders, vk};

/// The passes, in the order of the frame.
pub const PASSES: [PassInfo; 4] = [
    PassInfo::new("cells_insert", [44, 130, 90]),
    PassInfo::new("cells_resolve", [90, 165, 120]),
    PassInfo::new("cells_read", [140, 195, 150]),
    PassInfo::new("cells_light_hits", [170, 215, 180]),
];

/// Names of the first counters of cells, in the order of shaders/filters/cell_counters.glsl.
pub const COUNTERS: [&str; 3] = ["cells.occupied", "cells.dropped", "cells.evicted"];
/// Names of the counters of paths that the next frame goes on with, by their vertices.
pub const KEPT: [&str; 16] = [
    "kept.1", "kept.2", "kept.3", "kept.4", "kept.5", "kept.6", "kept.7", "kept.8", "kept.9", "kept.10",
    "kept.11", "kept.12", "kept.13", "kept.14", "kept.15", "kept.16",
];
/// Where these counts begin. Twin: PATHS_KEPT in shaders/filters/cell_counters.glsl.
pub const FIRST_KEPT: usize = 8;
/// Words of all counters.
pub const COUNTER_WORDS: u64 = 32;

/// Frames that the mean of a cell is of while lights or objects change, and for how many frames afterwards.
const CHANGING_WINDOW: u32 = 2;
const CHANGING_FRAMES: u32 = 8;
/// Frames after a change in which a mean is of the newest frame alone, so that light that went from cell to cell is gone.
const FLUSHING_FRAMES: u32 = 4;

/// Growth of the window by each frame, where light of further bounces takes frames to arrive: a mean of all frames since would hold the
/// dark first ones too long, as it then nears the light of all bounces by a power of the frames of only 1 less the albedo.
const GROWTH: f32 = 0.25;

/// The filter.
pub struct CellFilter {
    settings: CellSettings,
    samples: u32,
    growth: f32,
    insert: ComputePipeline,
    resolve: ComputePipeline,
    read: ComputePipeline,
    /// Only of a cache.
    light_hits: Option<ComputePipeline>,
    map: CellBuffers,
    filtered: Image,
    lit_by: LitBy,
    constants: [u32; 5],
    view: Option<CellViewPass>,
}

/// Causes of the light in cells, to forget sooner what has changed.
#[derive(Default)]
struct LitBy {
    lights: Vec<Light>,
    environment: Option<Environment>,
    instances: Vec<Affine3A>,
    /// Frames since the last change; none before the first frame.
    since: Option<u32>,
}

impl LitBy {
    /// The most frames that a mean may be of, where light changes or did so a few frames ago.
    fn window(&mut self, pose: &Pose) -> Option<u32> {
        let is_same = self.lights == pose.lights
            && self.environment == pose.environment
            && self.instances == pose.instances;
        if !is_same {
            self.lights.clone_from(&pose.lights);
            self.environment.clone_from(&pose.environment);
            self.instances.clone_from(&pose.instances);
        }
        let since = match self.since {
            // The map is empty.
            None => CHANGING_FRAMES,
            Some(since) if is_same => since.saturating_add(1),
            Some(_) => 0,
        };
        self.since = Some(since);
        match since {
            1..=FLUSHING_FRAMES => Some(1),
            0..CHANGING_FRAMES => Some(CHANGING_WINDOW),
            _ => None,
        }
    }
}

impl CellFilter {
    pub(super) fn new(device: &Arc<Device>, settings: &Settings) -> Result<Self, VulkanError> {
        let count = vertices(settings);
        let is_cache = settings.paths.filter == PathFilter::Cache;
        // The light behind the last layer is not known, so its mean would be of the paths alone that end there.
        let last = count.saturating_sub(2);
        let cache = u32::from(is_cache);
        let continues = u32::from(settings.paths.filter.continues());
        let constants = [cache, last, count, cache, continues];
        let pipeline = |name, shader| ComputePipeline::specialised(device, name, shader, &constants);
        Ok(Self {
            settings: settings.cells,
            samples: settings.paths.samples,
            growth: if count == 0 { 1.0 } else { GROWTH },
            insert: pipeline("cells_insert", shaders::CELLS_INSERT_COMP)?,
            resolve: ComputePipeline::new(device, "cells_resolve", shaders::CELLS_RESOLVE_COMP)?,
            read: pipeline("cells_read", shaders::CELLS_READ_COMP)?,
            light_hits: if is_cache {
                Some(pipeline("cells_light_hits", shaders::CELLS_LIGHT_HITS_COMP)?)
            } else {
                None
            },
            map: CellBuffers::new(device, &settings.cells)?,
            filtered: storage_image(device, "filtered", vk::Format::R16G16B16A16_SFLOAT, settings.size)?,
            lit_by: LitBy::default(),
            constants,
            view: None,
        })
    }

    pub(super) fn forget(&mut self) {
        self.lit_by.since = Some(0);
    }

    /// Makes what [`Self::draw_view`] needs.
    pub(super) fn prepare_views(&mut self, device: &Arc<Device>) -> Result<(), VulkanError> {
        if self.view.is_none() {
            self.view = Some(CellViewPass::new(device, &self.constants)?);
        }
        Ok(())
    }

    pub(super) fn draw_view(
        &self,
        frame: &mut Frame<'_>,
        inputs: &FrameInputs<'_>,
        display: &Image,
        view: &str,
    ) -> Result<(), VulkanError> {
        let Some(pass) = &self.view else { return Ok(()) };
        pass.record(frame, inputs, (&self.map, self.push(inputs, None)), display, view)
    }

    pub(super) fn light_hits(
        &self,
        frame: &mut Frame<'_>,
        inputs: &FrameInputs<'_>,
        hits: &Hits<'_>,
    ) -> Result<(), VulkanError> {
        let Some(pipeline) = &self.light_hits else { return Ok(()) };
        self.map
            .bind(inputs.bind(frame.pass("cells_light_hits", pipeline)))
            .read("hit_place", hits.place)
            .write("hit_weight", hits.weight)
            .write("reflection", hits.reflection)
            .push(&self.push(inputs, None))
            .dispatch_over(hits.reflection.extent())
    }

    pub(super) fn output(&self) -> &Image {
        &self.filtered
    }

    fn push(&self, inputs: &FrameInputs<'_>, window: Option<u32>) -> CellPush {
        CellPush {
            spread: self.settings.width * pixel_spread(inputs, self.filtered.extent()),
            widening: self.settings.widening,
            jitter: self.settings.jitter,
            jitters: self.settings.jitters,
            bits: self.settings.normal_bits,
            normal: self.settings.normal as u32,
            probes: self.settings.probes,
            levels: self.settings.levels,
            samples: self.samples,
            window: window.unwrap_or(self.settings.window),
            growth: self.growth,
            life: self.settings.life,
            view: 0,
        }
    }

    pub(super) fn record(
        &mut self,
        frame: &mut Frame<'_>,
        inputs: &FrameInputs<'_>,
        filter: &FilterInputs<'_>,
    ) -> Result<(), VulkanError> {
        self.map.clear_once(frame);
        let window = self.lit_by.window(inputs.pose);
        let push = self.push(inputs, window);
        let extent = self.filtered.extent();
        let pass = inputs.bind(frame.pass("cells_insert", &self.insert));
        self.map
            .bind(pass)
            .read("irradiance", filter.irradiance)
            .write("path_places", &filter.vertices.places)
            .write("path_lights", &filter.vertices.lights)
            .read("path_depths", &filter.vertices.depths)
            .write("ray_counters", filter.counters)
            .push(&push)
            .dispatch_over(extent)?;
        self.map
            .bind(frame.pass("cells_resolve", &self.resolve))
            .write("cell_ages", self.map.ages())
            .write("ray_counters", filter.counters)
            .push(&push)
            .dispatch_threads([self.map.capacity, 1, 1])?;
        let pass = inputs.bind(frame.pass("cells_read", &self.read));
        self.map
            .bind(pass)
            .read("irradiance", filter.irradiance)
            .read("path_places", &filter.vertices.places)
            .read("path_lights", &filter.vertices.lights)
            .write("filtered", &self.filtered)
            .push(&push)
            .dispatch_over(extent)
    }
}
