//! Light sources and their radiometry (DESIGN section "Lights").

use glam::Vec3;

use super::animation::Animation;

/// What kind of source a light is, with its power.
#[derive(Clone, Debug, PartialEq)]
pub enum LightKind {
    /// Intensity in W/sr, the same in all directions; flux 4 pi I.
    Point {
        /// W/sr.
        intensity: Vec3,
    },
    /// Intensity along the axis in W/sr, full within the inner cone, falling to zero at the outer by
    /// smoothstep in the cosine.
    Spot {
        /// W/sr on the axis.
        intensity: Vec3,
        /// Half angle of the inner cone, radians.
        inner_angle: f32,
        /// Half angle of the outer cone, radians, greater than the inner and less than pi.
        outer_angle: f32,
    },
    /// Irradiance in W/m^2 on a plane across the direction.
    Directional {
        /// W/m^2.
        irradiance: Vec3,
    },
    /// The emissive triangles of an instance, on their front sides.
    Area {
        /// Index into `Scene::instances`.
        instance: usize,
        /// Its emissive triangles.
        triangles: Vec<AreaTriangle>,
    },
}

/// One emissive triangle of an area light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AreaTriangle {
    /// Index into the instance's mesh's triangles.
    pub triangle: u32,
    /// Radiance, W/m^2/sr.
    pub radiance: Vec3,
}

/// A light source. Position and direction are in world space and unused where the kind has none.
#[derive(Clone, Debug, PartialEq)]
pub struct Light {
    /// Name in the scene file.
    pub name: String,
    /// Kind and power.
    pub kind: LightKind,
    /// World position (point, spot).
    pub position: Vec3,
    /// Unit direction in which the light travels (spot axis, directional).
    pub direction: Vec3,
    /// How it moves, if it does.
    pub animation: Option<Animation>,
}
