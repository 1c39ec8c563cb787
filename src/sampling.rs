//! Low-discrepancy points and their mappings to directions, discs and triangles.
//!
//! In: an index into the sequence, or a point of the unit square. Out: points distributed as named, each
//! mapping continuous inside the square, so that neighbouring points stay neighbours. The sequence is
//! an Owen-scrambled Sobol sequence (Burley 2020, "Practical Hash-based Owen Scrambling").

use std::f32::consts::{FRAC_PI_2, FRAC_PI_4, TAU};

use glam::{Vec2, Vec3};
use serde::{Deserialize, Serialize};

/// Largest float below 1.
const BELOW_ONE: f32 = 1.0 - f32::EPSILON / 2.0;

/// Mixes two words into one (the finaliser of MurmurHash3).
pub(crate) fn hash(a: u32, b: u32) -> u32 {
    let mut h = a.wrapping_mul(0x9e37_79b9) ^ b.rotate_left(16).wrapping_add(0x7f4a_7c15);
    h = (h ^ (h >> 16)).wrapping_mul(0x85eb_ca6b);
    h = (h ^ (h >> 13)).wrapping_mul(0xc2b2_ae35);
    h ^ (h >> 16)
}

/// Point `index` (below 65,536) of the sequence `seed`, in its `pair`-th two dimensions.
pub(crate) fn sequence_point(index: u32, pair: u32, seed: u32) -> Vec2 {
    let dimension = |offset| sobol_burley::sample(index, 2 * pair + offset, seed);
    Vec2::new(dimension(0), dimension(1))
}

/// Like [`sequence_point`], but independent and uniform: plain Monte Carlo.
pub(crate) fn random_point(index: u32, pair: u32, seed: u32) -> Vec2 {
    let number = |offset| hash(hash(seed, 2 * pair + offset), index) >> 8;
    Vec2::new(number(0) as f32, number(1) as f32) / (1u32 << 24) as f32
}

/// Uniform on the unit sphere.
pub(crate) fn sphere(u: Vec2) -> Vec3 {
    let z = 1.0 - 2.0 * u.x;
    let radius = (4.0 * u.x * (1.0 - u.x)).max(0.0).sqrt();
    let (sin, cos) = (TAU * u.y).sin_cos();
    Vec3::new(radius * cos, radius * sin, z)
}

/// Uniform on the unit disc (Shirley and Chiu 1997, the concentric map).
pub(crate) fn disc(u: Vec2) -> Vec2 {
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
pub(crate) fn cosine_hemisphere(u: Vec2) -> Vec3 {
    let p = disc(u);
    p.extend((1.0 - p.length_squared()).max(0.0).sqrt())
}

/// Barycentric weights of the second and third vertex, uniform over a triangle (Heitz 2019, "A
/// Low-Distortion Map Between Triangle and Square").
pub(crate) fn triangle(u: Vec2) -> Vec2 {
    if u.y > u.x {
        let x = 0.5 * u.x;
        Vec2::new(x, u.y - x)
    } else {
        let y = 0.5 * u.y;
        Vec2::new(u.x - y, y)
    }
}

/// `count` points well spread over a triangle, as barycentric weights.
pub(crate) fn triangle_points(count: u32) -> impl Iterator<Item = Vec2> {
    (0..count).map(|index| triangle(sequence_point(index, 0, 0)))
}

/// In [0, 1), in proportion to a function that goes linearly from the first value at 0 to the second at 1; neither is
/// negative. Without any light, uniform.
pub(crate) fn linear([first, last]: [f32; 2], u: f32) -> f32 {
    let most = first.max(last);
    if most <= 0.0 {
        return u;
    }
    let [first, last] = [first / most, last / most];
    let root = (first * first + (last * last - first * first) * u).max(0.0).sqrt();
    // Both are 0 at the start of a function that begins with 0.
    if first + root > 0.0 { (u * (first + last) / (first + root)).min(BELOW_ONE) } else { 0.0 }
}

/// Samples a bin of the discrete distribution with this `cdf` (ending in 1) by inversion, and remaps `u` within
/// the bin to [0, 1) for reuse.
pub(crate) fn discrete(cdf: &[f32], u: f32) -> (usize, f32) {
    let bin = cdf.partition_point(|&sum| sum <= u).min(cdf.len() - 1);
    let low = if bin == 0 { 0.0 } else { cdf[bin - 1] };
    let rest = (u - low) / (cdf[bin] - low);
    (bin, rest.clamp(0.0, BELOW_ONE))
}

/// How the intensity of a spot light falls between its cones, by t: 0 at the outer and 1 at the inner one, linear in the
/// cosine of the angle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SpotFalloff {
    /// Smoothstep, t^2 (3 - 2 t): that of scene files.
    #[default]
    Smooth,
    /// t^2: that of glTF (KHR_lights_punctual).
    Square,
}

impl SpotFalloff {
    /// Mean over t.
    pub fn mean(self) -> f64 {
        if self == Self::Smooth { 0.5 } else { 1.0 / 3.0 }
    }
}

/// The angular falloff of a spot light: 1 inside the inner cone, falling in the cosine to 0 at the outer one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SpotCone {
    /// 1 - cos of the inner angle; narrow cones need it exact.
    inner: f64,
    /// 1 - cos of the outer angle.
    outer: f64,
    falloff: SpotFalloff,
}

impl SpotCone {
    /// Half angles in radians.
    pub(crate) fn new(inner_angle: f32, outer_angle: f32, falloff: SpotFalloff) -> Self {
        let one_minus_cos = |angle: f32| 2.0 * (0.5 * f64::from(angle)).sin().powi(2);
        Self { inner: one_minus_cos(inner_angle), outer: one_minus_cos(outer_angle), falloff }
    }

    /// Samples a direction about +z in proportion to the emitted intensity.
    pub(crate) fn sample(&self, u: Vec2) -> Vec3 {
        // The distribution of 1 - cos has a flat part and a falloff.
        let falloff = self.outer - self.inner;
        let mass = f64::from(u.x) * (self.inner + self.falloff.mean() * falloff);
        let one_minus_cos = if mass <= self.inner || falloff <= 0.0 {
            mass.min(self.inner)
        } else {
            let mass = (mass - self.inner) / falloff;
            let place = match self.falloff {
                SpotFalloff::Smooth => inverse_falloff(mass),
                // From the inner edge the square leaves (1 - x)^3 / 3 of its integral.
                SpotFalloff::Square => 1.0 - (1.0 - 3.0 * mass).max(0.0).cbrt(),
            };
            self.inner + falloff * place
        };
        let sin_theta = (one_minus_cos * (2.0 - one_minus_cos)).max(0.0).sqrt() as f32;
        let (sin, cos) = (TAU * u.y).sin_cos();
        Vec3::new(sin_theta * cos, sin_theta * sin, (1.0 - one_minus_cos) as f32)
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
        let next = if step > low && step < high { step } else { 0.5 * (low + high) };
        if (next - x).abs() < 1e-12 {
            return next;
        }
        x = next;
    }
    x
}

/// An orthonormal frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Frame {
    tangent: Vec3,
    bitangent: Vec3,
    /// Z axis.
    pub(crate) normal: Vec3,
}

impl Frame {
    /// A frame with z axis `normal` (unit): a fixed reference frame, rotated by the smallest angle. Continuous in
    /// `normal` except for one direction (the hairy ball theorem requires one), which is far from all axes.
    pub(crate) fn around(normal: Vec3) -> Self {
        const REFERENCE: Vec3 = Vec3::new(-0.48, -0.6, -0.64);
        const TANGENT: Vec3 = Vec3::new(-0.8, 0.0, 0.6);
        // The rotation maps the tangent as a reflection along the sum of both axes does; the reflection stays exact
        // for a short sum.
        let sum = REFERENCE + normal;
        let length_squared = sum.length_squared();
        let rotated = if length_squared > 1e-10 {
            TANGENT - sum * (2.0 * TANGENT.dot(sum) / length_squared)
        } else {
            TANGENT
        };
        // Orthonormalise again: both axes are unit only up to rounding.
        let tangent = (rotated - normal * rotated.dot(normal)).normalize();
        Self { tangent, bitangent: normal.cross(tangent), normal }
    }

    /// Transforms a vector from the world to this frame.
    pub(crate) fn to_local(self, v: Vec3) -> Vec3 {
        Vec3::new(self.tangent.dot(v), self.bitangent.dot(v), self.normal.dot(v))
    }

    /// Transforms a vector from this frame to the world.
    pub(crate) fn to_world(self, v: Vec3) -> Vec3 {
        self.tangent * v.x + self.bitangent * v.y + self.normal * v.z
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    const POINTS: u32 = 65_536;

    fn points() -> impl Iterator<Item = Vec2> {
        (0..POINTS).map(|index| sequence_point(index, 3, 5))
    }

    /// Pearson's chi-square of counts against expected shares, divided by the degrees of freedom: about 1 for
    /// independent samples, less for stratified ones.
    pub(crate) fn chi_square(counts: &[u32], shares: &[f64]) -> f64 {
        let total: u32 = counts.iter().sum();
        let terms = counts.iter().zip(shares).map(|(&count, share)| {
            let expected = f64::from(total) * share;
            (f64::from(count) - expected).powi(2) / expected
        });
        terms.sum::<f64>() / (counts.len() - 1) as f64
    }

    fn assert_uniform(what: &str, points: impl Iterator<Item = Vec2>) {
        let mut counts = [0; 256];
        for point in points {
            let cell = (point * 16.0).as_uvec2().min(glam::UVec2::splat(15));
            counts[(cell.y * 16 + cell.x) as usize] += 1;
        }
        let chi = chi_square(&counts, &[1.0 / 256.0; 256]);
        assert!(chi < 0.5, "{what}: {chi}");
    }

    #[test]
    fn random_points_are_uniform_and_independent() {
        let points: Vec<Vec2> = (0..POINTS).map(|index| random_point(index, 1, 5)).collect();
        let mut counts = [0; 256];
        for point in &points {
            let cell = (*point * 16.0).as_uvec2();
            counts[(cell.y * 16 + cell.x) as usize] += 1;
        }
        let chi = chi_square(&counts, &[1.0 / 256.0; 256]);
        assert!((0.7..1.3).contains(&chi), "{chi}");
    }

    fn azimuth(v: Vec3) -> f32 {
        v.y.atan2(v.x) / TAU + 0.5
    }

    #[test]
    fn directions_follow_their_densities() {
        let sphere = points().map(sphere);
        assert_uniform("sphere", sphere.map(|v| Vec2::new(azimuth(v), v.z * 0.5 + 0.5)));
        let cosine = points().map(cosine_hemisphere);
        assert_uniform("cosine", cosine.map(|v| Vec2::new(azimuth(v), v.z * v.z)));
        let disc = points().map(disc);
        assert_uniform("disc", disc.map(|p| Vec2::new(azimuth(p.extend(0.0)), p.length_squared())));
        assert!(points().map(super::sphere).all(|v| (v.length() - 1.0).abs() < 1e-6));
    }

    #[test]
    fn triangles_are_covered_evenly() {
        let squared = points().map(triangle).map(|p| {
            assert!(p.min_element() >= 0.0 && p.element_sum() <= 1.0 + 1e-6);
            // The marginal of x is 2 (1 - x); given x, y is uniform below 1 - x.
            Vec2::new(1.0 - (1.0 - p.x) * (1.0 - p.x), p.y / (1.0 - p.x).max(1e-9))
        });
        assert_uniform("triangle", squared);
    }

    #[test]
    fn spots_follow_their_falloff() {
        let cones = [(0.2f32, 0.5f32), (0.0, 1.0), (1.0, 3.0), (0.002, 0.004), (0.7, 0.70001)];
        let both = |(inner, outer)| [SpotFalloff::Smooth, SpotFalloff::Square].map(|f| (inner, outer, f));
        for (inner, outer, kind) in cones.into_iter().flat_map(both) {
            let cone = SpotCone::new(inner, outer, kind);
            // The integral of the emission from the axis down to 1 - cos = x.
            let (near, falloff) = (cone.inner, cone.outer - cone.inner);
            let mass = |x: f64| {
                let rim = ((x - near) / falloff).clamp(0.0, 1.0);
                let smooth = rim - rim.powi(3) + 0.5 * rim.powi(4);
                let square = (1.0 - (1.0 - rim).powi(3)) / 3.0;
                x.min(near) + falloff * if kind == SpotFalloff::Smooth { smooth } else { square }
            };
            let bins = 64;
            let edge = |bin: usize| cone.outer * bin as f64 / bins as f64;
            let shares: Vec<f64> =
                (0..bins).map(|bin| (mass(edge(bin + 1)) - mass(edge(bin))) / mass(cone.outer)).collect();
            let mut counts = vec![0; bins];
            for v in points().map(|u| cone.sample(u)) {
                // 1 - cos from the sine, which stays exact for narrow cones.
                let sin2 = f64::from(v.x).powi(2) + f64::from(v.y).powi(2);
                let cos = f64::from(v.z);
                let x = if cos > 0.0 { sin2 / (1.0 + cos) } else { 1.0 - cos };
                assert!(x < cone.outer * 1.001);
                counts[((x / cone.outer * bins as f64) as usize).min(bins - 1)] += 1;
            }
            let chi = chi_square(&counts, &shares);
            assert!(chi < 0.7, "{inner} {outer} {kind:?}: {chi}");
        }
    }

    #[test]
    fn linear_functions_are_sampled_in_proportion() {
        for ends in [[0.0, 1.0], [3.0, 0.0], [2.0, 5.0], [1.0, 1.0], [0.0, 1e-30], [0.0, 0.0]] {
            let [first, last] = if ends[0] + ends[1] == 0.0 { [1.0, 1.0] } else { ends };
            for step in 0..=100 {
                let u = (step as f32 / 100.0).min(BELOW_ONE);
                let x = linear(ends, u);
                // The integral up to x over the whole is u.
                let part = (first * x + 0.5 * (last - first) * x * x) / (0.5 * (first + last));
                assert!((0.0..1.0).contains(&x) && (part - u).abs() < 1e-5, "{ends:?} {u}: {x} {part}");
            }
        }
    }

    #[test]
    fn discrete_choice_follows_its_shares_and_reuses_the_rest() {
        let cdf = [0.0, 0.25, 0.25, 0.875, 1.0, 1.0];
        let mut counts = [0; 6];
        let mut rests = [0.0f64; 6];
        for u in points() {
            let (bin, rest) = discrete(&cdf, u.x);
            counts[bin] += 1;
            rests[bin] += f64::from(rest);
            assert!((0.0..1.0).contains(&rest));
        }
        assert_eq!(counts, [0, POINTS / 4, 0, POINTS * 5 / 8, POINTS / 8, 0]);
        for (count, rest) in counts.iter().zip(rests).filter(|entry| *entry.0 > 0) {
            assert!((rest / f64::from(*count) - 0.5).abs() < 1e-3);
        }
        assert_eq!(discrete(&cdf, 0.0).0, 1);
        assert_eq!(discrete(&cdf, BELOW_ONE).0, 4);
    }

    #[test]
    fn frames_are_orthonormal_and_turn_smoothly() {
        let mut last: Option<Frame> = None;
        for step in 0..20_000 {
            // A spiral from pole to pole, which passes close to every direction.
            let t = step as f32 / 20_000.0;
            let (sin, cos) = (40.0 * t).sin_cos();
            let z = 1.0 - 2.0 * t;
            let radius = (1.0 - z * z).sqrt();
            let frame = Frame::around(Vec3::new(radius * cos, radius * sin, z).normalize());
            let [x, y, z] = [frame.tangent, frame.bitangent, frame.normal];
            assert!(x.dot(y).abs().max(y.dot(z).abs()).max(z.dot(x).abs()) < 1e-5);
            assert!((x.length() - 1.0).abs() < 1e-5 && x.cross(y).dot(z) > 0.999);
            if let Some(last) = last {
                let singular = Vec3::new(0.48, 0.6, 0.64);
                let moved = z.distance(last.normal);
                let near = z.distance(singular).min(last.normal.distance(singular));
                let bound = 4.0 * moved / near.min(1.0) + 1e-5;
                assert!(x.distance(last.tangent) <= bound, "{z}");
            }
            last = Some(frame);
        }
        for normal in [Vec3::new(0.48, 0.6, 0.64), Vec3::new(-0.48, -0.6, -0.64)] {
            let frame = Frame::around(normal);
            assert!((frame.tangent.length() - 1.0).abs() < 1e-5);
            assert!(frame.tangent.dot(normal).abs() < 1e-4);
        }
    }

    #[test]
    fn blocks_of_the_sequence_are_stratified() {
        // Any 64 neighbours that start at a multiple of 64 fill an 8 x 8 grid.
        for block in 0..32 {
            let mut seen = [false; 64];
            for index in block * 64..block * 64 + 64 {
                let cell = (sequence_point(index, 0, 9) * 8.0).as_uvec2();
                seen[(cell.y * 8 + cell.x) as usize] = true;
            }
            assert!(seen.iter().all(|seen| *seen));
        }
    }
}
