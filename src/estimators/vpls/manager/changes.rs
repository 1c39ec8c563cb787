//! Detects what changed in the world since the last frame.
//!
//! In: the world, once per frame. Out: the lights as emitters, the environment last, and flags for changed lights and instances.
//! The state depends on the current world only, so no history survives a change.

use glam::{Affine3A, Vec3};

use super::assignment::NONE;
use super::emitter::Emitter;
use super::focus::{FocusedDisc, focus_at_rest};
use super::quota::Claim;
use crate::bvh::World;
use crate::scene::{BoundingSphere, Environment, Light, LightKind, Scene};

/// Whether two lights have the same emission; names and extents are ignored, as paths start at the centre.
fn same_emission(a: &Light, b: &Light) -> bool {
    (&a.kind, a.position, a.direction) == (&b.kind, b.position, b.direction)
}

/// Compares each world with the last one.
#[derive(Clone, Debug)]
pub(super) struct SceneChanges {
    /// The lights of the current world, then its environment.
    pub(super) emitters: Vec<Emitter>,
    /// Covers everything visible. Constant while instances move within it.
    pub(super) bounds: BoundingSphere,
    /// Whether each light's paths start or point elsewhere; changes of its power are ignored.
    pub(super) light_changed: Vec<bool>,
    /// Whether each instance moved.
    pub(super) moved: Vec<bool>,
    /// Whether any visible instance moved.
    pub(super) geometry_moved: bool,
    /// Whether any visible static instance moved, as by an edit.
    pub(super) static_moved: bool,
    /// Whether [`Self::bounds`] changed, which changes the offsets of all rays.
    pub(super) bounds_changed: bool,
    /// Whether any flux or the number of lights changed.
    pub(super) flux_changed: bool,
    /// Index of each light in the last frame; none if it is new.
    pub(super) previous_index: Vec<Option<u32>>,
    rest_bounds: BoundingSphere,
    focus: Option<BoundingSphere>,
    lights: Vec<Light>,
    environment: Option<Environment>,
    transforms: Vec<Affine3A>,
}

impl SceneChanges {
    /// Records the first world.
    pub(super) fn new(world: World<'_>) -> Self {
        let rest_bounds = BoundingSphere::around(bounds_at_rest(world.scene));
        let mut changes = Self {
            emitters: Vec::new(),
            bounds: rest_bounds,
            light_changed: Vec::new(),
            moved: Vec::new(),
            geometry_moved: false,
            static_moved: false,
            bounds_changed: false,
            flux_changed: false,
            previous_index: Vec::new(),
            rest_bounds,
            focus: focus_at_rest(world.scene),
            lights: Vec::new(),
            environment: None,
            transforms: Vec::new(),
        };
        changes.update(world);
        changes
    }

    /// Compares the world with the last one and records it.
    pub(super) fn update(&mut self, world: World<'_>) {
        self.compare_instances(world);
        let bounds = quantized_bounds(&self.rest_bounds, world.bvh.bounds());
        self.bounds_changed = bounds != self.bounds;
        self.bounds = bounds;
        self.compare_emitters(world);
    }

    /// Whether anything that VPLs depend on changed since the last frame.
    pub(super) fn anything_changed(&self) -> bool {
        self.geometry_moved || self.bounds_changed || self.light_changed.contains(&true)
    }

    /// Whether an instance moved in this frame, or for [`NONE`] the environment turned.
    pub(super) fn has_moved(&self, instance: u32) -> bool {
        match instance {
            NONE => self.environment_changed(),
            _ => self.moved[instance as usize],
        }
    }

    /// Whether there is an environment, and one turned otherwise than in the last frame.
    pub(super) fn environment_changed(&self) -> bool {
        self.environment.is_some() && self.light_changed.last() == Some(&true)
    }

    /// Input of the quota, one for each light.
    pub(super) fn claims(&self) -> Vec<Claim> {
        self.emitters
            .iter()
            .map(|emitter| Claim {
                luminous_flux: emitter.sampling_weight(),
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

    /// Compares the lights, then the environment, which is the last emitter.
    fn compare_emitters(&mut self, world: World<'_>) {
        let (lights, environment) = (&world.pose.lights, &world.pose.environment);
        let disc = FocusedDisc::new(&self.bounds, self.focus.as_ref());
        self.flux_changed =
            self.lights.len() != lights.len() || self.environment.is_some() != environment.is_some();
        self.previous_index = previous_index(&self.lights, lights);
        self.light_changed.clear();
        let last_lights = std::mem::replace(&mut self.lights, lights.clone());
        let mut last: Vec<_> = self.emitters.drain(..).map(Some).collect();
        for (index, light) in lights.iter().enumerate() {
            let on_moved = matches!(&light.kind, LightKind::Area { instance, .. } if self.moved[*instance]);
            let directional = matches!(light.kind, LightKind::Directional { .. });
            let previous = self.previous_index[index].map(|previous| previous as usize);
            let same = previous.is_some_and(|previous| same_emission(&last_lights[previous], light));
            let same = same && !on_moved && !(directional && self.bounds_changed);
            let known = previous.and_then(|previous| last[previous].take());
            self.add_emitter(known, same, on_moved, || Emitter::new(world, light, &disc));
        }
        if let Some(environment) = environment {
            let known = last.get_mut(last_lights.len()).and_then(Option::take);
            self.previous_index.push(known.is_some().then_some(last_lights.len() as u32));
            let same = self.environment.as_ref() == Some(environment) && !self.bounds_changed;
            self.add_emitter(known, same, false, || Emitter::of_environment(environment, &disc));
        }
        self.environment.clone_from(environment);
    }

    /// Adds an emitter: the `known` one of the last frame if it is the `same`, else what `make` gives.
    fn add_emitter(
        &mut self,
        known: Option<Emitter>,
        same: bool,
        on_moved: bool,
        make: impl FnOnce() -> Emitter,
    ) {
        let (emitter, changed) = match known {
            Some(known) if same => (known, false),
            known => {
                let emitter = make();
                let flux_changed = known.as_ref().is_some_and(|known| known.flux != emitter.flux);
                self.flux_changed |= flux_changed;
                let changed = known.is_none_or(|known| on_moved || known.source != emitter.source);
                (emitter, changed)
            }
        };
        self.emitters.push(emitter);
        self.light_changed.push(changed);
    }
}

/// Index in `last` of each light: the same index if their number is unchanged, else an equal light, else one of the
/// same name.
fn previous_index(last: &[Light], now: &[Light]) -> Vec<Option<u32>> {
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

/// Bounds (min, max) of all visible instances at rest, from the corners of their meshes' boxes, like the
/// top level of the BVH; a unit box for an empty scene.
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

/// The bounding sphere of the scene at rest, scaled by powers of a constant until it covers the box. It depends on the
/// current box only, yet seldom changes while objects move: each change reshoots every VPL.
fn quantized_bounds(rest: &BoundingSphere, (min, max): (Vec3, Vec3)) -> BoundingSphere {
    const STEP: f32 = 1.25;
    let farthest = (max - rest.center).abs().max((min - rest.center).abs());
    let needed = farthest.length() / rest.radius;
    // The tolerance absorbs rounding differences at rest.
    let steps = ((needed / 1.001).ln() / STEP.ln()).ceil().max(0.0);
    BoundingSphere { center: rest.center, radius: 1.001 * rest.radius * STEP.powf(steps) }
}
