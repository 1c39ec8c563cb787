//! Triangulates polygons by ear clipping.
//!
//! In: the corners of a roughly planar polygon, convex or concave. Out: n - 2 triangles of corner indices with the
//! polygon's winding.

use glam::{Vec2, Vec3};

/// Larger concave polygons become triangle fans: ear clipping takes at least quadratic time.
const MAX_CLIPPED: usize = 1000;

/// Triangulates a polygon of at least three corners.
pub(crate) fn triangulate(corners: &[Vec3]) -> Vec<[usize; 3]> {
    let n = corners.len();
    let fan = || (1..n - 1).map(|i| [0, i, i + 1]).collect();
    if n == 3 || n > MAX_CLIPPED {
        return fan();
    }
    let Some(flat) = project(corners) else {
        return fan();
    };
    let all: Vec<usize> = (0..n).collect();
    if (0..n).all(|i| signed_area(&flat, &all, i) >= 0.0) {
        return fan();
    }
    clip_ears(&flat, all)
}

/// Projects the corners to the polygon's plane, counter-clockwise; none if it has no area.
fn project(corners: &[Vec3]) -> Option<Vec<Vec2>> {
    let local: Vec<Vec3> = corners.iter().map(|corner| *corner - corners[0]).collect();
    let area: Vec3 = (0..local.len()).map(|i| local[i].cross(local[(i + 1) % local.len()])).sum();
    let normal = area.try_normalize()?;
    let (x, y) = normal.any_orthonormal_pair();
    let (x, y) = if x.cross(y).dot(normal) > 0.0 { (x, y) } else { (y, x) };
    Some(local.iter().map(|point| Vec2::new(point.dot(x), point.dot(y))).collect())
}

/// Twice the signed area of corner `i` of the ring and its two neighbours; negative at a reflex corner.
fn signed_area(flat: &[Vec2], ring: &[usize], i: usize) -> f32 {
    let n = ring.len();
    let [a, b, c] = [ring[(i + n - 1) % n], ring[i], ring[(i + 1) % n]].map(|corner| flat[corner]);
    (b - a).perp_dot(c - b)
}

fn clip_ears(flat: &[Vec2], mut ring: Vec<usize>) -> Vec<[usize; 3]> {
    let mut triangles = Vec::with_capacity(ring.len() - 2);
    while ring.len() > 3 {
        let n = ring.len();
        let is_ear = |i: usize| {
            let ear = [ring[(i + n - 1) % n], ring[i], ring[(i + 1) % n]];
            signed_area(flat, &ring, i) > 0.0
                && !ring
                    .iter()
                    .any(|corner| !ear.contains(corner) && contains(ear.map(|e| flat[e]), flat[*corner]))
        };
        // A self-intersecting ring may have no ear: clip any corner, so that the loop terminates.
        let i = (0..n).find(|&i| is_ear(i)).unwrap_or(1);
        triangles.push([ring[(i + n - 1) % n], ring[i], ring[(i + 1) % n]]);
        ring.remove(i);
    }
    triangles.push([ring[0], ring[1], ring[2]]);
    triangles
}

fn contains([a, b, c]: [Vec2; 3], point: Vec2) -> bool {
    let side = |from: Vec2, to: Vec2| (to - from).perp_dot(point - from) >= 0.0;
    side(a, b) && side(b, c) && side(c, a)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(corners: &[Vec3], triangles: &[[usize; 3]]) -> f32 {
        let one = |t: &[usize; 3]| {
            let [a, b, c] = t.map(|i| corners[i]);
            0.5 * (b - a).cross(c - a).z
        };
        // Every triangle must keep the winding.
        assert!(triangles.iter().all(|t| one(t) >= 0.0));
        triangles.iter().map(one).sum()
    }

    #[test]
    fn concave_polygons_keep_their_area() {
        let arrow = [[0.0, 0.0], [4.0, 0.0], [1.0, 1.0], [0.0, 4.0]].map(|[x, y]| Vec3::new(x, y, 2.0));
        for start in 0..4 {
            let mut turned = arrow;
            turned.rotate_left(start);
            let triangles = triangulate(&turned);
            assert_eq!(triangles.len(), 2);
            assert!((area(&turned, &triangles) - 4.0).abs() < 1e-5);
        }
        let comb = [
            [0., 0.],
            [5., 0.],
            [5., 3.],
            [4., 3.],
            [4., 1.],
            [3., 1.],
            [3., 3.],
            [2., 3.],
            [2., 1.],
            [0., 1.],
        ];
        let comb = comb.map(|[x, y]: [f32; 2]| Vec3::new(x, y, 0.0));
        let triangles = triangulate(&comb);
        assert_eq!(triangles.len(), 8);
        assert!((area(&comb, &triangles) - 9.0).abs() < 1e-5);
    }

    #[test]
    fn degenerate_polygons_do_not_hang() {
        assert_eq!(triangulate(&[Vec3::ONE; 7]).len(), 5);
        let bow =
            [[0., 0.], [1., 1.], [1., 0.], [0., 1.], [0.5, -1.]].map(|[x, y]: [f32; 2]| Vec3::new(x, y, 0.0));
        assert_eq!(triangulate(&bow).len(), 3);
    }
}
