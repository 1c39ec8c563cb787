//! The world at one moment, and rays through its thin surfaces, which tint light without refracting it.
//!
//! In: rays. Out: where the light of each stops, with the weight of that; or the share of the light that arrives at its end. Light
//! that meets a thin surface passes it or stops there at random, in proportion to what passes.

use glam::Vec3;
use rayon::prelude::*;

use super::ray::{Hit, Occlusion, RAYS_PER_TASK, Ray};
use super::two_level::TwoLevelBvh;
use crate::scene::{Pose, Scene, Side, SurfacePoint};

/// The world at one moment, on the CPU.
#[derive(Clone, Copy, Debug)]
pub struct World<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// Where everything stands now.
    pub pose: &'a Pose,
    /// BVH, already updated to `pose`.
    pub bvh: &'a TwoLevelBvh,
}

/// Effect of thin surfaces on a ray's light, by channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transmission {
    /// The share that the thin surfaces let pass in which it has not stopped.
    pub transmittance: Vec3,
    /// The weight of where it stopped, which was chosen at random: the share of the light that arrives there over the probability.
    pub weight: Vec3,
}

impl Transmission {
    /// A ray that has met no thin surface.
    pub const CLEAR: Self = Self { transmittance: Vec3::ONE, weight: Vec3::ONE };
}

impl World<'_> {
    /// Where the light along a ray stops, whose closest hit is `hit`, and how it came there. `numbers`:
    /// random ones in [0, 1), for each thin surface that may stop it.
    pub fn pass_thin_surfaces(
        &self,
        ray: &Ray,
        hit: Option<Hit>,
        numbers: impl Iterator<Item = f32>,
    ) -> (Option<Hit>, Transmission) {
        self.pass(ray, hit, numbers, |rest| self.bvh.intersect(rest))
    }

    /// [`Self::pass_thin_surfaces`] for a ray from the eye, which passes the backs of single-sided surfaces as if they were not there.
    pub fn pass_from_eye(
        &self,
        ray: &Ray,
        hit: Option<Hit>,
        numbers: impl Iterator<Item = f32>,
    ) -> (Option<Hit>, Transmission) {
        let seen = |rest: &Ray, hit| self.behind_hidden(rest, hit);
        self.pass(ray, seen(ray, hit), numbers, |rest| seen(rest, self.bvh.intersect(rest)))
    }

    fn pass(
        &self,
        ray: &Ray,
        hit: Option<Hit>,
        mut numbers: impl Iterator<Item = f32>,
        intersect: impl Fn(&Ray) -> Option<Hit>,
    ) -> (Option<Hit>, Transmission) {
        let (mut hit, mut transmission) = (hit, Transmission::CLEAR);
        if !self.bvh.has_thin_surfaces() {
            return (hit, transmission);
        }
        while let Some(met) = hit {
            let Some((coverage, passed)) = self.thin_surface(&met, ray.direction) else { break };
            let passes = passed.max_element();
            // A surface that passes all light of a channel takes no number, so that invisible ones change nothing.
            if passes < 1.0 && numbers.next().is_some_and(|number| number >= passes) {
                transmission.weight *= coverage / (1.0 - passes);
                break;
            }
            transmission.weight *= passed / passes;
            transmission.transmittance *= passed;
            hit = intersect(&beyond(ray, &met));
        }
        (hit, transmission)
    }

    /// The surface that a ray shows the eye: its closest hit behind all thin surfaces that let more than half of the light pass.
    pub fn visible(&self, ray: &Ray) -> Option<Hit> {
        self.behind_clear_surfaces(ray, self.bvh.intersect(ray))
    }

    /// [`Self::visible`] for many rays over all cores.
    pub fn visible_batch(&self, rays: &[Ray]) -> Vec<Option<Hit>> {
        let hits = self.bvh.intersect_batch(rays).into_iter().zip(rays);
        hits.map(|(hit, ray)| self.behind_clear_surfaces(ray, hit)).collect()
    }

    fn behind_clear_surfaces(&self, ray: &Ray, hit: Option<Hit>) -> Option<Hit> {
        self.pass_from_eye(ray, hit, std::iter::repeat(0.5)).0
    }

    /// The closest hit that the eye sees on a ray whose closest one is `hit`, be it a thin surface.
    pub fn behind_hidden(&self, ray: &Ray, mut hit: Option<Hit>) -> Option<Hit> {
        while let Some(met) = hit.filter(|met| self.is_hidden(met, ray.direction)) {
            hit = self.bvh.intersect(&beyond(ray, &met));
        }
        hit
    }

    /// Whether a ray of this direction hits the back of a single-sided surface.
    fn is_hidden(&self, hit: &Hit, direction: Vec3) -> bool {
        let mesh = &self.scene.meshes[self.scene.instances[hit.instance as usize].mesh];
        let material = mesh.triangle_materials[hit.triangle as usize];
        if self.scene.materials[material as usize].double_sided {
            return false;
        }
        // In object space, where mirroring does not matter.
        let [a, b, c] = mesh.triangle_positions(hit.triangle);
        let local = self.pose.instances[hit.instance as usize].matrix3.inverse() * direction;
        (b - a).cross(c - a).dot(local) >= 0.0
    }

    /// The share of light that arrives along the segment, by channel: 0 where something opaque lies on it.
    pub fn transmittance(&self, ray: &Ray) -> Vec3 {
        self.tint(ray, self.bvh.occlusion(ray))
    }

    /// [`Self::transmittance`] for many rays on this thread; results in the order of the rays.
    pub fn transmittance_all(&self, rays: &[Ray]) -> Vec<Vec3> {
        let occlusions = self.bvh.occlusion_all(rays);
        rays.iter().zip(occlusions).map(|(ray, occlusion)| self.tint(ray, occlusion)).collect()
    }

    /// [`Self::transmittance_all`] over all cores.
    pub fn transmittance_batch(&self, rays: &[Ray]) -> Vec<Vec3> {
        rays.par_chunks(RAYS_PER_TASK).flat_map_iter(|rays| self.transmittance_all(rays)).collect()
    }

    fn tint(&self, ray: &Ray, occlusion: Occlusion) -> Vec3 {
        match occlusion {
            Occlusion::Clear => Vec3::ONE,
            Occlusion::Opaque => Vec3::ZERO,
            Occlusion::ThinSurfaces => self.tint_of_thin_surfaces(ray),
        }
    }

    /// The product of all thin surfaces on a segment.
    fn tint_of_thin_surfaces(&self, ray: &Ray) -> Vec3 {
        let (mut tint, mut rest) = (Vec3::ONE, *ray);
        while tint != Vec3::ZERO {
            let Some(hit) = self.bvh.intersect(&rest) else { break };
            let Some((_, passed)) = self.thin_surface(&hit, ray.direction) else { return Vec3::ZERO };
            tint *= passed;
            rest = beyond(ray, &hit);
        }
        tint
    }

    /// If the surface is a thin surface: how much of it is there, and what it lets pass of light in this direction.
    fn thin_surface(&self, hit: &Hit, direction: Vec3) -> Option<(f32, Vec3)> {
        let mesh = &self.scene.meshes[self.scene.instances[hit.instance as usize].mesh];
        let material = mesh.triangle_materials[hit.triangle as usize];
        let material = &self.scene.materials[material as usize];
        if !material.is_thin_surface() {
            return None;
        }
        let point = SurfacePoint { triangle: hit.triangle, barycentrics: hit.barycentrics };
        let found = self.scene.surface_at(self.pose, hit.instance, point, Side::Facing(direction));
        let bsdf = material.bsdf_at(self.scene, found.attributes);
        let reflection = bsdf.prepare(found.surface.normal, -direction.normalize());
        let thin_surface = material.thin_surface_at(self.scene, found.attributes);
        Some((thin_surface.coverage, thin_surface.transmittance(reflection.reflected_albedo().max_element())))
    }
}

/// The rest of a ray behind what it hit.
fn beyond(ray: &Ray, hit: &Hit) -> Ray {
    Ray { t_min: hit.t.next_up(), ..*ray }
}
