//! Light from everywhere around the scene: a constant, or an equirectangular map.
//!
//! In: a colour, and a map. Out: radiance by direction, and directions in proportion to it with their
//! density. The map's middle lies towards -z, its right half towards +x, its top row at +y; a rotation turns it about +y.

use std::f32::consts::{PI, TAU};
use std::sync::{Arc, OnceLock};

use glam::{Quat, Vec2, Vec3};

use super::light::luminance;
use crate::sampling;

/// An environment.
#[derive(Clone, Debug)]
pub struct Environment {
    /// Radiance, W/m^2/sr; with a map, its factor.
    pub radiance: Vec3,
    /// The map, if any.
    pub map: Option<Arc<EnvironmentMap>>,
    /// Radians by which the map is turned about +y, counter-clockwise seen from above.
    pub rotation: f32,
}

/// An equirectangular map and the distribution of its light.
///
/// It is interpolated bilinearly between the centres of its texels, so its cells are the rectangles between four of them:
/// `width` in a row, `height + 1` rows, the first and last of which reach from a pole to the nearest centres.
#[derive(Clone)]
pub struct EnvironmentMap {
    width: usize,
    height: usize,
    /// Linear, by rows from the top.
    texels: Vec<Vec3>,
    /// Cumulative distribution over the rows of cells, and over the cells within each.
    rows: Vec<f32>,
    columns: Vec<f32>,
    /// Integral of the luminance times the greatest sine in each row of cells, over the unit square; 0 without light.
    integral: f32,
    /// Average over all directions.
    mean: Vec3,
    /// Its suns and its sky, once suns.rs has searched for them.
    pub(super) separated: OnceLock<Option<Separated>>,
}

/// A sun of a map.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sun {
    /// Unit vector towards it, as the map lies unturned.
    pub direction: Vec3,
    /// Across that, where the map's values are radiance in W/m^2/sr; W/m^2.
    pub irradiance: Vec3,
    /// Of a disc of the same solid angle, radians.
    pub half_angle: f32,
}

/// A map in two parts.
#[derive(Clone, Debug)]
pub(super) struct Separated {
    pub suns: Vec<Sun>,
    pub sky: Arc<EnvironmentMap>,
}

impl std::fmt::Debug for EnvironmentMap {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "EnvironmentMap({} x {})", self.width, self.height)
    }
}

impl PartialEq for Environment {
    /// Texels are compared only where the maps were read separately.
    fn eq(&self, other: &Self) -> bool {
        let same_map = match (&self.map, &other.map) {
            (Some(map), Some(other)) => Arc::ptr_eq(map, other) || map.texels() == other.texels(),
            (None, None) => true,
            _ => false,
        };
        (self.radiance, self.rotation) == (other.radiance, other.rotation) && same_map
    }
}

impl Environment {
    /// Constant radiance from all directions, W/m^2/sr.
    pub fn constant(radiance: Vec3) -> Self {
        Self { radiance, map: None, rotation: 0.0 }
    }

    /// Radiance from the unit vector `direction`, W/m^2/sr.
    pub fn radiance(&self, direction: Vec3) -> Vec3 {
        match &self.map {
            Some(map) => self.radiance * map.bilinear(self.uv_of(direction)),
            None => self.radiance,
        }
    }

    /// Radiance averaged over all directions, W/m^2/sr.
    pub fn mean(&self) -> Vec3 {
        self.radiance * self.map.as_ref().map_or(Vec3::ONE, |map| map.mean)
    }

    /// The point of the unit square that the unit vector `direction` has in the map, from the top left; turns along with it.
    pub(crate) fn uv_of(&self, direction: Vec3) -> Vec2 {
        uv_of(self.turn(-1.0) * direction)
    }

    /// The unit vector whose place in the map is `uv`.
    pub(crate) fn direction_of(&self, uv: Vec2) -> Vec3 {
        self.turn(1.0) * direction_of(uv)
    }

    /// A direction in proportion to the map's luminance, nearly, with its density, 1/sr; none without a map or light.
    pub(crate) fn sample(&self, u: Vec2) -> Option<(Vec3, f32)> {
        let (uv, density) = self.map.as_ref()?.sample(u)?;
        Some((self.direction_of(uv), density))
    }

    /// Density of [`Self::sample`], 1/sr; 0 without a map.
    pub(crate) fn density(&self, direction: Vec3) -> f32 {
        self.map.as_ref().map_or(0.0, |map| map.density(self.uv_of(direction)))
    }

    /// A direction of the map as the environment is turned.
    pub(super) fn turned(&self, direction: Vec3) -> Vec3 {
        self.turn(1.0) * direction
    }

    fn turn(&self, sign: f32) -> Quat {
        Quat::from_rotation_y(sign * self.rotation)
    }
}

/// The place of a direction in the unit square, from the top left.
fn uv_of(direction: Vec3) -> Vec2 {
    let u = direction.x.atan2(-direction.z) / TAU + 0.5;
    // Exact near the poles, too, where an arc cosine is not.
    Vec2::new(u, direction.x.hypot(direction.z).atan2(direction.y) / PI)
}

pub(super) fn direction_of(uv: Vec2) -> Vec3 {
    let (sin_azimuth, cos_azimuth) = (TAU * (uv.x - 0.5)).sin_cos();
    let (sin, cos) = (PI * uv.y).sin_cos();
    Vec3::new(sin * sin_azimuth, cos, -sin * cos_azimuth)
}

impl EnvironmentMap {
    /// A map of `width` x `height` texels that has the given radiance in each direction (a unit vector).
    pub(crate) fn of_directions(width: usize, height: usize, radiance: impl Fn(Vec3) -> Vec3) -> Self {
        let size = Vec2::new(width as f32, height as f32);
        let centre = |i: usize| (Vec2::new((i % width) as f32, (i / width) as f32) + 0.5) / size;
        let texels = (0..width * height).map(|i| radiance(direction_of(centre(i)))).collect();
        Self::new(width, height, texels)
    }

    /// A map of `width` x `height` texels, linear, by rows from the top.
    ///
    /// # Panics
    /// If `texels` has another number of elements, or there are none.
    pub fn new(width: usize, height: usize, texels: Vec<Vec3>) -> Self {
        assert!(width > 0 && height > 0 && texels.len() == width * height);
        let (rows, columns) = (Vec::with_capacity(height + 1), Vec::with_capacity((height + 1) * width));
        let mut map = Self {
            width,
            height,
            texels,
            rows,
            columns,
            integral: 0.0,
            mean: Vec3::ZERO,
            separated: OnceLock::new(),
        };
        map.mean = map.average();
        let mut row_weights = Vec::with_capacity(height + 1);
        for row in 0..=height {
            let mean = |column| map.corners(row, column).map(f64::from).iter().sum::<f64>() / 4.0;
            let weights: Vec<f64> = (0..width).map(mean).collect();
            let sum: f64 = weights.iter().sum();
            let [top, bottom] = map.edges(row);
            row_weights.push(sum * f64::from(map.greatest_sine(row) * (bottom - top)) / width as f64);
            map.columns.extend(cumulative(&weights, sum));
        }
        let total: f64 = row_weights.iter().sum();
        map.rows.extend(cumulative(&row_weights, total));
        map.integral = total as f32;
        map
    }

    /// A map in which no suns are to be found.
    pub(super) fn without_suns(width: usize, height: usize, texels: Vec<Vec3>) -> Self {
        Self { separated: OnceLock::from(None), ..Self::new(width, height, texels) }
    }

    /// Radiance averaged over all directions.
    pub(super) fn mean(&self) -> Vec3 {
        self.mean
    }

    /// Width, height, and the texels: linear, by rows from the top.
    pub(crate) fn texels(&self) -> (usize, usize, &[Vec3]) {
        (self.width, self.height, &self.texels)
    }

    /// The cumulative distribution that directions are sampled by: of the rows of cells, then of the cells of each row; at the end the
    /// integral of what it is of.
    pub(crate) fn distribution(&self) -> Vec<f32> {
        [&self.rows[..], &self.columns, &[self.integral]].concat()
    }

    /// Luminance at the corners of a cell: left and right, above, then below.
    fn corners(&self, row: usize, column: usize) -> [f32; 4] {
        let right = (column + 1) % self.width;
        let (above, below) = (row.saturating_sub(1) * self.width, row.min(self.height - 1) * self.width);
        [above + column, above + right, below + column, below + right].map(|i| luminance(self.texels[i]))
    }

    /// Upper and lower edge of a row of cells in the unit square.
    fn edges(&self, row: usize) -> [f32; 2] {
        [row as f32 - 0.5, row as f32 + 0.5].map(|edge| (edge / self.height as f32).clamp(0.0, 1.0))
    }

    /// Greatest sine of the angle to the poles in a row of cells.
    fn greatest_sine(&self, row: usize) -> f32 {
        let [top, bottom] = self.edges(row);
        (PI * 0.5f32.clamp(top, bottom)).sin()
    }

    fn average(&self) -> Vec3 {
        let (mut sum, mut total) = (glam::DVec3::ZERO, 0.0);
        for (y, row) in self.texels.chunks(self.width).enumerate() {
            let weight = (std::f64::consts::PI * (y as f64 + 0.5) / self.height as f64).sin();
            sum += row.iter().map(|texel| texel.as_dvec3()).sum::<glam::DVec3>() * weight;
            total += weight * self.width as f64;
        }
        (sum / total).as_vec3()
    }

    /// Interpolated colour; it repeats to the sides.
    fn bilinear(&self, uv: Vec2) -> Vec3 {
        let at = uv * Vec2::new(self.width as f32, self.height as f32) - 0.5;
        let base = at.floor();
        let part = at - base;
        let texel = |dx: i64, dy: i64| {
            let x = (base.x as i64 + dx).rem_euclid(self.width as i64) as usize;
            let y = (base.y as i64 + dy).clamp(0, self.height as i64 - 1) as usize;
            self.texels[y * self.width + x]
        };
        let (top, bottom) = (texel(0, 0).lerp(texel(1, 0), part.x), texel(0, 1).lerp(texel(1, 1), part.x));
        top.lerp(bottom, part.y)
    }

    /// A place in proportion to its luminance, but for the sine, which counts as the greatest in its row of cells; so the
    /// luminance over the density is at most `integral` times the area of the unit square in steradians, 2 pi^2.
    fn sample(&self, u: Vec2) -> Option<(Vec2, f32)> {
        // A black map has no distribution.
        self.rows.last().filter(|sum| **sum > 0.0)?;
        let (row, v) = sampling::discrete(&self.rows, u.y);
        let (column, u) = sampling::discrete(&self.columns[row * self.width..(row + 1) * self.width], u.x);
        let [left, right, left_below, right_below] = self.corners(row, column);
        let v = sampling::linear([0.5 * (left + right), 0.5 * (left_below + right_below)], v);
        let mix = |above: f32, below: f32| above + (below - above) * v;
        let u = sampling::linear([mix(left, left_below), mix(right, right_below)], u);
        let [top, bottom] = self.edges(row);
        let place = Vec2::new((column as f32 + 0.5 + u) / self.width as f32, top + (bottom - top) * v);
        let place = Vec2::new(place.x.fract(), place.y);
        let density = self.density(place);
        (density > 0.0).then_some((place, density))
    }

    /// Density of [`Self::sample`], over solid angle.
    fn density(&self, uv: Vec2) -> f32 {
        let row = ((uv.y * self.height as f32 + 0.5) as usize).min(self.height);
        // The unit square covers 2 pi by pi, times the sine.
        let area = TAU * PI * (PI * uv.y).sin() * self.integral;
        if area > 0.0 { luminance(self.bilinear(uv)) * self.greatest_sine(row) / area } else { 0.0 }
    }
}

/// The cumulative distribution of these weights; zeros without any.
fn cumulative(weights: &[f64], total: f64) -> impl Iterator<Item = f32> + '_ {
    let mut sum = 0.0;
    weights.iter().map(move |weight| {
        sum += weight;
        if total > 0.0 { (sum / total).min(1.0) as f32 } else { 0.0 }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::{random_point, tests::chi_square};

    /// A dim sky with a sun of one texel.
    fn sky() -> Environment {
        let texel = |i: usize| {
            let (x, y) = (i % 32, i / 32);
            if (x, y) == (20, 4) {
                Vec3::new(900.0, 800.0, 700.0)
            } else {
                Vec3::new(0.2, 0.3, 0.02 * y as f32)
            }
        };
        let map = EnvironmentMap::new(32, 16, (0..512).map(texel).collect());
        Environment { radiance: Vec3::ONE, map: Some(Arc::new(map)), rotation: 0.7 }
    }

    #[test]
    fn directions_and_places_belong_together() {
        for (direction, uv) in [
            (Vec3::NEG_Z, Vec2::new(0.5, 0.5)),
            (Vec3::X, Vec2::new(0.75, 0.5)),
            (Vec3::new(-1.0, 1.0, 0.0).normalize(), Vec2::new(0.25, 0.25)),
        ] {
            assert!(uv_of(direction).distance(uv) < 1e-6 && direction_of(uv).distance(direction) < 1e-6);
        }
        let turned = Environment { rotation: std::f32::consts::FRAC_PI_2, ..sky() };
        let unturned = Environment { rotation: 0.0, ..sky() };
        // The part towards -z is turned towards -x.
        let [a, b] =
            [turned.radiance(Vec3::new(-0.8, 0.6, 0.0)), unturned.radiance(Vec3::new(0.0, 0.6, -0.8))];
        assert!(a.distance(b) < 1e-4, "{a} {b}");
    }

    #[test]
    fn samples_follow_their_density() {
        let sky = sky();
        const SAMPLES: u32 = 100_000;
        let (mut counts, mut shares) = (vec![0u32; 512], vec![0f64; 512]);
        let (mut sum, mut heaviest) = (glam::DVec3::ZERO, 0.0f32);
        let whole = sky.mean() * (4.0 * PI);
        for index in 0..SAMPLES {
            let (direction, density) = sky.sample(random_point(index, 0, 3)).unwrap();
            assert!((sky.density(direction) / density - 1.0).abs() < 0.02, "{direction}");
            let uv = uv_of(sky.turn(-1.0) * direction);
            counts[(uv.y * 16.0) as usize * 32 + ((uv.x * 32.0) as usize).min(31)] += 1;
            let weight = sky.radiance(direction) / density;
            // Only the sine varies within a row of cells; where the sun is, by a fifth.
            heaviest = heaviest.max(luminance(weight) / luminance(whole));
            sum += weight.as_dvec3();
        }
        assert!((1.0..1.2).contains(&heaviest), "{heaviest}");
        for (cell, share) in shares.iter_mut().enumerate() {
            for part in 0..400 {
                let within = Vec2::new((part % 20) as f32 + 0.5, (part / 20) as f32 + 0.5) / 20.0;
                let uv = (Vec2::new((cell % 32) as f32, (cell / 32) as f32) + within) / Vec2::new(32.0, 16.0);
                let direction = sky.turn(1.0) * direction_of(uv);
                let area = std::f64::consts::PI.powi(2) * 2.0 / 512.0 * f64::from((PI * uv.y).sin());
                *share += f64::from(sky.density(direction)) * area / 400.0;
            }
        }
        let total: f64 = shares.iter().sum();
        assert!((total - 1.0).abs() < 1e-3, "{total}");
        // Texels that are hardly ever sampled say little.
        let kept: Vec<usize> = (0..512).filter(|&cell| shares[cell] * f64::from(SAMPLES) > 5.0).collect();
        assert!(kept.len() > 8);
        let sampled: u32 = kept.iter().map(|&cell| counts[cell]).sum();
        let counts: Vec<u32> = kept.iter().map(|&cell| counts[cell]).collect();
        let part: f64 = kept.iter().map(|&cell| shares[cell]).sum();
        let shares: Vec<f64> = kept.iter().map(|&cell| shares[cell] / part).collect();
        assert!(f64::from(sampled) > 0.9 * f64::from(SAMPLES) * part);
        let chi = chi_square(&counts, &shares);
        assert!(chi < 1.8, "{chi} of {}", counts.len());
        let estimate = (sum / f64::from(SAMPLES) / (4.0 * std::f64::consts::PI)).as_vec3();
        assert!((estimate / sky.mean() - 1.0).abs().max_element() < 0.05, "{estimate} {}", sky.mean());
    }

    #[test]
    fn black_maps_have_no_directions() {
        let map = EnvironmentMap::new(4, 2, vec![Vec3::ZERO; 8]);
        let black = Environment { radiance: Vec3::ONE, map: Some(Arc::new(map)), rotation: 0.0 };
        assert_eq!((black.sample(Vec2::splat(0.4)), black.density(Vec3::X)), (None, 0.0));
    }
}
