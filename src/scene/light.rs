//! Light sources and their radiometry.

use std::ops::{Add, Mul, Sub};

use glam::{Vec2, Vec3};
use serde::{Deserialize, Serialize};

use super::animation::Animation;
pub use crate::sampling::SpotFalloff;

/// Type and power of a light.
#[derive(Clone, Debug, PartialEq)]
pub enum LightKind {
    /// Intensity in W/sr, the same in all directions; flux 4 pi I.
    Point {
        /// W/sr.
        intensity: Vec3,
    },
    /// Intensity along the axis in W/sr, full within the inner cone, falling to zero at the outer.
    Spot {
        /// W/sr on the axis.
        intensity: Vec3,
        /// Half angle of the inner cone, radians.
        inner_angle: f32,
        /// Half angle of the outer cone, radians, greater than the inner and less than pi.
        outer_angle: f32,
        /// How it falls.
        falloff: SpotFalloff,
    },
    /// Irradiance in W/m^2 on a plane perpendicular to the direction.
    Directional {
        /// W/m^2.
        irradiance: Vec3,
    },
    /// The emissive triangles of an instance.
    Area {
        /// Index into `Scene::instances`.
        instance: usize,
        /// Emissive triangles.
        triangles: Vec<AreaTriangle>,
    },
}

impl SpotFalloff {
    /// Share of the intensity at t, 0 to 1.
    pub fn at(self, t: f64) -> f64 {
        match self {
            Self::Smooth => t * t * (3.0 - 2.0 * t),
            Self::Square => t * t,
        }
    }
}

/// Types of lights.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum LightType {
    /// Equal intensity in all directions.
    #[default]
    Point,
    /// A cone.
    Spot,
    /// Parallel light from infinity.
    Directional,
    /// A surface.
    Area,
}

/// An emissive triangle of an area light, or a piece of one whose texture varies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AreaTriangle {
    /// Index into the instance's mesh's triangles.
    pub triangle: u32,
    /// The side that emits; where both do, each has an entry.
    pub front: bool,
    /// Corners within that triangle: the weights of the second and of the third vertex.
    pub corners: [Vec2; 3],
    /// Radiance times the share of it that is there, the mean over its textures, W/m^2/sr.
    pub radiance: Vec3,
}

impl AreaTriangle {
    /// The corners of a whole triangle of a mesh.
    pub const WHOLE: [Vec2; 3] = [Vec2::ZERO, Vec2::X, Vec2::Y];

    /// The index of its triangle, and whether it is its front.
    pub fn side(&self) -> (u32, bool) {
        (self.triangle, self.front)
    }

    /// Interpolates a value of the vertices to its corners.
    pub fn interpolate<T: Copy + Add<Output = T> + Sub<Output = T> + Mul<f32, Output = T>>(
        &self,
        [a, b, c]: [T; 3],
    ) -> [T; 3] {
        self.corners.map(|weights| a + (b - a) * weights.x + (c - a) * weights.y)
    }

    /// The barycentrics in the mesh's triangle of a point with these in the piece.
    pub fn barycentrics(&self, weights: Vec2) -> Vec2 {
        let [a, b, c] = self.corners;
        a + (b - a) * weights.x + (c - a) * weights.y
    }

    /// How far a point with these barycentrics in the mesh's triangle lies within the piece: its least weight there.
    pub fn depth_of(&self, barycentrics: Vec2) -> f32 {
        let [a, b, c] = self.corners;
        let (u, v, p) = (b - a, c - a, barycentrics - a);
        let weights = Vec2::new(p.perp_dot(v), u.perp_dot(p)) / u.perp_dot(v);
        weights.min_element().min(1.0 - weights.element_sum())
    }
}

/// A light source. Position and direction are in world space; these and its extent are unused where the kind has none.
#[derive(Clone, Debug, PartialEq)]
pub struct Light {
    /// Name in the scene file.
    pub name: String,
    /// Type and power.
    pub kind: LightKind,
    /// World position (point, spot).
    pub position: Vec3,
    /// Unit direction in which the light travels (spot axis, directional).
    pub direction: Vec3,
    /// Radius of the sphere that shines (point, spot), world units; 0 for a point. See [`super::LightCone`].
    pub radius: f32,
    /// Half angle of the disc that shines (directional), radians, at most pi/2; 0 for parallel light.
    pub half_angle: f32,
    /// Animation, if any; an area light moves with its instance instead.
    pub animation: Option<Animation>,
}

impl Light {
    /// Whether it shines from more than a point or a direction, so that its shadows are soft.
    pub fn has_extent(&self) -> bool {
        match self.kind {
            LightKind::Area { .. } => true,
            LightKind::Directional { .. } => self.half_angle > 0.0,
            LightKind::Point { .. } | LightKind::Spot { .. } => self.radius > 0.0,
        }
    }
}

/// Luminance of linear RGB (Rec. 709).
pub fn luminance(rgb: Vec3) -> f32 {
    rgb.dot(Vec3::new(0.2126, 0.7152, 0.0722))
}

/// Intensity of a spot light relative to its axis, at an angle with cosine `cos` to the axis: 1 inside the inner cone,
/// 0 outside the outer. Angles in radians.
pub fn spot_falloff(cos: f32, inner_angle: f32, outer_angle: f32, falloff: SpotFalloff) -> f32 {
    let (cos_inner, cos_outer) = (inner_angle.cos(), outer_angle.cos());
    let t = ((cos - cos_outer) / (cos_inner - cos_outer)).clamp(0.0, 1.0);
    falloff.at(f64::from(t)) as f32
}

impl Light {
    /// The light at `time` (seconds), moved by its animation.
    pub fn at(&self, time: f64) -> Light {
        let mut light = self.clone();
        if let Some(animation) = &self.animation {
            let motion = animation.motion(time, self.position);
            light.position = motion.position;
            light.direction = motion.turn(self.direction).normalize_or(self.direction);
        }
        light
    }
}
