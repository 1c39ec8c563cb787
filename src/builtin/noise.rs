//! Deterministic random numbers and noise.

use glam::{Vec2, vec2};

/// A hash of three integers to [0, 1) (PCG output of a mixed state).
pub(super) fn chance(x: u32, y: u32, seed: u32) -> f32 {
    let mut state =
        x.wrapping_mul(0x9e37_79b1) ^ y.wrapping_mul(0x85eb_ca77) ^ seed.wrapping_mul(0xc2b2_ae3d);
    state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    ((word >> 22) ^ word) as f32 / 4_294_967_296.0 * 0.999_999
}

/// Periodic value noise in [0, 1] with the unit square as period and `cells` lattice cells a side.
pub(super) fn noise(point: Vec2, cells: u32, seed: u32) -> f32 {
    let scaled = (point - point.floor()) * cells as f32;
    let cell = scaled.floor();
    let t = scaled - cell;
    let t = t * t * (3.0 - 2.0 * t);
    let (x, y) = (cell.x as u32 % cells, cell.y as u32 % cells);
    let (right, below) = ((x + 1) % cells, (y + 1) % cells);
    let top = chance(x, y, seed) * (1.0 - t.x) + chance(right, y, seed) * t.x;
    let bottom = chance(x, below, seed) * (1.0 - t.x) + chance(right, below, seed) * t.x;
    top * (1.0 - t.y) + bottom * t.y
}

/// Fractal noise in [0, 1]: `octaves` with doubling frequency and halving amplitude.
pub(super) fn fractal(point: Vec2, cells: u32, octaves: u32, seed: u32) -> f32 {
    let (mut sum, mut weight, mut total) = (0.0, 1.0, 0.0);
    for octave in 0..octaves {
        sum += weight * noise(point, cells << octave, seed + octave);
        total += weight;
        weight *= 0.5;
    }
    sum / total
}

/// Domain warping: `point` displaced by noise of amplitude `strength`.
pub(super) fn warped(point: Vec2, cells: u32, strength: f32, seed: u32) -> Vec2 {
    let push = vec2(fractal(point, cells, 3, seed), fractal(point, cells, 3, seed + 57));
    point + (push - 0.5) * strength
}

/// Smoothstep from 0 at `low` to 1 at `high`.
pub(super) fn ramp(low: f32, high: f32, value: f32) -> f32 {
    let t = ((value - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}
