//! Questions about VPLs: which of them light a point, and how much.

use super::Vpls;
use super::manager::VplContribution;
use super::scale::{geometry_bound, median_segment_length};
use crate::estimators::World;
use crate::scene::WorldSurface;
use crate::settings::VplSettings;

impl Vpls {
    /// The VPLs that face a surface point, visible ones first, then by their irradiance. The sum of these is the indirect
    /// irradiance there, once all sets have been rendered.
    pub fn inspect(&self, world: World<'_>, at: &WorldSurface) -> Vec<VplContribution> {
        self.manager.inspect(world, at, self.geometry_bound())
    }
}

/// Bound c of the geometry term of a renderer of this world, 1/m^2; 0: none.
pub(crate) fn geometry_bound_of(world: World<'_>, settings: &VplSettings, scene_radius: f32) -> f32 {
    geometry_bound(settings, median_segment_length(world).unwrap_or(scene_radius))
}
