//! Path tracing with next-event estimation. The paths of a group advance together, a bounce at a time, so that their
//! rays are traced in batches; they are independent otherwise.
//!
//! In: points in raster space. Out, for each: direct light, as radiance; indirect light, as irradiance at the visible
//! surface and as the radiance that its GGX lobe makes of it; and the features of that surface.
//!
//! With f the BSDF, g its GGX lobe, c the cosine to the shading normal and x0 the visible surface, two paths x0, x1, ...
//! estimate
//!
//! ```text
//! E(x0) = E_area(x0) + pi mean[ L(x1) ],         directions in proportion to c
//! R(x0) = R_area(x0) + mean[ g c / p L(x1) ],    directions by the visible normals of g, density p
//! L(x)  = Le(x) + sum over lights of f c E_light V + mean[ f c / p L(next) ]
//! ```
//!
//! (Kajiya 1986), where one light sample and one scattered ray estimate each integral, combined by the power heuristic.

use std::f32::consts::PI;
use std::iter;

use glam::{Vec2, Vec3};

use super::film::{PixelSample, VisibleSurface};
use super::light_sample::{LightSample, ShadowEnd, cosine_pdf, power_heuristic};
use super::lights::{LightSubset, ScatteredHit};
use super::path_tracer::Reference;
use super::sampler::Sampler;
use crate::bsdf::{Reflection, Sampled};
use crate::bvh::{Hit, Ray};
use crate::sampling::{self, Frame};
use crate::scene::{Attributes, Footprint, Material, SidedSurface, Texture, WorldSurface, luminance};

/// Bounces before Russian roulette begins on paths without a limit.
const MIN_BOUNCES: u32 = 3;

/// Highest survival probability of Russian roulette: paths between surfaces of albedo 1 must terminate too.
const MAX_SURVIVAL: f32 = 0.95;

/// A path in progress.
#[derive(Clone)]
struct Path<'a> {
    sampler: Sampler,
    /// Pixel.
    pixel: usize,
    /// The integral that it estimates.
    estimates: Estimates,
    /// Latest vertex.
    vertex: Interaction<'a>,
    /// How that reflects light towards the vertex before.
    reflection: Reflection,
    /// Direction of its latest ray, and the density with which it was sampled; none for that of a mirror.
    direction: Vec3,
    density: Option<f32>,
    /// Weight of the radiance along the next ray.
    throughput: Vec3,
    /// The estimate so far.
    gathered: Vec3,
}

/// The integral that a path estimates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Estimates {
    /// Irradiance at the visible surface, W/m^2.
    Irradiance,
    /// Radiance that the GGX lobe of the visible surface reflects, W/m^2/sr.
    Reflected,
}

/// The intersection of a ray with a surface.
#[derive(Clone, Copy)]
struct Interaction<'a> {
    surface: WorldSurface,
    front: bool,
    attributes: Attributes,
    material: &'a Material,
    /// The texels of its base colour, if it is textured.
    texels: Option<(&'a Texture, Footprint)>,
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
    pub(super) fn trace(&self, mut camera_samples: Vec<(Vec2, Sampler)>, samples: &mut [PixelSample]) {
        let rays: Vec<Ray> = camera_samples.iter().map(|&(point, _)| self.camera_ray(point)).collect();
        let world = self.world();
        let hits = self.intersect(&rays, |ray, hit| {
            world.pass_from_eye(&rays[ray], hit, iter::repeat_with(|| camera_samples[ray].1.next().x))
        });
        // Look up all surfaces before any texel is read.
        let mut visible = Vec::with_capacity(rays.len());
        for (pixel, ((_, sampler), (hit, weight))) in camera_samples.into_iter().zip(hits).enumerate() {
            let direction = rays[pixel].direction;
            let behind = match &self.scene.environment {
                Some(environment) => environment.radiance(direction.normalize()),
                None => self.scene.background,
            };
            samples[pixel] = PixelSample { direct: behind * weight, ..Default::default() };
            if let Some(hit) = hit {
                visible.push((pixel, sampler, self.interaction(&hit, direction), direction, weight, hit.t));
            }
        }
        let visible = visible.into_iter().map(|(pixel, sampler, vertex, direction, weight, depth)| {
            let reflection = self.reflection(&vertex, direction);
            let emission = vertex.material.emission_at(self.scene, vertex.attributes);
            let emits = vertex.material.emits_on(vertex.front);
            samples[pixel].direct = if emits { emission * weight } else { Vec3::ZERO };
            samples[pixel].visible = Some(VisibleSurface {
                albedo: reflection.diffuse_albedo() * weight,
                normal: vertex.surface.normal,
                position: vertex.surface.position + self.anchor,
                depth,
            });
            Path {
                sampler,
                pixel,
                estimates: Estimates::Reflected,
                vertex,
                reflection,
                direction,
                density: None,
                throughput: weight,
                gathered: Vec3::ZERO,
            }
        });
        let visible = visible.collect();

        let mut paths = self.shade_visible(visible, samples);
        self.trace_scattered(&mut paths);
        for path in paths {
            let sample = &mut samples[path.pixel];
            match path.estimates {
                Estimates::Irradiance => sample.irradiance += path.gathered,
                Estimates::Reflected => sample.reflected += path.gathered,
            }
        }
    }

    /// Adds a light sample of the direct lights, and one of area lights, to each visible surface, at which a path has begun;
    /// returns the paths that go on from there.
    fn shade_visible<'a>(&'a self, visible: Vec<Path<'a>>, samples: &mut [PixelSample]) -> Vec<Path<'a>> {
        let [mut direct, mut area, mut reflected]: [ShadowRays; 3] = Default::default();
        let mut paths = Vec::with_capacity(visible.len());
        for mut path in visible {
            let (picks, u_light) = (path.sampler.next(), path.sampler.next());
            let (pixel, reflection, weight) = (path.pixel, path.reflection, path.throughput);
            let surface = &path.vertex.surface;
            if let Some(light) = self.sample_light(surface, LightSubset::Direct, picks.x, u_light) {
                let lobes = reflection.evaluate(light.direction);
                let radiance = (lobes.diffuse + lobes.reflected) * weight * light.irradiance;
                samples[pixel].unshadowed = radiance;
                direct.push(self.shadow_ray(surface, &light), pixel, radiance);
            }
            if let Some(light) = self.sample_light(surface, LightSubset::Area, picks.y, u_light) {
                let ray = self.shadow_ray(surface, &light);
                let share = light.share(cosine_pdf(surface.normal.dot(light.direction)));
                area.push(ray, pixel, light.irradiance * share);
                if reflection.reflects() {
                    let share = light.share(reflection.reflected_density(light.direction));
                    let lobe = reflection.evaluate(light.direction).reflected;
                    reflected.push(ray, pixel, lobe * weight * light.irradiance * share);
                }
            }
            let mut scattered = path.clone();
            (scattered.estimates, scattered.throughput) = (Estimates::Irradiance, Vec3::splat(PI));
            if reflection.reflects() {
                path.sampler = path.sampler.fork();
                paths.push(path);
            }
            paths.push(scattered);
        }
        direct.trace(self, |pixel, radiance| {
            samples[pixel].lit = radiance;
            samples[pixel].direct += radiance;
        });
        area.trace(self, |pixel, irradiance| samples[pixel].irradiance += irradiance);
        reflected.trace(self, |pixel, radiance| samples[pixel].reflected += radiance);
        paths
    }

    /// Adds the light that scattered rays bring to the visible surfaces: emission that they hit, and light scattered at one to
    /// `bounces` surfaces.
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
                let ray = self.scatter(path, bounce, u_direction);
                // Beyond the bounce limit only emission counts.
                let ray = ray.filter(|ray| scatters || self.may_meet_light(ray));
                if let Some(ray) = ray {
                    numbers.push((u_choice, u_light));
                    rays.push(ray);
                }
                ray.is_some()
            });
            let world = self.world();
            let hits = self.intersect(&rays, |ray, hit| {
                let numbers = iter::repeat_with(|| paths[active[ray]].sampler.next().x);
                world.pass_thin_surfaces(&rays[ray], hit, numbers)
            });

            // Move the paths to the surfaces hit and add their emission.
            for (&index, (hit, weight)) in active.iter().zip(&hits) {
                let path = &mut paths[index];
                path.throughput *= *weight;
                match hit {
                    Some(hit) => self.advance(path, hit, subset),
                    None => self.leave(path, subset),
                }
            }
            if !scatters {
                break;
            }

            // Add one light sample at each new vertex.
            subset = LightSubset::All;
            let mut shadow_rays = ShadowRays::default();
            let mut surviving = Vec::with_capacity(active.len());
            for ((index, (hit, _)), (u_choice, u_light)) in active.into_iter().zip(hits).zip(numbers) {
                if hit.is_none() {
                    continue;
                }
                let path = &mut paths[index];
                path.reflection = self.reflection(&path.vertex, path.direction);
                let surface = path.vertex.surface;
                if let Some(light) = self.sample_light(&surface, subset, u_choice.x, u_light) {
                    let lobes = path.reflection.evaluate(light.direction);
                    let share = light.share(path.reflection.density(light.direction));
                    let contribution =
                        path.throughput * (lobes.diffuse + lobes.reflected) * light.irradiance * share;
                    shadow_rays.push(self.shadow_ray(&surface, &light), index, contribution);
                }
                if self.survives(path, bounce, u_choice.y) {
                    surviving.push(index);
                }
            }
            shadow_rays.trace(self, |path, light| paths[path].gathered += light);
            active = surviving;
        }
    }

    /// Samples the next ray of a path; none if nothing is reflected. One that the shading normal sends below the triangle is mirrored
    /// by it: no energy is lost. Light sampling cannot find such rays.
    fn scatter(&self, path: &mut Path<'_>, bounce: u32, u: Vec2) -> Option<Ray> {
        let surface = &path.vertex.surface;
        let sampled = match path.estimates {
            // Irradiance does not depend on what the visible surface reflects.
            Estimates::Irradiance if bounce == 1 => {
                let direction = Frame::around(surface.normal).to_world(sampling::cosine_hemisphere(u));
                let density = Some(cosine_pdf(surface.normal.dot(direction)));
                Sampled { direction, weight: Vec3::ONE, density }
            }
            Estimates::Reflected if bounce == 1 => path.reflection.sample_reflected(u)?,
            _ => {
                let pick = if path.reflection.reflects() { path.sampler.next().x } else { 1.0 };
                path.reflection.sample(pick, u)?
            }
        };
        path.throughput *= sampled.weight;
        (path.direction, path.density) = (sampled.direction, sampled.density);
        let origin = surface.offset_position();
        let above = sampled.direction.dot(surface.geometric_normal);
        if above <= 0.0 {
            path.direction -= 2.0 * above * surface.geometric_normal;
            path.density = None;
        }
        Some(Ray { origin, direction: path.direction, t_min: 0.0, t_max: f32::INFINITY })
    }

    fn may_meet_light(&self, ray: &Ray) -> bool {
        self.scene.environment.is_some() || self.lights.may_hit(ray)
    }

    /// Moves a path to the surface that its ray hit and adds its emission, weighted by MIS against light sampling
    /// among `subset`.
    fn advance<'a>(&'a self, path: &mut Path<'a>, hit: &Hit, subset: LightSubset) {
        let direction = path.direction;
        let from = path.vertex.surface;
        path.vertex = self.interaction(hit, direction);
        let at = path.vertex.surface.position;
        let scattered = ScatteredHit { from: from.position, normal: from.normal, direction, at };
        let vertex = &path.vertex;
        let emission = vertex.material.emission_at(self.scene, vertex.attributes);
        if vertex.material.emits_on(vertex.front)
            && let Some((radiance, pdf)) =
                self.lights.emitted(hit, vertex.front, emission, &scattered, subset)
        {
            let share = path.density.map_or(1.0, |density| power_heuristic(density, pdf));
            path.gathered += path.throughput * radiance * share;
        }
    }

    /// Adds the environment's light to a path whose ray left the scene, weighted by MIS likewise.
    fn leave(&self, path: &mut Path<'_>, subset: LightSubset) {
        let Some(environment) = &self.scene.environment else { return };
        let from = path.vertex.surface;
        let pdf = self.lights.environment_pdf(from.position, from.normal, path.direction, subset);
        let share = path.density.map_or(1.0, |density| power_heuristic(density, pdf));
        path.gathered += path.throughput * environment.radiance(path.direction) * share;
    }

    /// Russian roulette for paths without a limit. A path without throughput always ends.
    fn survives(&self, path: &mut Path<'_>, bounce: u32, u: f32) -> bool {
        let albedo = path.reflection.diffuse_albedo() + path.reflection.reflected_albedo();
        let next = path.throughput * albedo;
        if self.bounces.is_none() && bounce >= MIN_BOUNCES {
            let full = if path.estimates == Estimates::Irradiance { PI } else { 1.0 };
            let survival = (luminance(next) / full).clamp(0.05, MAX_SURVIVAL);
            if u >= survival {
                return false;
            }
            path.throughput /= survival;
        }
        next != Vec3::ZERO
    }

    /// Samples a light of `subset`, before the visibility test: its irradiance on the surface.
    fn sample_light(
        &self,
        surface: &WorldSurface,
        subset: LightSubset,
        pick: f32,
        u: Vec2,
    ) -> Option<LightSample> {
        let mut light = self.lights.sample(self.scene, surface, subset, pick, u)?;
        let cosine = surface.normal.dot(light.direction);
        if cosine <= 0.0 || surface.geometric_normal.dot(light.direction) <= 0.0 {
            return None;
        }
        light.irradiance *= cosine;
        Some(light)
    }

    /// The shadow ray of a light sample.
    fn shadow_ray(&self, surface: &WorldSurface, light: &LightSample) -> Ray {
        let origin = surface.offset_position();
        match light.end {
            ShadowEnd::Point(end) => Ray { origin, direction: end - origin, t_min: 0.0, t_max: 1.0 },
            ShadowEnd::Distance(t_max) => Ray { origin, direction: light.direction, t_min: 0.0, t_max },
        }
    }

    /// The surface that a ray of `direction` hit, on the side facing the ray.
    fn interaction(&self, hit: &Hit, direction: Vec3) -> Interaction<'_> {
        let (found, material) = self.surfaces.at(self.scene, hit, direction);
        let SidedSurface { front, surface, attributes } = found;
        let material = &self.scene.materials[material];
        // The texels are read only after all paths of the group advanced, so prefetch them.
        let texels = material.base_colour_texture.map(|image| {
            let texture = &*self.scene.textures[image.texture];
            (texture, texture.prefetch(image.coordinates(attributes.uvs), &image))
        });
        Interaction { surface, front, attributes, material, texels }
    }

    /// How a surface reflects light along a ray of `direction` backwards.
    fn reflection(&self, vertex: &Interaction<'_>, direction: Vec3) -> Reflection {
        let texel = vertex.texels.map_or(Vec3::ONE, |(texture, texels)| texture.filter(texels));
        let bsdf = vertex.material.bsdf(self.scene, texel, &vertex.attributes);
        bsdf.prepare(vertex.surface.normal, -direction.normalize())
    }
}

impl ShadowRays {
    fn push(&mut self, ray: Ray, path: usize, contribution: Vec3) {
        self.rays.push(ray);
        self.contributions.push((path, contribution));
    }

    /// Calls `add` with path and contribution of each ray on which light arrives.
    fn trace(&self, reference: &Reference<'_>, mut add: impl FnMut(usize, Vec3)) {
        for (share, &(path, contribution)) in
            reference.world().transmittance_all(&self.rays).into_iter().zip(&self.contributions)
        {
            if share != Vec3::ZERO {
                add(path, contribution * share);
            }
        }
    }
}
