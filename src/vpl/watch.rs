//! What changed in the world since the last frame.
//!
//! In: the world, frame by frame. Out: the lights as emitters, and which lights and instances are not
//! as they were. Everything kept here follows from the current world alone, so that after a change
//! nothing is left of the past.

use glam::{Affine3A, Vec3};

use super::World;
use super::emitter::{Emitter, Source};
use super::focus::{FocusedDisc, focus_at_rest};
use super::quota::Claim;
use crate::scene::{BoundingSphere, Light, LightKind, Scene};

/// Whether two lights light the world alike, whatever they are called.
fn shines_like(a: &Light, b: &Light) -> bool {
    (&a.kind, a.position, a.direction) == (&b.kind, b.position, b.direction)
}

/// Keeps the last world and compares.
#[derive(Clone, Debug)]
pub(super) struct Watch {
    /// The lights of the current world.
    pub(super) emitters: Vec<Emitter>,
    /// Covers everything visible. Keeps still while things move about within it.
    pub(super) bounds: BoundingSphere,
    /// Whether the paths of each light start or point elsewhere; its power does not matter.
    pub(super) light_changed: Vec<bool>,
    /// Whether each instance moved.
    pub(super) moved: Vec<bool>,
    /// Whether any visible instance moved.
    pub(super) geometry_moved: bool,
    /// Whether any visible instance moved that is static by itself.
    pub(super) static_moved: bool,
    /// Whether [`Self::bounds`] changed, and with it every ray.
    pub(super) bounds_changed: bool,
    /// Whether any flux or the number of lights changed.
    pub(super) flux_changed: bool,
    /// Which of the last frame's lights each light was; none if it is new.
    pub(super) known_as: Vec<Option<u32>>,
    rest_bounds: BoundingSphere,
    focus: Option<BoundingSphere>,
    lights: Vec<Light>,
    transforms: Vec<Affine3A>,
}

impl Watch {
    /// Looks at the world for the first time; nothing counts as changed.
    pub(super) fn new(world: World<'_>) -> Self {
        let rest_bounds = BoundingSphere::around(bounds_at_rest(world.scene));
        let bounds = stepped_bounds(&rest_bounds, world.bvh.bounds());
        let focus = focus_at_rest(world.scene);
        let disc = FocusedDisc::new(&bounds, focus.as_ref());
        let lights = world.pose.lights.clone();
        let emitters: Vec<_> = lights.iter().map(|light| Emitter::new(world, light, &disc)).collect();
        Self {
            light_changed: vec![false; lights.len()],
            moved: vec![false; world.pose.instances.len()],
            geometry_moved: false,
            static_moved: false,
            bounds_changed: false,
            flux_changed: false,
            known_as: (0..lights.len() as u32).map(Some).collect(),
            transforms: world.pose.instances.clone(),
            emitters,
            bounds,
            rest_bounds,
            focus,
            lights,
        }
    }

    /// Compares the world with the last one and keeps it.
    pub(super) fn update(&mut self, world: World<'_>) {
        self.compare_instances(world);
        let bounds = stepped_bounds(&self.rest_bounds, world.bvh.bounds());
        self.bounds_changed = bounds != self.bounds;
        self.bounds = bounds;
        self.compare_lights(world);
    }

    /// Whether anything that VPLs depend on is not as it was in the last frame.
    pub(super) fn anything_changed(&self) -> bool {
        self.geometry_moved || self.bounds_changed || self.light_changed.contains(&true)
    }

    /// Whether an instance moved in this frame.
    pub(super) fn has_moved(&self, instance: u32) -> bool {
        self.moved[instance as usize]
    }

    /// What each light may claim of the slots.
    pub(super) fn claims(&self) -> Vec<Claim> {
        self.emitters
            .iter()
            .map(|emitter| Claim {
                luminous_flux: emitter.luminous_claim(),
                first_bounce: emitter.first_bounce(),
            })
            .collect()
    }

    fn compare_instances(&mut self, world: World<'_>) {
        let now = &world.pose.instances;
        self.transforms.resize(now.len(), Affine3A::IDENTITY);
        self.moved.resize(now.len(), true);
        self.geometry_moved = false;
        self.static_moved = false;
        let last = self.transforms.iter_mut().zip(&mut self.moved);
        for ((last, moved), (now, instance)) in last.zip(now.iter().zip(&world.scene.instances)) {
            *moved = last != now;
            *last = *now;
            self.geometry_moved |= *moved && instance.visible;
            self.static_moved |= *moved && instance.visible && !instance.dynamic;
        }
    }

    fn compare_lights(&mut self, world: World<'_>) {
        let now = &world.pose.lights;
        let disc = FocusedDisc::new(&self.bounds, self.focus.as_ref());
        self.flux_changed = self.lights.len() != now.len();
        self.known_as = known_as(&self.lights, now);
        let mut known: Vec<_> = self.lights.drain(..).zip(self.emitters.drain(..)).map(Some).collect();
        self.light_changed.clear();
        for (index, light) in now.iter().enumerate() {
            let carried = match &light.kind {
                LightKind::Area { instance, .. } => self.moved[*instance],
                LightKind::Directional { .. } => self.bounds_changed,
                _ => false,
            };
            let known = self.known_as[index].and_then(|last| known[last as usize].take());
            let (emitter, changed) = match known {
                Some((last, emitter)) if shines_like(&last, light) && !carried => (emitter, false),
                known => {
                    let emitter = Emitter::new(world, light, &disc);
                    let changed = known.is_none_or(|(_, last)| {
                        let on_moved = matches!(last.source, Source::Area(_)) && carried;
                        self.flux_changed |= last.flux != emitter.flux;
                        on_moved || last.source != emitter.source
                    });
                    (emitter, changed)
                }
            };
            self.emitters.push(emitter);
            self.light_changed.push(changed);
        }
        self.lights.clone_from(now);
    }
}

/// Which of the `last` lights each one is now: the one in its place, or, where lights came or went, the same one,
/// or else one of the same name.
fn known_as(last: &[Light], now: &[Light]) -> Vec<Option<u32>> {
    if last.len() == now.len() {
        return (0..now.len() as u32).map(Some).collect();
    }
    let mut taken = vec![false; last.len()];
    let mut found = vec![None; now.len()];
    let same: [fn(&Light, &Light) -> bool; 2] = [|a, b| a == b, |a, b| a.name == b.name];
    for same in same {
        for (light, found) in now.iter().zip(&mut found).filter(|(_, found)| found.is_none()) {
            let place = (0..last.len()).find(|&place| !taken[place] && same(&last[place], light));
            *found = place.map(|place| place as u32);
            place.into_iter().for_each(|place| taken[place] = true);
        }
    }
    found
}

/// Bounds (min, max) of all visible instances at rest, from the corners of their meshes' boxes, as the
/// top level of the BVH has them; a unit box when there are none.
fn bounds_at_rest(scene: &Scene) -> (Vec3, Vec3) {
    let boxes: Vec<_> = scene.meshes.iter().map(|mesh| mesh.bounds()).collect();
    let instances = scene.instances.iter().filter(|instance| instance.visible);
    instances
        .flat_map(|instance| {
            let (min, max) = boxes[instance.mesh];
            (0..8).map(move |corner: u32| {
                let pick = |axis: u32| corner >> axis & 1 == 1;
                let corner = Vec3::select(glam::BVec3::new(pick(0), pick(1), pick(2)), max, min);
                instance.transform.transform_point3(corner)
            })
        })
        .map(|point| (point, point))
        .reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
        .unwrap_or((Vec3::splat(-0.5), Vec3::splat(0.5)))
}

/// The sphere about the scene at rest, widened in steps until it covers the box. It follows from the
/// current box alone, yet seldom changes while objects move: each change reshoots every VPL.
fn stepped_bounds(rest: &BoundingSphere, (min, max): (Vec3, Vec3)) -> BoundingSphere {
    const STEP: f32 = 1.25;
    let farthest = (max - rest.center).abs().max((min - rest.center).abs());
    let needed = farthest.length() / rest.radius;
    // At rest the two differ by rounding only, which must not cost a step.
    let steps = ((needed / 1.001).ln() / STEP.ln()).ceil().max(0.0);
    BoundingSphere { center: rest.center, radius: 1.001 * rest.radius * STEP.powf(steps) }
}
