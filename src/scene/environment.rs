//! Light from everywhere around the scene: a constant, or an equirectangular map.
//!
//! In: a colour, and an `.hdr` or `.exr`. Out: radiance by direction, and directions in proportion to it with their
//! density. The map's middle lies towards -z, its right half towards +x, its top row at +y; a rotation turns it about +y.

use std::f32::consts::{PI, TAU};
use std::path::Path;
use std::sync::Arc;

use glam::{Quat, Vec2, Vec3};

use super::light::luminance;
use crate::sampling;

/// Largest map.
const MAX_SIZE: [u32; 2] = [8192, 4096];

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
#[derive(Clone)]
pub struct EnvironmentMap {
    width: usize,
    height: usize,
    /// Linear, by rows from the top.
    texels: Vec<Vec3>,
    /// Cumulative distribution over the rows, and over the texels within each.
    rows: Vec<f32>,
    columns: Vec<f32>,
    /// Average over all directions.
    mean: Vec3,
}

impl std::fmt::Debug for EnvironmentMap {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "EnvironmentMap({} x {})", self.width, self.height)
    }
}

impl PartialEq for Environment {
    /// Maps are equal if they are the same one.
    fn eq(&self, other: &Self) -> bool {
        let map = |environment: &Self| environment.map.as_ref().map(Arc::as_ptr);
        (self.radiance, self.rotation, map(self)) == (other.radiance, other.rotation, map(other))
    }
}

impl Environment {
    /// The same radiance from all directions, W/m^2/sr.
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

    /// A direction in proportion to about the map's luminance, with its density, 1/sr; none without a map or light.
    pub(crate) fn sample(&self, u: Vec2) -> Option<(Vec3, f32)> {
        let (uv, density) = self.map.as_ref()?.sample(u)?;
        Some((self.direction_of(uv), density))
    }

    /// Density of [`Self::sample`], 1/sr; 0 without a map.
    pub(crate) fn density(&self, direction: Vec3) -> f32 {
        self.map.as_ref().map_or(0.0, |map| map.density(self.uv_of(direction)))
    }

    fn turn(&self, sign: f32) -> Quat {
        Quat::from_rotation_y(sign * self.rotation)
    }
}

/// The place of a direction in the unit square, from the top left.
fn uv_of(direction: Vec3) -> Vec2 {
    let u = direction.x.atan2(-direction.z) / TAU + 0.5;
    Vec2::new(u, direction.y.clamp(-1.0, 1.0).acos() / PI)
}

fn direction_of(uv: Vec2) -> Vec3 {
    let (sin_azimuth, cos_azimuth) = (TAU * (uv.x - 0.5)).sin_cos();
    let (sin, cos) = (PI * uv.y).sin_cos();
    Vec3::new(sin * sin_azimuth, cos, -sin * cos_azimuth)
}

impl EnvironmentMap {
    /// Reads an `.hdr` or `.exr`; also how many texels were not finite or negative and are black now. The error
    /// completes a sentence.
    pub(super) fn read(file: &Path) -> Result<(Self, usize), String> {
        let unreadable = |error: std::io::Error| format!("could not be read ({error})");
        let open = || {
            let reader = image::ImageReader::open(file).map_err(unreadable)?;
            reader.with_guessed_format().map_err(unreadable)
        };
        let broken = |error: image::ImageError| format!("could not be decoded ({error})");
        let (width, height) = open()?.into_dimensions().map_err(broken)?;
        if width > MAX_SIZE[0] || height > MAX_SIZE[1] {
            let [most_wide, most_high] = MAX_SIZE;
            return Err(format!(
                "is {width} x {height}; shrink it to at most {most_wide} x {most_high} texels"
            ));
        }
        let image = open()?.decode().map_err(broken)?;
        if width < 2 || height < 2 {
            return Err("has less than 2 x 2 texels".into());
        }
        let mut replaced = 0;
        let image = image.into_rgb32f();
        let texels = image.pixels().map(|texel| {
            let colour = Vec3::from_array(texel.0);
            let usable = colour.is_finite() && colour.min_element() >= 0.0;
            replaced += usize::from(!usable);
            if usable { colour } else { Vec3::ZERO }
        });
        let texels = texels.collect();
        Ok((Self::new(width as usize, height as usize, texels), replaced))
    }

    /// A map of `width` x `height` texels, linear, by rows from the top.
    ///
    /// # Panics
    /// If `texels` has another number of elements, or there are none.
    pub fn new(width: usize, height: usize, texels: Vec<Vec3>) -> Self {
        assert!(width > 0 && height > 0 && texels.len() == width * height);
        let mut map = Self { width, height, texels, rows: Vec::new(), columns: Vec::new(), mean: Vec3::ZERO };
        map.mean = map.average();
        let mut row_weights = Vec::with_capacity(height);
        for y in 0..height {
            let weights: Vec<f64> = (0..width).map(|x| f64::from(map.brightest_around(x, y))).collect();
            let sum: f64 = weights.iter().sum();
            map.columns.extend(cumulative(&weights, sum));
            row_weights.push(sum * (std::f64::consts::PI * (y as f64 + 0.5) / height as f64).sin());
        }
        map.rows = cumulative(&row_weights, row_weights.iter().sum()).collect();
        map
    }

    /// Width and height in texels.
    pub fn size(&self) -> [usize; 2] {
        [self.width, self.height]
    }

    /// Linear colours, by rows from the top.
    pub fn texels(&self) -> &[Vec3] {
        &self.texels
    }

    /// Greatest luminance of a texel and those around it, which a bilinear filter over it may return.
    fn brightest_around(&self, x: usize, y: usize) -> f32 {
        let columns = [(x + self.width - 1) % self.width, x, (x + 1) % self.width];
        let rows = y.saturating_sub(1)..=(y + 1).min(self.height - 1);
        let around = rows.flat_map(|y| columns.map(|x| luminance(self.texels[y * self.width + x])));
        around.fold(0.0, f32::max)
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

    fn sample(&self, u: Vec2) -> Option<(Vec2, f32)> {
        // A black map has no distribution.
        self.rows.last().filter(|sum| **sum > 0.0)?;
        let (y, v) = sampling::discrete(&self.rows, u.y);
        let (x, u) = sampling::discrete(&self.columns[y * self.width..(y + 1) * self.width], u.x);
        let uv = Vec2::new((x as f32 + u) / self.width as f32, (y as f32 + v) / self.height as f32);
        let density = self.density_in(x, y, uv.y);
        (density > 0.0).then_some((uv, density))
    }

    fn density(&self, uv: Vec2) -> f32 {
        let x = ((uv.x * self.width as f32) as usize).min(self.width - 1);
        let y = ((uv.y * self.height as f32) as usize).min(self.height - 1);
        self.density_in(x, y, uv.y)
    }

    /// Density within a texel, over solid angle.
    fn density_in(&self, x: usize, y: usize, v: f32) -> f32 {
        let share = |cdf: &[f32], bin: usize| cdf[bin] - if bin == 0 { 0.0 } else { cdf[bin - 1] };
        let row = &self.columns[y * self.width..(y + 1) * self.width];
        let probability = share(&self.rows, y) * share(row, x);
        // A texel covers 2 pi / width by pi / height, times the sine.
        let area = TAU / self.width as f32 * PI / self.height as f32 * (PI * v).sin();
        if area > 0.0 { probability / area } else { 0.0 }
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
        // What lay towards -z lies towards -x.
        let [a, b] =
            [turned.radiance(Vec3::new(-0.8, 0.6, 0.0)), unturned.radiance(Vec3::new(0.0, 0.6, -0.8))];
        assert!(a.distance(b) < 1e-4, "{a} {b}");
    }

    #[test]
    fn samples_follow_their_density() {
        let sky = sky();
        const SAMPLES: u32 = 100_000;
        let (mut counts, mut shares) = (vec![0u32; 512], vec![0f64; 512]);
        let mut sum = glam::DVec3::ZERO;
        let whole = sky.mean() * (4.0 * PI);
        for index in 0..SAMPLES {
            let (direction, density) = sky.sample(random_point(index, 0, 3)).unwrap();
            assert!((sky.density(direction) / density - 1.0).abs() < 0.02, "{direction}");
            let uv = uv_of(sky.turn(-1.0) * direction);
            counts[(uv.y * 16.0) as usize * 32 + ((uv.x * 32.0) as usize).min(31)] += 1;
            let weight = sky.radiance(direction) / density;
            // A texel is drawn as often as the brightest beside it: at most nine times what is there, and the sine
            // doubles within the rows at the poles.
            assert!(luminance(weight) < 18.0 * luminance(whole), "{weight} at {uv}");
            sum += weight.as_dvec3();
        }
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
        // Texels that are hardly ever drawn say little.
        let kept: Vec<usize> = (0..512).filter(|&cell| shares[cell] * f64::from(SAMPLES) > 5.0).collect();
        assert!(kept.len() > 8);
        let drawn: u32 = kept.iter().map(|&cell| counts[cell]).sum();
        let counts: Vec<u32> = kept.iter().map(|&cell| counts[cell]).collect();
        let part: f64 = kept.iter().map(|&cell| shares[cell]).sum();
        let shares: Vec<f64> = kept.iter().map(|&cell| shares[cell] / part).collect();
        assert!(f64::from(drawn) > 0.9 * f64::from(SAMPLES) * part);
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
