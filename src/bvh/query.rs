//! One ray through both levels: the closest hit or any hit.
//!
//! In: the two-level BVH and a ray. Out: a hit. A ray enters an instance by transforming its origin and
//! direction without normalising, so that t means the same in both spaces.

use glam::{Vec2, Vec3, Vec3A};

use super::{
    Hit, Ray, TwoLevelBvh,
    gpu::GpuTriangle,
    top::{PlacedInstance, TopLevel},
    traverse::{BoxRay, Stack, Visitor, traverse},
    triangle::{TriangleHit, TriangleRay},
};

/// A query in progress; `ANY` stops at the first hit, whichever it is.
pub(super) struct Query<'a, const ANY: bool> {
    bvh: &'a TwoLevelBvh,
    ray: Ray,
    best: Option<Hit>,
}

impl<'a, const ANY: bool> Query<'a, ANY> {
    pub(super) fn new(bvh: &'a TwoLevelBvh, ray: &Ray) -> Self {
        Self { bvh, ray: *ray, best: None }
    }

    /// The closest hit, or any one.
    pub(super) fn run(mut self) -> Option<Hit> {
        let bvh = self.bvh;
        let ray = BoxRay::new(self.ray.origin, self.ray.direction);
        let mut stack = Stack::new();
        for level in [&bvh.static_level, &bvh.dynamic_level] {
            if level.nodes.is_empty() {
                continue;
            }
            let mut visitor = InstanceVisitor { query: &mut self, level };
            if traverse(&level.nodes, 0, &ray, &mut stack, &mut visitor) {
                break;
            }
        }
        self.best
    }

    #[inline(always)]
    fn interval(&self) -> (f32, f32) {
        let t_max = self.best.map_or(self.ray.t_max, |hit| hit.t);
        (self.ray.t_min, t_max)
    }

    /// Keeps a hit if it is nearer than the best so far, or as near with lower indices.
    #[inline(always)]
    fn offer(&mut self, hit: Hit) -> bool {
        let (t_min, t_max) = self.interval();
        let nearer = hit.t < t_max
            || self.best.is_some_and(|best| {
                hit.t == best.t && (hit.instance, hit.triangle) < (best.instance, best.triangle)
            });
        let accepted = hit.t > t_min && nearer;
        if accepted {
            self.best = Some(hit);
        }
        accepted
    }
}

/// Goes down from a top level into its instances.
struct InstanceVisitor<'q, 'a, const ANY: bool> {
    query: &'q mut Query<'a, ANY>,
    level: &'a TopLevel,
}

impl<const ANY: bool> Visitor for InstanceVisitor<'_, '_, ANY> {
    #[inline(always)]
    fn interval(&self) -> (f32, f32) {
        self.query.interval()
    }

    #[inline(always)]
    fn visit(&mut self, primitive: u32, stack: &mut Stack) -> bool {
        let placed = &self.level.placed[primitive as usize];
        let bottom = &self.query.bvh.bottom;
        let (origin, direction) = to_object(placed, &self.query.ray);
        let mut visitor = TriangleVisitor {
            ray: TriangleRay::new(origin, direction),
            instance: placed.instance,
            query: self.query,
        };
        let ray = BoxRay::new(origin, direction);
        traverse(&bottom.nodes, placed.root, &ray, stack, &mut visitor)
    }
}

/// Tests the triangles of one instance.
struct TriangleVisitor<'q, 'a, const ANY: bool> {
    query: &'q mut Query<'a, ANY>,
    ray: TriangleRay,
    instance: u32,
}

impl<const ANY: bool> Visitor for TriangleVisitor<'_, '_, ANY> {
    #[inline(always)]
    fn interval(&self) -> (f32, f32) {
        self.query.interval()
    }

    #[inline(always)]
    fn visit(&mut self, primitive: u32, _stack: &mut Stack) -> bool {
        let bvh = self.query.bvh;
        let triangle = &bvh.bottom.triangles[primitive as usize];
        let Some(TriangleHit { t, barycentrics }) = self.ray.intersect(triangle) else {
            return false;
        };
        let (t_min, t_max) = self.query.interval();
        let nearer = t > t_min && t <= t_max;
        if !nearer || !is_opaque(bvh, triangle, barycentrics) {
            return false;
        }
        let hit = Hit { t, instance: self.instance, triangle: triangle.id, barycentrics };
        self.query.offer(hit) && ANY
    }
}

/// The ray's origin and direction in an instance's object space.
pub(super) fn to_object(placed: &PlacedInstance, ray: &Ray) -> (Vec3, Vec3) {
    let world_to_object = &placed.world_to_object;
    let origin = world_to_object.transform_point3a(Vec3A::from(ray.origin));
    let direction = world_to_object.transform_vector3a(Vec3A::from(ray.direction));
    (origin.into(), direction.into())
}

/// Whether the triangle's alpha mask, if it has one, leaves the surface there.
#[inline(always)]
fn is_opaque(bvh: &TwoLevelBvh, triangle: &GpuTriangle, barycentrics: Vec2) -> bool {
    if triangle.masked == 0 {
        return true;
    }
    let masked = &bvh.bottom.masked[triangle.masked as usize - 1];
    let first = 1.0 - barycentrics.x - barycentrics.y;
    let uv = masked.uv0 * first + masked.uv1 * barycentrics.x + masked.uv2 * barycentrics.y;
    bvh.alpha_masks[masked.mask as usize].opaque_at(uv)
}
