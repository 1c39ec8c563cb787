//! Depth-first traversal of a wide BVH, nearest child first.
//!
//! In: nodes, a root and a ray. Out: each leaf whose box the ray may hit, roughly front to back. The slab test is
//! conservative at every scale: its padding is relative to the rounded magnitudes, never an absolute epsilon.

use glam::Vec3A;

use super::{
    nodes::{Child, Node, WIDTH},
    simd::{Eight, Simd},
};

/// Padding of the slab test, relative to the coordinates of boxes (padded at build time) and of ray origins: bounds
/// the rounding errors of the slab test and the triangle test.
pub(super) const SLAB_PADDING: f32 = 1.0 / (1 << 19) as f32;

/// Smallest magnitude of a direction component, relative to the largest; smaller ones are raised to it.
const SMALLEST_DIRECTION: f32 = 1.0 / (1u64 << 60) as f32;

/// Most nodes on a path from a bottom level's root to a leaf.
pub(super) const BOTTOM_DEPTH: usize = 32;

/// Most nodes on a path from a top level's root to a leaf.
pub(super) const TOP_DEPTH: usize = 24;

/// Worst-case stack size of a query: each node on the path pushes all of its children but one.
const STACK_SIZE: usize = (BOTTOM_DEPTH + TOP_DEPTH) * (WIDTH - 1);

/// The traversal stack, shared by both levels of one query.
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
    pub(super) const EMPTY: Self =
        Self { entries: [Entry { child: Child::EMPTY, near: 0.0 }; STACK_SIZE], len: 0 };

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

/// A ray prepared for slab tests: it crosses the plane `x` at t = `x * inverse + start`, padded towards both ends.
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
    /// Prepares a ray; zero components of the direction become tiny, which avoids a division by zero.
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

    /// Tests the boxes of a node's children: entry distances, and the bit mask of the lanes hit.
    #[inline(always)]
    fn intersect_children(&self, node: &Node, t_max: f32) -> (Eight, u32) {
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

/// Receives the leaves of a traversal.
pub(super) trait Visitor {
    /// Whether any hit ends the traversal.
    const ANY: bool;
    /// Upper bound of t, the closest hit so far.
    fn t_max(&self) -> f32;
    /// Tests a leaf; true ends the traversal.
    fn visit(&mut self, leaf: Child, stack: &mut Stack) -> bool;
}

/// Visits all leaves below `root` whose boxes the ray hits before the visitor's t_max. True if the visitor ended the
/// traversal.
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
    let base = stack.len;
    let mut child = root;
    loop {
        if child.is_leaf() {
            visitor.visit(child, stack);
        } else {
            let node = &nodes[child.index()];
            let (near, mut mask) = ray.intersect_children(node, visitor.t_max());
            if mask != 0 {
                // Descend into the nearest child and push the others.
                let mut lane = mask.trailing_zeros() as usize % WIDTH;
                mask &= mask - 1;
                while mask != 0 {
                    let mut other = mask.trailing_zeros() as usize % WIDTH;
                    mask &= mask - 1;
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
            if stack.len == base {
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
    let base = stack.len;
    let mut child = root;
    loop {
        let (mut index, mut mask) = (child.index(), 0);
        if child.is_leaf() {
            if visitor.visit(child, stack) {
                stack.len = base;
                return true;
            }
        } else {
            mask = ray.intersect_children(&nodes[index], visitor.t_max()).1;
        }
        if mask == 0 {
            if stack.len == base {
                return false;
            }
            let entry = stack.pop();
            index = entry.child.index();
            mask = entry.near.to_bits();
        }
        // Descend into the first child and push the node with the mask of the others, as one entry.
        let lane = mask.trailing_zeros() as usize % WIDTH;
        mask &= mask - 1;
        stack.entries[stack.len] = Entry { child: Child::node(index), near: f32::from_bits(mask) };
        stack.len += usize::from(mask != 0);
        child = nodes[index].children[lane];
    }
}
