//! The ground truth: a path tracer on the CPU. It stays naive.
//!
//! In: a scene, its pose, how many bounces. Out: the mean of as many samples a pixel as one likes, with the
//! light that shadow maps carry (point, spot and directional lights on the visible surface) and the light
//! that VPLs carry (everything else) apart, and with features of the visible surface.
//!
//! Same scene, same lights, same materials, same bounces as the renderer, and none of its methods: paths
//! start at the camera, and no light is stored anywhere.
//!
//! - `path`: samples of some pixels: next-event estimation and multiple importance sampling.
//! - `lights`: drawing a light from a point.
//! - `sampler`: random numbers.
//! - `surfaces`: what a hit looks at.
//! - `film`: sums, means and errors.
//! - `resume`: what an unfinished picture says about itself.

mod film;
mod lights;
mod path;
mod resume;
mod sampler;
mod surfaces;

pub use film::Film;
pub use resume::{Identity, PixelFilter, Progress};

use std::sync::atomic::{AtomicBool, Ordering};

use glam::{UVec2, Vec2, Vec3};
use rayon::prelude::*;

use crate::bvh::{Ray, TwoLevelBvh};
use crate::scene::{Pose, Scene};
use lights::Lights;
use sampler::Sampler;
use surfaces::Surfaces;

/// Neighbouring pixels whose paths are traced together.
const GROUP: usize = 128;

/// How a picture is sampled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ReferenceSettings {
    /// Width and height in pixels, at least 1 each.
    pub size: [u32; 2],
    /// Most surfaces that pass light on before it reaches the visible one; none: no limit, and Russian
    /// roulette ends the paths.
    pub bounces: Option<u32>,
    /// Seed of the samples.
    pub seed: u32,
    /// Where in a pixel the paths start.
    pub filter: PixelFilter,
    /// Whether to keep direct and indirect light and the features of the visible surface.
    pub layers: bool,
}

/// Why there is no reference.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ReferenceError {
    /// The sums of all pixels do not fit into memory.
    #[error("--size: a picture of this size does not fit into memory; make it smaller or leave --layers out")]
    OutOfMemory,
    /// The picture is not one that this run could go on with.
    #[error("is not the beginning of this picture: it has another size or lacks layers")]
    CannotResume,
}

/// A scene at one moment, ready to be sampled.
#[derive(Debug)]
pub struct Reference<'a> {
    scene: &'a Scene,
    pose: &'a Pose,
    bvh: TwoLevelBvh,
    surfaces: Surfaces,
    lights: Lights,
    lights_can_be_found: bool,
    /// Of the scene, for ray offsets.
    radius: f32,
    size: UVec2,
    pixel_rays: [Vec3; 3],
    bounces: Option<u32>,
    seed: u32,
    filter: PixelFilter,
    layers: bool,
}

impl<'a> Reference<'a> {
    /// Builds the BVH and the lights of `scene` at `pose`.
    pub fn new(scene: &'a Scene, pose: &'a Pose, settings: &ReferenceSettings) -> Self {
        let radius = scene.bounding_sphere(pose).radius;
        let lights = Lights::new(scene, pose, radius);
        let size = UVec2::from(settings.size);
        Self {
            scene,
            pose,
            bvh: TwoLevelBvh::build(scene, &pose.instances),
            surfaces: Surfaces::new(scene, pose),
            lights_can_be_found: lights.can_be_found(),
            lights,
            radius,
            size,
            pixel_rays: pose.camera.pixel_rays(size.x as f32 / size.y as f32),
            bounces: settings.bounces,
            seed: settings.seed,
            filter: settings.filter,
            layers: settings.layers,
        }
    }

    /// Goes on with samples of another seed.
    pub fn reseed(&mut self, seed: u32) {
        self.seed = seed;
    }

    /// An empty film for its pictures.
    ///
    /// # Errors
    /// Where it does not fit into memory.
    pub fn film(&self) -> Result<Film, ReferenceError> {
        let instances = (0..self.pixels()).into_par_iter().with_min_len(GROUP);
        let in_middle = |pixel: usize| {
            let ray = self.camera_ray(self.place(pixel, Vec2::splat(0.5)));
            self.bvh.intersect(&ray).map_or(-1, |hit| hit.instance as i32)
        };
        let instances = instances.map(in_middle).collect();
        Film::new(self.size.x as usize, self.size.y as usize, self.layers, instances)
    }

    /// A film that goes on from `picture`, whose samples and error `progress` tells.
    ///
    /// # Errors
    /// Where the picture has another size or lacks a layer, or memory is short.
    pub fn resumed_film(
        &self,
        picture: &crate::output::Picture,
        progress: &Progress,
    ) -> Result<Film, ReferenceError> {
        let mut film = self.film()?;
        let fits = film.restore(picture, progress.samples, progress.standard_error);
        fits.then_some(film).ok_or(ReferenceError::CannotResume)
    }

    /// Adds one sample of every pixel to `film`, over all cores. Gives up and changes nothing once `stop` is
    /// set; false then.
    pub fn add_sample(&self, film: &mut Film, stop: &AtomicBool) -> bool {
        let number = film.samples();
        film.pass.par_chunks_mut(GROUP).enumerate().for_each(|(group, samples)| {
            if stop.load(Ordering::Relaxed) {
                return;
            }
            let pixels = (group * GROUP..).take(samples.len());
            let places = pixels.map(|pixel| {
                let mut sampler = Sampler::new(self.seed, pixel as u32, number);
                let inside = sampler.next();
                let inside = match self.filter {
                    PixelFilter::Box => inside,
                    PixelFilter::Center => Vec2::splat(0.5),
                };
                (self.place(pixel, inside), sampler)
            });
            self.trace(places.collect(), samples);
        });
        let complete = !stop.load(Ordering::Relaxed);
        if complete {
            film.add();
        }
        complete
    }

    fn pixels(&self) -> usize {
        self.size.x as usize * self.size.y as usize
    }

    /// A point of the picture: `inside` (the unit square) of pixel number `pixel`, by rows.
    fn place(&self, pixel: usize, inside: Vec2) -> Vec2 {
        let width = self.size.x as usize;
        Vec2::new((pixel % width) as f32, (pixel / width) as f32) + inside
    }

    /// The ray from the eye through `place`, in pixels; t is the view depth.
    fn camera_ray(&self, place: Vec2) -> Ray {
        let [axis, right, down] = self.pixel_rays;
        let at = place / self.size.as_vec2() * 2.0 - 1.0;
        let camera = &self.pose.camera;
        Ray {
            origin: camera.eye,
            direction: axis + right * at.x + down * at.y,
            t_min: camera.near,
            t_max: camera.far,
        }
    }
}
