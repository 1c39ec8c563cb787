//! Walls with openings, and their mouldings.
//!
//! In: rectangles and arches in the plane of a wall (x to the right, y up, z towards the viewer). Out: closed
//! solids. A wall with an opening consists of two halves that meet above and below the opening's centre.

use glam::{Vec2, Vec3, vec2, vec3};

use super::part::Part;
use super::paths::{circle, legged_arch, rectangle, way};
use super::shapes::{Ends, Frame, lying, prism, sweep};

/// A wall panel.
#[derive(Clone, Copy, Debug)]
pub(super) struct Panel {
    /// Lower left corner.
    pub min: Vec2,
    /// Upper right corner.
    pub max: Vec2,
    /// Back and front, in z.
    pub depth: [f32; 2],
}

/// An opening with an arch on top.
#[derive(Clone, Copy, Debug)]
pub(super) struct Opening {
    /// x of its centre.
    pub middle: f32,
    /// Half of its width.
    pub half: f32,
    /// Height of its sill; at or below the bottom of the panel: it has none.
    pub sill: f32,
    /// Height of its arch's springing.
    pub spring: f32,
    /// Rise of its arch.
    pub rise: f32,
    /// Segments of the arch, even.
    pub steps: u32,
}

impl Opening {
    /// The outline without the sill, from the lower left over the crown to the lower right, `wider` all round.
    pub fn outline(&self, wider: f32) -> Vec<Vec2> {
        let arch = legged_arch(self.half + wider, self.spring, self.rise + wider, self.sill, self.steps);
        arch.into_iter().map(|point| point + vec2(self.middle, 0.0)).collect()
    }

    /// A moulding along the outline: x of the profile points away from the opening, y towards the viewer.
    pub fn moulding(&self, profile: &[Vec2], z: f32, material: u32) -> Part {
        sweep(profile, &way(&self.outline(0.0), false), Ends::Capped, material).at(Vec3::Z * z)
    }

    /// A solid that fills the opening from z = `from` to z = `to`, extending by `wider` into the wall.
    pub fn filling(&self, wider: f32, [from, to]: [f32; 2], material: u32) -> Part {
        let mut outline = self.outline(wider);
        outline.reverse();
        let last = outline.len() - 1;
        outline[0].y -= wider;
        outline[last].y -= wider;
        prism(&outline, from, to, material)
    }
}

/// A wall panel with one opening.
pub(super) fn pierced(panel: &Panel, opening: &Opening, material: u32) -> Part {
    let outline = opening.outline(0.0);
    pierced_by(panel, &outline[outline.len() / 2..], opening.sill, material)
}

/// A wall panel with a round hole.
pub(super) fn pierced_by_circle(panel: &Panel, middle: Vec2, radius: f32, steps: u32, material: u32) -> Part {
    let ring = circle(middle, radius, 4 * (steps / 4));
    let quarter = ring.len() / 4;
    let mut right: Vec<Vec2> = ring[..=quarter].iter().rev().copied().collect();
    right.extend((3 * quarter..4 * quarter).rev().map(|i| ring[i]));
    // The highest and the lowest point are on the line between the halves.
    right[0].x = middle.x;
    if let Some(last) = right.last_mut() {
        last.x = middle.x;
    }
    pierced_by(panel, &right, middle.y - radius, material)
}

/// `right` is the right side of the opening, from its topmost point down; below `sill` there is wall again.
fn pierced_by(panel: &Panel, right: &[Vec2], sill: f32, material: u32) -> Part {
    let middle = right[0].x;
    let mut outline = vec![panel.max, vec2(middle, panel.max.y)];
    outline.extend_from_slice(right);
    if sill > panel.min.y {
        let lowest = vec2(middle, sill);
        if outline.last().is_some_and(|last| last.distance(lowest) > 1e-6) {
            outline.push(lowest);
        }
        outline.push(vec2(middle, panel.min.y));
    } else if let Some(last) = outline.last_mut() {
        last.y = panel.min.y;
    }
    let corner = vec2(panel.max.x, panel.min.y);
    if outline.last().is_some_and(|last| last.distance(corner) > 1e-6) {
        outline.push(corner);
    }
    let half = |edge: f32| {
        let mut points = outline.clone();
        for point in &mut points {
            if point.x == panel.max.x {
                point.x = edge;
            }
        }
        points
    };
    let mut left: Vec<Vec2> =
        half(2.0 * middle - panel.min.x).into_iter().map(|p| vec2(2.0 * middle - p.x, p.y)).collect();
    left.reverse();
    let [back, front] = panel.depth;
    prism(&half(panel.max.x), back, front, material).and(prism(&left, back, front, material))
}

/// A moulding that runs round the inside of a rectangle on the level y = 0: x of the profile goes inwards, y up.
pub(super) fn cornice(half_x: f32, half_z: f32, profile: &[Vec2], material: u32) -> Part {
    let ring = way(&rectangle(half_x, half_z), true);
    sweep(profile, &ring, Ends::Joined, material).placed(&lying())
}

/// A moulding that runs round a picture or a door, in the plane z = 0: x of the profile goes inwards, y towards
/// the viewer.
pub(super) fn frame(half: Vec2, profile: &[Vec2], material: u32) -> Part {
    sweep(profile, &way(&rectangle(half.x, half.y), true), Ends::Joined, material)
}

/// A straight moulding along x: x of the profile goes towards the viewer, y up.
pub(super) fn straight(from: f32, to: f32, profile: &[Vec2], material: u32) -> Part {
    let end = |x: f32| Frame { origin: vec3(x, 0.0, 0.0), right: Vec3::NEG_Z, up: Vec3::Y };
    let mirrored: Vec<Vec2> = profile.iter().rev().map(|p| vec2(-p.x, p.y)).collect();
    sweep(&mirrored, &[end(from), end(to)], Ends::Capped, material)
}
