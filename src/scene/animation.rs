//! Keyframed and rotating motion.
//!
//! In: keyframes and a constant rotation. Out: the rigid motion at a time.
//! Positions follow a cubic Hermite spline with Catmull-Rom tangents (Catmull and Rom 1974, for
//! unevenly spaced keys), rotations are interpolated by slerp.

use glam::{Affine3A, Mat3A, Quat, Vec3, Vec3A};

/// The motion of a camera, light or instance, relative to its rest pose. Both parts may be present.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Animation {
    /// Keyframes, sorted by time; smoothly interpolated (Catmull-Rom, slerp), held before the first and after the
    /// last.
    pub keyframes: Vec<Keyframe>,
    /// Whether the keyframes are samples of a motion that may jump: between two that are [`JUMP`] apart, and at the end.
    pub sampled: bool,
    /// Constant rotation: axis (unit), radians a second, about `pivot` (world space).
    pub rotation: Option<Rotation>,
    /// Whether the keyframes repeat after the last one. Motion is continuous if the first and last key are equal.
    pub repeat: bool,
}

/// Time between the sides of a jump, seconds.
pub const JUMP: f64 = 1e-4;

/// One key of an animation.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Keyframe {
    /// Seconds.
    pub time: f64,
    /// Translation added to the rest position.
    pub translation: Vec3,
    /// Rotation applied about the object's own origin.
    pub rotation: Quat,
    /// How an object is scaled and sheared about its own origin before the rotation.
    pub stretch: Mat3A,
}

/// Constant rotation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rotation {
    /// Unit axis.
    pub axis: Vec3,
    /// Radians a second.
    pub speed: f32,
    /// A point on the axis, world space; none: the object's own origin.
    pub pivot: Option<Vec3>,
}

/// A motion, as what turns and stretches the object about its own origin, and the new position of that: exact at rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// Rotation about the object's own origin.
    pub rotation: Quat,
    /// Position of its origin, world space.
    pub position: Vec3,
    /// Scale and shear, before the rotation.
    pub stretch: Mat3A,
}

/// Least scale of an object that is scaled to nothing, or of its thickness over its size.
const LEAST_SCALE: f32 = 1e-6;

/// The matrix, or where it scales an axis to nothing one that has an inverse: by a little of `like` more, which turns
/// alike. A point is too small to be seen.
pub fn invertible(matrix: Mat3A, like: Mat3A) -> Mat3A {
    let largest = |m: Mat3A| m.to_cols_array().into_iter().fold(0.0f32, |most, v| most.max(v.abs()));
    let size = largest(matrix);
    if size > LEAST_SCALE && (matrix * (1.0 / size)).determinant().abs() > 1e-9 {
        return matrix;
    }
    let scale = if size > LEAST_SCALE { size } else { 1.0 } * LEAST_SCALE;
    matrix + like * (scale / largest(like))
}

impl Motion {
    /// A direction that turns and stretches along with the object; where that leaves nothing of it, it turns alone.
    pub fn turn(&self, direction: Vec3) -> Vec3 {
        let stretched = Vec3::from(self.stretch * Vec3A::from(direction));
        let is_left = stretched.length() > LEAST_SCALE * direction.length();
        self.rotation * if is_left { stretched } else { direction }
    }

    /// Object to world of an object with rest transform `rest`.
    pub fn transform(&self, rest: &Affine3A) -> Affine3A {
        let rotation = Mat3A::from_quat(self.rotation);
        let matrix3 = invertible(rotation * self.stretch * rest.matrix3, rotation * rest.matrix3);
        Affine3A { matrix3, translation: self.position.into() }
    }
}

impl Animation {
    /// The motion at `time` (seconds) of an object whose origin rests at `origin` (world space): first the keyed
    /// rotation about `origin`, then the constant rotation about its pivot, then the keyed translation.
    pub fn motion(&self, time: f64, origin: Vec3) -> Motion {
        let key = self.key_at(time);
        let mut motion = Motion { rotation: key.rotation, position: origin, stretch: key.stretch };
        if let Some(rotation) = &self.rotation {
            // Reduce the angle in f64, so that a long run stays exact.
            let angle = (f64::from(rotation.speed) * time).rem_euclid(std::f64::consts::TAU);
            let turn = Quat::from_axis_angle(rotation.axis, angle as f32);
            motion.rotation = turn * motion.rotation;
            if let Some(pivot) = rotation.pivot {
                motion.position = pivot + turn * (origin - pivot);
            }
        }
        motion.position += key.translation;
        motion
    }

    /// The interpolated key at `time`; the rest pose without keys.
    pub fn key_at(&self, time: f64) -> Keyframe {
        let keys = &self.keyframes;
        let time = self.key_time(time);
        let next = keys.partition_point(|key| key.time <= time);
        let (Some(first), Some(last)) = (keys.first(), keys.last()) else {
            return Keyframe { time, ..Keyframe::default() };
        };
        if next == 0 {
            return Keyframe { time, ..*first };
        }
        if next == keys.len() {
            return Keyframe { time, ..*last };
        }
        let (a, b) = (&keys[next - 1], &keys[next]);
        let span = b.time - a.time;
        let s = ((time - a.time) / span) as f32;
        let tangent = |i: usize| self.tangent(i, span);
        Keyframe {
            time,
            translation: hermite([a.translation, b.translation], [tangent(next - 1), tangent(next)], s),
            rotation: a.rotation.slerp(b.rotation, s).normalize(),
            stretch: a.stretch + (b.stretch - a.stretch) * s,
        }
    }

    /// Wraps `time` into the range of the keys if they repeat.
    fn key_time(&self, time: f64) -> f64 {
        match (self.keyframes.first(), self.keyframes.last()) {
            (Some(first), Some(last)) if self.repeat && last.time > first.time => {
                first.time + (time - first.time).rem_euclid(last.time - first.time)
            }
            _ => time,
        }
    }

    /// Catmull-Rom tangent at key `i`, the slope between its neighbours, in scene units per `span` seconds.
    fn tangent(&self, i: usize, span: f64) -> Vec3 {
        let keys = &self.keyframes;
        let last = keys.len() - 1;
        let [mut before, mut after] = [keys[i.saturating_sub(1)], keys[(i + 1).min(last)]];
        // With repetition, the last key but one precedes the first, and the second follows the last.
        if self.sampled {
            // A jump has a slope on either side.
            let is_jump = |a: &Keyframe, b: &Keyframe| b.time - a.time < 1.5 * JUMP;
            before = if is_jump(&before, &keys[i]) { keys[i] } else { before };
            after = if is_jump(&keys[i], &after) { keys[i] } else { after };
            if before.time == after.time {
                return Vec3::ZERO;
            }
        } else if self.repeat && last > 0 && (i == 0 || i == last) {
            let [before_offset, after_offset] =
                [keys[last - 1].time - keys[last].time, keys[1].time - keys[0].time];
            before = Keyframe { time: keys[i].time + before_offset, ..keys[last - 1] };
            after = Keyframe { time: keys[i].time + after_offset, ..keys[1] };
        }
        // The ratio of two times stays in range of f32 where the times do not.
        (after.translation - before.translation) * (span / (after.time - before.time)) as f32
    }
}

fn hermite(ends: [Vec3; 2], tangents: [Vec3; 2], s: f32) -> Vec3 {
    let (s2, s3) = (s * s, s * s * s);
    ends[0] * (2.0 * s3 - 3.0 * s2 + 1.0)
        + tangents[0] * (s3 - 2.0 * s2 + s)
        + ends[1] * (3.0 * s2 - 2.0 * s3)
        + tangents[1] * (s3 - s2)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn key(time: f64, translation: Vec3, degrees: f32) -> Keyframe {
        let rotation = Quat::from_rotation_y(degrees.to_radians());
        Keyframe { time, translation, rotation, ..Keyframe::default() }
    }

    #[test]
    fn passes_through_keys_and_holds_outside() {
        let keys =
            [key(1.0, Vec3::X, 0.0), key(2.0, Vec3::new(3.0, 1.0, 0.0), 90.0), key(4.0, Vec3::Z, 180.0)];
        let animation = Animation { keyframes: keys.to_vec(), ..Animation::default() };
        for expected in &keys {
            let got = animation.key_at(expected.time);
            assert!(got.translation.distance(expected.translation) < 1e-6);
            assert!(got.rotation.dot(expected.rotation).abs() > 1.0 - 1e-6);
        }
        assert_eq!(animation.key_at(-5.0).translation, Vec3::X);
        assert_eq!(animation.key_at(50.0).translation, Vec3::Z);
    }

    #[test]
    fn evenly_keyed_line_is_uniform_motion() {
        let keyframes = (0..5).map(|i| key(f64::from(i), Vec3::X * i as f32, 0.0)).collect();
        let animation = Animation { keyframes, ..Animation::default() };
        for i in 0..=40 {
            let time = f64::from(i) * 0.1;
            assert!((animation.key_at(time).translation.x - time as f32).abs() < 1e-5);
        }
    }

    #[test]
    fn repeated_keys_start_over_without_a_jump() {
        let ring = [Vec3::X, Vec3::Z, Vec3::NEG_X, Vec3::NEG_Z, Vec3::X];
        let keyframes = (0u8..5).map(|i| key(2.0 + f64::from(i), ring[usize::from(i)], 0.0)).collect();
        let animation = Animation { keyframes, repeat: true, ..Animation::default() };
        let at = |time: f64| animation.key_at(time).translation;
        for time in [2.0, 2.3, 5.9, 6.0] {
            assert!(at(time).distance(at(time + 4.0)) < 1e-6);
            assert!(at(time).distance(at(time - 8.0)) < 1e-6);
        }
        let velocity = |time: f64| (at(time + 1e-3) - at(time)) / 1e-3;
        assert!(velocity(6.0 - 1.1e-3).distance(velocity(6.0)) < 2e-2);
    }

    #[test]
    fn velocity_is_continuous_at_uneven_keys() {
        let keyframes = vec![
            key(0.0, Vec3::ZERO, 0.0),
            key(1.0, Vec3::X, 0.0),
            key(4.0, Vec3::Y, 0.0),
            key(5.0, Vec3::Z, 0.0),
        ];
        let animation = Animation { keyframes, ..Animation::default() };
        let at = |time: f64| animation.key_at(time).translation;
        for knot in [1.0, 4.0] {
            let before = (at(knot) - at(knot - 1e-3)) / 1e-3;
            let after = (at(knot + 1e-3) - at(knot)) / 1e-3;
            assert!(before.distance(after) < 1e-2, "{before} {after}");
        }
    }

    #[test]
    fn very_short_and_long_spans_stay_finite() {
        for end in [1e-310, 1e-30, 1e9] {
            let keyframes = vec![key(0.0, Vec3::ZERO, 0.0), key(end, Vec3::X, 90.0), key(2e9, Vec3::Y, 0.0)];
            let animation = Animation { keyframes, ..Animation::default() };
            for share in [0.0, 0.25, 1.0] {
                let key = animation.key_at(share * end);
                assert!(key.translation.is_finite() && key.rotation.is_finite(), "{key:?} of {end}");
                assert!(key.translation.length() < 2.0, "{key:?} of {end}");
            }
        }
    }

    #[test]
    fn constant_rotation_is_about_its_pivot() {
        let rotation = Rotation { axis: Vec3::Y, speed: std::f32::consts::FRAC_PI_2, pivot: Some(Vec3::X) };
        let animation = Animation { rotation: Some(rotation), ..Animation::default() };
        let motion = animation.motion(1.0, Vec3::new(2.0, 5.0, 0.0));
        let expected = Vec3::new(1.0, 5.0, -1.0);
        assert!(motion.position.distance(expected) < 1e-5, "{motion:?}");
        assert!((motion.rotation * Vec3::X).distance(Vec3::NEG_Z) < 1e-6);
        let own = Animation { rotation: Some(Rotation { pivot: None, ..rotation }), ..animation };
        let origin = Vec3::new(7.0, 0.1, 3.3);
        assert_eq!(own.motion(0.7, origin).position, origin);
    }

    #[test]
    fn rest_is_exactly_rest() {
        let animation = Animation { keyframes: vec![key(0.0, Vec3::ZERO, 0.0)], ..Animation::default() };
        let rest = Affine3A::from_rotation_translation(Quat::from_rotation_x(0.3), Vec3::new(0.1, 0.2, 0.3));
        let motion = animation.motion(3.0, rest.translation.into());
        assert_eq!(motion.transform(&rest), rest);
    }

    #[test]
    fn halfway_slerp_is_half_the_angle() {
        let animation = Animation {
            keyframes: vec![key(0.0, Vec3::ZERO, 0.0), key(1.0, Vec3::ZERO, 90.0)],
            ..Animation::default()
        };
        let half = animation.key_at(0.5).rotation;
        assert!(half.angle_between(Quat::from_rotation_y(45f32.to_radians())) < 1e-3);
    }
}
