//! Depth-first traversal of a wide BVH, nearest child first.
//!
//! In: nodes, where to start and a ray. Out: each leaf whose box the ray may touch, roughly front to back.
//! The slab test is conservative at every scale: its padding follows from the magnitudes that were
//! rounded, never from an absolute epsilon.

use glam::Vec3A;

use super::{
    nodes::{Child, Node, WIDTH},
    simd::{Eight, Simd},
};

/// Padding of the slab test, relative to the coordinates of a box, which is padded when it is built, and to
/// those of a ray's origin: covers the rounding of both the slab test and the triangle test.
pub(super) const SLAB_PADDING: f32 = 1.0 / (1 << 19) as f32;

/// A direction component below this share of the largest counts as this much.
const SMALLEST_DIRECTION: f32 = 1.0 / (1u64 << 60) as f32;

/// Most nodes on the way from a bottom level's root to a leaf.
pub(super) const BOTTOM_DEPTH: usize = 32;

/// Most nodes on the way from a top level's root to a leaf.
pub(super) const TOP_DEPTH: usize = 24;

/// Deepest stack that a query can need: each node on the way leaves all of its children but one for later.
const STACK_SIZE: usize = (BOTTOM_DEPTH + TOP_DEPTH) * (WIDTH - 1);

/// What is still to be visited, shared by both levels of one query.
#[derive(Debug)]
pub(super) struct Stack {
    entries: [Entry; STACK_SIZE],
    len: usize,
}

#[derive(Clone, Copy, Debug)]
struct Entry {
    child: Child,
    near: f32,
}

impl Stack {
    pub(super) const EMPTY: Self = Self { entries: [Entry { child: Child::NOTHING, near: 0.0 }; STACK_SIZE], len: 0 };

    #[inline(always)]
    fn push(&mut self, entry: Entry) {
        self.entries[self.len] = entry;
        self.len += 1;
    }

    #[inline(always)]
    fn pop(&mut self) -> Entry {
        self.len -= 1;
        self.entries[self.len]
    }
}

/// A ray prepared for box tests: it meets the plane `x` at `x * inverse + start`, padded towards both ends.
#[derive(Clone, Copy, Debug)]
pub(super) struct BoxRay<S: Simd> {
    simd: S,
    inverse: [S::Floats; 3],
    near_start: [S::Floats; 3],
    far_start: [S::Floats; 3],
    /// Index of the near plane on each axis.
    near: [usize; 3],
    t_min: S::Floats,
}

impl<S: Simd> BoxRay<S> {
    /// Prepares a ray; zero components of the direction are made tiny, so that nothing divides by zero.
    #[inline(always)]
    pub(super) fn new(simd: S, origin: Vec3A, direction: Vec3A, t_min: f32) -> Self {
        let size = direction.abs();
        let size = size.max(Vec3A::splat(size.max_element() * SMALLEST_DIRECTION));
        let inverse = 1.0 / size.copysign(direction);
        let start = -origin * inverse;
        let padding = inverse.abs() * (SLAB_PADDING * origin.abs().max_element());
        let splat = |v: Vec3A| [simd.splat(v.x), simd.splat(v.y), simd.splat(v.z)];
        let negative = direction.is_negative_bitmask() as usize;
        Self {
            simd,
            inverse: splat(inverse),
            near_start: splat(start - padding),
            far_start: splat(start + padding),
            near: [negative & 1, negative >> 1 & 1, negative >> 2 & 1],
            t_min: simd.splat(t_min),
        }
    }

    /// Where the ray enters the boxes of a node's children, and a bit for each that it meets.
    #[inline(always)]
    fn meet(&self, node: &Node, t_max: f32) -> (Eight, u32) {
        let simd = self.simd;
        let slab = |axis: usize| {
            let near = self.near[axis] & 1;
            let [enter, leave] = [&node.planes[axis][near], &node.planes[axis][near ^ 1]];
            (
                simd.mul_add(simd.load(enter), self.inverse[axis], self.near_start[axis]),
                simd.mul_add(simd.load(leave), self.inverse[axis], self.far_start[axis]),
            )
        };
        let [x, y, z] = [slab(0), slab(1), slab(2)];
        let enter = simd.max(simd.max(x.0, y.0), simd.max(z.0, self.t_min));
        let leave = simd.min(simd.min(x.1, y.1), simd.min(z.1, simd.splat(t_max)));
        (simd.store(enter), simd.le(enter, leave))
    }
}

/// What a traversal does with the leaves that it finds.
pub(super) trait Visitor {
    const ANY: bool;
    /// Where what is of interest ends.
    fn t_max(&self) -> f32;
    /// Tests a leaf; true ends the traversal.
    fn visit(&mut self, leaf: Child, stack: &mut Stack) -> bool;
}

/// Visits all leaves below `root` whose boxes the ray meets before the visitor's t_max. True if the
/// visitor ended it.
#[inline(always)]
pub(super) fn traverse<S: Simd, V: Visitor>(
    nodes: &[Node],
    root: Child,
    ray: &BoxRay<S>,
    stack: &mut Stack,
    visitor: &mut V,
) -> bool {
    if V::ANY {
        traverse_any(nodes, root, ray, stack, visitor)
    } else {
        traverse_closest(nodes, root, ray, stack, visitor);
        false
    }
}

#[inline(always)]
fn traverse_closest<S: Simd, V: Visitor>(
    nodes: &[Node],
    root: Child,
    ray: &BoxRay<S>,
    stack: &mut Stack,
    visitor: &mut V,
) {
    let floor = stack.len;
    let mut child = root;
    loop {
        if child.is_leaf() {
            visitor.visit(child, stack);
        } else {
            let node = &nodes[child.index()];
            let (near, mut met) = ray.meet(node, visitor.t_max());
            if met != 0 {
                // Go on with the nearest child, and leave the others for later.
                let mut lane = met.trailing_zeros() as usize % WIDTH;
                met &= met - 1;
                while met != 0 {
                    let mut other = met.trailing_zeros() as usize % WIDTH;
                    met &= met - 1;
                    if near[other] < near[lane] {
                        (lane, other) = (other, lane);
                    }
                    stack.push(Entry { child: node.children[other], near: near[other] });
                }
                child = node.children[lane];
                continue;
            }
        }
        loop {
            if stack.len == floor {
                return;
            }
            let entry = stack.pop();
            if entry.near <= visitor.t_max() {
                child = entry.child;
                break;
            }
        }
    }
}

#[inline(always)]
fn traverse_any<S: Simd, V: Visitor>(
    nodes: &[Node],
    root: Child,
    ray: &BoxRay<S>,
    stack: &mut Stack,
    visitor: &mut V,
) -> bool {
    let floor = stack.len;
    let mut child = root;
    loop {
        let (mut index, mut met) = (child.index(), 0);
        if child.is_leaf() {
            if visitor.visit(child, stack) {
                stack.len = floor;
                return true;
            }
        } else {
            met = ray.meet(&nodes[index], visitor.t_max()).1;
        }
        if met == 0 {
            if stack.len == floor {
                return false;
            }
            let entry = stack.pop();
            index = entry.child.index();
            met = entry.near.to_bits();
        }
        // Go on with the first child, and leave the others for later.
        let lane = met.trailing_zeros() as usize % WIDTH;
        met &= met - 1;
        stack.entries[stack.len] = Entry { child: Child::node(index), near: f32::from_bits(met) };
        stack.len += usize::from(met != 0);
        child = nodes[index].children[lane];
    }
}
