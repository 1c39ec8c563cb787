//! `indirect_shadows`: each texel of the set buffers samples a few VPLs of the set, by their unoccluded light, and casts
//! an occlusion ray to each.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};

use super::clusters::CLUSTERS;
use super::set_buffers::set_step;
use super::vpl_buffer::UploadedSet;
use crate::gpu_scene::tracer::TracerVariant;
use crate::passes::frame_inputs::FrameInputs;
use crate::passes::storage_image;
use crate::settings::VplSettings;
use crate::vulkan::{Buffer, ComputePipeline, Device, Frame, Image, VulkanError, shaders, vk};

/// Rays of a texel in one dispatch, at most: watchdogs of GPUs end long ones.
const MOST_RAYS: u32 = 32;
/// VPLs that a texel samples at least, where its share of `--vpls` is no less.
const LEAST_SAMPLES: f32 = 2.0;
/// Texels of a tile in each direction. Twin: shaders/estimators/vpls/clusters.glsl.
const TILE: u32 = 16;
/// Texels of a block in each direction. Twin: shaders/estimators/vpls/clusters.glsl.
const BLOCK: u32 = 8;

/// A still frame has so many times the samples, and each texel compensates bias: the mean takes all that helps it, at rays that cost
/// little beside the rest.
const STILL_SAMPLES: u32 = 4;

/// The samples of a dispatch; `SamplingPush` in shaders/estimators/vpls/clusters.glsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub(super) struct SamplingPush {
    tiles: [u32; 2],
    /// Pixels from one texel of the set buffers to the next.
    set_step: u32,
    first_sample: u32,
    end_sample: u32,
    /// Samples over all dispatches; 0: every VPL is gathered.
    samples: u32,
    /// Share of the light that a set holds.
    set_share: f32,
    /// One of `spread` x `spread` texels compensates the bias of the clamped geometry term.
    spread: u32,
}

impl SamplingPush {
    /// Constants of a pass that samples a set without a set buffer.
    pub fn of_share(set_share: f32) -> Self {
        Self { set_share, ..Self::default() }
    }
}

/// The pass.
pub struct IndirectShadowsPass {
    visibility: ComputePipeline,
    sampling: ComputePipeline,
    compensate: ComputePipeline,
    /// Share of the light that a set holds.
    set_share: f32,
    /// Whether there is a bound of the geometry term.
    bounded: bool,
    step: u32,
    /// Probability that each tile sees each cluster.
    cluster_visibility: Buffer,
    /// Weight with which each block samples each cluster.
    cluster_weights: Buffer,
    /// rgb: scaled irradiance of each texel, before the filter; a: view depth.
    irradiance: Image,
}

impl IndirectShadowsPass {
    /// Makes the pipeline for a tracer, and the image.
    pub fn new(
        device: &Arc<Device>,
        tracer: TracerVariant,
        size: [u32; 2],
        settings: &VplSettings,
    ) -> Result<Self, VulkanError> {
        let traced = |name, shader| tracer.pipeline(device, name, shader, &[]);
        let sampling = traced("vpl_sampling", shaders::VPL_SAMPLING_COMP)?;
        let visibility = traced("cluster_visibility", shaders::CLUSTER_VISIBILITY_COMP)?;
        let compensate = traced("bias_compensation", shaders::BIAS_COMPENSATION_COMP)?;
        let step = set_step(settings);
        let extent = size.map(|side| side.div_ceil(step));
        let tiles = extent.map(|side| u64::from(side.div_ceil(TILE)));
        let blocks = tiles.map(|tiles| tiles * u64::from(TILE / BLOCK) + 1);
        Ok(Self {
            visibility,
            sampling,
            compensate,
            set_share: 1.0 / settings.temporal_sets as f32,
            bounded: settings.clamp > 0.0,
            step,
            cluster_weights: Buffer::new(
                device,
                "cluster_weights",
                blocks[0] * blocks[1] * CLUSTERS as u64 * 4,
            )?,
            cluster_visibility: Buffer::new(
                device,
                "cluster_visibility",
                tiles[0] * tiles[1] * CLUSTERS as u64 * 4,
            )?,
            // 32 bits: many dispatches may add to it.
            irradiance: storage_image(device, "sampled_irradiance", vk::Format::R32G32B32A32_SFLOAT, extent)?,
        })
    }

    /// rgb: scaled irradiance of each texel, before the filter; a: view depth.
    pub fn output(&self) -> &Image {
        &self.irradiance
    }

    /// Samples the set.
    pub fn record(
        &self,
        frame: &mut Frame<'_>,
        inputs: &FrameInputs<'_>,
        set: &UploadedSet,
        samples: u32,
    ) -> Result<&Image, VulkanError> {
        let extent = self.irradiance.extent();
        let tiles = extent.map(|side| side.div_ceil(TILE));
        let is_still = inputs.clock.averaged().is_some();
        let samples = if is_still { samples.saturating_mul(STILL_SAMPLES) } else { samples };
        let all = SamplingPush {
            tiles,
            set_step: self.step,
            set_share: self.set_share,
            spread: if self.set_share <= 0.25 && !is_still { 2 } else { 1 },
            ..SamplingPush::default()
        };

        let dispatches = dispatches(all, set.count, samples);
        if self.bounded || dispatches.iter().any(|push| push.samples > 0) {
            self.sample_visibility(frame, inputs, set, all)?;
        }
        for push in dispatches {
            let pass = inputs
                .bind(frame.pass("vpl_sampling", &self.sampling))
                .read("vpl_clusters", &*set.clusters)
                .read("cluster_visibility", &self.cluster_visibility)
                .write("cluster_weights", &self.cluster_weights)
                .write("sampled_irradiance", &self.irradiance)
                .write("ray_counters", set.ray_counters.buffer())
                .push(&push);
            // Blocks may lie before the first texel.
            set.bind(pass).dispatch_over(extent.map(|side| side + BLOCK - 1))?;
        }

        if self.bounded {
            self.compensate_bias(frame, inputs, set, all)?;
        }
        Ok(&self.irradiance)
    }

    /// Finds out how likely each tile sees each cluster.
    fn sample_visibility(
        &self,
        frame: &mut Frame<'_>,
        inputs: &FrameInputs<'_>,
        set: &UploadedSet,
        all: SamplingPush,
    ) -> Result<(), VulkanError> {
        let threads = CLUSTERS as u32;
        let pass = inputs
            .bind(frame.pass("cluster_visibility", &self.visibility))
            .read("vpl_clusters", &*set.clusters)
            .write("cluster_visibility", &self.cluster_visibility)
            .write("ray_counters", set.ray_counters.buffer())
            .push(&all);
        set.bind(pass).dispatch_threads([all.tiles[0] * threads, all.tiles[1], 1])
    }

    /// Adds what the clamped geometry term has taken away.
    fn compensate_bias(
        &self,
        frame: &mut Frame<'_>,
        inputs: &FrameInputs<'_>,
        set: &UploadedSet,
        all: SamplingPush,
    ) -> Result<(), VulkanError> {
        let pass = inputs
            .bind(frame.pass("bias_compensation", &self.compensate))
            .read("vpl_clusters", &*set.clusters)
            .read("cluster_weights", &self.cluster_weights)
            .write("sampled_irradiance", &self.irradiance)
            .write("ray_counters", set.ray_counters.buffer())
            .push(&all);
        let blocks = self.irradiance.extent().map(|side| side.div_ceil(all.spread));
        set.bind(pass).dispatch_over(blocks)
    }
}

/// VPLs that a texel samples in each frame from a set that holds so many: all, if its share of `--vpls` is no less, else that share
/// times the share of the lights' rays that hit something, so that light that leaves the scene takes no rays. A texel that stands for
/// several pixels samples half as many more.
pub(crate) fn samples(settings: &VplSettings, vpls: u32, hit_share: f32) -> u32 {
    let each = settings.slots as f32 / (settings.temporal_sets * settings.interleave.pow(2)) as f32;
    if vpls as f32 <= each {
        return vpls;
    }
    let more = if set_step(settings) > 1 { 1.5 } else { 1.0 };
    // A single one a texel is the noisiest for what it costs.
    (each * more * hit_share).round().max(each.min(LEAST_SAMPLES)).max(1.0) as u32
}

/// The dispatches that sample so many of a set's VPLs: at least one, so that an empty set gives black.
fn dispatches(all: SamplingPush, vpls: u32, samples: u32) -> Vec<SamplingPush> {
    let (samples, count) = if vpls <= samples { (0, vpls) } else { (samples, samples) };
    let from = |first_sample| SamplingPush {
        samples,
        first_sample,
        end_sample: (first_sample + MOST_RAYS).min(count),
        ..all
    };
    (0..count.max(1)).step_by(MOST_RAYS as usize).map(from).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu_scene::structs::tests::same_layout;

    #[test]
    fn structs_have_the_layout_of_the_shaders() {
        same_layout!(
            shaders::VPL_SAMPLING_COMP.software,
            SamplingPush,
            tiles,
            set_step,
            first_sample,
            end_sample,
            samples,
            set_share,
            spread
        );
    }

    #[test]
    fn dispatches_take_all_samples_once() {
        for (vpls, samples) in [(0, 2), (1, 2), (512, 512), (700, 512), (1024, 2), (5000, 3), (65_536, 40)] {
            let all = dispatches(SamplingPush::default(), vpls, samples);
            assert!(!all.is_empty());
            let ends = all.iter().map(|push| push.end_sample);
            assert!(all.iter().map(|push| push.first_sample).skip(1).eq(ends.take(all.len() - 1)));
            assert_eq!(all.last().unwrap().end_sample, samples.min(vpls), "{vpls} VPLs, {samples} samples");
            assert!(all.iter().all(|push| push.samples == if vpls <= samples { 0 } else { samples }));
        }
    }
}
