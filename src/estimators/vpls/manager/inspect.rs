//! The contribution of each VPL to a surface point, on the CPU; and a warning if most slots carry no light.
//!
//! In: a surface point. Out: irradiance and visibility of each VPL, E = phi/pi <n_x,w>+ <n_y,-w>+ min(1/d^2, c) V.
//! Twin of shaders/estimators/vpls/gather.glsl.

use glam::Vec3;
use rayon::prelude::*;

use super::assignment::NONE;
use super::counters::VplCounters;
use super::upload::GpuVpl;
use super::vpl_manager::VplManager;
use crate::bvh::{Ray, World};
use crate::scene::{WorldSurface, luminance};

/// The contribution of one VPL to a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VplContribution {
    /// The VPL's slot.
    pub slot: u32,
    /// World position of the VPL, the end of its visibility ray.
    pub position: Vec3,
    /// Irradiance if it is visible, W/m^2, as far as thin surfaces between let it pass.
    pub irradiance: Vec3,
    /// Whether it is unoccluded.
    pub visible: bool,
}

impl VplManager {
    /// The VPLs of all sets that face a surface point, visible ones first, then by descending luminance. `clamp` is the bound c of the
    /// geometry term, 1/m^2; 0: unbounded.
    pub fn inspect(&self, world: World<'_>, at: &WorldSurface, clamp: f32) -> Vec<VplContribution> {
        let start = at.offset_position();
        let mut found: Vec<VplContribution> = (0..self.slots.len() as u32)
            .into_par_iter()
            .filter_map(|slot| self.gpu_vpl(world, slot))
            .map(|vpl| (vpl, contribution(&vpl, at, clamp)))
            .filter(|(_, irradiance)| *irradiance != Vec3::ZERO)
            .map(|(vpl, irradiance)| {
                let arrives = world.transmittance(&ray_to(&vpl, start));
                let visible = arrives != Vec3::ZERO;
                let irradiance = if visible { irradiance * arrives } else { irradiance };
                // Where a VPL at infinity is shown.
                let surface = &self.surfaces[vpl.slot as usize];
                let position = if vpl.at_infinity == 0 { vpl.position } else { surface.position };
                VplContribution { slot: vpl.slot, position, irradiance, visible }
            })
            .collect();
        found.sort_by(|a, b| {
            let brighter = luminance(b.irradiance).total_cmp(&luminance(a.irradiance));
            b.visible.cmp(&a.visible).then(brighter)
        });
        found
    }

    /// The slots of a VPL's path, from its first bounce to itself.
    pub fn path_to(&self, slot: u32) -> Vec<u32> {
        let parent = |&slot: &u32| {
            let address = self.assignment.addresses.get(slot as usize)?;
            (address.parent != NONE).then_some(address.parent)
        };
        let mut path: Vec<u32> = std::iter::successors(Some(slot), parent).collect();
        path.reverse();
        path
    }

    /// A warning if over half of all slots have no flux, with what to do about it. None in scenes without lights.
    pub fn wasted_slots_warning(&self) -> Option<String> {
        let VplCounters { slots, escaped, .. } = self.counters();
        let dark = self.slots().filter(|slot| slot.light.is_some() && slot.flux == Vec3::ZERO).count();
        let dark = dark as u32 / self.vpls_per_slot;
        if self.changes.emitters.is_empty() || 2 * dark <= slots {
            return None;
        }
        let mut reasons = Vec::new();
        if escaped > 0 {
            reasons.push(format!("{escaped} of {slots} VPL slots hold paths that left the scene"));
        }
        if dark > escaped {
            reasons.push(format!(
                "{} of {slots} VPL slots hold paths that end on black surfaces",
                dark - escaped
            ));
        }
        let reasons = reasons.join(", ");
        Some(format!(
            "{reasons}; for less noise aim the lights at surfaces, or give fewer --bounces or more --vpls"
        ))
    }
}

/// The ray from a point to a VPL.
fn ray_to(vpl: &GpuVpl, origin: Vec3) -> Ray {
    let (direction, t_max) = match vpl.at_infinity {
        0 => (vpl.position - origin, 1.0),
        _ => (vpl.position, f32::INFINITY),
    };
    Ray { origin, direction, t_min: 0.0, t_max }
}

/// Unoccluded irradiance at a surface point, W/m^2; `clamp` bounds the geometry term unless it is 0.
pub(crate) fn contribution(vpl: &GpuVpl, at: &WorldSurface, clamp: f32) -> Vec3 {
    if vpl.at_infinity != 0 {
        return vpl.flux * at.received(vpl.position);
    }
    let d = vpl.position - at.position;
    let squared = d.length_squared();
    if squared <= 0.0 {
        return Vec3::ZERO;
    }
    let (inverse, direction) = (1.0 / squared, d / squared.sqrt());
    let geometry = if clamp > 0.0 { inverse.min(clamp) } else { inverse };
    vpl.flux * vpl.lobe.density(vpl.normal, -direction) * (at.received(direction) * geometry)
}
