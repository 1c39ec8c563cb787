//! Asking the renderer about VPLs, where they are its estimator.

use super::manager::{Gathering, VplContribution, VplManager};
use super::{VplSettings, Vpls, geometry_bound, median_segment_length};
use crate::estimators::World;
use crate::renderer::{RenderError, Renderer};
use crate::scene::{Pose, WorldSurface};

impl Renderer {
    /// The VPLs as they are now; none with another estimator.
    pub fn vpls(&self) -> Option<&VplManager> {
        self.estimator::<Vpls>().map(Vpls::manager)
    }

    /// The VPLs that face a surface point, visible ones first, then by what they bring; what they bring
    /// together is the indirect irradiance there, once all sets have been drawn.
    pub fn inspect(&self, pose: &Pose, at: &WorldSurface) -> Vec<VplContribution> {
        let Some(vpls) = self.estimator::<Vpls>() else { return Vec::new() };
        let gathering = Gathering { clamp: vpls.geometry_bound(), scene_radius: vpls.scene_radius };
        vpls.manager.inspect(self.world(pose), at, &gathering)
    }

    /// How many sets have seen the surface of each pixel of the last frame; where they have half the resolution, about how many.
    ///
    /// # Errors
    /// Where the device fails.
    pub fn read_set_counts(&self) -> Result<Vec<u32>, RenderError> {
        Ok(self.read_irradiance_alpha()?.into_iter().map(|count| count.round() as u32).collect())
    }
}

/// Bound c of the geometry term of a renderer of this world, 1/m^2; 0: none.
pub(crate) fn geometry_bound_of(world: World<'_>, settings: &VplSettings, scene_radius: f32) -> f32 {
    geometry_bound(settings, median_segment_length(world).unwrap_or(scene_radius))
}
