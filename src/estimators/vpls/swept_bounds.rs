//! Where instances have moved since each temporal set was rendered.
//!
//! In: the pose of each frame. Out: for each set, boxes in world space. The occlusion of a ray that crosses none of them is unchanged.

use bytemuck::{Pod, Zeroable};
use glam::{Affine3A, Vec3};
use obvhs::aabb::Aabb;

use crate::bvh::transformed;
use crate::scene::{Instance, Pose, Scene};

/// Boxes that shaders are told of, at most. Twin: shaders/estimators/vpls/vpls.glsl.
pub const MAX_SWEPT_BOXES: usize = 8;
/// Stands for an instance, where a box bounds what several have swept.
const SEVERAL: usize = usize::MAX;

/// A box in world space; `SweptBox` in shaders/estimators/vpls/vpls.glsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct SweptBox {
    low: Vec3,
    /// 1: there is a box.
    exists: f32,
    high: Vec3,
    pad: f32,
}

impl SweptBox {
    /// Bounds of a box in object space.
    fn of((low, high): (Vec3, Vec3), to_world: &Affine3A) -> Self {
        let bounds = transformed(&Aabb::new(low.into(), high.into()), to_world);
        Self { low: bounds.min.into(), exists: 1.0, high: bounds.max.into(), pad: 0.0 }
    }

    fn union(self, other: Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high), ..self }
    }
}

/// The boxes that instances have swept since each set was rendered.
pub struct SweptBounds {
    /// Object-space bounds of each mesh.
    meshes: Vec<(Vec3, Vec3)>,
    last: Vec<Affine3A>,
    /// The instances that have swept boxes, and the boxes, for each set.
    swept: Vec<Vec<(usize, SweptBox)>>,
}

impl SweptBounds {
    /// Nothing has moved yet.
    pub fn new(scene: &Scene, sets: u32) -> Self {
        Self {
            meshes: scene.meshes.iter().map(|mesh| mesh.bounds()).collect(),
            last: Vec::new(),
            swept: vec![Vec::new(); sets as usize],
        }
    }

    /// Compares the transforms with those of the last frame.
    pub fn advance(&mut self, scene: &Scene, pose: &Pose) {
        let both = scene.instances.iter().zip(self.last.iter().zip(&pose.instances)).enumerate();
        let moves = |(index, (instance, (from, to))): (usize, (&Instance, (&Affine3A, &Affine3A)))| {
            let mesh = self.meshes[instance.mesh];
            (instance.visible && from != to)
                .then(|| (index, SweptBox::of(mesh, from).union(SweptBox::of(mesh, to))))
        };
        let moves: Vec<_> = both.filter_map(moves).collect();
        for boxes in &mut self.swept {
            moves.iter().for_each(|&(mover, swept)| add(boxes, mover, swept));
        }
        self.last.clone_from(&pose.instances);
    }

    /// The boxes of a set that is rendered now. There are none from then on.
    pub fn take(&mut self, set: u32) -> [SweptBox; MAX_SWEPT_BOXES] {
        let mut boxes = [SweptBox::default(); MAX_SWEPT_BOXES];
        for (to, (_, from)) in boxes.iter_mut().zip(self.swept[set as usize].drain(..)) {
            *to = from;
        }
        boxes
    }
}

/// Adds what an instance has swept to its box; where there are too many, all become one.
fn add(boxes: &mut Vec<(usize, SweptBox)>, mover: usize, swept: SweptBox) {
    let joined = boxes.first().is_some_and(|(first, _)| *first == SEVERAL);
    if let Some((_, known)) = boxes.iter_mut().find(|(known, _)| joined || *known == mover) {
        *known = known.union(swept);
    } else if boxes.len() < MAX_SWEPT_BOXES {
        boxes.push((mover, swept));
    } else {
        let all = boxes.drain(..).fold(swept, |all, (_, swept)| all.union(swept));
        boxes.push((SEVERAL, all));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn box_at(x: f32) -> SweptBox {
        SweptBox::of((Vec3::splat(-1.0), Vec3::splat(1.0)), &Affine3A::from_translation(Vec3::X * x))
    }

    #[test]
    fn boxes_hold_all_that_an_instance_has_swept() {
        let mut boxes = Vec::new();
        add(&mut boxes, 3, box_at(0.0));
        add(&mut boxes, 3, box_at(5.0));
        assert_eq!(boxes.len(), 1);
        assert_eq!((boxes[0].1.low.x, boxes[0].1.high.x), (-1.0, 6.0));
    }

    #[test]
    fn too_many_boxes_become_one() {
        let mut boxes = Vec::new();
        (0..20).for_each(|mover| add(&mut boxes, mover, box_at(mover as f32)));
        assert_eq!(boxes.len(), 1);
        assert_eq!((boxes[0].1.low.x, boxes[0].1.high.x), (-1.0, 20.0));
    }
}
