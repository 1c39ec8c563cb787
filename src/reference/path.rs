//! Samples of some pixels: paths from the camera, lit at every surface that they meet. The paths of a group go
//! on together, a bounce at a time, so that their rays are traced together; none knows of the others.
//!
//! In: rays through pixels. Out, for each: the light that shadow maps carry, as radiance; the light that VPLs carry, as
//! irradiance at the visible surface; and what that surface is.
//!
//! With rho the albedo, n the shading normal and x0 the visible surface, the path x0, x1, ... estimates
//!
//! ```text
//! E(x0) = E_area(x0) + pi mean[ rho(x1)/pi E_all(x1) + rho(x1) rho(x2)/pi E_all(x2) + ... ]
//! ```
//!
//! (Kajiya 1986), each E by one light sample and one scattered ray, joined by the power heuristic.

use std::f32::consts::PI;

use glam::{Vec2, Vec3};

use super::Reference;
use super::lights::{Arrival, LightSample, Share, cosine_density, power_heuristic};
use super::sampler::Sampler;
use crate::bvh::{Hit, Ray, TwoLevelBvh};
use crate::sampling::{self, Frame};
use crate::scene::{Footprint, Material, Side, Texture, WorldSurface, luminance};

/// Bounces before Russian roulette may end a path without a limit.
const CERTAIN_BOUNCES: u32 = 3;

/// Most that a path without a limit goes on with at each bounce: an albedo of 1 must end too.
const HIGHEST_SURVIVAL: f32 = 0.95;

/// What one sample saw.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct PixelSample {
    /// Radiance that shadow maps carry, with emission and background, W/m^2/sr.
    pub(super) direct: Vec3,
    /// Irradiance that VPLs carry to the visible surface, W/m^2.
    pub(super) irradiance: Vec3,
    /// The visible surface, if there is one.
    pub(super) seen: Option<Seen>,
}

/// The visible surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seen {
    pub(super) albedo: Vec3,
    /// Unit shading normal, world space.
    pub(super) normal: Vec3,
    /// World position.
    pub(super) position: Vec3,
    /// Along the view axis.
    pub(super) depth: f32,
}

impl PixelSample {
    /// Radiance of the pixel: direct + albedo/pi * irradiance.
    pub(super) fn radiance(&self) -> Vec3 {
        let albedo = self.seen.map_or(Vec3::ZERO, |seen| seen.albedo);
        self.direct + albedo / PI * self.irradiance
    }
}

/// A path on its way.
struct Path<'a> {
    sampler: Sampler,
    sample: PixelSample,
    /// The surface that it has reached, or that it leaves.
    at: Found<'a>,
    /// The direction in which it leaves.
    direction: Vec3,
    /// What the radiance along the next ray counts for.
    throughput: Vec3,
    /// What scattered rays bring to the visible surface, W/m^2.
    scattered: Vec3,
}

/// A surface that a ray has found.
#[derive(Clone, Copy)]
struct Found<'a> {
    surface: WorldSurface,
    front: bool,
    material: &'a Material,
    /// The texels of its albedo, if it has a texture.
    texels: Option<(&'a Texture, Footprint)>,
}

impl Found<'_> {
    fn albedo(&self) -> Vec3 {
        self.texels.map_or(Vec3::ONE, |(texture, texels)| texture.filter(texels)) * self.material.albedo
    }
}

/// Rays to lights, and what arrives where nothing is in between.
#[derive(Default)]
struct LightRays {
    rays: Vec<Ray>,
    /// For each ray its path, and what its light counts for.
    arriving: Vec<(usize, Vec3)>,
}

impl Reference<'_> {
    /// One sample for each of `places`, points of the picture in pixels, each with its random numbers, into as
    /// many `samples`.
    pub(super) fn trace(&self, places: Vec<(Vec2, Sampler)>, samples: &mut [PixelSample]) {
        let rays: Vec<Ray> = places.iter().map(|&(place, _)| self.camera_ray(place)).collect();
        let hits = self.bvh.intersect_all(&rays);
        hits.iter().flatten().for_each(|hit| self.surfaces.prefetch(hit));
        samples.fill(PixelSample { direct: self.scene.background, ..Default::default() });
        let (mut paths, mut pixels) = (Vec::with_capacity(rays.len()), Vec::with_capacity(rays.len()));
        for (pixel, ((_, sampler), hit)) in places.into_iter().zip(&hits).enumerate() {
            let Some(hit) = hit else { continue };
            let direction = rays[pixel].direction;
            let at = self.look(hit, direction);
            let seen = Seen {
                albedo: Vec3::ZERO,
                normal: at.surface.normal,
                position: at.surface.position,
                depth: hit.t,
            };
            let sample = PixelSample { seen: Some(seen), ..Default::default() };
            let (throughput, scattered) = (Vec3::splat(PI), Vec3::ZERO);
            paths.push(Path { sampler, sample, at, direction, throughput, scattered });
            pixels.push(pixel);
        }

        self.light_what_is_seen(&mut paths);
        self.scatter_light(&mut paths);
        for (path, pixel) in paths.into_iter().zip(pixels) {
            let irradiance = path.sample.irradiance + path.scattered;
            samples[pixel] = PixelSample { irradiance, ..path.sample };
        }
    }

    /// Emission of the visible surfaces, and what lights bring to them.
    fn light_what_is_seen(&self, paths: &mut [Path<'_>]) {
        let (mut shadow_mapped, mut area) = (LightRays::default(), LightRays::default());
        for (index, path) in paths.iter_mut().enumerate() {
            let (picks, on_light) = (path.sampler.next(), path.sampler.next());
            let found = &path.at;
            let albedo = found.albedo();
            path.sample.direct = if found.front { found.material.emission } else { Vec3::ZERO };
            if let Some(seen) = &mut path.sample.seen {
                seen.albedo = albedo;
            }
            let to_eye = -path.direction.normalize();
            if let Some(light) = self.unshadowed(&found.surface, Share::ShadowMapped, picks.x, on_light) {
                let radiance = reflected(&light, found, albedo, to_eye);
                shadow_mapped.push(self.light_ray(&found.surface, &light), index, radiance);
            }
            if let Some(light) = self.unshadowed(&found.surface, Share::Area, picks.y, on_light) {
                area.push(self.light_ray(&found.surface, &light), index, light.irradiance);
            }
        }
        shadow_mapped.trace(&self.bvh, |path, radiance| paths[path].sample.direct += radiance);
        area.trace(&self.bvh, |path, irradiance| paths[path].sample.irradiance += irradiance);
    }

    /// Irradiance at the visible surfaces that scattered rays bring: emission that they find, and light that
    /// one to `bounces` surfaces pass on.
    fn scatter_light<'a>(&'a self, paths: &mut [Path<'a>]) {
        let mut going: Vec<usize> = (0..paths.len()).collect();
        let mut share = Share::Area;
        for bounce in 1.. {
            let passes_on = self.bounces.is_none_or(|limit| bounce <= limit);
            if going.is_empty() || !passes_on && !self.lights_can_be_found {
                break;
            }

            // Scatter.
            let mut numbers = Vec::with_capacity(going.len());
            let mut rays = Vec::with_capacity(going.len());
            going.retain(|&index| {
                let path = &mut paths[index];
                let [turn, choice, on_light] = std::array::from_fn(|_| path.sampler.next());
                // Where the limit is reached only emission counts.
                let ray = self.scattered_ray(&path.at.surface, turn);
                let ray = ray.filter(|ray| passes_on || self.lights.may_be_found_by(ray));
                if let Some(ray) = ray {
                    path.direction = ray.direction;
                    numbers.push((choice, on_light));
                    rays.push(ray);
                }
                ray.is_some()
            });
            let hits = self.bvh.intersect_all(&rays);
            hits.iter().flatten().for_each(|hit| self.surfaces.prefetch(hit));

            // Look at what was found, and add what it emits.
            for (&index, hit) in going.iter().zip(&hits) {
                if let Some(hit) = hit {
                    self.arrive(&mut paths[index], hit, share);
                }
            }
            if !passes_on {
                break;
            }

            // Add what lights send to it and it passes on.
            share = Share::All;
            let mut light_rays = LightRays::default();
            let mut arrived = Vec::with_capacity(going.len());
            for ((index, hit), (choice, on_light)) in going.into_iter().zip(hits).zip(numbers) {
                if hit.is_none() {
                    continue;
                }
                let path = &mut paths[index];
                let surface = path.at.surface;
                path.throughput *= path.at.albedo();
                if let Some(light) = self.unshadowed(&surface, share, choice.x, on_light) {
                    let counts = path.throughput / PI * light.irradiance;
                    light_rays.push(self.light_ray(&surface, &light), index, counts);
                }
                if self.survives(path, bounce, choice.y) {
                    arrived.push(index);
                }
            }
            light_rays.trace(&self.bvh, |path, irradiance| paths[path].scattered += irradiance);
            going = arrived;
        }
    }

    /// A ray about the shading normal; none where it points into the surface, which absorbs it.
    fn scattered_ray(&self, from: &WorldSurface, u: Vec2) -> Option<Ray> {
        let direction = Frame::around(from.normal).to_world(sampling::cosine_hemisphere(u));
        let origin = from.offset_position(self.radius);
        let leaves = direction.dot(from.geometric_normal) > 0.0;
        leaves.then_some(Ray { origin, direction, t_min: 0.0, t_max: f32::INFINITY })
    }

    /// Brings a path to the surface that its ray has hit. Adds what that emits, weighted against choosing it as
    /// one of the lights of `share`.
    fn arrive<'a>(&'a self, path: &mut Path<'a>, hit: &Hit, share: Share) {
        let direction = path.direction;
        let from = path.at.surface;
        path.at = self.look(hit, direction);
        let arrival =
            Arrival { from: from.position, normal: from.normal, direction, at: path.at.surface.position };
        if let Some((radiance, density)) = self.lights.found(hit.instance, hit.triangle, &arrival, share) {
            let cosine = from.normal.dot(direction);
            path.scattered += path.throughput * radiance * power_heuristic(cosine_density(cosine), density);
        }
    }

    /// Russian roulette for paths without a limit; where nothing is left, a path ends in any case.
    fn survives(&self, path: &mut Path<'_>, bounce: u32, u: f32) -> bool {
        if self.bounces.is_none() && bounce >= CERTAIN_BOUNCES {
            let survival = (luminance(path.throughput) / PI).clamp(0.05, HIGHEST_SURVIVAL);
            if u >= survival {
                return false;
            }
            path.throughput /= survival;
        }
        path.throughput != Vec3::ZERO
    }

    /// A light sample of `share`, were nothing between: its irradiance on the surface, where what a scattered ray
    /// could find as well counts by the power heuristic.
    fn unshadowed(&self, surface: &WorldSurface, share: Share, pick: f32, u: Vec2) -> Option<LightSample> {
        let mut light = self.lights.sample(surface.position, surface.normal, share, pick, u)?;
        let cosine = surface.normal.dot(light.direction);
        if cosine <= 0.0 || surface.geometric_normal.dot(light.direction) <= 0.0 {
            return None;
        }
        let weight = light.density.map_or(1.0, |density| power_heuristic(density, cosine_density(cosine)));
        light.irradiance *= cosine * weight;
        Some(light)
    }

    /// The ray that must be free for a light sample to arrive.
    fn light_ray(&self, surface: &WorldSurface, light: &LightSample) -> Ray {
        let origin = surface.offset_position(self.radius);
        match light.end {
            Some(end) => Ray { origin, direction: end - origin, t_min: 0.0, t_max: 1.0 },
            None => Ray { origin, direction: light.direction, t_min: 0.0, t_max: f32::INFINITY },
        }
    }

    /// The surface that a ray of `direction` has hit, on the side that it met.
    fn look(&self, hit: &Hit, direction: Vec3) -> Found<'_> {
        let (triangle, placement) = self.surfaces.of(hit);
        let found = placement.place(&triangle.interpolate(hit.barycentrics), Side::Facing(direction));
        let material = &self.scene.materials[triangle.material as usize];
        // Its texels are wanted when all paths have arrived, which gives them the time to come.
        let texels = material.albedo_texture.map(|texture| {
            let texture = &self.scene.textures[texture];
            (texture, texture.prefetch(found.uv))
        });
        Found { surface: found.surface, front: found.front, material, texels }
    }
}

impl LightRays {
    fn push(&mut self, ray: Ray, path: usize, counts: Vec3) {
        self.rays.push(ray);
        self.arriving.push((path, counts));
    }

    /// Gives `arrive` the light of all rays that meet nothing.
    fn trace(&self, bvh: &TwoLevelBvh, mut arrive: impl FnMut(usize, Vec3)) {
        for (occluded, &(path, light)) in bvh.occluded_all(&self.rays).into_iter().zip(&self.arriving) {
            if !occluded {
                arrive(path, light);
            }
        }
    }
}

/// Radiance towards the eye of a light's irradiance: Lambert and normalised Blinn-Phong.
fn reflected(light: &LightSample, found: &Found<'_>, albedo: Vec3, to_eye: Vec3) -> Vec3 {
    let (specular, shininess) = (found.material.specular, found.material.shininess);
    let half = (light.direction + to_eye).normalize_or(found.surface.normal);
    let lobe = found.surface.normal.dot(half).max(0.0).powf(shininess);
    light.irradiance * (albedo / PI + specular * ((shininess + 8.0) / (8.0 * PI) * lobe))
}
