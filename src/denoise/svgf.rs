//! SVGF, spatiotemporal variance-guided filtering (Schied et al. 2017): accumulate a signal over time along the motion of
//! surfaces, estimate its variance, and blur it along surfaces as far as that variance explains differences.
//!
//! In: a signal without the albedo of the surface, one noisy frame after the other. Out: the signal, denoised.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};

use crate::passes::storage_image;
use crate::vulkan::{ComputePipeline, Device, Frame, Image, Pass, Upload, VulkanError, shaders, vk};

/// Most levels of the à-trous filter.
pub const MAX_LEVELS: u32 = 5;

/// How SVGF filters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SvgfSettings {
    /// Least share of the newest frame in the signal. Less: less noise, and changes show later.
    pub alpha: f32,
    /// The same in the moments of its luminance.
    pub moments_alpha: f32,
    /// Longest history, frames.
    pub longest_history: u32,
    /// Standard deviations of the 3x3 noisy pixels around that history may lie off their mean (Salvi 2016); 0: any. Less: what has
    /// changed goes sooner, and rare bright samples are lost.
    pub clamp: f32,
    /// Levels of the à-trous filter, 1 to [`MAX_LEVELS`]; each doubles the radius of the blur.
    pub levels: u32,
    /// After which level the signal becomes history; 0: before the first.
    pub feedback: u32,
    /// 5 + 5 taps a level in place of 25: faster, and edges that are neither upright nor level blur more.
    pub separable: bool,
    /// Pixel footprints off the plane of the surface, for each pixel between, by which the weight falls to 1/e.
    pub depth_tolerance: f32,
    /// Exponent of the cosine between normals.
    pub normal_exponent: f32,
    /// Standard deviations of luminance by which the weight falls to 1/e.
    pub luminance_tolerance: f32,
}

impl Default for SvgfSettings {
    /// Those of Schied et al. 2017 and, for times, of Falcor's SVGFPass.
    fn default() -> Self {
        Self {
            alpha: 0.05,
            moments_alpha: 0.2,
            longest_history: 32,
            clamp: 0.0,
            levels: 4,
            feedback: 1,
            separable: false,
            depth_tolerance: 1.0,
            normal_exponent: 128.0,
            luminance_tolerance: 4.0,
        }
    }
}

/// What SVGF reads.
pub struct SvgfInputs<'a> {
    /// Frame uniforms.
    pub frame: &'a Upload,
    /// rgb: the signal, RGBA16F.
    pub noisy: &'a Image,
    /// Of the G-buffer.
    pub depth: &'a Image,
    /// Of the G-buffer.
    pub normal: &'a Image,
    /// Packed surfaces: `ReprojectionPass::surface`.
    pub surface: &'a Image,
    /// Where the signal was in the last frame: `ReprojectionPass::reprojected`, or likewise of a mirror image.
    pub reprojected: &'a Image,
}

impl SvgfInputs<'_> {
    /// What the passes read that compare surfaces.
    fn bind_surfaces<'f>(&'f self, pass: Pass<'f>) -> Pass<'f> {
        pass.read("frame_uniforms", self.frame)
            .read("surface", self.surface)
            .read("gbuffer_depth", self.depth)
            .read("gbuffer_normal", self.normal)
    }
}

/// The denoiser of one signal.
pub struct Svgf {
    temporal: ComputePipeline,
    variance: ComputePipeline,
    /// The whole window; or along x, then along y.
    atrous: Vec<ComputePipeline>,
    settings: SvgfSettings,
    /// Before and after a step of the filter, in turns.
    light: [Image; 2],
    history: Image,
    /// Of this frame and the last one, in turns.
    moments: [Image; 2],
    /// Which of `moments` is the last frame's; none without a history.
    last: Option<usize>,
    /// Which of `light` holds the result; none: the history does.
    result: Option<usize>,
}

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct TemporalPush {
    least_alpha: f32,
    least_moments_alpha: f32,
    longest: f32,
    clamp_width: f32,
    has_history: u32,
}

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct AtrousPush {
    step: i32,
    depth_tolerance: f32,
    normal_exponent: f32,
    luminance_tolerance: f32,
}

impl Svgf {
    /// Makes the pipelines, and the images of `extent` texels.
    pub fn new(device: &Arc<Device>, extent: [u32; 2], settings: &SvgfSettings) -> Result<Self, VulkanError> {
        let image = |name| storage_image(device, name, vk::Format::R16G16B16A16_SFLOAT, extent);
        let radii: &[[u32; 2]] = if settings.separable { &[[2, 0], [0, 2]] } else { &[[2, 2]] };
        let atrous = |radii: &[u32; 2]| {
            ComputePipeline::specialised(device, "svgf_atrous", shaders::SVGF_ATROUS_COMP, radii)
        };
        Ok(Self {
            temporal: ComputePipeline::new(device, "svgf_temporal", shaders::SVGF_TEMPORAL_COMP)?,
            variance: ComputePipeline::new(device, "svgf_variance", shaders::SVGF_VARIANCE_COMP)?,
            atrous: radii.iter().map(atrous).collect::<Result<_, _>>()?,
            settings: *settings,
            light: [image("svgf light 0")?, image("svgf light 1")?],
            history: image("svgf history")?,
            moments: [image("svgf moments 0")?, image("svgf moments 1")?],
            last: None,
            result: None,
        })
    }

    /// Forgets all frames so far.
    pub fn forget(&mut self) {
        self.last = None;
    }

    /// rgb: the denoised signal of the last frame; a: its standard deviation.
    pub fn output(&self) -> &Image {
        self.result.map_or(&self.history, |index| &self.light[index])
    }

    /// Of the last frame: r: mean luminance; g: its standard deviation; b: length of the history, frames.
    pub fn moments(&self) -> &Image {
        &self.moments[self.last.unwrap_or_default()]
    }

    /// What the last steps of the filter wrote, in turns, as [`Self::output`].
    pub fn light(&self, index: usize) -> &Image {
        &self.light[index]
    }

    /// What the next frame takes as history, as [`Self::output`].
    pub fn history(&self) -> &Image {
        &self.history
    }

    /// Denoises one frame.
    pub fn record(&mut self, frame: &mut Frame<'_>, inputs: &SvgfInputs<'_>) -> Result<(), VulkanError> {
        self.accumulate(frame, inputs)?;
        // Filter from image to image; what becomes history goes there instead.
        let mut from = Some(0);
        for level in 0..=self.settings.levels {
            let last_of_level = |part: usize| part + 1 == self.atrous.len() || level == 0;
            let parts = if level == 0 { 1 } else { self.atrous.len() };
            for part in 0..parts {
                let becomes_history = level == self.settings.feedback && last_of_level(part);
                let to = if becomes_history { None } else { Some(from.map_or(0, |index| 1 - index)) };
                match level {
                    0 => self.estimate_variance(frame, inputs, [from, to])?,
                    _ => self.filter(frame, inputs, (level, part), [from, to])?,
                }
                from = to;
            }
        }
        self.result = from;
        Ok(())
    }

    fn image(&self, place: Option<usize>) -> &Image {
        place.map_or(&self.history, |index| &self.light[index])
    }

    fn accumulate(&mut self, frame: &mut Frame<'_>, inputs: &SvgfInputs<'_>) -> Result<(), VulkanError> {
        let last = self.last.unwrap_or_default();
        frame
            .pass("svgf_temporal", &self.temporal)
            .read("frame_uniforms", inputs.frame)
            .read("surface", inputs.surface)
            .read("noisy", inputs.noisy)
            .read("reprojected", inputs.reprojected)
            .read("history", &self.history)
            .read("last_moments", &self.moments[last])
            .write("light", &self.light[0])
            .write("moments", &self.moments[1 - last])
            .push(&TemporalPush {
                least_alpha: self.settings.alpha,
                least_moments_alpha: self.settings.moments_alpha,
                longest: self.settings.longest_history as f32,
                clamp_width: self.settings.clamp,
                has_history: u32::from(self.last.is_some()),
            })
            .dispatch_over(self.history.extent())?;
        self.last = Some(1 - last);
        Ok(())
    }

    fn estimate_variance(
        &self,
        frame: &mut Frame<'_>,
        inputs: &SvgfInputs<'_>,
        [from, to]: [Option<usize>; 2],
    ) -> Result<(), VulkanError> {
        inputs
            .bind_surfaces(frame.pass("svgf_variance", &self.variance))
            .read("moments", self.moments())
            .read("light", self.image(from))
            .write("filtered", self.image(to))
            .push(&[self.settings.depth_tolerance, self.settings.normal_exponent])
            .dispatch_over(self.history.extent())
    }

    fn filter(
        &self,
        frame: &mut Frame<'_>,
        inputs: &SvgfInputs<'_>,
        (level, part): (u32, usize),
        [from, to]: [Option<usize>; 2],
    ) -> Result<(), VulkanError> {
        inputs
            .bind_surfaces(frame.pass("svgf_atrous", &self.atrous[part]))
            .read("light", self.image(from))
            .write("filtered", self.image(to))
            .push(&AtrousPush {
                step: 1 << (level - 1),
                depth_tolerance: self.settings.depth_tolerance,
                normal_exponent: self.settings.normal_exponent,
                luminance_tolerance: self.settings.luminance_tolerance,
            })
            .dispatch_over(self.history.extent())
    }
}
