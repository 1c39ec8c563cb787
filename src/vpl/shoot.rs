//! Shooting: light paths through the scene, all rays of one bounce in one batch.
//!
//! In: ranges of light paths whose slots are to be filled, and the world. Out: filled slots
//! (Keller 1997; the rays of DESIGN section "Paths").

use glam::Vec3;
use rayon::prelude::*;

use super::deal::NONE;
use super::emitter::Source;
use super::slots::{Slot, SlotState};
use super::{VplManager, World};
use crate::bvh::{Hit, Ray};
use crate::sampling::{self, Frame};
use crate::scene::{Side, SurfacePoint, WorldSurface};

/// Fewest slots that are worth a task of their own.
pub(super) const SLOTS_PER_TASK: usize = 256;

/// A shot ray is free up to this part of the way to its hit: the hit itself must not count.
const BEFORE_HIT: f32 = 1.0 - 1e-5;

/// Part of a path that is shot together: slots `start..end` of the path, counted from its first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Unit {
    pub(super) path: usize,
    pub(super) start: usize,
    pub(super) end: usize,
}

/// What shooting a slot begins with.
enum Aim {
    /// The path has ended.
    Escape,
    /// The slot lies on the light itself.
    Start(u32, SurfacePoint, Vec3),
    /// A ray must be traced; what it carries is weighted.
    Trace(Ray, f32),
}

impl VplManager {
    /// Shoots the slots of all units, parents before their children.
    pub(super) fn shoot(&mut self, world: World<'_>, units: &[Unit]) {
        let last = units.iter().map(|unit| unit.end).max().unwrap_or(0);
        for level in 0..last {
            let wave = units.iter().filter(|unit| (unit.start..unit.end).contains(&level));
            let jobs: Vec<u32> = wave.map(|unit| self.deal.path(unit.path)[level]).collect();
            self.shoot_wave(world, &jobs);
            self.end_escaped_paths(units, level);
        }
    }

    /// Shoots slots none of which is the parent of another.
    fn shoot_wave(&mut self, world: World<'_>, jobs: &[u32]) {
        // Aim.
        let this = &*self;
        let aims: Vec<Aim> =
            jobs.par_iter().with_min_len(SLOTS_PER_TASK).map(|&slot| this.aim(slot)).collect();
        // Trace.
        let rays: Vec<Ray> = aims
            .iter()
            .filter_map(|aim| if let Aim::Trace(ray, _) = aim { Some(*ray) } else { None })
            .collect();
        let mut hits = world.bvh.intersect_batch(&rays).into_iter();
        let traced: Vec<Option<Hit>> = aims
            .iter()
            .map(|aim| match aim {
                Aim::Trace(..) => hits.next().flatten(),
                _ => None,
            })
            .collect();
        // Land.
        let landed: Vec<(Slot, WorldSurface)> = (jobs, &aims, &traced)
            .into_par_iter()
            .with_min_len(SLOTS_PER_TASK)
            .map(|(&slot, aim, hit)| this.land(world, slot, aim, *hit))
            .collect();
        for (&slot, (filled, surface)) in jobs.iter().zip(landed) {
            self.slots[slot as usize] = filled;
            self.surfaces[slot as usize] = surface;
        }
    }

    fn aim(&self, slot: u32) -> Aim {
        let address = &self.deal.addresses[slot as usize];
        let emitter = &self.watch.emitters[address.light as usize];
        if let (NONE, Source::Area(table)) = (address.parent, &emitter.source) {
            let (point, weight) = table.sample(self.layout.point(address, 0));
            return Aim::Start(table.instance, point, weight);
        }
        match self.ray_of(slot) {
            Some((ray, weight)) => Aim::Trace(ray, weight),
            None => Aim::Escape,
        }
    }

    /// The ray that shooting `slot` again would trace now, and the weight of what it carries; none if its
    /// path has ended before, or would end on its parent's surface. Not for slots that lie on their light.
    pub(super) fn ray_of(&self, slot: u32) -> Option<(Ray, f32)> {
        let address = &self.deal.addresses[slot as usize];
        let emitter = &self.watch.emitters[address.light as usize];
        let u = self.layout.point(address, address.bounce - emitter.first_bounce());
        if address.parent == NONE {
            return emitter.first_ray(u);
        }
        if self.slots[address.parent as usize].state != SlotState::Valid {
            return None;
        }
        let parent = &self.surfaces[address.parent as usize];
        let direction = Frame::around(parent.normal).to_world(sampling::cosine_hemisphere(u));
        // A direction above the shading normal's plane but below the surface carries no light.
        let ray = Ray {
            origin: parent.offset_position(self.watch.bounds.radius),
            direction,
            t_min: 0.0,
            t_max: f32::INFINITY,
        };
        (direction.dot(parent.geometric_normal) > 0.0).then_some((ray, 1.0))
    }

    fn land(&self, world: World<'_>, slot: u32, aim: &Aim, hit: Option<Hit>) -> (Slot, WorldSurface) {
        let parent = self.deal.addresses[slot as usize].parent;
        let (fresh, carried) = match parent {
            NONE => (true, Vec3::ONE),
            _ => {
                let parent = &self.slots[parent as usize];
                (parent.fresh, parent.throughput)
            }
        };
        let found_at = |instance, point, side| world.scene.surface_at(world.pose, instance, point, side);
        let (instance, point, found, throughput, free) = match (aim, hit) {
            (&Aim::Start(instance, point, weight), _) => {
                let mut found = found_at(instance, point, Side::Front(true));
                // The light's own surface emits about the flat triangle's normal.
                found.surface.normal = found.surface.geometric_normal;
                (instance, point, found, weight, None)
            }
            (&Aim::Trace(ray, weight), Some(hit)) => {
                let point = SurfacePoint { triangle: hit.triangle, barycentrics: hit.barycentrics };
                let found = found_at(hit.instance, point, Side::Facing(ray.direction));
                let mesh = &world.scene.meshes[world.scene.instances[hit.instance as usize].mesh];
                let material = mesh.triangle_materials[hit.triangle as usize];
                let albedo = world.scene.materials[material as usize].albedo_at(world.scene, found.uv);
                let free = Ray { t_max: hit.t * BEFORE_HIT, ..ray };
                (hit.instance, point, found, carried * weight * albedo, Some(free))
            }
            (Aim::Trace(..) | Aim::Escape, _) => {
                let free = if let Aim::Trace(ray, _) = aim { Some(*ray) } else { None };
                return (Slot { free, ..Slot::escaped(fresh, self.frame) }, WorldSurface::default());
            }
        };
        let filled = Slot {
            state: SlotState::Valid,
            fresh,
            front: found.front,
            instance,
            point,
            throughput,
            shot: self.frame,
            free,
        };
        (filled, found.surface)
    }

    /// What comes after an escaped slot has escaped too, even where the budget cuts the unit before it.
    fn end_escaped_paths(&mut self, units: &[Unit], level: usize) {
        for unit in units.iter().filter(|unit| (unit.start..unit.end).contains(&level)) {
            let (path, slots) = (self.deal.path(unit.path), &mut self.slots);
            let shot = slots[path[level] as usize];
            if shot.state == SlotState::Escaped {
                for &descendant in &path[level + 1..] {
                    slots[descendant as usize] = Slot::escaped(shot.fresh, shot.shot);
                }
            }
        }
    }
}
