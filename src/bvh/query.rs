//! Closest-hit and any-hit queries through both levels.
//!
//! In: the two-level BVH and a ray. Out: the closest hit, on thin surfaces too; or whether anything opaque, or a thin surface, occludes
//! the ray. Rays are transformed into object space without normalising the direction, so t is the same in both spaces.

use std::cell::RefCell;

use exr::prelude::f16;
use glam::{Vec2, Vec3A, Vec4};
use rayon::prelude::*;

use super::{
    nodes::Child,
    ray::{Hit, Occlusion, RAYS_PER_TASK, Ray},
    simd::{Portable, Simd},
    thin_surfaces::THIN_SURFACE,
    top::{PlacedInstance, TopLevel},
    traverse::{BoxRay, Stack, Visitor, traverse},
    triangle::{BlockHits, TriangleBlock, TriangleRay},
    two_level::TwoLevelBvh,
};

thread_local! {
    /// Reused, because initialising it for each ray would be slow.
    static STACK: RefCell<Stack> = const { RefCell::new(Stack::EMPTY) };
}

impl TwoLevelBvh {
    /// The closest hit along `ray`, be it a thin surface. Ties in t go to the lowest instance, then to the lowest triangle.
    pub fn intersect(&self, ray: &Ray) -> Option<Hit> {
        query::<false>(self, &self.levels(), ray).hit
    }

    /// Whether anything lies on the segment.
    pub fn occlusion(&self, ray: &Ray) -> Occlusion {
        query::<true>(self, &self.levels(), ray).occlusion()
    }

    /// Whether anything of a dynamic instance lies on the segment.
    pub fn occlusion_by_dynamic(&self, ray: &Ray) -> Occlusion {
        query::<true>(self, &[&self.dynamic_level], ray).occlusion()
    }

    /// Whether anything opaque occludes the segment.
    pub fn occluded(&self, ray: &Ray) -> bool {
        self.occlusion(ray) == Occlusion::Opaque
    }

    /// [`Self::intersect`] for many rays on this thread; results in the order of the rays.
    pub fn intersect_all(&self, rays: &[Ray]) -> Vec<Option<Hit>> {
        let mut hits = vec![None; rays.len()];
        query_all::<false>(self, rays, &mut |ray, found| hits[ray] = found.hit);
        hits
    }

    /// [`Self::occlusion`] for many rays on this thread; results in the order of the rays.
    pub fn occlusion_all(&self, rays: &[Ray]) -> Vec<Occlusion> {
        let mut occlusions = vec![Occlusion::Clear; rays.len()];
        query_all::<true>(self, rays, &mut |ray, found| occlusions[ray] = found.occlusion());
        occlusions
    }

    /// [`Self::intersect_all`] over all cores.
    pub fn intersect_batch(&self, rays: &[Ray]) -> Vec<Option<Hit>> {
        rays.par_chunks(RAYS_PER_TASK).flat_map_iter(|rays| self.intersect_all(rays)).collect()
    }

    /// [`Self::occluded`] for many rays over all cores.
    pub fn occluded_batch(&self, rays: &[Ray]) -> Vec<bool> {
        let occluded = |rays| self.occlusion_all(rays).into_iter().map(|found| found == Occlusion::Opaque);
        rays.par_chunks(RAYS_PER_TASK).flat_map_iter(occluded).collect()
    }
}

/// Outcome of a query.
struct Found {
    /// The closest hit, or, with `ANY`, any opaque one.
    hit: Option<Hit>,
    /// With `ANY`: whether the ray met a thin surface on the way.
    thin_surfaces: bool,
}

impl Found {
    /// The answer of an `ANY` query.
    fn occlusion(&self) -> Occlusion {
        match (self.hit, self.thin_surfaces) {
            (Some(_), _) => Occlusion::Opaque,
            (None, true) => Occlusion::ThinSurfaces,
            (None, false) => Occlusion::Clear,
        }
    }
}

/// The closest hit along `ray` in `levels` of `bvh`, or, with `ANY`, any opaque one.
fn query<const ANY: bool>(bvh: &TwoLevelBvh, levels: &[&TopLevel], ray: &Ray) -> Found {
    STACK.with_borrow_mut(|stack| {
        #[cfg(target_arch = "x86_64")]
        if let Some(avx2) = bvh.avx2 {
            return avx2.vectorize(
                #[inline(always)]
                || Query::<_, ANY>::new(avx2, bvh, ray).run(levels, stack),
            );
        }
        Query::<_, ANY>::new(Portable, bvh, ray).run(levels, stack)
    })
}

/// [`query`] in both levels for many rays; calls `found` with each ray's index and outcome.
fn query_all<const ANY: bool>(bvh: &TwoLevelBvh, rays: &[Ray], found: &mut impl FnMut(usize, Found)) {
    let levels = &bvh.levels();
    STACK.with_borrow_mut(|stack| {
        #[cfg(target_arch = "x86_64")]
        if let Some(avx2) = bvh.avx2 {
            return avx2.vectorize(
                #[inline(always)]
                || {
                    for (index, ray) in rays.iter().enumerate() {
                        found(index, Query::<_, ANY>::new(avx2, bvh, ray).run(levels, stack));
                    }
                },
            );
        }
        for (index, ray) in rays.iter().enumerate() {
            found(index, Query::<_, ANY>::new(Portable, bvh, ray).run(levels, stack));
        }
    });
}

/// A query in progress; `ANY` stops at the first opaque hit, whichever it is.
struct Query<'a, S, const ANY: bool> {
    simd: S,
    bvh: &'a TwoLevelBvh,
    ray: Ray,
    /// The closest hit so far. Initially t is t_max and the indices are the lowest, so that no hit at t_max is closer.
    best: Hit,
    thin_surfaces: bool,
}

impl<'a, S: Simd, const ANY: bool> Query<'a, S, ANY> {
    #[inline(always)]
    fn new(simd: S, bvh: &'a TwoLevelBvh, ray: &Ray) -> Self {
        let best = Hit { t: ray.t_max, instance: 0, triangle: 0, barycentrics: Vec2::ZERO };
        Self { simd, bvh, ray: *ray, best, thin_surfaces: false }
    }

    /// Runs the query.
    #[inline(always)]
    fn run(mut self, levels: &[&'a TopLevel], stack: &mut Stack) -> Found {
        for &level in levels {
            let (simd, ray) = (self.simd, self.ray);
            let mut visitor = InstanceVisitor { query: &mut self, level };
            let done = if level.root.is_leaf() {
                // One instance or none: there are no boxes to test.
                visitor.visit(level.root, stack)
            } else {
                let ray = BoxRay::new(simd, ray.origin.into(), ray.direction.into(), ray.t_min);
                traverse(&level.nodes, level.root, &ray, stack, &mut visitor)
            };
            if done {
                break;
            }
        }
        Found { hit: (self.best.t < self.ray.t_max).then_some(self.best), thin_surfaces: self.thin_surfaces }
    }

    /// Updates the closest hit with those of a block. True if the query is done.
    #[inline(always)]
    fn accept(&mut self, instance: u32, block: &TriangleBlock, hits: &BlockHits) -> bool {
        let mut mask = hits.mask;
        let t = hits.t.to_array();
        while mask != 0 {
            let lane = mask.trailing_zeros() as usize % t.len();
            mask &= mask - 1;
            let best = &self.best;
            let triangle = block.ids[lane];
            let nearer = t[lane] < best.t
                || t[lane] == best.t && (instance, triangle) < (best.instance, best.triangle);
            let barycentrics = Vec2::new(hits.barycentrics[0][lane], hits.barycentrics[1][lane]);
            let masked = block.masked[lane];
            if ANY && nearer && masked & THIN_SURFACE != 0 {
                self.thin_surfaces = true;
                continue;
            }
            if nearer
                && (masked == 0 || masked & THIN_SURFACE != 0 || is_opaque(self.bvh, masked, barycentrics))
            {
                self.best = Hit { t: t[lane], instance, triangle, barycentrics };
                if ANY {
                    return true;
                }
            }
        }
        false
    }
}

/// Traverses the bottom levels of a top level's instances.
struct InstanceVisitor<'q, 'a, S, const ANY: bool> {
    query: &'q mut Query<'a, S, ANY>,
    level: &'a TopLevel,
}

impl<S: Simd, const ANY: bool> Visitor for InstanceVisitor<'_, '_, S, ANY> {
    const ANY: bool = ANY;
    #[inline(always)]
    fn t_max(&self) -> f32 {
        self.query.best.t
    }

    #[inline(always)]
    fn visit(&mut self, leaf: Child, stack: &mut Stack) -> bool {
        for placed in &self.level.placed[leaf.range()] {
            let bottom = &self.query.bvh.bottom;
            let (origin, direction) = to_object(placed, &self.query.ray);
            let (simd, t_min) = (self.query.simd, self.query.ray.t_min);
            let mut visitor = TriangleVisitor {
                blocks: &bottom.blocks,
                ray: TriangleRay::new(origin, direction),
                t_min: Vec4::splat(t_min),
                instance: placed.instance,
                query: self.query,
            };
            let ray = BoxRay::new(simd, origin, direction, t_min);
            if traverse(&bottom.nodes, placed.mesh.root, &ray, stack, &mut visitor) {
                return true;
            }
        }
        false
    }
}

/// Tests the triangles of one instance.
struct TriangleVisitor<'q, 'a, S, const ANY: bool> {
    query: &'q mut Query<'a, S, ANY>,
    blocks: &'a [TriangleBlock],
    ray: TriangleRay,
    t_min: Vec4,
    instance: u32,
}

impl<S: Simd, const ANY: bool> Visitor for TriangleVisitor<'_, '_, S, ANY> {
    const ANY: bool = ANY;
    #[inline(always)]
    fn t_max(&self) -> f32 {
        self.query.best.t
    }

    #[inline(always)]
    fn visit(&mut self, leaf: Child, _stack: &mut Stack) -> bool {
        for block in &self.blocks[leaf.range()] {
            if let Some(hits) = self.ray.intersect(block, self.t_min, self.query.best.t)
                && self.query.accept(self.instance, block, &hits)
            {
                return true;
            }
        }
        false
    }
}

/// The ray's origin and direction in an instance's object space.
#[inline(always)]
fn to_object(placed: &PlacedInstance, ray: &Ray) -> (Vec3A, Vec3A) {
    let world_to_object = &placed.world_to_object;
    let origin = world_to_object.transform_point3a(Vec3A::from(ray.origin));
    let direction = world_to_object.transform_vector3a(Vec3A::from(ray.direction));
    (origin, direction)
}

/// Whether the alpha test of masked triangle `masked` (from 1) passes at these barycentrics.
#[inline(never)]
fn is_opaque(bvh: &TwoLevelBvh, masked: u32, barycentrics: Vec2) -> bool {
    let masked = &bvh.bottom.masked[masked as usize - 1];
    let first = 1.0 - barycentrics.x - barycentrics.y;
    let uv = masked.uv0 * first + masked.uv1 * barycentrics.x + masked.uv2 * barycentrics.y;
    let [a, b, c] = masked.alphas.map(|bits| f16::from_bits(bits).to_f32());
    let alpha = a + (b - a) * barycentrics.x + (c - a) * barycentrics.y;
    bvh.alpha_masks[masked.mask as usize].opaque_at(uv, alpha)
}
