//! The test of one slot: whether its VPL still stands, by at most one ray through the current world.
//!
//! In: a slot and the world. Out: why it is invalid, if it is; else whether thin surfaces treat its ray as when it was shot.

use glam::Vec3;

use super::assignment::{Address, NONE};
use super::counters::InvalidationReason::{self, FacesAway, LightChanged, LightTurnedAway, Occluded};
use super::emitter::Source;
use super::slots::{Slot, SlotState};
use super::vpl_manager::VplManager;
use crate::bvh::{Hit, Occlusion, Ray, Transmission, World};
use crate::scene::{SurfacePoint, WorldSurface};

/// A light that moves so far in one frame that it shoots at a surface this much more or less densely has jumped: its VPLs there
/// would be too many or too few until they are shot again. So would VPLs to which thin surfaces let pass this much more or less.
const MOST_CHANGE: f32 = 2.0;

/// The ray that a slot's test traces: the slot stays valid if nothing opaque occludes it and thin surfaces let about as much pass as
/// before. Without a ray it stays as it is.
type Test = Result<Option<Ray>, InvalidationReason>;

/// Outcome of a test that a slot passed.
#[derive(Clone, Copy, Default)]
pub(super) struct Passed {
    /// Whether thin surfaces treat its ray otherwise than when it was shot.
    pub(super) changed: bool,
    /// The ray that was traced.
    pub(super) unoccluded: Option<Ray>,
}

impl VplManager {
    /// Tests a slot against the current world.
    pub(super) fn test(&self, world: World<'_>, index: usize) -> Result<Passed, InvalidationReason> {
        let Some(ray) = self.select_test(index)? else { return Ok(Passed::default()) };
        let slot = &self.slots[index];
        let passed = Passed { unoccluded: Some(ray), changed: false };
        let occlusion = if self.changes.static_moved || slot.unoccluded != Some(ray) {
            world.bvh.occlusion(&ray)
        } else if self.changes.geometry_moved {
            world.bvh.occlusion_by_dynamic(&ray)
        } else {
            return Ok(passed);
        };
        match occlusion {
            Occlusion::Opaque => Err(Occluded),
            Occlusion::Clear if slot.transmission == Transmission::CLEAR => Ok(passed),
            _ => self.test_passage(world, index, passed, &ray),
        }
    }

    /// Test of a ray that meets thin surfaces, or met some when it was shot; `passed` is the result where nothing has changed.
    fn test_passage(
        &self,
        world: World<'_>,
        index: usize,
        passed: Passed,
        ray: &Ray,
    ) -> Result<Passed, InvalidationReason> {
        let slot = &self.slots[index];
        if slot.fresh || slot.state == SlotState::Escaped {
            // Shoot it again.
            let ray = Ray { t_max: f32::INFINITY, ..*ray };
            let candidate = (index as u32, slot.candidate);
            let (hit, transmission) =
                self.pass_thin_surfaces(world, candidate, &ray, world.bvh.intersect(&ray));
            let same_place = |hit: Hit| {
                let point = SurfacePoint { triangle: hit.triangle, barycentrics: hit.barycentrics };
                (hit.instance, point) == (slot.instance, slot.point)
            };
            match (slot.state, hit) {
                (SlotState::Escaped, None) => return Ok(passed),
                (SlotState::Escaped, Some(_)) => return Err(Occluded),
                (_, Some(hit)) if same_place(hit) && transmission == slot.transmission => return Ok(passed),
                _ => {}
            }
        }
        let (now, then) = (world.transmittance(ray), slot.transmission.transmittance);
        let jumped = now.cmpgt(then * MOST_CHANGE) | then.cmpgt(now * MOST_CHANGE);
        if jumped.any() { Err(Occluded) } else { Ok(Passed { changed: true, ..passed }) }
    }

    fn select_test(&self, index: usize) -> Test {
        let (slot, address) = (&self.slots[index], &self.assignment.addresses[index]);
        let takes_parents_state =
            address.parent != NONE && self.slots[address.parent as usize].state != SlotState::Valid;
        match slot.state {
            SlotState::Invalid => Ok(None),
            _ if takes_parents_state => Ok(None),
            _ if slot.fresh => Ok(slot.unoccluded),
            SlotState::Escaped => Ok(self.sample_ray(index as u32, 0).map(|(ray, _)| ray)),
            _ if slot.is_at_infinity() => Ok(None),
            _ if address.bounce == 0 => self.test_primary(slot, address),
            _ => self.test_segment(&self.surfaces[index], address, slot.unoccluded),
        }
    }

    fn test_primary(&self, slot: &Slot, address: &Address) -> Test {
        match &self.changes.emitters[address.light as usize].source {
            Source::Area(table)
                if table.instance == slot.instance && table.contains(slot.point.triangle, slot.front) =>
            {
                Ok(None)
            }
            _ => Err(LightChanged),
        }
    }

    /// Test of the segment from the slot's parent to its surface: the two sides must face each other, the light
    /// must emit in that direction, and nothing opaque may occlude the segment.
    fn test_segment(&self, surface: &WorldSurface, address: &Address, last: Option<Ray>) -> Test {
        let end = surface.offset_position();
        let towards = |origin| Ray { origin, direction: end - origin, t_min: 0.0, t_max: 1.0 };
        if address.parent != NONE {
            let parent = &self.surfaces[address.parent as usize];
            if self.slots[address.parent as usize].is_at_infinity() {
                return test_towards_infinity(surface, end, parent.geometric_normal);
            }
            let along = surface.position - parent.position;
            let leaves = parent.geometric_normal.dot(along) > 0.0;
            let arrives = surface.geometric_normal.dot(along) < 0.0;
            let faces = leaves && arrives;
            return if faces { Ok(Some(towards(parent.offset_position()))) } else { Err(FacesAway) };
        }
        let source = &self.changes.emitters[address.light as usize].source;
        let position = match source {
            Source::Point { position } | Source::Spot { position, .. } => *position,
            Source::Directional { frame, .. } => return test_towards_infinity(surface, end, frame.normal),
            Source::Area(_) | Source::Environment(_) => return Err(LightChanged),
        };
        let few_to_many = 1.0 / MOST_CHANGE..=MOST_CHANGE;
        let arrives = surface.geometric_normal.dot(surface.position - position) < 0.0;
        match last {
            Some(last) if !few_to_many.contains(&density_change(surface, last.origin, position)) => {
                Err(LightChanged)
            }
            _ if !arrives => Err(FacesAway),
            _ if !source.emits_towards(surface.position) => Err(LightTurnedAway),
            _ => Ok(Some(towards(position))),
        }
    }
}

/// Test of the ray from a surface, which starts at `origin`, against the direction in which its light travels.
fn test_towards_infinity(surface: &WorldSurface, origin: Vec3, direction: Vec3) -> Test {
    let arrives = surface.geometric_normal.dot(direction) < 0.0;
    let ray = Ray { origin, direction: -direction, t_min: 0.0, t_max: f32::INFINITY };
    if arrives { Ok(Some(ray)) } else { Err(FacesAway) }
}

/// How much more densely a point light at `to` shoots at a surface than one at `from`.
fn density_change(surface: &WorldSurface, from: Vec3, to: Vec3) -> f32 {
    let density = |light: Vec3| {
        let d = light - surface.position;
        surface.geometric_normal.dot(d).max(0.0) / d.length().powi(3)
    };
    density(to) / density(from)
}
