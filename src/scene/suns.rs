//! The suns of an environment map: its compact parts that are far brighter than their surroundings, cut out as directional lights.
//!
//! In: a map. Out: up to [`MOST`] suns, and the sky: the map with their texels filled with the mean around them, so that both together
//! send what the map sends. Who sees what of an environment that has suns:
//!
//! - the map: the eye, and rays from perfect mirrors, to which lights send nothing;
//! - the sky, and the suns as lights: irradiance (VPLs at infinity and those after them, what is behind thin surfaces), and other GGX
//!   lobes, to which direct light sends the highlight of a sun and reflection rays bring the sky;
//! - `reference` sees the map alone.

use std::borrow::Cow;
use std::f32::consts::{PI, TAU};
use std::sync::Arc;

use glam::Vec3;

use super::contents::Pose;
use super::environment::{Environment, EnvironmentMap, Separated, Sun, direction_of};
use super::light::{Light, LightKind, luminance};

/// Suns that are cut out, and bright regions that are looked at, at most.
const MOST: usize = 4;
const CANDIDATES: usize = 16;
/// A region's texels are brighter than this share of its brightest: the core of a sun with its bloom.
const BORDER: f32 = 0.1;
/// How many times as bright as its surroundings it is.
const CONTRAST: f32 = 10.0;
/// Irradiance, as a share of the mean over all planes, below which the shadow of a sun would hardly be seen.
const LEAST_IRRADIANCE: f32 = 0.1;
/// Half angle up to which shadows are those of a sun, radians; wider ones are soft enough for VPLs.
const WIDEST: f32 = 0.1;
/// How far texels may be from the middle, in half angles of a disc of the same solid angle.
const LONGEST: f32 = 2.0;

impl Pose {
    /// The pose with the suns of its environment as lights after all others.
    pub(crate) fn with_suns(pose: Cow<'_, Self>) -> Cow<'_, Self> {
        let Some(environment) = &pose.environment else { return pose };
        let Some(Separated { suns, sky }) = environment.map.as_ref().and_then(|map| map.separated()) else {
            return pose;
        };
        let light = |(index, sun): (usize, &Sun)| Light {
            name: format!("sun {index} of the environment"),
            kind: LightKind::Directional { irradiance: environment.radiance * sun.irradiance },
            position: Vec3::ZERO,
            direction: -environment.turned(sun.direction),
            radius: 0.0,
            half_angle: sun.half_angle,
            animation: None,
        };
        let lights: Vec<Light> = suns.iter().enumerate().map(light).collect();
        let environment = Environment { map: Some(Arc::clone(sky)), ..environment.clone() };
        let mut pose = pose.into_owned();
        pose.lights.extend(lights);
        pose.environment = Some(environment);
        Cow::Owned(pose)
    }
}

impl Separated {
    /// The suns of a map, if it has any, and its sky.
    fn of(map: &EnvironmentMap) -> Option<Self> {
        let (width, height, texels) = map.texels();
        let mut search =
            Search { width, height, texels: texels.to_vec(), rejected: vec![false; texels.len()] };
        let mean = luminance(map.mean());
        let mut suns = Vec::new();
        for _ in 0..CANDIDATES {
            let Some(brightest) = search.brightest().filter(|_| suns.len() < MOST) else { break };
            if luminance(search.texels[brightest]) <= CONTRAST * mean {
                break;
            }
            let region = search.region(brightest);
            match search.sun_of(&region, LEAST_IRRADIANCE * PI * mean) {
                Some((sun, around)) => {
                    region.iter().for_each(|&i| search.texels[i] = search.texels[i].min(around));
                    suns.push(sun);
                }
                None => region.iter().for_each(|&i| search.rejected[i] = true),
            }
        }
        let sky = || Arc::new(EnvironmentMap::without_suns(width, height, search.texels));
        (!suns.is_empty()).then(|| Self { sky: sky(), suns })
    }
}

impl EnvironmentMap {
    /// Its suns and the rest, if it has any. Searches for them at the first call.
    fn separated(&self) -> Option<&Separated> {
        self.separated.get_or_init(|| Separated::of(self)).as_ref()
    }

    /// The map without its suns; none if it has none.
    pub(crate) fn sky(&self) -> Option<&Self> {
        self.separated().map(|separated| &*separated.sky)
    }
}

/// A map while suns are cut out of it.
struct Search {
    width: usize,
    height: usize,
    texels: Vec<Vec3>,
    /// Texels of bright regions that are no suns.
    rejected: Vec<bool>,
}

impl Search {
    fn brightest(&self) -> Option<usize> {
        let open = (0..self.texels.len()).filter(|&i| !self.rejected[i]);
        open.max_by(|&a, &b| luminance(self.texels[a]).total_cmp(&luminance(self.texels[b])))
    }

    /// The bright texels that hang together with this one, the brightest; across the seam and the poles, too.
    fn region(&self, brightest: usize) -> Vec<usize> {
        let least = BORDER * luminance(self.texels[brightest]);
        let mut found = vec![false; self.texels.len()];
        found[brightest] = true;
        let (mut region, mut next) = (vec![brightest], 0);
        while let Some(&texel) = region.get(next) {
            next += 1;
            for neighbour in self.neighbours(texel) {
                if !std::mem::replace(&mut found[neighbour], true)
                    && luminance(self.texels[neighbour]) > least
                {
                    region.push(neighbour);
                }
            }
        }
        region
    }

    fn neighbours(&self, texel: usize) -> impl Iterator<Item = usize> + '_ {
        let (x, y) = (texel % self.width, texel / self.width);
        (0..9).map(move |i| {
            // Beyond a pole lies the other half of its row.
            let (row, over) = match y + i / 3 {
                0 => (0, self.width / 2),
                row if row > self.height => (self.height - 1, self.width / 2),
                row => (row - 1, 0),
            };
            row * self.width + (x + i % 3 + self.width - 1 + over) % self.width
        })
    }

    fn direction(&self, texel: usize) -> Vec3 {
        let at = glam::Vec2::new((texel % self.width) as f32, (texel / self.width) as f32) + 0.5;
        direction_of(at / glam::Vec2::new(self.width as f32, self.height as f32))
    }

    /// Solid angle of a texel: of the tent by which it is interpolated, which is level towards a pole.
    fn solid_angle(&self, texel: usize) -> f32 {
        let row = (texel / self.width).min(self.height - 1 - texel / self.width);
        let step = std::f64::consts::PI / self.height as f64;
        let sines = |row: f64| ((row + 1.0) * step).sin() - (row * step).sin();
        let height = match row {
            0 => 1.0 - sines(0.5) / step,
            row => (sines(row as f64 - 0.5) - sines(row as f64 + 0.5)) / step,
        };
        TAU / self.width as f32 * height as f32
    }

    /// The region as a sun, with the mean around it, if it is one.
    fn sun_of(&self, region: &[usize], least_irradiance: f32) -> Option<(Sun, Vec3)> {
        let solid_angle: f32 = region.iter().map(|&i| self.solid_angle(i)).sum();
        let half_angle = 2.0 * (0.25 * solid_angle / PI).min(1.0).sqrt().asin();
        let towards = |&i: &usize| self.direction(i) * (luminance(self.texels[i]) * self.solid_angle(i));
        let direction = region.iter().map(towards).sum::<Vec3>().normalize_or(Vec3::Y);
        let is_far = |&i: &usize| self.direction(i).dot(direction) < (LONGEST * half_angle).cos();
        if half_angle > WIDEST || region.iter().any(is_far) {
            return None;
        }
        let around = self.around(region, direction, 2.0 * half_angle);
        let excess = |i: usize| self.texels[i] - self.texels[i].min(around);
        let across = |&i: &usize| excess(i) * (self.solid_angle(i) * self.direction(i).dot(direction));
        let irradiance = region.iter().map(across).sum();
        let inside = region.iter().map(|&i| self.texels[i] * self.solid_angle(i)).sum::<Vec3>() / solid_angle;
        let is_sun =
            luminance(irradiance) >= least_irradiance && luminance(inside) >= CONTRAST * luminance(around);
        is_sun.then_some((Sun { direction, irradiance, half_angle }, around))
    }

    /// The mean of the texels beside a region up to this angle from its middle, and two texels more.
    fn around(&self, region: &[usize], middle: Vec3, angle: f32) -> Vec3 {
        let rows = PI / self.height as f32;
        let angle = angle + 2.0 * rows;
        let row = |polar: f32| (polar.clamp(0.0, PI) / rows) as usize * self.width;
        let polar = middle.angle_between(Vec3::Y);
        let near = row(polar - angle)..(row(polar + angle) + self.width).min(self.texels.len());
        let mut counts = vec![true; near.len()];
        region.iter().filter(|i| near.contains(i)).for_each(|&i| counts[i - near.start] = false);
        let (mut sum, mut total) = (Vec3::ZERO, 0.0);
        for i in near.clone().filter(|&i| counts[i - near.start]) {
            if self.direction(i).dot(middle) >= angle.min(PI).cos() {
                sum += self.texels[i] * self.solid_angle(i);
                total += self.solid_angle(i);
            }
        }
        if total > 0.0 { sum / total } else { Vec3::ZERO }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::{Frame, cosine_hemisphere};

    const SIZE: [usize; 2] = [128, 64];

    /// A grey map with white regions: first column and row, width, height.
    fn map(white: Vec3, regions: &[[usize; 4]]) -> EnvironmentMap {
        let lies_in = |i: usize, [x, y, width, height]: &[usize; 4]| {
            (i % SIZE[0] + SIZE[0] - x) % SIZE[0] < *width && (y..&(y + height)).contains(&&(i / SIZE[0]))
        };
        let texel = |i: usize| match regions.iter().any(|region| lies_in(i, region)) {
            true => white,
            false => Vec3::splat(0.5),
        };
        EnvironmentMap::new(SIZE[0], SIZE[1], (0..SIZE[0] * SIZE[1]).map(texel).collect())
    }

    /// Irradiance of a plane.
    fn irradiance(environment: &Environment, normal: Vec3) -> Vec3 {
        const SIDE: u32 = 1024;
        let place = |i: u32| (glam::Vec2::new((i % SIDE) as f32, (i / SIDE) as f32) + 0.5) / SIDE as f32;
        let directions =
            (0..SIDE * SIDE).map(|i| Frame::around(normal).to_world(cosine_hemisphere(place(i))));
        let sum: glam::DVec3 = directions.map(|towards| environment.radiance(towards).as_dvec3()).sum();
        (sum * std::f64::consts::PI / f64::from(SIDE * SIDE)).as_vec3()
    }

    /// The pose of a scene with nothing but an environment, its suns cut out.
    fn separated(map: EnvironmentMap) -> (Environment, Pose) {
        let (radiance, rotation) = (Vec3::new(1.0, 0.5, 2.0), 0.7);
        let environment = Environment { radiance, map: Some(Arc::new(map)), rotation };
        let mut scene = crate::scene::Scene::new("sky");
        scene.environment = Some(environment.clone());
        (environment, Pose::with_suns(Cow::Owned(scene.pose(0.0))).into_owned())
    }

    #[test]
    fn suns_and_sky_send_what_the_map_sends() {
        let white = Vec3::new(3000.0, 2000.0, 1000.0);
        for (regions, count) in [
            (&[[40, 20, 1, 1]][..], 1),
            (&[[40, 20, 2, 2]], 1),
            // Across the seam; on a pole; beside one.
            (&[[127, 30, 3, 2]], 1),
            (&[[0, 0, 128, 1]], 1),
            (&[[0, 62, 128, 2]], 1),
            (&[[70, 1, 6, 1]], 1),
            (&[[40, 20, 1, 1], [90, 25, 2, 1]], 2),
        ] {
            let (environment, pose) = separated(map(white, regions));
            assert_eq!(pose.lights.len(), count, "{regions:?}");
            let sky = pose.environment.as_ref().unwrap();
            for light in &pose.lights {
                let sent: Vec3 = pose
                    .lights
                    .iter()
                    .map(|sun| {
                        let LightKind::Directional { irradiance } = sun.kind else { panic!("directional") };
                        irradiance * sun.direction.dot(light.direction).max(0.0)
                    })
                    .sum();
                let ratio =
                    (sent + irradiance(sky, -light.direction)) / irradiance(&environment, -light.direction);
                assert!((ratio - 1.0).abs().max_element() < 0.01, "{regions:?}: {ratio}");
                // Nothing is left of it in the sky; towards its middle it was white.
                let towards = -light.direction;
                assert!(sky.radiance(towards).x < 1.0, "{regions:?}: {}", sky.radiance(towards));
                assert!(environment.radiance(towards).x > 1000.0 && light.half_angle < WIDEST, "{regions:?}");
            }
        }
    }

    #[test]
    fn what_is_large_or_long_or_dim_is_no_sun() {
        for (what, white, region) in [
            ("one colour", 0.5, [0, 0, 1, 1]),
            ("a softbox", 50.0, [30, 20, 10, 10]),
            ("half a sky", 50.0, [100, 0, 64, 64]),
            ("a tube", 300.0, [30, 20, 14, 1]),
            ("a window", 20.0, [30, 20, 6, 6]),
            ("a lamp far away", 40.0, [30, 20, 1, 1]),
        ] {
            let (environment, pose) = separated(map(Vec3::splat(white), &[region]));
            assert!(pose.lights.is_empty() && pose.environment == Some(environment), "{what}");
        }
    }
}
