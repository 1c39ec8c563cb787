//! The directions from which a light with an extent shines on a point: a cone, to a sphere about the place of a point or
//! spot light, or to the disc of a directional one.
//!
//! In: where a light is seen from a point, its extent, and a point of the unit square. Out: a direction, uniform in the
//! cone, how far the light is along it, and what irradiance it carries. With theta the cone's half angle, where
//! sin theta = radius / distance of a sphere, and E the irradiance across the direction to the centre of a light
//! without extent,
//!
//! ```text
//! p(w) = 1 / (2 pi (1 - cos theta))
//! E(w) = E 2 / (1 + cos theta)         irradiance across w over p(w)
//! ```
//!
//! The mean cosine of w to the axis is (1 + cos theta)/2, so a plane that faces the centre gets E, as of a light without
//! extent. For a sphere this is what it sends by a radiance of I / (pi radius^2), the same in all directions.

use glam::{Vec2, Vec3};

use crate::sampling::{self, Frame};

/// The cone of directions from a point to a light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightCone {
    /// Unit direction to the light's centre.
    pub axis: Vec3,
    /// 1 - cos theta, which narrow cones need exactly; 0 without extent, 1 at most.
    pub one_minus_cos: f32,
    /// Distance to the light's centre, world units; infinite for a directional light.
    pub distance: f32,
    /// Radius of the sphere, world units; 0 without one.
    pub radius: f32,
}

/// A direction in a [`LightCone`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConeSample {
    /// Unit direction.
    pub direction: Vec3,
    /// Distance along it to the light's near surface, world units: surfaces beyond cast no shadow.
    pub distance: f32,
}

impl LightCone {
    /// To a sphere. Within the sphere it is the hemisphere about the direction to the centre, at distance 0.
    pub fn to_sphere(axis: Vec3, distance: f32, radius: f32) -> Self {
        let sine = (radius / distance).min(1.0);
        let one_minus_cos = sine * sine / (1.0 + (1.0 - sine * sine).sqrt());
        Self { axis, one_minus_cos, distance, radius }
    }

    /// The cone to a disc at infinity with this half angle, radians, at most pi/2.
    pub fn to_disc(axis: Vec3, half_angle: f32) -> Self {
        let sine = (0.5 * half_angle).sin();
        let one_minus_cos = (2.0 * sine * sine).min(1.0);
        Self { axis, one_minus_cos, distance: f32::INFINITY, radius: 0.0 }
    }

    /// Samples a direction uniformly: the disc bent onto the cap, which keeps areas in proportion.
    pub fn sample(&self, u: Vec2) -> ConeSample {
        if self.one_minus_cos == 0.0 {
            return ConeSample { direction: self.axis, distance: self.distance };
        }
        let p = sampling::disc(u);
        let one_minus_cos = p.length_squared() * self.one_minus_cos;
        let across = p * (self.one_minus_cos * (2.0 - one_minus_cos)).sqrt();
        let direction = Frame::around(self.axis).to_world(across.extend(1.0 - one_minus_cos));
        ConeSample { direction, distance: self.reach(one_minus_cos) }
    }

    /// Irradiance across a sampled direction over its pdf, relative to that across the axis of a light without extent.
    pub fn gain(&self) -> f32 {
        2.0 / (2.0 - self.one_minus_cos)
    }

    /// The largest cosine to `n` (unit) of a direction in the cone.
    pub fn largest_cosine(&self, n: Vec3) -> f32 {
        let (cosine, cone) = (n.dot(self.axis), 1.0 - self.one_minus_cos);
        if self.one_minus_cos == 0.0 {
            return cosine;
        }
        if cosine >= cone {
            return 1.0;
        }
        let sines = (1.0 - cosine * cosine).max(0.0) * self.one_minus_cos * (2.0 - self.one_minus_cos);
        cosine * cone + sines.sqrt()
    }

    /// Distance to the light along a direction at an angle to the axis, by 1 - cos of that: the smaller root t of
    /// t^2 - 2 t d cos + d^2 - r^2 = 0, with d the distance and r the radius, without cancellation.
    fn reach(&self, one_minus_cos: f32) -> f32 {
        let (d, r) = (self.distance, self.radius);
        if r == 0.0 {
            return d;
        }
        if d <= r {
            return 0.0;
        }
        let half_chord = (r * r - d * d * one_minus_cos * (2.0 - one_minus_cos)).max(0.0).sqrt();
        (d + r) * (d - r) / (d * (1.0 - one_minus_cos) + half_chord)
    }
}

#[cfg(test)]
mod tests {
    use std::f32::consts::{FRAC_PI_2, TAU};

    use super::*;
    use crate::sampling::{sequence_point, tests::chi_square};

    const POINTS: u32 = 65_536;

    fn axis() -> Vec3 {
        Vec3::new(0.3, -0.7, 0.2).normalize()
    }

    fn cones() -> impl Iterator<Item = LightCone> {
        let discs = [0.002, 4f32.to_radians(), 20f32.to_radians(), 1.2, FRAC_PI_2];
        let spheres = [(5.0, 0.004), (5.0, 0.5), (5.0, 4.9), (2.0, 3.0)];
        let discs = discs.map(|angle| LightCone::to_disc(axis(), angle));
        let spheres = spheres.map(|(distance, radius)| LightCone::to_sphere(axis(), distance, radius));
        discs.into_iter().chain(spheres)
    }

    fn samples(cone: &LightCone) -> impl Iterator<Item = ConeSample> {
        (0..POINTS).map(|index| cone.sample(sequence_point(index, 3, 5)))
    }

    /// 1 - cos to the axis from the sine, which narrow cones need.
    fn one_minus_cos(direction: Vec3) -> f32 {
        let (sine, cosine) = (direction.cross(axis()).length(), direction.dot(axis()));
        sine * sine / (1.0 + cosine)
    }

    #[test]
    fn half_angles_are_those_of_sphere_and_disc() {
        for half_angle in [1e-4, 0.07, 0.5, 1.5, FRAC_PI_2] {
            let expected = 2.0 * (0.5 * f64::from(half_angle)).sin().powi(2);
            let sphere = LightCone::to_sphere(axis(), 7.0, 7.0 * f64::from(half_angle).sin() as f32);
            for cone in [LightCone::to_disc(axis(), half_angle), sphere] {
                // The sine is flat near a right angle.
                let tolerance = if half_angle > 1.4 { 1e-3 } else { 1e-5 };
                assert!((f64::from(cone.one_minus_cos) / expected - 1.0).abs() < tolerance, "{cone:?}");
            }
        }
    }

    #[test]
    fn directions_are_uniform_in_the_cone() {
        for cone in cones() {
            let frame = Frame::around(axis());
            let mut counts = [0; 256];
            for sample in samples(&cone) {
                assert!((sample.direction.length() - 1.0).abs() < 1e-5);
                let local = frame.to_local(sample.direction);
                let part = one_minus_cos(sample.direction) / cone.one_minus_cos;
                assert!(part < 1.001, "{cone:?}: {part}");
                let turn = local.y.atan2(local.x) / TAU + 0.5;
                let cell = (Vec2::new(part, turn) * 16.0).as_uvec2().min(glam::UVec2::splat(15));
                counts[(cell.y * 16 + cell.x) as usize] += 1;
            }
            let chi = chi_square(&counts, &[1.0 / 256.0; 256]);
            assert!(chi < 0.5, "{cone:?}: {chi}");
        }
    }

    #[test]
    fn a_plane_that_faces_the_centre_gets_what_a_light_without_extent_sends() {
        for cone in cones() {
            let cosines = samples(&cone).map(|sample| f64::from(sample.direction.dot(axis())));
            let mean = cosines.sum::<f64>() / f64::from(POINTS) * f64::from(cone.gain());
            assert!((mean - 1.0).abs() < 1e-5, "{cone:?}: {mean}");
        }
    }

    #[test]
    fn rays_end_on_the_sphere() {
        for (distance, radius) in [(5.0f32, 0.004f32), (5.0, 0.5), (5.0, 4.9)] {
            let cone = LightCone::to_sphere(axis(), distance, radius);
            for sample in samples(&cone) {
                let on = sample.direction * sample.distance - axis() * distance;
                assert!((on.length() - radius).abs() < 5e-5 * distance, "{cone:?}: {}", on.length());
                assert!(sample.distance <= distance, "the far side");
            }
        }
        let within = LightCone::to_sphere(axis(), 2.0, 3.0);
        assert!(samples(&within).all(|sample| sample.distance == 0.0));
        let disc = LightCone::to_disc(axis(), 0.3);
        assert!(samples(&disc).all(|sample| sample.distance == f32::INFINITY));
    }

    #[test]
    fn without_extent_all_directions_are_the_axis() {
        for cone in [LightCone::to_disc(axis(), 0.0), LightCone::to_sphere(axis(), 3.0, 0.0)] {
            assert!(samples(&cone).all(|sample| sample.direction == axis()));
            assert_eq!((cone.gain(), cone.largest_cosine(Vec3::Y)), (1.0, axis().y));
        }
    }

    #[test]
    fn the_largest_cosine_is_that_of_the_nearest_direction() {
        for cone in cones() {
            for index in 0..64 {
                let n = sampling::sphere(sequence_point(index, 0, 1));
                let nearest = samples(&cone).map(|sample| n.dot(sample.direction)).fold(-1.0, f32::max);
                let largest = cone.largest_cosine(n);
                assert!((-1e-5..0.01).contains(&(largest - nearest)), "{cone:?} {n}: {largest} {nearest}");
            }
        }
    }
}
