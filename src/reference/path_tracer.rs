//! The path tracer of one scene and pose.

use std::borrow::Cow;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use glam::{UVec2, Vec2, Vec3};
use rayon::prelude::*;

use super::film::{CentralHit, Film, ReferenceError};
use super::lights::Lights;
use super::resume::{PixelFilter, Progress};
use super::sampler::Sampler;
use super::surfaces::Surfaces;
use crate::bvh::{Hit, Ray, Transmission, TwoLevelBvh, World};
use crate::scene::{Pose, Scene};
use crate::settings::{Antialiasing, Settings};

/// Neighbouring pixels whose paths are traced as one batch.
const GROUP: usize = 128;

/// How a picture is sampled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ReferenceSettings {
    /// Width and height in pixels, at least 1 each.
    pub size: [u32; 2],
    /// Most scattering events between a light and the visible surface; none: no limit, and Russian roulette
    /// terminates the paths.
    pub bounces: Option<u32>,
    /// Seed of the samples.
    pub seed: u32,
    /// Distribution of camera rays within a pixel.
    pub filter: PixelFilter,
    /// Whether to keep layers: direct, indirect and reflected light, shadows, and features of the visible surface.
    pub layers: bool,
}

impl ReferenceSettings {
    /// The settings that correspond to the renderer's.
    pub fn like(settings: &Settings) -> Self {
        let filter = match settings.antialiasing {
            Antialiasing::Taa => PixelFilter::Box,
            Antialiasing::None => PixelFilter::Center,
        };
        let Settings { size, bounces, seed, .. } = *settings;
        Self { size, bounces: Some(bounces), seed, filter, layers: false }
    }
}

/// A path tracer for one scene and pose.
#[derive(Debug)]
pub struct Reference<'a> {
    pub(super) scene: &'a Scene,
    /// Origin of positions in here, world units.
    pub(super) anchor: Vec3,
    pub(super) pose: Cow<'a, Pose>,
    pub(super) bvh: TwoLevelBvh,
    pub(super) bvh_ms: f64,
    pub(super) surfaces: Surfaces,
    pub(super) lights: Lights,
    /// Whether rays can meet light: area lights, the environment.
    pub(super) any_light_hittable: bool,
    pub(super) size: UVec2,
    pub(super) pixel_rays: [Vec3; 3],
    pub(super) bounces: Option<u32>,
    pub(super) seed: u32,
    pub(super) filter: PixelFilter,
    pub(super) layers: bool,
}

impl<'a> Reference<'a> {
    /// Builds the BVH and the lights of `scene` at `pose`.
    pub fn new(scene: &'a Scene, pose: &'a Pose, settings: &ReferenceSettings) -> Self {
        let anchor = scene.anchor();
        let pose = pose.about(anchor);
        let lights = Lights::new(scene, &pose);
        let size = UVec2::from(settings.size);
        let begun = Instant::now();
        let bvh = TwoLevelBvh::build(scene, &pose.instances);
        let bvh_ms = begun.elapsed().as_secs_f64() * 1e3;
        log::info!("{}: built the BVH in {bvh_ms:.0} ms", scene.name);
        Self {
            scene,
            anchor,
            bvh,
            bvh_ms,
            surfaces: Surfaces::new(scene, &pose),
            any_light_hittable: lights.any_hittable() || scene.environment.is_some(),
            lights,
            size,
            pixel_rays: pose.camera.pixel_rays(size.x as f32 / size.y as f32),
            bounces: settings.bounces,
            seed: settings.seed,
            filter: settings.filter,
            layers: settings.layers,
            pose,
        }
    }

    pub(super) fn world(&self) -> World<'_> {
        World { scene: self.scene, pose: &self.pose, bvh: &self.bvh }
    }

    /// Build time of the BVH, milliseconds.
    pub fn bvh_ms(&self) -> f64 {
        self.bvh_ms
    }

    /// Sets the seed of further samples.
    pub fn reseed(&mut self, seed: u32) {
        self.seed = seed;
    }

    /// An empty film.
    ///
    /// # Errors
    /// If it does not fit into memory.
    pub fn film(&self) -> Result<Film, ReferenceError> {
        let pixels = (0..self.pixels()).into_par_iter().with_min_len(GROUP);
        let centre_of = |pixel: usize| {
            let ray = self.camera_ray(self.raster_point(pixel, Vec2::splat(0.5)));
            let hit = self.world().behind_hidden(&ray, self.bvh.intersect(&ray));
            hit.map(|hit| self.central(&hit, ray.direction))
        };
        let centres = pixels.map(centre_of).collect();
        Film::new(self.size.x as usize, self.size.y as usize, self.layers, centres)
    }

    /// The surface that a ray along `direction` hit.
    fn central(&self, hit: &Hit, direction: Vec3) -> CentralHit {
        let (found, material) = self.surfaces.at(self.scene, hit, direction);
        let material = &self.scene.materials[material];
        let shines = material.emits_on(found.front)
            && material.emission_at(self.scene, found.attributes) != Vec3::ZERO;
        let roughness = material.bsdf_at(self.scene, found.attributes).roughness;
        CentralHit { instance: hit.instance, shines, roughness }
    }

    /// A film that resumes from `picture`, with the samples and error of `progress`.
    ///
    /// # Errors
    /// If the picture has another size or lacks a layer, or does not fit into memory.
    pub fn resumed_film(
        &self,
        picture: &crate::output::Picture,
        progress: &Progress,
    ) -> Result<Film, ReferenceError> {
        let mut film = self.film()?;
        let fits = film.restore(picture, progress.samples, progress.standard_error);
        fits.then_some(film).ok_or(ReferenceError::CannotResume)
    }

    /// Adds one sample of every pixel to `film`, on all cores. Once `stop` is set, returns false and leaves the
    /// film as it was.
    pub fn add_sample(&self, film: &mut Film, stop: &AtomicBool) -> bool {
        let number = film.samples();
        film.pass.par_chunks_mut(GROUP).enumerate().for_each(|(group, samples)| {
            if stop.load(Ordering::Relaxed) {
                return;
            }
            let pixels = (group * GROUP..).take(samples.len());
            let camera_samples = pixels.map(|pixel| {
                let mut sampler = Sampler::new(self.seed, pixel as u32, number);
                let offset = sampler.next();
                let offset = match self.filter {
                    PixelFilter::Box => offset,
                    PixelFilter::Center => Vec2::splat(0.5),
                };
                (self.raster_point(pixel, offset), sampler)
            });
            self.trace(camera_samples.collect(), samples);
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

    /// A point in raster space: `offset` (the unit square) within pixel `pixel`, counted by rows.
    fn raster_point(&self, pixel: usize, offset: Vec2) -> Vec2 {
        let width = self.size.x as usize;
        Vec2::new((pixel % width) as f32, (pixel / width) as f32) + offset
    }

    /// The surface where the light along each ray stops, if any, and its weight. `pass` takes the ray of an index from its
    /// closest hit through thin surfaces.
    pub(super) fn intersect(
        &self,
        rays: &[Ray],
        mut pass: impl FnMut(usize, Option<Hit>) -> (Option<Hit>, Transmission),
    ) -> Vec<(Option<Hit>, Vec3)> {
        let hits = self.bvh.intersect_all(rays);
        hits.iter().flatten().for_each(|hit| self.surfaces.prefetch(hit));
        let pass = |(index, hit): (usize, Option<Hit>)| {
            let (hit, transmission) = pass(index, hit);
            (hit, transmission.weight)
        };
        hits.into_iter().enumerate().map(pass).collect()
    }

    /// The ray from the eye through `point` in raster space; t is the view depth.
    pub(super) fn camera_ray(&self, point: Vec2) -> Ray {
        let [axis, right, down] = self.pixel_rays;
        let ndc = point / self.size.as_vec2() * 2.0 - 1.0;
        let camera = &self.pose.camera;
        Ray {
            origin: camera.eye,
            direction: axis + right * ndc.x + down * ndc.y,
            t_min: camera.near,
            t_max: camera.far,
        }
    }
}
