//! Path tracing with next-event estimation. The paths of a group advance together, a bounce at a time, so that their
//! rays are traced in batches; they are independent otherwise.
//!
//! In: points in raster space. Out, for each: direct light, as radiance; indirect light, as irradiance at the visible
//! surface; and the features of that surface.
//!
//! With rho the albedo, n the shading normal and x0 the visible surface, the path x0, x1, ... estimates
//!
//! ```text
//! E(x0) = E_area(x0) + pi mean[ rho(x1)/pi E_all(x1) + rho(x1) rho(x2)/pi E_all(x2) + ... ]
//! ```
//!
//! (Kajiya 1986), where one light sample and one scattered ray estimate each E, combined by the power heuristic.

use std::f32::consts::PI;

use glam::{Vec2, Vec3};

use super::Reference;
use super::lights::{LightSample, LightSubset, ScatteredHit, cosine_pdf, power_heuristic};
use super::sampler::Sampler;
use crate::bvh::{Hit, Ray, TwoLevelBvh};
use crate::sampling::{self, Frame};
use crate::scene::{Footprint, Material, Side, Texture, WorldSurface, luminance};

/// Bounces before Russian roulette begins on paths without a limit.
const MIN_BOUNCES: u32 = 3;

/// Highest survival probability of Russian roulette: paths between surfaces of albedo 1 must terminate too.
const MAX_SURVIVAL: f32 = 0.95;

/// One sample of a pixel.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct PixelSample {
    /// Direct radiance of point, spot and directional lights, with emission and background, W/m^2/sr.
    pub(super) direct: Vec3,
    /// Irradiance at the visible surface by area lights and indirect light, W/m^2: the part that VPLs estimate.
    pub(super) irradiance: Vec3,
    /// The visible surface; none if the camera ray missed.
    pub(super) visible: Option<VisibleSurface>,
}

/// Features of the visible surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct VisibleSurface {
    pub(super) albedo: Vec3,
    /// Unit shading normal, world space.
    pub(super) normal: Vec3,
    /// World position.
    pub(super) position: Vec3,
    /// View depth: distance along the view axis.
    pub(super) depth: f32,
}

impl PixelSample {
    /// Radiance of the pixel: direct + albedo/pi * irradiance.
    pub(super) fn radiance(&self) -> Vec3 {
        let albedo = self.visible.map_or(Vec3::ZERO, |visible| visible.albedo);
        self.direct + albedo / PI * self.irradiance
    }
}

/// A path in progress.
struct Path<'a> {
    sampler: Sampler,
    sample: PixelSample,
    /// Its latest vertex.
    vertex: Interaction<'a>,
    /// Direction of its latest ray.
    direction: Vec3,
    /// Weight of the radiance along the next ray.
    throughput: Vec3,
    /// Irradiance at the visible surface by scattered rays, W/m^2.
    scattered: Vec3,
}

/// The intersection of a ray with a surface.
#[derive(Clone, Copy)]
struct Interaction<'a> {
    surface: WorldSurface,
    front: bool,
    material: &'a Material,
    /// The texels of its albedo, if it is textured.
    texels: Option<(&'a Texture, Footprint)>,
}

impl Interaction<'_> {
    fn albedo(&self) -> Vec3 {
        self.texels.map_or(Vec3::ONE, |(texture, texels)| texture.filter(texels)) * self.material.albedo
    }
}

/// Shadow rays, and the contributions of those that are unoccluded.
#[derive(Default)]
struct ShadowRays {
    rays: Vec<Ray>,
    /// Path and contribution of each ray.
    contributions: Vec<(usize, Vec3)>,
}

impl Reference<'_> {
    /// Traces one sample for each of `camera_samples` (a point in raster space and a sampler) into `samples`, of the
    /// same length.
    pub(super) fn trace(&self, camera_samples: Vec<(Vec2, Sampler)>, samples: &mut [PixelSample]) {
        let rays: Vec<Ray> = camera_samples.iter().map(|&(point, _)| self.camera_ray(point)).collect();
        let hits = self.bvh.intersect_all(&rays);
        hits.iter().flatten().for_each(|hit| self.surfaces.prefetch(hit));
        samples.fill(PixelSample { direct: self.scene.background, ..Default::default() });
        let (mut paths, mut pixels) = (Vec::with_capacity(rays.len()), Vec::with_capacity(rays.len()));
        for (pixel, ((_, sampler), hit)) in camera_samples.into_iter().zip(&hits).enumerate() {
            let Some(hit) = hit else { continue };
            let direction = rays[pixel].direction;
            let vertex = self.interaction(hit, direction);
            let visible = VisibleSurface {
                albedo: Vec3::ZERO,
                normal: vertex.surface.normal,
                position: vertex.surface.position,
                depth: hit.t,
            };
            let sample = PixelSample { visible: Some(visible), ..Default::default() };
            let (throughput, scattered) = (Vec3::splat(PI), Vec3::ZERO);
            paths.push(Path { sampler, sample, vertex, direction, throughput, scattered });
            pixels.push(pixel);
        }

        self.shade_visible(&mut paths);
        self.trace_scattered(&mut paths);
        for (path, pixel) in paths.into_iter().zip(pixels) {
            let irradiance = path.sample.irradiance + path.scattered;
            samples[pixel] = PixelSample { irradiance, ..path.sample };
        }
    }

    /// Adds the emission of the visible surfaces and one light sample each of shadow-mapped and area lights.
    fn shade_visible(&self, paths: &mut [Path<'_>]) {
        let (mut shadow_mapped, mut area) = (ShadowRays::default(), ShadowRays::default());
        for (index, path) in paths.iter_mut().enumerate() {
            let (picks, u_light) = (path.sampler.next(), path.sampler.next());
            let vertex = &path.vertex;
            let albedo = vertex.albedo();
            path.sample.direct = if vertex.front { vertex.material.emission } else { Vec3::ZERO };
            if let Some(visible) = &mut path.sample.visible {
                visible.albedo = albedo;
            }
            let to_eye = -path.direction.normalize();
            if let Some(light) =
                self.sample_light(&vertex.surface, LightSubset::ShadowMapped, picks.x, u_light)
            {
                let radiance = reflected(&light, vertex, albedo, to_eye);
                shadow_mapped.push(self.shadow_ray(&vertex.surface, &light), index, radiance);
            }
            if let Some(light) = self.sample_light(&vertex.surface, LightSubset::Area, picks.y, u_light) {
                area.push(self.shadow_ray(&vertex.surface, &light), index, light.irradiance);
            }
        }
        shadow_mapped.trace(&self.bvh, |path, radiance| paths[path].sample.direct += radiance);
        area.trace(&self.bvh, |path, irradiance| paths[path].sample.irradiance += irradiance);
    }

    /// Adds the irradiance at the visible surfaces by scattered rays: emission that they hit, and light scattered at
    /// one to `bounces` surfaces.
    fn trace_scattered<'a>(&'a self, paths: &mut [Path<'a>]) {
        let mut active: Vec<usize> = (0..paths.len()).collect();
        let mut subset = LightSubset::Area;
        for bounce in 1.. {
            let scatters = self.bounces.is_none_or(|limit| bounce <= limit);
            if active.is_empty() || !scatters && !self.any_light_hittable {
                break;
            }

            // Sample scattered rays.
            let mut numbers = Vec::with_capacity(active.len());
            let mut rays = Vec::with_capacity(active.len());
            active.retain(|&index| {
                let path = &mut paths[index];
                let [u_direction, u_choice, u_light] = std::array::from_fn(|_| path.sampler.next());
                // Beyond the bounce limit only emission counts.
                let ray = self.scattered_ray(&path.vertex.surface, u_direction);
                let ray = ray.filter(|ray| scatters || self.lights.may_hit(ray));
                if let Some(ray) = ray {
                    path.direction = ray.direction;
                    numbers.push((u_choice, u_light));
                    rays.push(ray);
                }
                ray.is_some()
            });
            let hits = self.bvh.intersect_all(&rays);
            hits.iter().flatten().for_each(|hit| self.surfaces.prefetch(hit));

            // Move the paths to the surfaces hit and add their emission.
            for (&index, hit) in active.iter().zip(&hits) {
                if let Some(hit) = hit {
                    self.advance(&mut paths[index], hit, subset);
                }
            }
            if !scatters {
                break;
            }

            // Add one light sample at each new vertex.
            subset = LightSubset::All;
            let mut shadow_rays = ShadowRays::default();
            let mut surviving = Vec::with_capacity(active.len());
            for ((index, hit), (u_choice, u_light)) in active.into_iter().zip(hits).zip(numbers) {
                if hit.is_none() {
                    continue;
                }
                let path = &mut paths[index];
                let surface = path.vertex.surface;
                path.throughput *= path.vertex.albedo();
                if let Some(light) = self.sample_light(&surface, subset, u_choice.x, u_light) {
                    let contribution = path.throughput / PI * light.irradiance;
                    shadow_rays.push(self.shadow_ray(&surface, &light), index, contribution);
                }
                if self.survives(path, bounce, u_choice.y) {
                    surviving.push(index);
                }
            }
            shadow_rays.trace(&self.bvh, |path, irradiance| paths[path].scattered += irradiance);
            active = surviving;
        }
    }

    /// Samples a cosine-weighted ray about the shading normal; none if it points into the surface, which absorbs it.
    fn scattered_ray(&self, from: &WorldSurface, u: Vec2) -> Option<Ray> {
        let direction = Frame::around(from.normal).to_world(sampling::cosine_hemisphere(u));
        let origin = from.offset_position(self.radius);
        let above = direction.dot(from.geometric_normal) > 0.0;
        above.then_some(Ray { origin, direction, t_min: 0.0, t_max: f32::INFINITY })
    }

    /// Moves a path to the surface that its ray hit and adds its emission, weighted by MIS against light sampling
    /// among `subset`.
    fn advance<'a>(&'a self, path: &mut Path<'a>, hit: &Hit, subset: LightSubset) {
        let direction = path.direction;
        let from = path.vertex.surface;
        path.vertex = self.interaction(hit, direction);
        let at = path.vertex.surface.position;
        let scattered = ScatteredHit { from: from.position, normal: from.normal, direction, at };
        if let Some((radiance, pdf)) = self.lights.emitted(hit.instance, hit.triangle, &scattered, subset) {
            let cosine = from.normal.dot(direction);
            path.scattered += path.throughput * radiance * power_heuristic(cosine_pdf(cosine), pdf);
        }
    }

    /// Russian roulette for paths without a limit. A path without throughput always ends.
    fn survives(&self, path: &mut Path<'_>, bounce: u32, u: f32) -> bool {
        if self.bounces.is_none() && bounce >= MIN_BOUNCES {
            let survival = (luminance(path.throughput) / PI).clamp(0.05, MAX_SURVIVAL);
            if u >= survival {
                return false;
            }
            path.throughput /= survival;
        }
        path.throughput != Vec3::ZERO
    }

    /// Samples a light of `subset`, before the visibility test: its irradiance on the surface, weighted by MIS against
    /// scattered rays.
    fn sample_light(
        &self,
        surface: &WorldSurface,
        subset: LightSubset,
        pick: f32,
        u: Vec2,
    ) -> Option<LightSample> {
        let mut light = self.lights.sample(surface.position, surface.normal, subset, pick, u)?;
        let cosine = surface.normal.dot(light.direction);
        if cosine <= 0.0 || surface.geometric_normal.dot(light.direction) <= 0.0 {
            return None;
        }
        let weight = light.pdf.map_or(1.0, |pdf| power_heuristic(pdf, cosine_pdf(cosine)));
        light.irradiance *= cosine * weight;
        Some(light)
    }

    /// The shadow ray of a light sample.
    fn shadow_ray(&self, surface: &WorldSurface, light: &LightSample) -> Ray {
        let origin = surface.offset_position(self.radius);
        match light.end {
            Some(end) => Ray { origin, direction: end - origin, t_min: 0.0, t_max: 1.0 },
            None => Ray { origin, direction: light.direction, t_min: 0.0, t_max: f32::INFINITY },
        }
    }

    /// The surface that a ray of `direction` hit, on the side facing the ray.
    fn interaction(&self, hit: &Hit, direction: Vec3) -> Interaction<'_> {
        let (triangle, placement) = self.surfaces.at(hit);
        let found = placement.place(&triangle.interpolate(hit.barycentrics), Side::Facing(direction));
        let material = &self.scene.materials[triangle.material as usize];
        // The texels are read only after all paths of the group advanced, so prefetch them.
        let texels = material.albedo_texture.map(|texture| {
            let texture = &self.scene.textures[texture];
            (texture, texture.prefetch(found.uv))
        });
        Interaction { surface: found.surface, front: found.front, material, texels }
    }
}

impl ShadowRays {
    fn push(&mut self, ray: Ray, path: usize, contribution: Vec3) {
        self.rays.push(ray);
        self.contributions.push((path, contribution));
    }

    /// Calls `add` with path and contribution of each unoccluded ray.
    fn trace(&self, bvh: &TwoLevelBvh, mut add: impl FnMut(usize, Vec3)) {
        for (occluded, &(path, contribution)) in
            bvh.occluded_all(&self.rays).into_iter().zip(&self.contributions)
        {
            if !occluded {
                add(path, contribution);
            }
        }
    }
}

/// Reflected radiance towards the eye: Lambert and normalised Blinn-Phong.
fn reflected(light: &LightSample, vertex: &Interaction<'_>, albedo: Vec3, to_eye: Vec3) -> Vec3 {
    let (specular, shininess) = (vertex.material.specular, vertex.material.shininess);
    let half = (light.direction + to_eye).normalize_or(vertex.surface.normal);
    let lobe = vertex.surface.normal.dot(half).max(0.0).powf(shininess);
    light.irradiance * (albedo / PI + specular * ((shininess + 8.0) / (8.0 * PI) * lobe))
}
