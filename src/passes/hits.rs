//! Hits of reflection rays beyond the screen, for estimators to light.

use crate::vulkan::Image;

/// Surfaces that reflection rays have hit and that are not on the screen: shaders/include/hit_record.glsl.
pub struct Hits<'a> {
    /// Where they are: RGBA32UI.
    pub place: &'a Image,
    /// Weight of their irradiance in the reflection, and a random number from 0 to 1: RGBA16F.
    pub weight: &'a Image,
    /// The reflection, RGBA16F, to which their light is added.
    pub reflection: &'a Image,
}
