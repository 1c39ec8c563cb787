//! Keyframed and rotating motion.

use glam::{Quat, Vec3};

/// How a camera, light or instance moves, relative to its rest pose. Both parts may be present.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Animation {
    /// Keyframes, sorted by time; smoothly interpolated (Catmull-Rom, slerp), held before the first and after the last.
    pub keyframes: Vec<Keyframe>,
    /// Constant rotation: axis (unit), radians a second, about `pivot` (world space).
    pub rotation: Option<Rotation>,
}

/// One key of an animation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Keyframe {
    /// Seconds.
    pub time: f64,
    /// Translation added to the rest position.
    pub translation: Vec3,
    /// Rotation applied about the object's own origin.
    pub rotation: Quat,
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
