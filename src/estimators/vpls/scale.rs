//! The scale of a scene: a typical distance, the bound of the geometry term that follows, and powers of two.

use std::borrow::Cow;

use super::manager::{SlotState, SlotView, VplManager, median_length};
use crate::bvh::World;
use crate::settings::{Settings, VplSettings};

/// Bound c of the geometry term, 1/m^2, where surfaces that light each other are about `length` apart; 0: none.
pub(super) fn geometry_bound(settings: &VplSettings, length: f32) -> f32 {
    settings.clamp / length.powi(2)
}

/// Powers of two scale without rounding. 1 for what is no positive number.
fn power_of_two_near(value: f32) -> f32 {
    if value.is_normal() { value.log2().round().clamp(-100.0, 100.0).exp2() } else { 1.0 }
}

/// Factor of irradiance in images: the irradiance of all VPLs of these luminous fluxes, spread over surfaces a typical `length` apart,
/// is brought near 1 by a power of two, so that half floats neither overflow nor lose digits, whatever the scene's units.
pub(super) fn irradiance_scale(flux: &[f32], length: f32) -> f32 {
    power_of_two_near(flux.iter().sum::<f32>() / (6.0 * length * length)).recip()
}

/// Median distance from a VPL to its parent VPL in the scene without animation: a length that, unlike the bounds, neither a
/// large ground plane nor a sky dome changes. None where no VPL has a parent on a surface.
pub(super) fn median_segment_length(world: World<'_>) -> Option<f32> {
    let pose = world.scene.pose(0.0);
    let mut bvh = Cow::Borrowed(world.bvh);
    if pose.instances != world.pose.instances {
        bvh.to_mut().update(&pose.instances);
    }
    let vpl =
        VplSettings { slots: 1024, pool: 1024, candidates: 1, temporal_sets: 1, ..VplSettings::default() };
    let settings = Settings { bounces: 2, vpl, ..Settings::default() };
    let manager = VplManager::new(World { scene: world.scene, pose: &pose, bvh: &bvh }, &settings);
    let slots: Vec<SlotView> = manager.slots().collect();
    let lengths: Vec<f32> = slots
        .iter()
        .filter(|slot| slot.state == SlotState::Valid)
        .filter_map(|slot| Some((slot, &slots[slot.parent? as usize])))
        .filter(|(_, parent)| !parent.at_infinity)
        .map(|(slot, parent)| slot.position.distance(parent.position))
        .collect();
    median_length(&lengths)
}
