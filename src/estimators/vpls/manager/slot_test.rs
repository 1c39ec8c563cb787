//! The test of one slot: whether its VPL still stands, by at most one ray through the current world.
//!
//! In: a slot and the world. Out: why it is invalid, if it is; else whether thin surfaces treat its ray as when it was shot.

use glam::Vec3;

use super::assignment::{Address, NONE};
use super::emitter::Source;
use super::invalidation::InvalidationReason;
use super::slots::{Slot, SlotState};
use super::{VplManager, World};
use crate::bvh::{Hit, Occlusion, Ray, Transmission};
use crate::scene::{SurfacePoint, WorldSurface};

/// A light that moves so far in one frame that it shoots at a surface this much more or less densely has jumped: its VPLs there
/// would be too many or too few until they are shot again. So would those to which thin surfaces let pass this much more or less.
const MOST_CHANGE: f32 = 2.0;

/// The test that a slot needs.
enum Test {
    /// None: it stays as it is.
    Keep,
    /// None: it is invalid for this reason.
    Fail(InvalidationReason),
    /// It stays valid if nothing opaque occludes this ray, and thin surfaces let about as much pass as before.
    Trace(Ray),
}

/// Outcome of a slot's test.
pub(super) struct TestResult {
    /// Why it is invalid; none if it passed.
    pub(super) failure: Option<InvalidationReason>,
    /// Whether a passed ray fares otherwise among thin surfaces than when it was shot.
    pub(super) changed: bool,
    /// The ray that was traced, if it passed.
    pub(super) unoccluded: Option<Ray>,
}

impl TestResult {
    const KEPT: Self = Self { failure: None, changed: false, unoccluded: None };

    fn failed(reason: InvalidationReason) -> Self {
        Self { failure: Some(reason), ..Self::KEPT }
    }
}

impl VplManager {
    pub(super) fn test(&self, world: World<'_>, index: usize) -> TestResult {
        let ray = match self.select_test(index) {
            Test::Keep => return TestResult::KEPT,
            Test::Fail(reason) => return TestResult::failed(reason),
            Test::Trace(ray) => ray,
        };
        let slot = &self.slots[index];
        let passed = TestResult { unoccluded: Some(ray), ..TestResult::KEPT };
        let occlusion = if self.changes.static_moved || slot.unoccluded != Some(ray) {
            world.bvh.occlusion(&ray)
        } else if self.changes.geometry_moved {
            world.bvh.occlusion_by_dynamic(&ray)
        } else {
            return passed;
        };
        match occlusion {
            Occlusion::Opaque => TestResult::failed(InvalidationReason::Occluded),
            Occlusion::Clear if slot.transmission == Transmission::CLEAR => passed,
            _ => self.test_thin_surfaces(world, index, passed, &ray),
        }
    }

    /// Test of a ray that meets thin surfaces, or met some when it was shot; `passed` is what it gives where nothing has changed.
    fn test_thin_surfaces(
        &self,
        world: World<'_>,
        index: usize,
        passed: TestResult,
        ray: &Ray,
    ) -> TestResult {
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
                (SlotState::Escaped, None) => return passed,
                (SlotState::Escaped, Some(_)) => return TestResult::failed(InvalidationReason::Occluded),
                (_, Some(hit)) if same_place(hit) && transmission == slot.transmission => return passed,
                _ => {}
            }
        }
        let (now, then) = (world.transmittance(ray), slot.transmission.transmittance);
        let jumped = now.cmpgt(then * MOST_CHANGE) | then.cmpgt(now * MOST_CHANGE);
        match jumped.any() {
            true => TestResult::failed(InvalidationReason::Occluded),
            false => TestResult { changed: true, ..passed },
        }
    }

    fn select_test(&self, index: usize) -> Test {
        let (slot, address) = (&self.slots[index], &self.assignment.addresses[index]);
        if slot.state == SlotState::Invalid {
            return Test::Keep;
        }
        if address.parent != NONE && self.slots[address.parent as usize].state != SlotState::Valid {
            // It takes the state of its parent.
            return Test::Keep;
        }
        match slot.state {
            _ if slot.fresh => slot.unoccluded.map_or(Test::Keep, Test::Trace),
            SlotState::Escaped => {
                self.sample_ray(index as u32, 0).map_or(Test::Keep, |(ray, _)| Test::Trace(ray))
            }
            _ if slot.is_at_infinity() => Test::Keep,
            _ if address.bounce == 0 => self.test_primary(slot, address),
            _ => self.test_segment(&self.surfaces[index], address, slot.unoccluded),
        }
    }

    fn test_primary(&self, slot: &Slot, address: &Address) -> Test {
        match &self.changes.emitters[address.light as usize].source {
            Source::Area(table) if table.instance == slot.instance && table.contains(slot.point.triangle) => {
                Test::Keep
            }
            _ => Test::Fail(InvalidationReason::LightChanged),
        }
    }

    /// Test of the segment from the slot's parent to its surface: the two sides must face each other, the light
    /// must emit in that direction, and nothing opaque may occlude the segment.
    fn test_segment(&self, surface: &WorldSurface, address: &Address, last: Option<Ray>) -> Test {
        let radius = self.changes.bounds.radius;
        let end = surface.offset_position(radius);
        let towards = |origin| Ray { origin, direction: end - origin, t_min: 0.0, t_max: 1.0 };
        if address.parent != NONE {
            let parent = &self.surfaces[address.parent as usize];
            if self.slots[address.parent as usize].is_at_infinity() {
                return test_towards_infinity(surface, end, parent.normal);
            }
            let along = surface.position - parent.position;
            let leaves = parent.geometric_normal.dot(along) > 0.0 && parent.normal.dot(along) > 0.0;
            let arrives = surface.geometric_normal.dot(along) < 0.0;
            return match leaves && arrives {
                true => Test::Trace(towards(parent.offset_position(radius))),
                false => Test::Fail(InvalidationReason::FacesAway),
            };
        }
        let source = &self.changes.emitters[address.light as usize].source;
        let ray = match source {
            Source::Point { position } | Source::Spot { position, .. } => towards(*position),
            Source::Directional { frame, .. } => return test_towards_infinity(surface, end, frame.normal),
            Source::Area(_) | Source::Environment(_) => return Test::Fail(InvalidationReason::LightChanged),
        };
        let jumped = match (source, last) {
            (Source::Point { position } | Source::Spot { position, .. }, Some(last)) => {
                !(1.0 / MOST_CHANGE..=MOST_CHANGE).contains(&density_change(surface, last.origin, *position))
            }
            _ => false,
        };
        if jumped {
            return Test::Fail(InvalidationReason::LightChanged);
        }
        let arrives = surface.geometric_normal.dot(surface.position - ray.origin) < 0.0;
        match (arrives, source.emits_towards(surface.position)) {
            (true, true) => Test::Trace(ray),
            (false, _) => Test::Fail(InvalidationReason::FacesAway),
            (true, false) => Test::Fail(InvalidationReason::LightTurnedAway),
        }
    }
}

/// Test of the ray from a surface, which starts at `origin`, against the direction in which its light travels.
fn test_towards_infinity(surface: &WorldSurface, origin: Vec3, direction: Vec3) -> Test {
    match surface.geometric_normal.dot(direction) < 0.0 {
        true => Test::Trace(Ray { origin, direction: -direction, t_min: 0.0, t_max: f32::INFINITY }),
        false => Test::Fail(InvalidationReason::FacesAway),
    }
}

/// How much more densely a point light at `to` shoots at a surface than one at `from`.
fn density_change(surface: &WorldSurface, from: Vec3, to: Vec3) -> f32 {
    let density = |light: Vec3| {
        let d = light - surface.position;
        surface.geometric_normal.dot(d).max(0.0) / d.length().powi(3)
    };
    density(to) / density(from)
}
