//! Columns, pedestals, balusters and vases: surfaces of revolution.
//!
//! In: heights and radii in metres. Out: parts on y = 0 around the y axis.

use glam::{Vec2, Vec3, vec2, vec3};

use super::part::Part;
use super::paths::arc;
use super::shapes::{cuboid, lathe, lathe_shaped};

/// A column with base and capital.
#[derive(Clone, Copy, Debug)]
pub(super) struct Column {
    /// Height from the floor to the top of the abacus.
    pub height: f32,
    /// Radius of the shaft at its foot.
    pub radius: f32,
    /// Segments around the shaft.
    pub segments: u32,
    /// Materials of the shaft, and of base and capital.
    pub materials: [u32; 2],
}

/// A square plate of side 2 x `half` between two heights.
fn plate(half: f32, [from, to]: [f32; 2], material: u32) -> Part {
    cuboid(vec3(-half, from, -half), vec3(half, to, half), material)
}

impl Column {
    /// Height of the plate under the base, and of the plate on the capital.
    fn plates(&self) -> [f32; 2] {
        [0.45 * self.radius, 0.4 * self.radius]
    }

    /// Segments of a round moulding, fewer where there are few around.
    fn steps(&self) -> u32 {
        (self.segments / 8).clamp(2, 5)
    }

    fn capital_height(&self) -> f32 {
        1.9 * self.radius
    }

    /// Bottom of the capital's bell.
    pub fn capital_foot(&self) -> f32 {
        self.height - self.plates()[1] - self.capital_height()
    }

    /// The whole column, with a plain bell for a capital.
    pub fn part(&self) -> Part {
        let r = self.radius;
        let [_, on_top] = self.plates();
        let (foot, head) = (self.capital_foot(), self.height - on_top);
        let mut bell = vec![vec2(0.8 * r, foot - 0.02)];
        bell.extend(arc(vec2(0.9 * r, foot + 0.09 * r), 0.09 * r, [-90.0, 90.0], self.steps()));
        bell.extend([[0.9, 0.8], [1.08, 1.35], [1.36, 1.68]].map(|p| vec2(p[0] * r, foot + p[1] * r)));
        bell.push(vec2(1.38 * r, head - 0.06 * r));
        bell.push(vec2(1.2 * r, head + 0.01));
        self.shaft(self.segments, |_, _| 1.0)
            .and(lathe(&bell, self.segments, self.materials[1]))
            .and(self.abacus())
    }

    /// Plate, base and shaft up to the capital; `shape` scales the radius of the shaft, which has its own `segments`.
    pub fn shaft(&self, segments: u32, shape: impl Fn(f32, f32) -> f32) -> Part {
        let r = self.radius;
        let [under, _] = self.plates();
        let [stone, trim] = self.materials;
        let mut base = vec![vec2(1.3 * r, under - 0.02)];
        base.extend(arc(vec2(1.22 * r, under + 0.17 * r), 0.17 * r, [-80.0, 90.0], self.steps()));
        base.push(vec2(1.12 * r, under + 0.48 * r));
        base.extend(arc(vec2(1.1 * r, under + 0.72 * r), 0.11 * r, [-70.0, 90.0], self.steps()));
        base.push(vec2(1.0 * r, under + 0.86 * r));
        let (from, to) = (under + 0.8 * r, self.capital_foot() + 0.1 * r);
        // The shaft swells a little and tapers to the top.
        let profile: Vec<Vec2> = (0..=3)
            .map(|i| {
                let t = i as f32 / 3.0;
                vec2(r * (1.0 - 0.16 * t * t), from + (to - from) * t)
            })
            .collect();
        plate(1.42 * r, [-0.02, under], trim)
            .and(lathe(&base, self.segments, trim))
            .and(lathe_shaped(&profile, segments, stone, shape))
    }

    /// The plate on the capital.
    pub fn abacus(&self) -> Part {
        let [_, on_top] = self.plates();
        plate(1.5 * self.radius, [self.height - on_top, self.height], self.materials[1])
    }
}

/// A pedestal of side 2 x `half` with foot and head.
pub(super) fn pedestal(half: f32, height: f32, material: u32) -> Part {
    let wide = 1.12 * half;
    plate(wide, [-0.02, 0.12 * height], material)
        .and(plate(half, [0.1 * height, 0.91 * height], material))
        .and(plate(wide, [0.9 * height, height], material))
}

/// A baluster of `height` and largest `radius`.
pub(super) fn baluster(height: f32, radius: f32, segments: u32, material: u32) -> Part {
    let profile = [[0.85, -0.02], [0.7, 0.09], [1.0, 0.3], [0.42, 0.7], [0.75, 1.02]];
    lathe(&profile.map(|[r, y]| vec2(r * radius, y * height)), segments, material)
}

/// A bulging vase with an open mouth; `height` to the rim.
pub(super) fn vase(height: f32, [segments, steps]: [u32; 2], material: u32) -> Part {
    // Radius by height: foot, belly, neck, lip.
    let outside = |t: f32| {
        let belly = (std::f32::consts::PI * t.powf(0.8)).sin();
        let lip = ((t - 0.86) / 0.14).max(0.0);
        height * (0.15 + 0.25 * belly * (1.0 - 0.35 * t) + 0.07 * lip * lip)
    };
    let wall = 0.03 * height;
    let point = |i: u32| i as f32 / steps as f32;
    let mut profile: Vec<Vec2> = (0..=steps).map(|i| vec2(outside(point(i)), height * point(i))).collect();
    // Back down inside, to the floor of the vase.
    profile.extend((1..=steps).rev().map(|i| vec2(outside(point(i)) - wall, height * point(i) - 0.2 * wall)));
    profile.push(vec2(0.0, height * point(1)));
    lathe(&profile, segments, material)
}

/// Equidistant values over a range, including both ends.
pub(super) fn along(from: Vec3, to: Vec3, count: u32) -> impl Iterator<Item = Vec3> {
    (0..count).map(move |i| if count == 1 { from } else { from.lerp(to, i as f32 / (count - 1) as f32) })
}
