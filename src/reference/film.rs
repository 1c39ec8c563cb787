//! The film: accumulates the samples of all pixels.
//!
//! In: passes of one sample a pixel. Out: the mean picture, its layers, and an estimate of its error.

use std::f32::consts::PI;

use glam::{DVec3, Vec3};

use crate::output::{Layer, Picture};
use crate::scene::luminance;

/// Why a reference cannot be rendered.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ReferenceError {
    /// The sums of all pixels do not fit into memory.
    #[error("--size: a picture of this size does not fit into memory; make it smaller or leave --layers out")]
    OutOfMemory,
    /// The picture cannot be resumed by this run.
    #[error("cannot be resumed: it has another size or lacks layers")]
    CannotResume,
}

/// One sample of a pixel.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct PixelSample {
    /// Direct radiance of point, spot and directional lights, with emission and background, W/m^2/sr.
    pub(super) direct: Vec3,
    /// The part of the direct radiance that comes from lights, W/m^2/sr.
    pub(super) lit: Vec3,
    /// Direct radiance that lights would give if they were unoccluded, W/m^2/sr.
    pub(super) unshadowed: Vec3,
    /// Irradiance at the visible surface by area lights, the environment and indirect light, W/m^2: the part that VPLs
    /// estimate.
    pub(super) irradiance: Vec3,
    /// Radiance that the visible surface's GGX lobe makes of the same light, W/m^2/sr.
    pub(super) reflected: Vec3,
    /// The visible surface; none if the camera ray missed.
    pub(super) visible: Option<VisibleSurface>,
}

/// Features of the visible surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct VisibleSurface {
    /// Radiance that it scatters over its irradiance, times pi, as far as thin surfaces before it let that pass.
    pub(super) albedo: Vec3,
    /// Unit shading normal, world space.
    pub(super) normal: Vec3,
    /// World position.
    pub(super) position: Vec3,
    /// View depth: distance along the view axis.
    pub(super) depth: f32,
}

impl PixelSample {
    /// Radiance of the pixel: direct + albedo/pi * irradiance + reflected.
    pub(super) fn radiance(&self) -> Vec3 {
        let albedo = self.visible.map_or(Vec3::ZERO, |visible| visible.albedo);
        self.direct + albedo / PI * self.irradiance + self.reflected
    }
}

/// The surface at the centre of a pixel.
#[derive(Clone, Copy, Debug)]
pub(super) struct CentralHit {
    /// Index of the instance.
    pub(super) instance: u32,
    /// Whether it shines itself.
    pub(super) shines: bool,
    /// Roughness of its GGX lobe.
    pub(super) roughness: f32,
}

/// Sums over the samples of each pixel, in rows from the top left.
#[derive(Clone, Debug)]
pub struct Film {
    width: usize,
    height: usize,
    samples: u64,
    /// The latest sample of each pixel.
    pub(super) pass: Vec<PixelSample>,
    radiance: Vec<RadianceSums>,
    /// With `--layers`; else empty.
    layers: Vec<LayerSums>,
    /// Hit of the ray through the centre of each pixel; none where it misses.
    centres: Vec<Option<CentralHit>>,
    /// Samples and standard error of an earlier run that this one resumes.
    resumed: Option<(u64, f64)>,
    /// Samples that were not finite and count as black.
    dropped: u64,
}

#[derive(Clone, Copy, Debug, Default)]
struct RadianceSums {
    radiance: DVec3,
    /// Luminance of this run's even and odd samples.
    halves: [f64; 2],
}

#[derive(Clone, Copy, Debug, Default)]
struct LayerSums {
    direct: DVec3,
    lit: DVec3,
    unshadowed: DVec3,
    irradiance: DVec3,
    reflected: DVec3,
    /// The following over the samples that hit a surface.
    albedo: DVec3,
    normal: DVec3,
    position: DVec3,
    depth: f64,
    hits: u64,
}

impl Film {
    /// An empty film of `width` x `height` pixels, with `layers` or without. `centres` tells what is at the
    /// centre of each pixel.
    pub(super) fn new(
        width: usize,
        height: usize,
        layers: bool,
        centres: Vec<Option<CentralHit>>,
    ) -> Result<Self, ReferenceError> {
        let pixels = width * height;
        Ok(Self {
            width,
            height,
            samples: 0,
            pass: filled(pixels)?,
            radiance: filled(pixels)?,
            layers: filled(if layers { pixels } else { 0 })?,
            centres,
            resumed: None,
            dropped: 0,
        })
    }

    /// Samples of each pixel so far.
    pub fn samples(&self) -> u64 {
        self.samples
    }

    /// Samples that were not finite; they count as black.
    pub fn dropped(&self) -> u64 {
        self.dropped
    }

    /// Whether layers are accumulated.
    pub fn has_layers(&self) -> bool {
        !self.layers.is_empty()
    }

    /// Accumulates the latest sample of every pixel.
    pub(super) fn add(&mut self) {
        let half = (self.samples & 1) as usize;
        for (sums, sample) in self.radiance.iter_mut().zip(&self.pass) {
            let radiance = sample.radiance();
            if radiance.is_finite() {
                sums.radiance += radiance.as_dvec3();
                sums.halves[half] += f64::from(luminance(radiance));
            } else {
                self.dropped += 1;
            }
        }
        for (sums, sample) in self.layers.iter_mut().zip(&self.pass) {
            if sample.radiance().is_finite() {
                sums.direct += sample.direct.as_dvec3();
                sums.irradiance += sample.irradiance.as_dvec3();
                sums.reflected += sample.reflected.as_dvec3();
                if sample.unshadowed.is_finite() {
                    sums.lit += sample.lit.as_dvec3();
                    sums.unshadowed += sample.unshadowed.as_dvec3();
                }
            }
            if let Some(visible) = &sample.visible {
                sums.add(visible);
            }
        }
        self.samples += 1;
    }

    /// Standard error of the luminance, root mean square over the pixels, W/m^2/sr; none before two samples.
    ///
    /// Even and odd samples give independent estimates A and B of the same picture from a and b samples, so the
    /// standard error of their mean is |A - B| sqrt(ab)/(a + b) in expectation. A resumed picture is independent too.
    pub fn standard_error(&self) -> Option<f64> {
        let (old, old_error) = self.resumed.unwrap_or((0, 0.0));
        let new = self.samples - old;
        let first = old % 2;
        // Even samples come first, unless an odd number was resumed.
        let (even, odd) = if first == 0 { (new.div_ceil(2), new / 2) } else { (new / 2, new.div_ceil(2)) };
        if even == 0 || odd == 0 {
            return self.resumed.map(|(_, error)| error);
        }
        let (even, odd, total) = (even as f64, odd as f64, self.samples as f64);
        let squares = self.radiance.iter().map(|sums| (sums.halves[0] / even - sums.halves[1] / odd).powi(2));
        let mean_square = squares.sum::<f64>() / self.radiance.len() as f64;
        let new_error = (mean_square * even * odd).sqrt() / (even + odd);
        Some((old_error * old as f64).hypot(new_error * (even + odd)) / total)
    }

    /// Mean luminance of the picture, W/m^2/sr.
    pub fn mean_luminance(&self) -> f64 {
        let sum: f64 = self.radiance.iter().map(|sums| f64::from(luminance(sums.radiance.as_vec3()))).sum();
        sum / (self.radiance.len() as f64 * (self.samples.max(1)) as f64)
    }

    /// The current mean: `colour` and, if accumulated, the layers; without `display`.
    pub fn picture(&self) -> Picture {
        let mean = |sum: DVec3| (sum / self.samples.max(1) as f64).as_vec3().to_array();
        let mut picture = Picture {
            width: self.width,
            height: self.height,
            colour: self.radiance.iter().map(|sums| mean(sums.radiance)).collect(),
            ..Picture::default()
        };
        if self.has_layers() {
            let over_hits =
                |sums: &LayerSums, sum: DVec3| (sum / sums.hits.max(1) as f64).as_vec3().to_array();
            let of = |part: &dyn Fn(&LayerSums) -> [f32; 3]| self.layers.iter().map(part).collect::<Vec<_>>();
            let scalar = |part: &dyn Fn(&LayerSums) -> f32| self.layers.iter().map(part).collect::<Vec<_>>();
            picture.layers = vec![
                Layer::colour("direct", &of(&|sums| mean(sums.direct))),
                Layer::colour("indirect", &of(&|sums| mean(sums.irradiance))),
                Layer::colour("reflected", &of(&|sums| mean(sums.reflected))),
                Layer::colour("shadow", &of(&LayerSums::shadow)),
                Layer::colour("unshadowed", &of(&|sums| mean(sums.unshadowed))),
                Layer::colour("albedo", &of(&|sums| over_hits(sums, sums.albedo))),
                Layer::vector("normal", &of(&|sums| unit(sums.normal))),
                Layer::vector("position", &of(&|sums| over_hits(sums, sums.position))),
                Layer::single("depth", "Z", scalar(&|sums| (sums.depth / sums.hits.max(1) as f64) as f32)),
                Layer::single("instance", "id", self.instances().collect()),
                Layer::single(
                    "coverage",
                    "A",
                    scalar(&|sums| (sums.hits as f64 / self.samples.max(1) as f64) as f32),
                ),
            ];
        }
        picture
    }

    /// Whether the ray through the centre of each pixel hits a surface.
    pub fn covered(&self) -> impl Iterator<Item = bool> {
        self.centres.iter().map(Option::is_some)
    }

    /// Index of the instance at the centre of each pixel, -1 for none.
    fn instances(&self) -> impl Iterator<Item = f32> {
        self.centres.iter().map(|hit| hit.map_or(-1.0, |hit| hit.instance as f32))
    }

    /// Roughness of the surface at the centre of each pixel, 0 where there is none.
    pub fn roughness(&self) -> impl Iterator<Item = f32> {
        self.centres.iter().map(|hit| hit.map_or(0.0, |hit| hit.roughness))
    }

    /// How much each pixel counts for automatic exposure. Twin: `SHARE_OF_LIGHTS` in shaders/passes/direct_shading.comp.
    pub fn metered(&self) -> impl Iterator<Item = f32> {
        self.centres.iter().map(|hit| match hit.map(|hit| hit.shines) {
            None => 0.0,
            Some(false) => 1.0,
            Some(true) => 1.0 / 16.0,
        })
    }

    /// Restores the mean of an earlier run: `picture`, of `samples` samples with the standard error `error`. False if
    /// the picture has another size or lacks a layer.
    pub(super) fn restore(&mut self, picture: &Picture, samples: u64, error: f64) -> bool {
        let pixels = self.radiance.len();
        if (picture.width, picture.height, picture.colour.len()) != (self.width, self.height, pixels) {
            return false;
        }
        let total = samples as f64;
        for (sums, colour) in self.radiance.iter_mut().zip(&picture.colour) {
            sums.radiance = Vec3::from(*colour).as_dvec3() * total;
        }
        if self.has_layers() && self.restore_layers(picture, total).is_none() {
            return false;
        }
        self.samples = samples;
        self.resumed = Some((samples, error));
        true
    }

    fn restore_layers(&mut self, picture: &Picture, total: f64) -> Option<()> {
        let channels = |name: &str| {
            let layer = picture.layers.iter().find(|layer| layer.name == name)?;
            Some(&layer.channels)
        };
        let vector = |name: &str, index: usize, by: [&str; 3]| -> Option<DVec3> {
            let channels = channels(name)?;
            let value = |letter: &str| {
                let (_, samples) = channels.iter().find(|(channel, _)| channel == letter)?;
                samples.get(index).map(|&value| f64::from(value))
            };
            Some(DVec3::new(value(by[0])?, value(by[1])?, value(by[2])?))
        };
        let scalar = |name: &str, index: usize| Some(f64::from(*channels(name)?.first()?.1.get(index)?));
        const RGB: [&str; 3] = ["R", "G", "B"];
        const XYZ: [&str; 3] = ["X", "Y", "Z"];
        for (index, sums) in self.layers.iter_mut().enumerate() {
            let hits = (scalar("coverage", index)? * total).round();
            let unshadowed = vector("unshadowed", index, RGB)? * total;
            *sums = LayerSums {
                direct: vector("direct", index, RGB)? * total,
                lit: vector("shadow", index, RGB)? * unshadowed,
                unshadowed,
                irradiance: vector("indirect", index, RGB)? * total,
                reflected: vector("reflected", index, RGB)? * total,
                albedo: vector("albedo", index, RGB)? * hits,
                normal: vector("normal", index, XYZ)? * hits,
                position: vector("position", index, XYZ)? * hits,
                depth: scalar("depth", index)? * hits,
                hits: hits as u64,
            };
        }
        Some(())
    }
}

impl LayerSums {
    fn add(&mut self, visible: &VisibleSurface) {
        self.albedo += visible.albedo.as_dvec3();
        self.normal += visible.normal.as_dvec3();
        self.position += visible.position.as_dvec3();
        self.depth += f64::from(visible.depth);
        self.hits += 1;
    }

    /// Shadowed over unshadowed light of the lights, by channel; 1 where there is no light.
    fn shadow(&self) -> [f32; 3] {
        let share = |channel: usize| match self.unshadowed[channel] {
            unshadowed if unshadowed > 0.0 => (self.lit[channel] / unshadowed) as f32,
            _ => 1.0,
        };
        [0, 1, 2].map(share)
    }
}

fn unit(normal: DVec3) -> [f32; 3] {
    normal.normalize_or_zero().as_vec3().to_array()
}

/// A vector of defaults, or an error if it cannot be allocated.
fn filled<T: Clone + Default>(length: usize) -> Result<Vec<T>, ReferenceError> {
    let mut vector = Vec::new();
    vector.try_reserve_exact(length).map_err(|_| ReferenceError::OutOfMemory)?;
    vector.resize(length, T::default());
    Ok(vector)
}
