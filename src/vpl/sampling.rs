//! Low-discrepancy points and their mappings to directions, discs and triangles.
//!
//! In: a place in the sequence, or a point of the unit square. Out: points distributed as named, each
//! mapping continuous inside the square, so that neighbouring points stay neighbours. The sequence is
//! an Owen-scrambled Sobol sequence (Burley 2020, "Practical Hash-based Owen Scrambling").

use std::f32::consts::{FRAC_PI_2, FRAC_PI_4, TAU};

use glam::{Vec2, Vec3};

/// Largest float below 1.
const BELOW_ONE: f32 = 1.0 - f32::EPSILON / 2.0;

/// Mixes two words into one (the finaliser of MurmurHash3).
pub(super) fn hash(a: u32, b: u32) -> u32 {
    let mut h = a.wrapping_mul(0x9e37_79b9) ^ b.rotate_left(16).wrapping_add(0x7f4a_7c15);
    h = (h ^ (h >> 16)).wrapping_mul(0x85eb_ca6b);
    h = (h ^ (h >> 13)).wrapping_mul(0xc2b2_ae35);
    h ^ (h >> 16)
}

/// Point `index` (below 65,536) of the sequence `seed`, in its `pair`-th two dimensions.
pub(super) fn sequence_point(index: u32, pair: u32, seed: u32) -> Vec2 {
    let dimension = |offset| sobol_burley::sample(index, 2 * pair + offset, seed);
    Vec2::new(dimension(0), dimension(1))
}

/// Uniform on the unit sphere.
pub(super) fn sphere(u: Vec2) -> Vec3 {
    let z = 1.0 - 2.0 * u.x;
    let radius = (4.0 * u.x * (1.0 - u.x)).max(0.0).sqrt();
    let (sin, cos) = (TAU * u.y).sin_cos();
    Vec3::new(radius * cos, radius * sin, z)
}

/// Uniform on the unit disc (Shirley and Chiu 1997, the concentric map).
pub(super) fn disc(u: Vec2) -> Vec2 {
    let p = 2.0 * u - Vec2::ONE;
    if p == Vec2::ZERO {
        return Vec2::ZERO;
    }
    let (radius, angle) = if p.x.abs() > p.y.abs() {
        (p.x, FRAC_PI_4 * (p.y / p.x))
    } else {
        (p.y, FRAC_PI_2 - FRAC_PI_4 * (p.x / p.y))
    };
    radius * Vec2::from_angle(angle)
}

/// Cosine-weighted about +z: the disc lifted to the hemisphere (Malley's method).
pub(super) fn cosine_hemisphere(u: Vec2) -> Vec3 {
    let p = disc(u);
    p.extend((1.0 - p.length_squared()).max(0.0).sqrt())
}

/// Barycentric weights of the second and third vertex, uniform over a triangle (Heitz 2019, "A
/// Low-Distortion Map Between Triangle and Square").
pub(super) fn triangle(u: Vec2) -> Vec2 {
    if u.y > u.x {
        let x = 0.5 * u.x;
        Vec2::new(x, u.y - x)
    } else {
        let y = 0.5 * u.y;
        Vec2::new(u.x - y, y)
    }
}

/// Picks a bin of a discrete distribution whose running sums are `cdf` (ending in 1), and stretches
/// what is left of `u` over [0, 1).
pub(super) fn discrete(cdf: &[f32], u: f32) -> (usize, f32) {
    let bin = cdf.partition_point(|&sum| sum <= u).min(cdf.len() - 1);
    let low = if bin == 0 { 0.0 } else { cdf[bin - 1] };
    let rest = (u - low) / (cdf[bin] - low);
    (bin, rest.clamp(0.0, BELOW_ONE))
}

/// The emission of a spot light over the cosine to its axis: full inside the inner cone, smoothstep in
/// the cosine out to the outer one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SpotCone {
    /// 1 - cos of the inner angle; narrow cones need it exact.
    inner: f64,
    /// 1 - cos of the outer angle.
    outer: f64,
}

impl SpotCone {
    /// Half angles in radians.
    pub(super) fn new(inner_angle: f32, outer_angle: f32) -> Self {
        let one_minus_cos = |angle: f32| 2.0 * (0.5 * f64::from(angle)).sin().powi(2);
        Self {
            inner: one_minus_cos(inner_angle),
            outer: one_minus_cos(outer_angle),
        }
    }

    /// A direction about +z in proportion to the emission.
    pub(super) fn sample(&self, u: Vec2) -> Vec3 {
        // Split the distribution of 1 - cos into its flat part and its falloff, which weighs half.
        let falloff = self.outer - self.inner;
        let mass = f64::from(u.x) * (self.inner + 0.5 * falloff);
        let one_minus_cos = if mass <= self.inner || falloff <= 0.0 {
            mass.min(self.inner)
        } else {
            self.inner + falloff * inverse_falloff((mass - self.inner) / falloff)
        };
        let sin_theta = (one_minus_cos * (2.0 - one_minus_cos)).max(0.0).sqrt() as f32;
        let (sin, cos) = (TAU * u.y).sin_cos();
        Vec3::new(
            sin_theta * cos,
            sin_theta * sin,
            (1.0 - one_minus_cos) as f32,
        )
    }
}

/// Solves F(x) = `mass` for x in [0, 1], where F integrates the falloff 1 - smoothstep from the inner
/// edge: F(x) = x - x^3 + x^4 / 2, and F(1) = 1/2.
fn inverse_falloff(mass: f64) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    let mut x = mass.min(1.0);
    // Newton's method, held inside the shrinking bracket because the slope vanishes at the rim.
    for _ in 0..32 {
        let error = x - x.powi(3) + 0.5 * x.powi(4) - mass;
        if error > 0.0 {
            high = x;
        } else {
            low = x;
        }
        let slope = 1.0 - 3.0 * x * x + 2.0 * x.powi(3);
        let step = x - error / slope;
        let next = if step > low && step < high {
            step
        } else {
            0.5 * (low + high)
        };
        if (next - x).abs() < 1e-12 {
            return next;
        }
        x = next;
    }
    x
}

/// An orthonormal frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Frame {
    tangent: Vec3,
    bitangent: Vec3,
    /// Its z axis.
    pub(super) normal: Vec3,
}

impl Frame {
    /// The fixed reference frame turned by the smallest rotation that takes its z axis to `normal` (unit).
    /// Continuous in `normal` but for one direction, as any such frame must have one (the hairy ball
    /// theorem); it is put well away from all axes.
    pub(super) fn around(normal: Vec3) -> Self {
        const REFERENCE: Vec3 = Vec3::new(-0.48, -0.6, -0.64);
        const TANGENT: Vec3 = Vec3::new(-0.8, 0.0, 0.6);
        let denominator = 1.0 + REFERENCE.dot(normal);
        let turned = if denominator > 1e-4 {
            TANGENT - (REFERENCE + normal) * (TANGENT.dot(normal) / denominator)
        } else {
            TANGENT
        };
        // Near the singular direction the division is inexact.
        let tangent = (turned - normal * turned.dot(normal)).normalize();
        Self {
            tangent,
            bitangent: normal.cross(tangent),
            normal,
        }
    }

    /// From this frame to the world.
    pub(super) fn to_world(self, v: Vec3) -> Vec3 {
        self.tangent * v.x + self.bitangent * v.y + self.normal * v.z
    }
}
