//! One sample of one pixel: a path from the camera, lit at every surface that it meets.
//!
//! In: a ray through a pixel. Out: the light that shadow maps carry, as radiance; the light that VPLs carry, as
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
use crate::bvh::{Hit, Ray};
use crate::sampling::{self, Frame};
use crate::scene::{Material, Side, WorldSurface, luminance};

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

/// A surface that a ray has found.
struct Found<'a> {
    surface: WorldSurface,
    front: bool,
    material: &'a Material,
    uv: Vec2,
}

impl Reference<'_> {
    /// The sample of a path through `place`, a point of the picture in pixels.
    pub(super) fn trace(&self, place: Vec2, sampler: &mut Sampler) -> PixelSample {
        let ray = self.camera_ray(place);
        let direction = ray.direction;
        let Some(hit) = self.bvh.intersect(&ray) else {
            return PixelSample { direct: self.scene.background, ..Default::default() };
        };
        let found = self.look(&hit, direction);
        let (picks, on_light) = (sampler.next(), sampler.next());
        let emission = if found.front { found.material.emission } else { Vec3::ZERO };
        let to_eye = -direction.normalize();
        let first = found.surface;
        let irradiance =
            self.light(&first, Share::Area, picks.y, on_light) + self.scattered_light(&first, sampler);
        let albedo = found.material.albedo_at(self.scene, found.uv);
        PixelSample {
            direct: emission + self.direct_light(&found, albedo, to_eye, picks.x, on_light),
            irradiance,
            seen: Some(Seen {
                albedo,
                normal: first.normal,
                position: first.position,
                depth: hit.t,
            }),
        }
    }

    /// Radiance towards the eye of point, spot and directional lights: Lambert and normalised Blinn-Phong.
    fn direct_light(
        &self,
        found: &Found<'_>,
        albedo: Vec3,
        to_eye: Vec3,
        pick: f32,
        u: Vec2,
    ) -> Vec3 {
        let Some((light, cosine)) = self.unshadowed(&found.surface, Share::ShadowMapped, pick, u) else {
            return Vec3::ZERO;
        };
        let (specular, shininess) = (found.material.specular, found.material.shininess);
        let half = (light.direction + to_eye).normalize_or(found.surface.normal);
        let lobe = found.surface.normal.dot(half).max(0.0).powf(shininess);
        let reflectance = albedo / PI + specular * ((shininess + 8.0) / (8.0 * PI) * lobe);
        light.irradiance * cosine * reflectance
    }

    /// Irradiance of one light sample of `share` at a surface. What a scattered ray could find as well counts
    /// by the power heuristic.
    fn light(&self, surface: &WorldSurface, share: Share, pick: f32, u: Vec2) -> Vec3 {
        match self.unshadowed(surface, share, pick, u) {
            Some((light, cosine)) => {
                let weight =
                    light.density.map_or(1.0, |density| power_heuristic(density, cosine_density(cosine)));
                light.irradiance * (cosine * weight)
            }
            None => Vec3::ZERO,
        }
    }

    /// A light sample that reaches the surface, with the cosine there.
    fn unshadowed(
        &self,
        surface: &WorldSurface,
        share: Share,
        pick: f32,
        u: Vec2,
    ) -> Option<(LightSample, f32)> {
        let light = self.lights.sample(surface.position, surface.normal, share, pick, u)?;
        let cosine = surface.normal.dot(light.direction);
        if cosine <= 0.0 || surface.geometric_normal.dot(light.direction) <= 0.0 {
            return None;
        }
        let origin = surface.offset_position(self.radius);
        let ray = match light.end {
            Some(end) => Ray { origin, direction: end - origin, t_min: 0.0, t_max: 1.0 },
            None => Ray { origin, direction: light.direction, t_min: 0.0, t_max: f32::INFINITY },
        };
        (!self.bvh.occluded(&ray)).then_some((light, cosine))
    }

    /// Irradiance at the visible surface that scattered rays bring: emission that they find, and light that
    /// one to `bounces` surfaces pass on.
    fn scattered_light(&self, first: &WorldSurface, sampler: &mut Sampler) -> Vec3 {
        let mut sum = Vec3::ZERO;
        let mut from = *first;
        // What the radiance along the next ray counts for.
        let mut throughput = Vec3::splat(PI);
        let mut share = Share::Area;
        for bounce in 1.. {
            let passes_on = self.bounces.is_none_or(|limit| bounce <= limit);
            if !passes_on && !self.lights_can_be_found {
                break;
            }
            let (turn, choice, on_light) = (sampler.next(), sampler.next(), sampler.next());

            // Scatter about the shading normal; what points into the surface is absorbed.
            let direction = Frame::around(from.normal).to_world(sampling::cosine_hemisphere(turn));
            if direction.dot(from.geometric_normal) <= 0.0 {
                break;
            }
            let origin = from.offset_position(self.radius);
            let ray = Ray { origin, direction, t_min: 0.0, t_max: f32::INFINITY };
            let Some(hit) = self.bvh.intersect(&ray) else { break };
            let found = self.look(&hit, direction);

            // Add what the surface emits, weighted against choosing it as a light.
            let arrival =
                Arrival { from: from.position, normal: from.normal, direction, at: found.surface.position };
            if let Some((radiance, density)) = self.lights.found(hit.instance, hit.triangle, &arrival, share)
            {
                let cosine = from.normal.dot(direction);
                sum += throughput * radiance * power_heuristic(cosine_density(cosine), density);
            }
            if !passes_on {
                break;
            }

            // Add what lights send to it and it passes on.
            share = Share::All;
            let arriving = self.light(&found.surface, share, choice.x, on_light);
            throughput *= found.material.albedo_at(self.scene, found.uv);
            sum += throughput / PI * arriving;

            // Russian roulette.
            if self.bounces.is_none() && bounce >= CERTAIN_BOUNCES {
                let survival = (luminance(throughput) / PI).clamp(0.05, HIGHEST_SURVIVAL);
                if choice.y >= survival {
                    break;
                }
                throughput /= survival;
            }
            if throughput == Vec3::ZERO {
                break;
            }
            from = found.surface;
        }
        sum
    }

    /// The surface that a ray of `direction` has hit, on the side that it met.
    fn look(&self, hit: &Hit, direction: Vec3) -> Found<'_> {
        let (triangle, placement) = self.surfaces.of(hit);
        let found = placement.place(&triangle.interpolate(hit.barycentrics), Side::Facing(direction));
        let material = &self.scene.materials[triangle.material as usize];
        // Its texels are wanted after the rays to the lights, which give them the time to come.
        if let Some(texture) = material.albedo_texture {
            self.scene.textures[texture].prefetch(found.uv);
        }
        Found { surface: found.surface, front: found.front, material, uv: found.uv }
    }
}
