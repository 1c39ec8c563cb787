//! `indirect_reprojection`: all set buffers into the current view, each by the camera and the instance
//! transforms of the frame that drew it (algorithm 4 of Tonna 2019).

use std::collections::{BTreeSet, VecDeque};
use std::sync::Arc;

use bytemuck::{Pod, Zeroable};

use super::gbuffer::Surfaces;
use super::scene_buffers::Instances;
use super::set_history::{Redrawn, SetHistory, SetParameters, SetView, upload_parameters};
use super::{rows_of_thread, storage_image, to_u32};
use crate::scene::Pose;
use crate::vulkan::{Area, ComputePipeline, Device, Frame, Image, Upload, VulkanError, shaders, vk};

/// Frames after which all running sums have been made anew. Twin: `REFRESHED` in shaders/indirect_reprojection.comp.
const REFRESHED: usize = 1024;

/// What the pass reads.
pub struct ReprojectionInputs<'a> {
    /// Frame uniforms.
    pub frame: &'a Upload,
    /// The visible surfaces.
    pub surfaces: Surfaces<'a>,
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
    first: [u32; 2],
    end: [u32; 2],
    anew_first: [u32; 2],
    anew_end: [u32; 2],
    set_size: [u32; 2],
    row_step: u32,
    running: u32,
    refresh: u32,
    instance_count: u32,
    scale_missing: u32,
    total_flux: f32,
    set_count: u32,
    drawn_count: u32,
    same_view_count: u32,
    first_texel: u32,
    layer_before: u32,
    layer_now: u32,
    scale_before: f32,
    scale_now: f32,
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
    /// The instances that were not as in the frame before.
    moved: BTreeSet<usize>,
    /// Where surfaces, or how they are summed up, have changed in this frame and those before, as long as not every set has
    /// been drawn since; the latest last.
    changes: VecDeque<Area>,
}

impl Summed {
    /// Whether nothing but one set is different from the frame before.
    fn follows(&self, last: &Self) -> bool {
        Arc::ptr_eq(&self.sets, &last.sets)
            && self.draws == last.draws + 1
            && self.view == last.view
            && self.position_cutoff == last.position_cutoff
    }

    /// Where not every set has been drawn since the last change.
    fn unsettled(&self) -> Area {
        self.changes.iter().copied().fold(Area::default(), Area::union)
    }
}

/// What differs between pixels is known when a pipeline is made: CPU devices spend time on what no pixel needs, too.
struct Pipelines {
    /// Where something that is seen may have moved since a set was drawn.
    moving: ComputePipeline,
    /// Where nothing has.
    still: ComputePipeline,
    /// Where, moreover, all sums can go on.
    steady: ComputePipeline,
}

/// The pass.
pub struct IndirectReprojectionPass {
    pipelines: Arc<Pipelines>,
    irradiance: Image,
    /// Pixels of a thread. Twin: `ROWS` in shaders/indirect_reprojection.comp.
    rows: u32,
    /// What is in `irradiance`; none before the first frame.
    summed: Option<Summed>,
}

impl IndirectReprojectionPass {
    /// Makes the pipeline and its image of `extent` texels.
    pub fn new(device: &Arc<Device>, extent: [u32; 2]) -> Result<Self, VulkanError> {
        let rows = rows_of_thread(device);
        let pipeline = |moves, steady| {
            let spirv = shaders::INDIRECT_REPROJECTION_COMP;
            ComputePipeline::specialised(device, "indirect_reprojection", spirv, &[moves, steady, rows])
        };
        Ok(Self {
            pipelines: Arc::new(Pipelines {
                moving: pipeline(1, 0)?,
                still: pipeline(0, 0)?,
                steady: pipeline(0, 1)?,
            }),
            irradiance: irradiance(device, extent)?,
            rows,
            summed: None,
        })
    }

    /// The same pass for pictures of `extent` texels.
    pub fn resized(&self, device: &Arc<Device>, extent: [u32; 2]) -> Result<Self, VulkanError> {
        Ok(Self {
            pipelines: Arc::clone(&self.pipelines),
            irradiance: irradiance(device, extent)?,
            rows: self.rows,
            summed: None,
        })
    }

    /// Indirect irradiance of the last frame; a: how many sets had seen the pixel's surface, negative where it may move.
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
        let view = SetView::new(&inputs.pose.camera, extent);
        let set_size = sets.extent();
        let (same_view, other): (Vec<SetParameters>, Vec<SetParameters>) =
            sets.parameters().iter().flatten().partition(|set| set_size == extent && set.view == view);
        // Only there is there anything to follow.
        let movers = if other.is_empty() { inputs.surfaces.movers } else { Area::whole(extent) };
        let step = self.step(inputs, view);
        let parameters = upload_parameters(frame, same_view.iter().chain(&other).copied())?;
        let push = Push {
            running: u32::from(step.redrawn.is_some() && other.is_empty()),
            drawn_count: to_u32(same_view.len() + other.len()),
            same_view_count: to_u32(same_view.len()),
            first_texel: parameters.first_texel(),
            ..push(inputs, &step)
        };
        let mut dispatch = |pipeline, area: Area, push: Push| {
            let [width, height] = area.extent;
            frame
                .pass("indirect_reprojection", pipeline)
                .read("frame_uniforms", inputs.frame)
                .read("gbuffer_depth", &inputs.surfaces.gbuffer.depth)
                .read("gbuffer_normal", &inputs.surfaces.gbuffer.normal)
                .read("gbuffer_instance", &inputs.surfaces.gbuffer.instance)
                .read("set_buffers", sets.buffers())
                .read("drawn_sets", &parameters)
                .read("instances", &*inputs.instances.data)
                .read("view_history", sets.views())
                .write("irradiance", &self.irradiance)
                .push(&Push { first: area.offset, end: area.end(), ..push })
                .dispatch_over([width, height.div_ceil(push.row_step * self.rows)])
        };
        let Pipelines { moving, still, steady } = &*self.pipelines;
        let anew = Push { running: 0, ..push };
        for settled in Area::whole(extent).minus(step.unsettled) {
            dispatch(steady, settled, push)?;
            let rows = refreshed_rows(settled, push.refresh);
            if !rows.is_empty() {
                dispatch(still, rows, Push { row_step: to_u32(REFRESHED), ..anew })?;
            }
        }
        // By now every set has seen them where they are.
        for settled in step.unsettled_before.minus(step.unsettled) {
            dispatch(still, settled, anew)?;
        }
        for unmoved in step.unsettled.minus(movers) {
            dispatch(still, unmoved, push)?;
        }
        let moved = step.unsettled.within(movers);
        if !moved.is_empty() {
            dispatch(moving, moved, push)?;
        }
        Ok(&self.irradiance)
    }

    /// What is different from the frame before, in which the sums were those of `self.summed`.
    fn step(&mut self, inputs: &ReprojectionInputs<'_>, view: SetView) -> Step {
        let sets = inputs.sets;
        let whole = Area::whole(self.irradiance.extent());
        let mut summed = Summed {
            sets: Arc::clone(sets.identity()),
            draws: sets.draws(),
            view,
            position_cutoff: inputs.position_cutoff,
            moved: inputs.instances.moved.iter().map(|moved| moved.instance).collect(),
            changes: VecDeque::new(),
        };
        let changed = inputs.surfaces.changed;
        let last = self.summed.take().filter(|last| summed.follows(last) && changed != whole);
        let redrawn = sets.redrawn().filter(|redrawn| last.is_some() && redrawn.before.view == view).copied();
        // While the same things move on, what they uncover is known: the sums of the frame before say where they were.
        let known = last.as_ref().is_some_and(|last| summed.moved.is_subset(&last.moved));
        let anew = if known { Area::default() } else { changed };
        let unsettled_before = last.as_ref().map_or(whole, Summed::unsettled);
        if let Some(last) = last {
            summed.changes = last.changes;
            summed.changes.push_back(changed);
            while summed.changes.len() > sets.parameters().len() {
                summed.changes.pop_front();
            }
        } else {
            summed.changes.push_back(whole);
        }
        let unsettled = if redrawn.is_some() { summed.unsettled() } else { whole };
        self.summed = Some(summed);
        Step { redrawn, anew, unsettled_before, unsettled }
    }
}

/// What a frame adds to the sums of the one before.
struct Step {
    /// The set that was drawn again; none where sums cannot go on.
    redrawn: Option<Redrawn>,
    /// Where sums must not go on though what is seen and what was seen may not move.
    anew: Area,
    /// Where not every set had been drawn since the last change, in the frame before.
    unsettled_before: Area,
    /// The same in this one.
    unsettled: Area,
}

/// The push constants of whole pictures, less what is known of the list of sets.
fn push(inputs: &ReprojectionInputs<'_>, step: &Step) -> Push {
    let sets = inputs.sets;
    let flux = |(set, drawn): (usize, &Option<SetParameters>)| {
        drawn.map_or(inputs.set_flux.get(set).copied().unwrap_or(0.0), |set| set.flux)
    };
    let layer =
        |of: fn(&Redrawn) -> SetParameters| step.redrawn.as_ref().map_or(0, |redrawn| of(redrawn).layer);
    let scale =
        |of: fn(&Redrawn) -> SetParameters| step.redrawn.as_ref().map_or(0.0, |redrawn| of(redrawn).scale);
    Push {
        anew_first: step.anew.offset,
        anew_end: step.anew.end(),
        set_size: sets.extent(),
        row_step: 1,
        refresh: to_u32(sets.draws() as usize % REFRESHED),
        instance_count: to_u32(inputs.pose.instances.len()),
        scale_missing: u32::from(inputs.scale_missing),
        total_flux: sets.parameters().iter().enumerate().map(flux).sum(),
        set_count: to_u32(sets.parameters().len()),
        layer_before: layer(|redrawn| redrawn.before),
        layer_now: layer(|redrawn| redrawn.now),
        scale_before: scale(|redrawn| redrawn.before),
        scale_now: scale(|redrawn| redrawn.now),
        ..Push::zeroed()
    }
}

/// From the first of an area's rows that are summed up anew, each of [`REFRESHED`] rows in turn, to its end.
fn refreshed_rows(area: Area, refresh: u32) -> Area {
    let skipped = (i64::from(refresh) - i64::from(area.offset[1])).rem_euclid(REFRESHED as i64);
    area.within(area.moved([0, u32::try_from(skipped).unwrap_or(0)]))
}

fn irradiance(device: &Arc<Device>, extent: [u32; 2]) -> Result<Image, VulkanError> {
    storage_image(device, "irradiance", vk::Format::R32G32B32A32_SFLOAT, extent)
}
