//! `indirect_reprojection`: all set buffers into the current view, each by the camera and the instance
//! transforms of the frame that drew it (algorithm 4 of Tonna 2019).

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};

use super::gbuffer::GBuffer;
use super::scene_buffers::Instances;
use super::set_history::{Redrawn, SetHistory, SetParameters, SetView, upload_parameters};
use super::storage_image;
use crate::scene::Pose;
use crate::vulkan::{ComputePipeline, Device, Frame, Image, Upload, VulkanError, shaders, vk};

/// Frames after which all running sums have been made anew. Twin: `REFRESHED` in shaders/indirect_reprojection.comp.
const REFRESHED: usize = 256;

/// What the pass reads.
pub struct ReprojectionInputs<'a> {
    /// Frame uniforms.
    pub frame: &'a Upload,
    /// The visible surfaces.
    pub gbuffer: &'a GBuffer,
    /// What the sets have drawn.
    pub sets: &'a SetHistory,
    /// Instances of this frame.
    pub instances: &'a Instances,
    /// Where everything stands.
    pub pose: &'a Pose,
    /// Fraction of view depth.
    pub position_cutoff: f32,
    /// Scale up what is there by total flux over present flux.
    pub scale_missing: bool,
    /// Luminous flux of each set now, for those that have never been drawn.
    pub set_flux: &'a [f32],
}

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Push {
    instance_count: u32,
    scale_missing: u32,
    total_flux: f32,
    drawn_count: u32,
    same_view_count: u32,
    set_count: u32,
    set_size: [u32; 2],
    running: u32,
    refresh: u32,
    first_row: u32,
    row_step: u32,
    layer_before: u32,
    layer_now: u32,
    scale_before: f32,
    scale_now: f32,
    first_texel: u32,
    pad: u32,
}

/// What the sums of a frame were made of.
struct Summed {
    /// Which sets.
    sets: Arc<()>,
    /// How often sets had been drawn.
    draws: u64,
    /// The camera.
    view: SetView,
    position_cutoff: f32,
    /// Frames in a row, with this one, in which nothing moved and only one set was different.
    still_frames: usize,
}

impl Summed {
    /// Whether nothing but one set is different from the frame before.
    fn follows(&self, last: &Self) -> bool {
        Arc::ptr_eq(&self.sets, &last.sets)
            && self.draws == last.draws + 1
            && self.view == last.view
            && self.position_cutoff == last.position_cutoff
    }
}

/// What differs between frames is known when a pipeline is made: CPU devices spend time on what no pixel needs, too.
struct Pipelines {
    /// While something moves.
    moving: ComputePipeline,
    /// When nothing that is seen has moved since a set was drawn.
    still: ComputePipeline,
    /// When, moreover, the sums of all pixels can go on.
    steady: ComputePipeline,
}

/// The pass.
pub struct IndirectReprojectionPass {
    pipelines: Arc<Pipelines>,
    irradiance: Image,
    /// What is in `irradiance`; none before the first frame.
    summed: Option<Summed>,
}

impl IndirectReprojectionPass {
    /// Makes the pipeline and its image of `extent` texels.
    pub fn new(device: &Arc<Device>, extent: [u32; 2]) -> Result<Self, VulkanError> {
        let pipeline = |moves, steady| {
            let spirv = shaders::INDIRECT_REPROJECTION_COMP;
            ComputePipeline::specialised(device, "indirect_reprojection", spirv, &[moves, steady])
        };
        Ok(Self {
            pipelines: Arc::new(Pipelines {
                moving: pipeline(1, 0)?,
                still: pipeline(0, 0)?,
                steady: pipeline(0, 1)?,
            }),
            irradiance: irradiance(device, extent)?,
            summed: None,
        })
    }

    /// The same pass for pictures of `extent` texels.
    pub fn resized(&self, device: &Arc<Device>, extent: [u32; 2]) -> Result<Self, VulkanError> {
        Ok(Self {
            pipelines: Arc::clone(&self.pipelines),
            irradiance: irradiance(device, extent)?,
            summed: None,
        })
    }

    /// Indirect irradiance of the last frame; a: how many sets had seen the pixel's surface, negative where that may
    /// move.
    pub fn output(&self) -> &Image {
        &self.irradiance
    }

    /// Brings all sets together.
    pub fn record(
        &mut self,
        frame: &mut Frame<'_>,
        inputs: &ReprojectionInputs<'_>,
    ) -> Result<&Image, VulkanError> {
        let (sets, extent) = (inputs.sets, self.irradiance.extent());
        let flux = |(set, drawn): (usize, &Option<SetParameters>)| {
            drawn.map_or(inputs.set_flux.get(set).copied().unwrap_or(0.0), |set| set.flux)
        };
        let total_flux = sets.parameters().iter().enumerate().map(flux).sum();
        let now = SetView::new(&inputs.pose.camera, extent);
        let set_size = sets.buffers().extent();
        let (same_view, other): (Vec<SetParameters>, Vec<SetParameters>) =
            sets.parameters().iter().flatten().partition(|set| set_size == extent && set.view == now);
        let moves = !other.is_empty() || inputs.instances.may_move;
        let mut summed = Summed {
            sets: Arc::clone(sets.identity()),
            draws: sets.draws(),
            view: now,
            position_cutoff: inputs.position_cutoff,
            still_frames: 0,
        };
        let last = self.summed.take().filter(|last| summed.follows(last));
        let redrawn =
            sets.redrawn().filter(|redrawn| last.is_some() && other.is_empty() && redrawn.before.view == now);
        if !moves {
            summed.still_frames = last.map_or(0, |last| last.still_frames) + 1;
        }
        let set_count = sets.parameters().len();
        // Every set has been drawn since, and every surface has been summed up with all of them.
        let steady = redrawn.is_some() && summed.still_frames > set_count;
        self.summed = Some(summed);
        let layer = |of: fn(&Redrawn) -> SetParameters| redrawn.map_or(0, |redrawn| of(redrawn).layer);
        let scale = |of: fn(&Redrawn) -> SetParameters| redrawn.map_or(0.0, |redrawn| of(redrawn).scale);
        let parameters = upload_parameters(frame, same_view.iter().chain(&other).copied())?;
        let push = Push {
            instance_count: to_u32(inputs.pose.instances.len()),
            scale_missing: u32::from(inputs.scale_missing),
            total_flux,
            drawn_count: to_u32(same_view.len() + other.len()),
            same_view_count: to_u32(same_view.len()),
            set_count: to_u32(set_count),
            set_size,
            running: u32::from(redrawn.is_some()),
            refresh: to_u32(sets.draws() as usize % REFRESHED),
            first_row: 0,
            row_step: 1,
            layer_before: layer(|redrawn| redrawn.before),
            layer_now: layer(|redrawn| redrawn.now),
            scale_before: scale(|redrawn| redrawn.before),
            scale_now: scale(|redrawn| redrawn.now),
            first_texel: parameters.first_texel(),
            pad: 0,
        };
        let mut dispatch = |pipeline, push: &Push| {
            let rows = (extent[1] - push.first_row).div_ceil(push.row_step);
            frame
                .pass("indirect_reprojection", pipeline)
                .read("frame_uniforms", inputs.frame)
                .read("gbuffer_depth", &inputs.gbuffer.depth)
                .read("gbuffer_normal", &inputs.gbuffer.normal)
                .read("gbuffer_instance", &inputs.gbuffer.instance)
                .read("set_buffers", sets.buffers())
                .read("drawn_sets", &parameters)
                .read("instances", &inputs.instances.data)
                .read("view_history", sets.views())
                .write("irradiance", &self.irradiance)
                .push(push)
                .dispatch_over([extent[0], rows])
        };
        let pipelines = &self.pipelines;
        if steady {
            dispatch(&pipelines.steady, &push)?;
            let anew = Push { running: 0, first_row: push.refresh, row_step: to_u32(REFRESHED), ..push };
            if anew.first_row < extent[1] {
                dispatch(&pipelines.still, &anew)?;
            }
        } else {
            dispatch(if moves { &pipelines.moving } else { &pipelines.still }, &push)?;
        }
        Ok(&self.irradiance)
    }
}

fn irradiance(device: &Arc<Device>, extent: [u32; 2]) -> Result<Image, VulkanError> {
    storage_image(device, "irradiance", vk::Format::R32G32B32A32_SFLOAT, extent)
}

fn to_u32(count: usize) -> u32 {
    u32::try_from(count).unwrap_or(u32::MAX)
}
