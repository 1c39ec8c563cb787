//! Triangulates polygons by ear clipping.
//!
//! In: the corners of a roughly planar polygon, convex or concave. Out: n - 2 triangles of corner indices with the
//! polygon's winding.

use glam::{Vec2, Vec3};

/// Triangulates a polygon of at least three corners.
pub(crate) fn triangulate(corners: &[Vec3]) -> Vec<[usize; 3]> {
    let n = corners.len();
    let fan = || (1..n - 1).map(|i| [0, i, i + 1]).collect();
    if n == 3 {
        return fan();
    }
    let Some(flat) = project(corners) else {
        return fan();
    };
    let ring = Ring::new(flat);
    if ring.reflex.iter().all(|reflex| !reflex) {
        return fan();
    }
    ring.clip_ears()
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

/// A polygon of which ears are being clipped: what is left is a doubly linked list.
struct Ring {
    flat: Vec<Vec2>,
    last: Vec<usize>,
    next: Vec<usize>,
    /// Corners that turn inwards: only these can lie in an ear.
    reflex: Vec<bool>,
    /// The reflex corners by cells of a grid, so that large polygons take little more than linear time.
    cells: Vec<Vec<usize>>,
    side: usize,
    origin: Vec2,
    scale: Vec2,
}

impl Ring {
    fn new(flat: Vec<Vec2>) -> Self {
        let n = flat.len();
        let (low, high) = flat.iter().fold((flat[0], flat[0]), |(low, high), p| (low.min(*p), high.max(*p)));
        let side = (n as f32).sqrt() as usize;
        let mut ring = Self {
            last: (0..n).map(|i| (i + n - 1) % n).collect(),
            next: (0..n).map(|i| (i + 1) % n).collect(),
            reflex: vec![false; n],
            cells: vec![Vec::new(); side * side],
            side,
            origin: low,
            scale: side as f32 / (high - low).max(Vec2::splat(f32::MIN_POSITIVE)),
            flat,
        };
        for i in 0..n {
            ring.reflex[i] = ring.signed_area(i) < 0.0;
            if ring.reflex[i] {
                let [x, y] = ring.cell(ring.flat[i]);
                ring.cells[y * side + x].push(i);
            }
        }
        ring
    }

    fn cell(&self, point: Vec2) -> [usize; 2] {
        ((point - self.origin) * self.scale).to_array().map(|place| (place as usize).min(self.side - 1))
    }

    fn ear(&self, i: usize) -> [usize; 3] {
        [self.last[i], i, self.next[i]]
    }

    /// Twice the signed area of corner `i` and its two neighbours; negative at a reflex corner.
    fn signed_area(&self, i: usize) -> f32 {
        let [a, b, c] = self.ear(i).map(|corner| self.flat[corner]);
        (b - a).perp_dot(c - b)
    }

    fn is_ear(&self, i: usize) -> bool {
        if self.signed_area(i) <= 0.0 {
            return false;
        }
        let ear = self.ear(i).map(|corner| self.flat[corner]);
        let [low, high] =
            [ear[0].min(ear[1]).min(ear[2]), ear[0].max(ear[1]).max(ear[2])].map(|point| self.cell(point));
        let blocks = |&corner: &usize| {
            let point = self.flat[corner];
            // Corners at the same place are where a hole is joined to the outline.
            self.reflex[corner] && !ear.contains(&point) && contains(ear, point)
        };
        (low[1]..=high[1])
            .all(|y| (low[0]..=high[0]).all(|x| !self.cells[y * self.side + x].iter().any(blocks)))
    }

    fn clip_ears(mut self) -> Vec<[usize; 3]> {
        let n = self.flat.len();
        let mut triangles = Vec::with_capacity(n - 2);
        let (mut i, mut refused) = (0, 0);
        while triangles.len() < n - 2 {
            // A self-intersecting ring may have no ear: clip any corner, so that the loop terminates.
            let rest = n - triangles.len();
            if rest > 3 && refused < rest && !self.is_ear(i) {
                refused += 1;
                i = self.next[i];
                continue;
            }
            let [last, _, next] = self.ear(i);
            triangles.push([last, i, next]);
            (self.next[last], self.last[next], self.reflex[i]) = (next, last, false);
            for corner in [last, next] {
                self.reflex[corner] &= self.signed_area(corner) < 0.0;
            }
            // The one after the next, for fewer slivers.
            (i, refused) = (self.next[next], 0);
        }
        triangles
    }
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
    fn large_polygons_keep_their_shape() {
        let n = 20_000;
        let corner = |i: usize| {
            let (radius, angle) =
                (if i.is_multiple_of(2) { 1.0 } else { 0.6 }, std::f32::consts::TAU * i as f32 / n as f32);
            Vec3::new(radius * angle.cos(), radius * angle.sin(), 0.0)
        };
        let star: Vec<Vec3> = (0..n).map(corner).collect();
        let triangles = triangulate(&star);
        assert_eq!(triangles.len(), n - 2);
        let expected = 0.5 * 0.6 * (std::f64::consts::TAU / n as f64).sin() * n as f64;
        assert!((f64::from(area(&star, &triangles)) / expected - 1.0).abs() < 1e-3);
    }

    #[test]
    fn degenerate_polygons_do_not_hang() {
        assert_eq!(triangulate(&[Vec3::ONE; 7]).len(), 5);
        let bow =
            [[0., 0.], [1., 1.], [1., 0.], [0., 1.], [0.5, -1.]].map(|[x, y]: [f32; 2]| Vec3::new(x, y, 0.0));
        assert_eq!(triangulate(&bow).len(), 3);
    }
}
