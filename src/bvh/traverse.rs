//! Depth-first traversal of a wide BVH, nearest child first.
//!
//! In: nodes, where to start and a ray. Out: each leaf whose box the ray may touch, roughly front to back.
//! The slab test is conservative at every scale: its padding follows from the magnitudes that were
//! rounded, never from an absolute epsilon.

use arrayvec::ArrayVec;
use glam::{Vec3, Vec4};

use super::nodes::{Child, Node, WIDTH};

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

/// What is still to be visited, and where the ray enters its box; shared by both levels of one query.
pub(super) type Stack = ArrayVec<(Child, f32), STACK_SIZE>;

/// A ray prepared for box tests: it meets the plane `x` at `x * inverse + start`, padded towards both ends.
#[derive(Clone, Copy, Debug)]
pub(super) struct BoxRay {
    inverse: [Vec4; 3],
    near_start: [Vec4; 3],
    far_start: [Vec4; 3],
    /// Index of the near plane on each axis.
    near: [usize; 3],
    t_min: Vec4,
}

impl BoxRay {
    /// Prepares a ray; zero components of the direction are made tiny, so that nothing divides by zero.
    pub(super) fn new(origin: Vec3, direction: Vec3, t_min: f32) -> Self {
        let size = direction.abs();
        let size = size.max(Vec3::splat(size.max_element() * SMALLEST_DIRECTION));
        let inverse_size = 1.0 / size;
        let negative = [direction.x < 0.0, direction.y < 0.0, direction.z < 0.0];
        let sign = Vec3::from(negative.map(|negative| if negative { -1.0 } else { 1.0 }));
        let inverse = inverse_size * sign;
        let start = -origin * inverse;
        let padding = inverse_size * (SLAB_PADDING * origin.abs().max_element());
        let splat = |v: Vec3| [Vec4::splat(v.x), Vec4::splat(v.y), Vec4::splat(v.z)];
        Self {
            inverse: splat(inverse),
            near_start: splat(start - padding),
            far_start: splat(start + padding),
            near: negative.map(usize::from),
            t_min: Vec4::splat(t_min),
        }
    }

    /// Where the ray enters the boxes of a node's children, and a bit for each that it meets.
    #[inline(always)]
    fn meet(&self, node: &Node, t_max: f32) -> (Vec4, u32) {
        let enter =
            |axis: usize| node.planes[axis][self.near[axis] & 1] * self.inverse[axis] + self.near_start[axis];
        let leave =
            |axis: usize| node.planes[axis][!self.near[axis] & 1] * self.inverse[axis] + self.far_start[axis];
        let near = enter(0).max(enter(1)).max(enter(2).max(self.t_min));
        let far = leave(0).min(leave(1)).min(leave(2).min(Vec4::splat(t_max)));
        (near, near.cmple(far).bitmask())
    }
}

/// What a traversal does with the leaves that it finds.
pub(super) trait Visitor {
    /// Where what is of interest ends.
    fn t_max(&self) -> f32;
    /// Tests a leaf; true ends the traversal.
    fn visit(&mut self, leaf: Child, stack: &mut Stack) -> bool;
}

/// Visits all leaves below `root` whose boxes the ray meets before the visitor's t_max. True if the
/// visitor ended it.
#[inline(always)]
pub(super) fn traverse(
    nodes: &[Node],
    root: Child,
    ray: &BoxRay,
    stack: &mut Stack,
    visitor: &mut impl Visitor,
) -> bool {
    let floor = stack.len();
    let mut child = root;
    loop {
        if child.is_leaf() {
            if visitor.visit(child, stack) {
                stack.truncate(floor);
                return true;
            }
        } else {
            let node = &nodes[child.index()];
            let (near, mut met) = ray.meet(node, visitor.t_max());
            if met != 0 {
                // Go on with the nearest child, and leave the others for later.
                let near = near.to_array();
                let lane = met.trailing_zeros() as usize % WIDTH;
                met &= met - 1;
                let mut nearest = (node.children[lane], near[lane]);
                while met != 0 {
                    let lane = met.trailing_zeros() as usize % WIDTH;
                    met &= met - 1;
                    let other = (node.children[lane], near[lane]);
                    if other.1 < nearest.1 {
                        stack.push(nearest);
                        nearest = other;
                    } else {
                        stack.push(other);
                    }
                }
                child = nearest.0;
                continue;
            }
        }
        loop {
            if stack.len() == floor {
                return false;
            }
            let Some((next, near)) = stack.pop() else { return false };
            if near <= visitor.t_max() {
                child = next;
                break;
            }
        }
    }
}
