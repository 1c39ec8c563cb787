//! Depth-first traversal of a compressed wide BVH (Ylitie et al. 2017, algorithm 1).
//!
//! In: nodes, a root and a ray. Out: each primitive whose box the ray may touch, roughly front to back.
//! The slab test is conservative at every scale: its padding follows from the magnitudes that were
//! rounded, never from an absolute epsilon.

use glam::{Vec3, Vec4};
use obvhs::cwbvh::node::CwBvhNode;

/// Relative padding of the slab test: covers the rounding of the quantised boxes and of the test.
pub(super) const SLAB_PADDING: f32 = 1.0 / (1 << 19) as f32;

/// A direction component below this share of the largest counts as this much.
pub(super) const SMALLEST_DIRECTION: f32 = 1.0 / (1u64 << 60) as f32;

/// Deepest stack that a query can need; the depths of both levels bound it, see [`super::wide`].
const STACK_SIZE: usize = 64;

/// A ray prepared for box tests.
#[derive(Clone, Copy, Debug)]
pub(super) struct BoxRay {
    origin: Vec3,
    inverse: Vec3,
    negative: [bool; 3],
    /// Bits 0 to 2 inverted by sign of the direction, repeated in each byte: orders the children.
    octant: u32,
}

impl BoxRay {
    /// Prepares a ray; zero components of the direction are made tiny, so that nothing divides by zero.
    pub(super) fn new(origin: Vec3, direction: Vec3) -> Self {
        let size = direction.abs();
        let size = size.max(Vec3::splat(size.max_element() * SMALLEST_DIRECTION));
        let negative = [direction.x < 0.0, direction.y < 0.0, direction.z < 0.0];
        let sign = Vec3::from(negative.map(|negative| if negative { -1.0 } else { 1.0 }));
        let bits = [4, 2, 1];
        let positive: u32 = (0..3).filter(|&i| !negative[i]).map(|i| bits[i]).sum();
        Self { origin, inverse: sign / size, negative, octant: positive * 0x0101_0101 }
    }
}

/// Groups of nodes still to visit, shared by both levels of one query.
pub(super) struct Stack {
    entries: [[u32; 2]; STACK_SIZE],
    len: usize,
}

impl Stack {
    pub(super) fn new() -> Self {
        Self { entries: [[0; 2]; STACK_SIZE], len: 0 }
    }

    #[inline(always)]
    fn push(&mut self, group: [u32; 2]) {
        self.entries[self.len] = group;
        self.len += 1;
    }

    #[inline(always)]
    fn pop(&mut self) -> [u32; 2] {
        self.len -= 1;
        self.entries[self.len]
    }
}

/// What a traversal does with the primitives that it finds.
pub(super) trait Visitor {
    /// The open interval of t that is still of interest.
    fn interval(&self) -> (f32, f32);
    /// Tests one primitive; true ends the traversal.
    fn visit(&mut self, primitive: u32, stack: &mut Stack) -> bool;
}

/// Visits all primitives below `root` whose boxes meet the ray within the visitor's interval. True if
/// the visitor ended it.
#[inline(always)]
pub(super) fn traverse(
    nodes: &[CwBvhNode],
    root: u32,
    ray: &BoxRay,
    stack: &mut Stack,
    visitor: &mut impl Visitor,
) -> bool {
    let floor = stack.len;
    // A group is (index of its first child, hit bits by visiting order << 24 | mask of inner children).
    let mut group = [root, 0x8000_0000];
    loop {
        // Take the nearest child of the group, and leave the rest for later.
        let first = 31 - group[1].leading_zeros();
        let slot = (first - 24) ^ (ray.octant & 7);
        let before = (group[1] & !(u32::MAX << slot)).count_ones();
        let node = &nodes[(group[0] + before) as usize];
        group[1] &= !(1 << first);
        if group[1] >> 24 != 0 {
            stack.push(group);
        }

        // Intersect its children, and test those that are primitives.
        let (t_min, t_max) = visitor.interval();
        let hits = child_hits(node, ray, t_min, t_max);
        let mut primitives = hits & 0x00ff_ffff;
        while primitives != 0 {
            let offset = 31 - primitives.leading_zeros();
            primitives &= !(1 << offset);
            if visitor.visit(node.primitive_base_idx + offset, stack) {
                stack.len = floor;
                return true;
            }
        }

        // Go on with its inner children, or with what was left for later.
        group = [node.child_base_idx, hits & 0xff00_0000 | u32::from(node.imask)];
        if group[1] >> 24 == 0 {
            if stack.len == floor {
                return false;
            }
            group = stack.pop();
        }
    }
}

/// Bits 24 to 31: inner children that the ray meets, by visiting order; bits 0 to 23: primitives.
#[inline(always)]
fn child_hits(node: &CwBvhNode, ray: &BoxRay, t_min: f32, t_max: f32) -> u32 {
    // Bring the ray into the node's grid; the padding moves each near plane nearer and far plane farther.
    let cell = Vec3::new(
        f32::from_bits(u32::from(node.e[0]) << 23),
        f32::from_bits(u32::from(node.e[1]) << 23),
        f32::from_bits(u32::from(node.e[2]) << 23),
    );
    let to_node = node.p - ray.origin;
    let reach = to_node.abs().max_element() + 255.0 * cell.max_element();
    let padding = (SLAB_PADDING * reach) * ray.inverse.abs();
    let step = cell * ray.inverse;
    let start = to_node * ray.inverse;
    let (near, far) = (start - padding, start + padding);

    // Test four children at a time.
    let [near_x, far_x] = ordered(ray.negative[0], &node.child_min_x, &node.child_max_x);
    let [near_y, far_y] = ordered(ray.negative[1], &node.child_min_y, &node.child_max_y);
    let [near_z, far_z] = ordered(ray.negative[2], &node.child_min_z, &node.child_max_z);
    let mut met = 0;
    for half in 0..2 {
        let enter_x = lanes(near_x, half) * step.x + near.x;
        let enter_y = lanes(near_y, half) * step.y + near.y;
        let enter_z = lanes(near_z, half) * step.z + near.z;
        let leave_x = lanes(far_x, half) * step.x + far.x;
        let leave_y = lanes(far_y, half) * step.y + far.y;
        let leave_z = lanes(far_z, half) * step.z + far.z;
        let enter = enter_x.max(enter_y).max(enter_z.max(Vec4::splat(t_min)));
        let leave = leave_x.min(leave_y).min(leave_z.min(Vec4::splat(t_max)));
        met |= enter.cmple(leave).bitmask() << (4 * half);
    }

    // Spread the met children over the bits of their visiting order or their primitives.
    let (bits, shifts) = node.get_child_and_index_bits(ray.octant);
    let mut hits = 0;
    while met != 0 {
        let byte = met.trailing_zeros() * 8;
        met &= met - 1;
        hits |= ((bits >> byte) as u32 & 0xff) << ((shifts >> byte) as u32 & 0x1f);
    }
    hits
}

#[inline(always)]
fn ordered<'a>(negative: bool, min: &'a [u8; 8], max: &'a [u8; 8]) -> [&'a [u8; 8]; 2] {
    if negative { [max, min] } else { [min, max] }
}

#[inline(always)]
fn lanes(planes: &[u8; 8], half: usize) -> Vec4 {
    Vec4::new(
        f32::from(planes[4 * half]),
        f32::from(planes[4 * half + 1]),
        f32::from(planes[4 * half + 2]),
        f32::from(planes[4 * half + 3]),
    )
}
