//! The VPLs of one temporal set as the shaders read them.
//!
//! In: the slots and the current pose. Out: positions, normals and flux of the valid ones. The flux of a
//! VPL is that of its light, over the number of slots of its light and bounce that are not invalid, times its
//! throughput, so the others compensate for invalid slots (docs/VPLS.md, "Energy").

use bytemuck::{Pod, Zeroable};
use glam::Vec3;

use super::assignment::NONE;
use super::emitter::{Sky, Source};
use super::glossy_lobe::GlossyLobe;
use super::slots::{SlotHistory, SlotState, SlotView};
use super::vpl_manager::VplManager;
use crate::bvh::World;
use crate::scene::{BoundingSphere, luminance};

/// A VPL as the shaders see it (std430, 64 bytes).
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct GpuVpl {
    /// World position, a ray offset above the surface; at infinity the unit direction towards it.
    pub position: Vec3,
    /// Slot index.
    pub slot: u32,
    /// Unit geometric normal of the emitting side.
    pub normal: Vec3,
    /// Bounce, 0 for a primary VPL of an area light or environment.
    pub bounce: u32,
    /// Flux phi, W; at infinity the irradiance across its direction, W/m^2.
    pub flux: Vec3,
    /// 1: a direction instead of a place.
    pub at_infinity: u32,
    /// Lobe of a glossy surface.
    pub lobe: GlossyLobe,
}

impl VplManager {
    /// The valid VPLs with non-zero flux of temporal set `set`, at their current positions, sorted along a curve through space:
    /// neighbours in the list are neighbours in the scene.
    pub fn set_vpls(&self, world: World<'_>, set: u32) -> Vec<GpuVpl> {
        let mut vpls: Vec<GpuVpl> =
            self.layout.set_slots(set).filter_map(|slot| self.gpu_vpl(world, slot)).collect();
        let BoundingSphere { center, radius } = self.changes.bounds;
        let place = |vpl: &GpuVpl| (vpl.position - center) / (2.0 * radius) + 0.5;
        // VPLs at infinity come last, sorted by their direction.
        let code = |vpl: &GpuVpl| match vpl.at_infinity {
            0 => morton_code(place(vpl)),
            _ => morton_code(0.5 * vpl.position + 0.5),
        };
        vpls.sort_by_cached_key(|vpl| (vpl.at_infinity, code(vpl), vpl.slot));
        vpls
    }

    /// Luminous flux of the valid VPLs of each temporal set; of one at infinity that through the middle of the scene.
    pub fn set_flux(&self) -> Vec<f32> {
        let flux = |slot: u32| {
            let index = slot as usize;
            luminance(self.flux(index)) * self.sky_of(index).map_or(1.0, Sky::core_area)
        };
        (0..self.layout.sets).map(|set| self.layout.set_slots(set).map(flux).sum()).collect()
    }

    /// The environment that a VPL at infinity belongs to; none for others.
    fn sky_of(&self, index: usize) -> Option<&Sky> {
        match &self.changes.emitters.get(self.assignment.addresses[index].light as usize)?.source {
            Source::Environment(sky) if self.slots[index].is_at_infinity() => Some(sky),
            _ => None,
        }
    }

    /// All slots, for tests and debug views.
    pub fn slots(&self) -> impl Iterator<Item = SlotView> + '_ {
        self.assignment.addresses.iter().enumerate().map(|(index, address)| {
            let (slot, surface) = (&self.slots[index], &self.surfaces[index]);
            SlotView {
                slot: index as u32,
                state: slot.state,
                light: (address.light != NONE).then_some(address.light),
                path: address.path,
                bounce: address.bounce,
                parent: (address.parent != NONE).then_some(address.parent),
                at_infinity: slot.is_at_infinity(),
                position: surface.position,
                normal: surface.geometric_normal,
                flux: self.flux(index),
                useful: slot.useful,
                stale: address.light != NONE && !slot.fresh,
                set: self.layout.set(index as u32),
                origin: self.origin(index),
            }
        })
    }

    /// History of a slot; none if there is no such slot.
    pub fn history(&self, slot: u32) -> Option<SlotHistory> {
        let shot = self.slots.get(slot as usize)?.shot;
        Some(SlotHistory { age: self.frame - shot, invalidation: self.invalidations[slot as usize] })
    }

    /// World position of the parent or light of a slot's VPL.
    pub(super) fn origin(&self, index: usize) -> Vec3 {
        let (address, surface) = (&self.assignment.addresses[index], &self.surfaces[index]);
        if address.parent != NONE {
            return self.surfaces[address.parent as usize].position;
        }
        match self.changes.emitters.get(address.light as usize).map(|emitter| &emitter.source) {
            Some(Source::Point { position } | Source::Spot { position, .. }) => *position,
            Some(Source::Directional { frame, .. }) => {
                surface.position - frame.normal * (0.5 * self.changes.bounds.radius)
            }
            Some(Source::Area(_) | Source::Environment(_)) | None => surface.position,
        }
    }

    /// The VPL of a slot at its current position; none if it has no flux or there is no such slot.
    pub fn gpu_vpl(&self, world: World<'_>, slot: u32) -> Option<GpuVpl> {
        let index = slot as usize;
        let stored = self.slots.get(index)?;
        let flux = self.flux(index);
        if flux == Vec3::ZERO {
            return None;
        }
        let address = &self.assignment.addresses[index];
        let surface = stored.surface(world, address, &self.changes.emitters);
        let normal = surface.geometric_normal;
        let vpl = GpuVpl {
            position: surface.offset_position(),
            slot,
            normal,
            bounce: address.bounce,
            flux,
            at_infinity: 0,
            lobe: stored.lobe,
        };
        Some(match self.sky_of(index) {
            Some(sky) => {
                let flux = flux * sky.irradiance_of_flux();
                GpuVpl { position: -normal, flux, at_infinity: 1, ..vpl }
            }
            None => vpl,
        })
    }

    /// Flux of a slot's VPL, W; zero unless it is valid and shines.
    fn flux(&self, index: usize) -> Vec3 {
        let (slot, address) = (&self.slots[index], &self.assignment.addresses[index]);
        if slot.state != SlotState::Valid {
            return Vec3::ZERO;
        }
        let (light, bounce) = (address.light as usize, address.bounce as usize);
        let on_area = bounce == 0 && matches!(self.changes.emitters[light].source, Source::Area(_));
        if on_area && !self.area_lights_shine {
            return Vec3::ZERO;
        }
        let share = self.flux_corrections[light][bounce] / self.live[light][bounce] as f32;
        self.changes.emitters[light].flux * share * slot.throughput * slot.gain
    }
}

/// The Z-order curve (Morton 1966): of a point of the unit cube, 10 bits of each coordinate, interleaved.
fn morton_code(p: Vec3) -> u32 {
    let spread = |coordinate: f32| {
        let bits = (coordinate * 1024.0).clamp(0.0, 1023.0) as u32;
        (0..10).fold(0, |code, bit| code | (bits >> bit & 1) << (3 * bit))
    };
    spread(p.x) | spread(p.y) << 1 | spread(p.z) << 2
}
