//! Curves of arches, and sweep paths of mouldings.
//!
//! In: spans and rises. Out: polylines in a wall's plane, and [`Frame`]s along them.

use std::f32::consts::{PI, TAU};

use glam::{Vec2, Vec3, vec2};

use super::shapes::Frame;

/// An arch from its left foot at (-`half_span`, 0) over its crown at (0, `rise`) to the right foot, in an even
/// number of `steps`: half an ellipse, or two arcs that meet in a point where it rises higher than a semicircle.
pub(super) fn arch(half_span: f32, rise: f32, steps: u32) -> Vec<Vec2> {
    let half = steps / 2;
    let side = |i: u32| {
        let share = i as f32 / half as f32;
        if rise <= half_span {
            let angle = 0.5 * PI * share;
            return if i == half {
                vec2(0.0, rise)
            } else {
                vec2(half_span * angle.cos(), rise * angle.sin())
            };
        }
        // Each side is an arc with its centre on the base line, beyond the middle.
        let radius = (half_span * half_span + rise * rise) / (2.0 * half_span);
        let angle = (rise / radius).asin() * share;
        if i == half {
            vec2(0.0, rise)
        } else {
            vec2(half_span - radius + radius * angle.cos(), radius * angle.sin())
        }
    };
    let left = (0..=half).map(|i| side(i) * vec2(-1.0, 1.0));
    let right = (0..half).rev().map(side);
    left.chain(right).collect()
}

/// The arch with straight legs down to y = `foot` below it, lifted so that its feet are at `spring`.
pub(super) fn legged_arch(half_span: f32, spring: f32, rise: f32, foot: f32, steps: u32) -> Vec<Vec2> {
    let mut points: Vec<Vec2> =
        arch(half_span, rise, steps).into_iter().map(|point| point + vec2(0.0, spring)).collect();
    if foot < spring {
        points.insert(0, vec2(-half_span, foot));
        points.push(vec2(half_span, foot));
    }
    points
}

/// A circle around `middle`, counter-clockwise from the right.
pub(super) fn circle(middle: Vec2, radius: f32, steps: u32) -> Vec<Vec2> {
    (0..steps).map(|i| middle + radius * Vec2::from_angle(TAU * i as f32 / steps as f32)).collect()
}

/// A sweep path along a polyline in the plane z = 0: x of the profile points to the left of the path, y to +z.
/// Corners are mitred; `closed` joins the last point to the first.
pub(super) fn way(points: &[Vec2], closed: bool) -> Vec<Frame> {
    let n = points.len();
    let left_of = |i: usize, j: usize| (points[j] - points[i]).normalize_or(Vec2::X).perp();
    let frame = |i: usize| {
        let (first, last) = (!closed && i == 0, !closed && i + 1 == n);
        let before = if first { left_of(0, 1) } else { left_of((i + n - 1) % n, i) };
        let after = if last { left_of(n - 2, n - 1) } else { left_of(i, (i + 1) % n) };
        let mitre = (before + after) / (1.0 + before.dot(after)).max(0.1);
        Frame { origin: points[i].extend(0.0), right: mitre.extend(0.0), up: Vec3::Z }
    };
    (0..n).map(frame).collect()
}

/// A rectangle around the origin, counter-clockwise, from the lower left.
pub(super) fn rectangle(half_x: f32, half_y: f32) -> [Vec2; 4] {
    [vec2(-half_x, -half_y), vec2(half_x, -half_y), vec2(half_x, half_y), vec2(-half_x, half_y)]
}

/// An axis-aligned rectangle as a profile.
pub(super) fn strip(min: Vec2, max: Vec2) -> [Vec2; 4] {
    [min, vec2(max.x, min.y), max, vec2(min.x, max.y)]
}

/// The arc of a round moulding from one angle to another (degrees, counter-clockwise where rising), about `middle`.
pub(super) fn arc(middle: Vec2, radius: f32, [from, to]: [f32; 2], steps: u32) -> Vec<Vec2> {
    let point = |i: u32| {
        let angle = from + (to - from) * i as f32 / steps as f32;
        middle + radius * Vec2::from_angle(angle.to_radians())
    };
    (0..=steps).map(point).collect()
}

/// Points from their coordinates, such as those of a profile.
pub(super) fn points(list: &[[f32; 2]]) -> Vec<Vec2> {
    list.iter().copied().map(Vec2::from).collect()
}
