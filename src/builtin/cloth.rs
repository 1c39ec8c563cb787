//! Cloth in folds: open surfaces without thickness.

use std::f32::consts::TAU;

use glam::{Vec2, Vec3, vec2, vec3};

use super::noise::{chance, ramp};
use super::part::Part;
use super::paths::points;
use super::shapes::open_surface;

/// A curtain that hangs from a rod along x at y = 0, from x = 0, where it is tied back, to x = `width`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Curtain {
    pub width: f32,
    pub drop: f32,
    /// Seed of its folds.
    pub seed: u32,
    pub material: u32,
}

impl Curtain {
    /// Height of its tie, as a fraction of its height from above.
    const TIE: f32 = 0.58;

    /// Width at a fraction of its height.
    fn width_at(&self, v: f32) -> f32 {
        let gathered = 0.2 * self.width;
        if v < Self::TIE {
            // Falls straight at first, then is drawn to the side.
            let t = v / Self::TIE;
            gathered + (self.width - gathered) * (1.0 - t * t * (0.4 + 0.6 * t))
        } else {
            gathered + 0.26 * self.width * ramp(Self::TIE, 1.0, v).powf(0.7)
        }
    }

    /// The curtain as a grid of quads.
    pub fn part(&self, quads: [u32; 2]) -> Part {
        let pick = |i: u32| chance(self.seed, i, 201);
        let folds = 6.0 + 2.0 * pick(0);
        let point = |share: Vec2| {
            let width = self.width_at(share.y);
            // Gathered cloth has deeper folds.
            let depth = 0.035 + 0.05 * (1.0 - width / self.width);
            let drift = pick(1) + 0.3 * (share.y - 0.3) * (pick(2) - 0.5);
            let phase = TAU * (folds * share.x + drift);
            let sway = 0.4 * (0.5 * phase + TAU * pick(3)).sin();
            let hem = 0.05 * (1.0 - share.x) * ramp(0.9, 1.0, share.y) + 0.02 * phase.cos() * share.y;
            let along = share.x + 0.014 * (2.0 * phase).sin();
            vec3(width * along, -self.drop * share.y + hem, depth * (phase.sin() + sway))
        };
        open_surface(quads, vec2(1.6 * self.width, self.drop), self.material, point)
    }
}

/// A banner that hangs from y = 0 in front of z = 0, pointed at the bottom, with slight folds.
pub(super) fn banner(width: f32, drop: f32, seed: u32, material: u32) -> Part {
    let point = |share: Vec2| {
        let x = share.x - 0.5;
        let pointed = drop * (1.0 - 0.28 * (2.0 * x).abs() * share.y * share.y);
        let phase = TAU * (1.5 * share.x + chance(seed, 1, 211));
        let wave = 0.035 * share.y * phase.sin() + 0.03 * (3.0 * share.y + TAU * chance(seed, 2, 211)).sin();
        vec3(width * x * (1.0 - 0.05 * share.y), -pointed * share.y, wave)
    };
    open_surface([16, 24], vec2(width, drop), material, point)
}

/// The tie of a curtain: a closed ring around the y axis.
pub(super) fn tie(half: Vec2, material: u32) -> Part {
    use super::shapes::{Ends, Frame, sweep};
    let frame = |i: u32| {
        let (sin, cos) = (TAU * i as f32 / 20.0).sin_cos();
        let out = vec3(cos, 0.0, -sin);
        Frame { origin: vec3(half.x * cos, 0.0, -half.y * sin), right: out, up: Vec3::NEG_Y }
    };
    let way: Vec<Frame> = (0..20).map(frame).collect();
    let profile = [[-0.01, -0.05], [0.012, -0.05], [0.02, 0.0], [0.012, 0.05], [-0.01, 0.05]];
    sweep(&points(&profile), &way, Ends::Joined, material)
}
