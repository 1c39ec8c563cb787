//! Outlines of what moves, as lights see it. What lies behind the inside of an object's shadow, or beside it, is lit as it was
//! in the frame before; only where an outline has passed may that have changed.
//!
//! In: meshes, and the matrices that lead from where they stood and stand to a shadow tile. Out: the cells of the tile in which
//! a shadow may have come or gone.
//!
//! Outlines are the edges between triangles that face the light and triangles that face away (Crow 1977); what they wind around
//! is inside.

use std::collections::HashMap;

use glam::{Mat4, Vec2, Vec3};

use super::closed::places;
use crate::scene::Mesh;

/// Cells across a shadow tile.
pub const CELLS: usize = 128;

/// Most triangles of a mesh that has an outline: as a light sees it, it is found anew in every frame.
const MAX_TRIANGLES: usize = 1 << 15;

/// What is marked around outlines, in cells: rasterisers round.
const SLOP: f32 = 0.125;

/// What the slope of a triangle is multiplied by in shadow maps. Twin: `SLOPE_BIAS` in direct_shadows.rs, with a margin.
const SLOPE_BIAS: f32 = 1.6;

/// The triangles of a mesh and which edges they share.
pub struct Edges {
    /// Where vertices are, each place once.
    places: Vec<Vec3>,
    /// By triangle, its corners among these.
    corners: Vec<[u32; 3]>,
    /// By triangle, twice the number of each edge, and one more where it runs along it backwards.
    sides: Vec<[u32; 3]>,
    /// By edge, its ends among the places.
    ends: Vec<[u32; 2]>,
}

impl Edges {
    /// The edges of a mesh; none if it has too many triangles, or is not finite.
    pub fn of(mesh: &Mesh) -> Option<Self> {
        let finite = mesh.positions.iter().all(|position| position.is_finite());
        if mesh.triangles.len() > MAX_TRIANGLES || !finite {
            return None;
        }
        let (places, of_vertices) = places(&mesh.positions);
        let mut edges = Self { places, corners: Vec::new(), sides: Vec::new(), ends: Vec::new() };
        let mut edge_of = HashMap::new();
        for triangle in &mesh.triangles {
            let corners = triangle.map(|vertex| of_vertices[vertex as usize]);
            let [a, b, c] = corners;
            edges.sides.push([[a, b], [b, c], [c, a]].map(|[from, to]| {
                let edge = *edge_of.entry([from.min(to), from.max(to)]).or_insert_with_key(|ends| {
                    edges.ends.push(*ends);
                    u32::try_from(edges.ends.len() - 1).expect("a few edges a triangle")
                });
                2 * edge + u32::from(from > to)
            }));
            edges.corners.push(corners);
        }
        Some(edges)
    }

    /// How many triangles there are.
    pub fn triangle_count(&self) -> usize {
        self.corners.len()
    }
}

/// Where in a shadow tile shadows may have come or gone.
pub struct ChangedCells {
    /// Depth of what moves that is nearest to the light, where it was and is.
    pub nearest: f32,
    /// What lies farther away than this is in the shadow of all that moves before it.
    pub farthest: f32,
    /// The cells that have changed.
    changed: Cells,
}

impl ChangedCells {
    /// What instances change that stood and stand where the pairs of matrices lead: from object space to the clip space of a
    /// tile, of `texels` across. None where that is not known, since one of them reaches beyond what the tile's matrix sees in
    /// depth.
    pub fn of<'a>(moved: impl IntoIterator<Item = (&'a Edges, [Mat4; 2])>, texels: u32) -> Option<Self> {
        let mut cells =
            Self { nearest: f32::NEG_INFINITY, farthest: f32::INFINITY, changed: Cells::default() };
        for (edges, matrices) in moved {
            let [from, to] = matrices.map(|matrix| Coverage::of(edges, &matrix, texels));
            let (from, to) = (from?, to?);
            for row in 0..CELLS {
                let partly = from.partly.rows[row] | to.partly.rows[row];
                cells.changed.rows[row] |= partly | (from.wholly.rows[row] ^ to.wholly.rows[row]);
            }
            for coverage in [from, to] {
                cells.nearest = cells.nearest.max(coverage.nearest);
                cells.farthest = cells.farthest.min(coverage.farthest);
            }
        }
        Some(cells)
    }

    /// The cells from which one that has changed is at most `reach` cells away in both directions: a bit each, row by row.
    pub fn within_reach(&self, reach: usize) -> Vec<[u32; 4]> {
        let reach = reach.min(CELLS - 1);
        let wide =
            self.changed.rows.map(|row| (1..=reach).fold(row, |wide, by| wide | row << by | row >> by));
        let rows = |row: usize| row.saturating_sub(reach)..(row + reach + 1).min(CELLS);
        (0..CELLS)
            .map(|row| wide[rows(row)].iter().fold(0, |all, row| all | row))
            .map(|bits| [0, 32, 64, 96].map(|first| (bits >> first) as u32))
            .collect()
    }
}

/// Some of a tile's cells.
#[derive(Clone)]
struct Cells {
    /// Bit by bit.
    rows: [u128; CELLS],
}

impl Default for Cells {
    fn default() -> Self {
        Self { rows: [0; CELLS] }
    }
}

/// What an object covers of a tile.
struct Coverage {
    nearest: f32,
    farthest: f32,
    /// The cells of which it covers all, nearer than `farthest`.
    wholly: Cells,
    /// Those of which it may cover a part.
    partly: Cells,
}

impl Coverage {
    fn of(edges: &Edges, matrix: &Mat4, texels: u32) -> Option<Self> {
        let places = project(&edges.places, matrix)?;
        let nearest = places.iter().map(|place| place.z).fold(f32::NEG_INFINITY, f32::max);
        let deepest = places.iter().map(|place| place.z).fold(f32::INFINITY, f32::min);
        // Depth is reversed. A margin, so that triangles may be moved away by their slopes.
        let farthest = 0.95 * deepest - 0.2 * deepest.min(nearest - deepest);
        let of_texel = SLOPE_BIAS * CELLS as f32 / texels as f32;
        let mut outline = Outline::default();
        // Of triangles that show their front and of those that show their back: how often each edge bounds them, in its direction.
        let mut bounds = vec![[0i32; 2]; edges.ends.len()];
        for (corners, sides) in edges.corners.iter().zip(&edges.sides) {
            let [a, b, c] = corners.map(|place| places[place as usize]);
            let (u, v) = (b - a, c - a);
            let area = u.x * v.y - u.y * v.x;
            if area == 0.0 {
                continue;
            }
            for side in sides {
                let along = if side & 1 == 0 { 1 } else { -1 };
                bounds[(side / 2) as usize][usize::from(area < 0.0)] += along;
            }
            let slope = Vec2::new(u.z * v.y - v.z * u.y, v.z * u.x - u.z * v.x).length();
            if (a.z.min(b.z).min(c.z) - farthest) * area.abs() <= of_texel * slope {
                let (low, high) = (a.min(b).min(c).truncate(), a.max(b).max(c).truncate());
                outline.mark_rectangle(low, high);
            }
        }
        for (ends, bounds) in edges.ends.iter().zip(&bounds) {
            if *bounds != [0, 0] {
                let ends = ends.map(|place| places[place as usize].truncate());
                outline.mark_line(ends);
                outline.wind(ends, *bounds);
            }
        }
        Some(Self { nearest, farthest, wholly: outline.inside(), partly: outline.marked })
    }
}

/// Places in a tile: x and y in cells, z its depth. None if one of them is beyond what it sees in depth: that covers nothing.
fn project(places: &[Vec3], matrix: &Mat4) -> Option<Vec<Vec3>> {
    let of_place = |place: &Vec3| {
        let clip = *matrix * place.extend(1.0);
        let p = clip.truncate() / clip.w;
        let seen = clip.w > 0.0 && (0.0..=1.0).contains(&p.z) && p.is_finite();
        seen.then(|| ((p.truncate() * 0.5 + 0.5) * CELLS as f32).extend(p.z))
    };
    places.iter().map(of_place).collect()
}

/// The outline of an object while it is drawn into a tile. Points are in cells, from the tile's corner.
struct Outline {
    marked: Cells,
    /// Row by row, how the winding numbers of front and back sides around a cell's middle differ from those of the cell to its
    /// left.
    turns: Vec<[i32; 2]>,
}

impl Default for Outline {
    fn default() -> Self {
        Self { marked: Cells::default(), turns: vec![[0; 2]; CELLS * CELLS] }
    }
}

impl Outline {
    /// Marks the cells of a row between two points.
    fn mark(&mut self, row: usize, low: f32, high: f32) {
        let column = |x: f32| x.floor().clamp(0.0, CELLS as f32) as u32;
        let (first, end) = (column(low - SLOP), column(high + SLOP + 1.0));
        let before = |column: u32| 1u128.checked_shl(column).map_or(u128::MAX, |bit| bit - 1);
        self.marked.rows[row] |= before(end) & !before(first);
    }

    /// Marks the cells of a rectangle.
    fn mark_rectangle(&mut self, low: Vec2, high: Vec2) {
        for row in rows_between(low.y, high.y) {
            self.mark(row, low.x, high.x);
        }
    }

    /// Marks the cells that a line touches.
    fn mark_line(&mut self, [a, b]: [Vec2; 2]) {
        let (top, bottom) = if a.y <= b.y { (a, b) } else { (b, a) };
        let height = bottom.y - top.y;
        if height <= SLOP {
            return self.mark_rectangle(a.min(b), a.max(b));
        }
        let x_at = |y: f32| top.x + ((y - top.y) / height).clamp(0.0, 1.0) * (bottom.x - top.x);
        for row in rows_between(top.y, bottom.y) {
            let (enters, leaves) = (x_at(row as f32 - SLOP), x_at(row as f32 + 1.0 + SLOP));
            self.mark(row, enters.min(leaves), enters.max(leaves));
        }
    }

    /// Adds a line to what winds around the cells' middles.
    fn wind(&mut self, [a, b]: [Vec2; 2], times: [i32; 2]) {
        let (top, bottom, down) = if a.y <= b.y { (a, b, 1) } else { (b, a, -1) };
        let first_behind = |x: f32| (x - 0.5).ceil().clamp(0.0, CELLS as f32) as usize;
        for row in first_behind(top.y)..first_behind(bottom.y) {
            let part = (row as f32 + 0.5 - top.y) / (bottom.y - top.y);
            let column = first_behind(top.x + part * (bottom.x - top.x));
            if column < CELLS {
                let turns = &mut self.turns[row * CELLS + column];
                *turns = [0, 1].map(|side| turns[side] + down * times[side]);
            }
        }
    }

    /// The cells that lie inside as a whole.
    fn inside(&self) -> Cells {
        let mut inside = Cells::default();
        for ((row, turns), marked) in
            inside.rows.iter_mut().zip(self.turns.chunks(CELLS)).zip(&self.marked.rows)
        {
            let mut winding = [0; 2];
            for (column, turns) in turns.iter().enumerate() {
                winding = [0, 1].map(|side| winding[side] + turns[side]);
                *row |= u128::from(winding != [0, 0]) << column;
            }
            *row &= !marked;
        }
        inside
    }
}

/// The rows of cells between two points.
fn rows_between(low: f32, high: f32) -> std::ops::Range<usize> {
    let row = |y: f32| y.floor().clamp(0.0, CELLS as f32) as usize;
    row(low - SLOP)..row(high + SLOP + 1.0)
}

#[cfg(test)]
mod tests {
    use glam::Affine3A;

    use super::*;
    use crate::scene::Camera;

    const TEXELS: u32 = 256;

    /// Depth of what covers the middle of a texel, nearest, moved away by its slope; by going through all triangles.
    fn depth_at(mesh: &Mesh, matrix: &Mat4, texel: Vec2) -> f32 {
        let mut nearest = 0.0f32;
        for triangle in &mesh.triangles {
            let [a, b, c] = triangle.map(|vertex| {
                let clip = *matrix * mesh.positions[vertex as usize].extend(1.0);
                let p = clip.truncate() / clip.w;
                ((p.truncate() * 0.5 + 0.5) * TEXELS as f32).extend(p.z)
            });
            let cross = |p: Vec2, q: Vec2| p.x * q.y - p.y * q.x;
            let (u, v, p) = ((b - a).truncate(), (c - a).truncate(), texel - a.truncate());
            let (s, t) = (cross(p, v) / cross(u, v), cross(u, p) / cross(u, v));
            if s >= 0.0 && t >= 0.0 && s + t <= 1.0 {
                let (rise, run) = (b.z - a.z, c.z - a.z);
                let slope = (v * rise - u * run).length() / cross(u, v).abs();
                nearest = nearest.max(a.z + s * rise + t * run - 1.5 * slope);
            }
        }
        nearest
    }

    /// Two triangles: a square of that half width, facing along z.
    fn square(half: f32) -> Mesh {
        let mut mesh = Mesh::sphere("square", 1.0, 0, 0);
        mesh.positions = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
            .map(|(x, y)| Vec3::new(half * x, half * y, 0.0))
            .to_vec();
        mesh.triangles = vec![[0, 1, 2], [0, 2, 3]];
        mesh
    }

    fn light() -> Mat4 {
        let camera = Camera { near: 100.0, far: 0.1, ..Camera::looking(Vec3::ZERO, Vec3::NEG_Z) };
        camera.projection_matrix(1.0) * camera.view_matrix()
    }

    /// Checks every texel of a tile: where cells stand still, what is there before is there now. Out: share of changed cells.
    fn check(mesh: &Mesh, from: Affine3A, to: Affine3A) -> f32 {
        let edges = Edges::of(mesh).expect("a small mesh");
        let matrices = [from, to].map(|at| light() * Mat4::from(at));
        let cells = ChangedCells::of([(&edges, matrices)], TEXELS).expect("before the light");
        let texels_of_cell = TEXELS as usize / CELLS;
        for cell in 0..CELLS * CELLS {
            let (row, column) = (cell / CELLS, cell % CELLS);
            if cells.changed.rows[row] >> column & 1 == 1 {
                continue;
            }
            let texel = Vec2::new(column as f32, row as f32) * texels_of_cell as f32 + 0.5;
            let [before, now] = matrices.map(|matrix| depth_at(mesh, &matrix, texel));
            assert_eq!(before > 0.0, now > 0.0, "at texel {texel}");
            for depth in [before, now].into_iter().filter(|depth| *depth > 0.0) {
                assert!(depth > cells.farthest && depth <= cells.nearest, "{depth} at texel {texel}");
            }
        }
        let changed: u32 = cells.changed.rows.iter().map(|row| row.count_ones()).sum();
        changed as f32 / (CELLS * CELLS) as f32
    }

    #[test]
    fn only_outlines_change() {
        let at = |x: f32, y: f32, z: f32| Affine3A::from_translation(Vec3::new(x, y, z));
        let sphere = Mesh::sphere("sphere", 0.5, 3, 0);
        let still = check(&sphere, at(0.1, 0.0, -2.0), at(0.1, 0.0, -2.0));
        assert!(still > 0.0 && still < 0.1, "{still} of the cells around a sphere");
        let moved = check(&sphere, at(0.1, 0.0, -2.0), at(0.06, 0.02, -2.05));
        assert!(moved > still && moved < 0.15, "{moved} of the cells where a sphere moves");
        // What lies beyond the tile's sides winds around it as well.
        check(&sphere, at(0.8, 0.7, -1.5), at(-0.8, -0.9, -1.5));
    }

    #[test]
    fn meshes_need_not_be_closed_nor_face_the_light() {
        let turned = |angle: f32| Affine3A::from_rotation_y(angle);
        let at = |angle: f32| Affine3A::from_translation(Vec3::NEG_Z * 2.0) * turned(angle);
        let half = square(0.6);
        check(&half, at(0.3), at(0.5));
        check(&half, at(0.3), at(0.3 + std::f32::consts::PI));
        // Nearly along the rays its slope is so great that nothing is known of the depth behind it.
        let edge_on = check(&half, at(1.55), at(1.57));
        assert!(edge_on > 0.0 && edge_on < 0.1, "{edge_on}");
    }

    #[test]
    fn dented_meshes_with_holes_are_seen_as_they_are() {
        // Deterministic, between 0 and 1.
        let mut state = 1u32;
        let mut random = || {
            state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
            (state >> 8) as f32 / (1 << 24) as f32
        };
        for turn in 0..16 {
            let mut mesh = Mesh::sphere("dented", 0.6, 2, 0);
            for position in &mut mesh.positions {
                *position *= 0.4 + 0.6 * random();
            }
            if turn % 2 == 0 {
                mesh.triangles.retain(|_| random() > 0.1);
            }
            let from = Affine3A::from_rotation_x(6.0 * random()) * Affine3A::from_rotation_y(6.0 * random());
            let from = Affine3A::from_translation(Vec3::new(random() - 0.5, random() - 0.5, -1.5)) * from;
            let to = from * Affine3A::from_rotation_z(0.05 * random());
            let changed = check(&mesh, from, to);
            assert!(changed > 0.0 && changed < 0.7, "{changed} of the cells in turn {turn}");
        }
    }

    #[test]
    fn reach_is_a_square() {
        let mut cells = ChangedCells { nearest: 1.0, farthest: 0.0, changed: Cells::default() };
        cells.changed.rows[1] = 1 << 40;
        let rows = cells.within_reach(2);
        assert_eq!(rows.len(), CELLS);
        for (row, bits) in rows.into_iter().enumerate() {
            assert_eq!(bits, if row < 4 { [0, 0b11111 << 6, 0, 0] } else { [0; 4] }, "row {row}");
        }
        assert_eq!(cells.within_reach(500), [[u32::MAX; 4]; CELLS]);
    }

    #[test]
    fn what_reaches_behind_the_light_is_not_known() {
        let edges = Edges::of(&Mesh::sphere("sphere", 0.5, 2, 0)).expect("a small mesh");
        let matrix = light() * Mat4::from_translation(Vec3::NEG_Z * 0.2);
        assert!(ChangedCells::of([(&edges, [matrix; 2])], TEXELS).is_none());
    }
}
