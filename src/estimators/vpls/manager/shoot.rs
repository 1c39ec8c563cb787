//! Traces light paths through the scene, all rays of one bounce in one batch.
//!
//! In: ranges of light paths, and the world. Out: their slots filled (Keller 1997; docs/VPLS.md, "Paths"). Rays pass thin
//! surfaces or stop there at random, in proportion to what passes.

use glam::{Vec2, Vec3};
use rayon::prelude::*;

use super::assignment::{NONE, PathRange};
use super::emitter::Source;
use super::glossy_lobe::GlossyLobe;
use super::slots::{Slot, SlotState};
use super::vpl_manager::VplManager;
use crate::bvh::{Hit, Ray, Transmission, World};
use crate::scene::{Side, SurfacePoint, WorldSurface};

/// Minimum number of slots per task.
pub(super) const SLOTS_PER_TASK: usize = 256;

/// Fraction of the hit distance up to which nothing opaque occludes a shot ray; excludes the hit itself.
const HIT_MARGIN: f32 = 1.0 - 1e-5;

/// How the shot of a slot starts.
enum Start {
    /// The path has ended.
    Escape,
    /// A primary VPL on the light: instance, point, weight.
    OnLight(u32, SurfacePoint, Side, Vec3),
    /// A primary VPL at infinity: place in the environment's map, weight.
    AtInfinity(Vec2, Vec3),
    /// A ray to trace, with its weight.
    Trace(Ray, Vec3),
}

impl VplManager {
    /// Shoots the slots of all ranges, parents before their children.
    pub(super) fn shoot(&mut self, world: World<'_>, ranges: &[PathRange]) {
        let last = ranges.iter().map(|range| range.end).max().unwrap_or(0);
        for level in 0..last {
            let in_level = ranges.iter().filter(|range| (range.start..range.end).contains(&level));
            let slots: Vec<u32> = in_level.map(|range| self.assignment.path(range.path)[level]).collect();
            self.shoot_batch(world, &slots);
            self.propagate_escapes(ranges, level);
        }
    }

    /// Shoots slots none of which is the parent of another.
    fn shoot_batch(&mut self, world: World<'_>, slots: &[u32]) {
        // Sample the rays of all candidates.
        let this = &*self;
        let candidates: Vec<(u32, u32)> = slots
            .iter()
            .flat_map(|&slot| (0..this.candidates(slot)).map(move |index| (slot, index)))
            .collect();
        let starts: Vec<Start> = candidates
            .par_iter()
            .with_min_len(SLOTS_PER_TASK)
            .map(|&(slot, index)| this.start(slot, index))
            .collect();
        // Trace them.
        let rays: Vec<Ray> = starts
            .iter()
            .filter_map(|start| if let Start::Trace(ray, _) = start { Some(*ray) } else { None })
            .collect();
        let mut hits = world.bvh.intersect_batch(&rays).into_iter();
        let traced: Vec<Option<Hit>> = starts
            .iter()
            .map(|start| match start {
                Start::Trace(..) => hits.next().flatten(),
                _ => None,
            })
            .collect();
        // Choose one candidate for each slot.
        let shots: Vec<(Slot, WorldSurface)> = (&candidates, &starts, &traced)
            .into_par_iter()
            .with_min_len(SLOTS_PER_TASK)
            .map(|(&candidate, start, hit)| this.store_hit(world, candidate, start, *hit))
            .collect();
        let mut rest = &shots[..];
        for &slot in slots {
            let (candidates, others) = rest.split_at(self.candidates(slot) as usize);
            rest = others;
            let choice = self.layout.choice(&self.assignment.addresses[slot as usize]);
            let (chosen, surface) = self.placement.choose(candidates, choice);
            self.slots[slot as usize] = chosen;
            self.surfaces[slot as usize] = surface;
        }
    }

    /// Candidates that a shot of `slot` would choose from now; none if it is unassigned.
    pub(super) fn candidates(&self, slot: u32) -> u32 {
        let address = &self.assignment.addresses[slot as usize];
        match address.light {
            NONE => 0,
            light => {
                let first_bounce = self.changes.emitters[light as usize].first_bounce();
                self.placement.candidates(light, address.bounce - first_bounce)
            }
        }
    }

    fn start(&self, slot: u32, candidate: u32) -> Start {
        let address = &self.assignment.addresses[slot as usize];
        let u = || self.layout.point(address, 0, candidate);
        match (address.parent, &self.changes.emitters[address.light as usize].source) {
            (NONE, Source::Area(table)) => {
                let (point, side, weight) = table.sample(u());
                Start::OnLight(table.instance, point, side, weight)
            }
            (NONE, Source::Environment(sky)) => {
                let (uv, weight) = sky.sample(u());
                Start::AtInfinity(uv, weight)
            }
            _ => {
                let traced = self.sample_ray(slot, candidate);
                traced.map_or(Start::Escape, |(ray, weight)| Start::Trace(ray, weight))
            }
        }
    }

    /// The ray that a shot of `slot` would trace now for a candidate, with its weight; none if the parent is not valid, or if the
    /// lobe has no such direction. Not for primary VPLs.
    pub(super) fn sample_ray(&self, slot: u32, candidate: u32) -> Option<(Ray, Vec3)> {
        let address = &self.assignment.addresses[slot as usize];
        let emitter = &self.changes.emitters[address.light as usize];
        let u = self.layout.point(address, address.bounce - emitter.first_bounce(), candidate);
        if address.parent == NONE {
            let (ray, weight) = emitter.first_ray(u)?;
            return Some((ray, Vec3::splat(weight)));
        }
        let slot = &self.slots[address.parent as usize];
        if slot.state != SlotState::Valid {
            return None;
        }
        let parent = &self.surfaces[address.parent as usize];
        if let (1, Source::Environment(sky)) = (address.bounce, &emitter.source) {
            let (ray, weight) = sky.next_ray(parent, u);
            return Some((ray, Vec3::splat(weight)));
        }
        let (direction, weight) = slot.lobe.sample(parent.geometric_normal, u)?;
        let origin = parent.offset_position();
        Some((Ray { origin, direction, t_min: 0.0, t_max: f32::INFINITY }, weight))
    }

    /// Where the ray of a slot's candidate stops, whose closest hit is `hit`, and how it came there. The random numbers belong to
    /// the candidate, so the same ray stops at the same thin surface again.
    pub(super) fn pass_thin_surfaces(
        &self,
        world: World<'_>,
        (slot, candidate): (u32, u32),
        ray: &Ray,
        hit: Option<Hit>,
    ) -> (Option<Hit>, Transmission) {
        let address = &self.assignment.addresses[slot as usize];
        world.pass_thin_surfaces(ray, hit, (0..).map(|nth| self.layout.thin_number(address, candidate, nth)))
    }

    /// The slot as one of its candidates fills it, whose ray first hits `hit`.
    fn store_hit(
        &self,
        world: World<'_>,
        (slot, candidate): (u32, u32),
        start: &Start,
        hit: Option<Hit>,
    ) -> (Slot, WorldSurface) {
        let address = &self.assignment.addresses[slot as usize];
        let parent = self.slots.get(address.parent as usize);
        let (fresh, throughput) =
            parent.map_or((true, Vec3::ONE), |parent| (parent.fresh, parent.throughput * parent.gain));
        let escaped = Slot::escaped(fresh, self.frame);
        let valid = Slot { state: SlotState::Valid, ..escaped };
        let surface_at = |instance: u32, point: SurfacePoint, side| {
            let mesh = &world.scene.meshes[world.scene.instances[instance as usize].mesh];
            let material = mesh.triangle_materials[point.triangle as usize];
            (world.scene.surface_at(world.pose, instance, point, side), material)
        };
        match *start {
            Start::Escape => (escaped, WorldSurface::default()),
            Start::OnLight(instance, point, side, weight) => {
                let (found, material) = surface_at(instance, point, side);
                if !world.scene.opaque_at(material, found.attributes) {
                    // The alpha mask cuts this point out of the light.
                    return (escaped, WorldSurface::default());
                }
                (Slot { front: found.front, instance, point, throughput: weight, ..valid }, found.surface)
            }
            Start::AtInfinity(uv, weight) => {
                let point = SurfacePoint { triangle: 0, barycentrics: uv };
                let filled = Slot { instance: NONE, point, throughput: weight, ..valid };
                (filled, filled.surface(world, address, &self.changes.emitters))
            }
            Start::Trace(ray, weight) => {
                let (hit, transmission) = self.pass_thin_surfaces(world, (slot, candidate), &ray, hit);
                let Some(hit) = hit else {
                    return (
                        Slot { unoccluded: Some(ray), transmission, ..escaped },
                        WorldSurface::default(),
                    );
                };
                let point = SurfacePoint { triangle: hit.triangle, barycentrics: hit.barycentrics };
                let (found, material) = surface_at(hit.instance, point, Side::Facing(ray.direction));
                let material = &world.scene.materials[material as usize];
                let bsdf = material.bsdf_at(world.scene, found.attributes);
                let direction = ray.direction.normalize();
                let (albedo, gain, lobe) =
                    GlossyLobe::of(&bsdf, &found.surface, direction, address.parent == NONE);
                let filled = Slot {
                    front: found.front,
                    instance: hit.instance,
                    point,
                    throughput: throughput * weight * transmission.weight * albedo,
                    gain,
                    lobe,
                    transmission,
                    unoccluded: Some(Ray { t_max: hit.t * HIT_MARGIN, ..ray }),
                    ..valid
                };
                (filled, found.surface)
            }
        }
    }

    /// Marks all descendants of an escaped slot as escaped, also those beyond the range.
    fn propagate_escapes(&mut self, ranges: &[PathRange], level: usize) {
        for range in ranges.iter().filter(|range| (range.start..range.end).contains(&level)) {
            let (path, slots) = (self.assignment.path(range.path), &mut self.slots);
            let shot = slots[path[level] as usize];
            if shot.state == SlotState::Escaped {
                for &descendant in &path[level + 1..] {
                    slots[descendant as usize] = Slot::escaped(shot.fresh, shot.shot);
                }
            }
        }
    }
}
