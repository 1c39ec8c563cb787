//! The VPLs of one temporal set as the shaders read them, class by class.
//!
//! In: the slots and the current pose. Out: positions, normals and flux of the valid ones. The flux of a
//! VPL is that of its light, over the number of slots of its light and bounce that are not invalid, times its
//! throughput, so the others compensate for invalid slots (ARCHITECTURE.md, "Energy").

use glam::Vec3;

use super::assignment::NONE;
use super::emitter::Source;
use super::invalidate::locate;
use super::slots::{SlotHistory, SlotState, SlotView};
use super::{CellFlux, GpuVpl, SetVpls, VplManager, World};
use crate::scene::luminance;

impl VplManager {
    /// The valid VPLs with non-zero flux of temporal set `set`, at their current positions.
    pub fn set_vpls(&self, world: World<'_>, set: u32) -> SetVpls {
        let layout = &self.layout;
        let classes = layout.classes as usize;
        let mut result = SetVpls {
            vpls: Vec::with_capacity((layout.slots / layout.sets + 1) as usize),
            class_starts: Vec::with_capacity(classes + 1),
        };
        for class in 0..layout.classes {
            result.class_starts.push(result.vpls.len() as u32);
            let slots: &[u32] =
                if set < layout.sets { self.assignment.cell(layout, set, class) } else { &[] };
            result.vpls.extend(slots.iter().filter_map(|&slot| self.gpu_vpl(world, slot)));
        }
        result.class_starts.push(result.vpls.len() as u32);
        result
    }

    /// Luminous flux of the valid VPLs of each temporal set, and of each pixel class over all sets.
    pub fn flux_by_cell(&self) -> CellFlux {
        let layout = &self.layout;
        let mut flux =
            CellFlux { sets: vec![0.0; layout.sets as usize], classes: vec![0.0; layout.classes as usize] };
        for set in 0..layout.sets {
            for class in 0..layout.classes {
                let cell: f32 = self
                    .assignment
                    .cell(layout, set, class)
                    .iter()
                    .map(|&slot| luminance(self.flux(slot as usize)))
                    .sum();
                flux.sets[set as usize] += cell;
                flux.classes[class as usize] += cell;
            }
        }
        flux
    }

    /// Luminous flux of all valid VPLs, the sum over all temporal sets.
    pub fn total_flux(&self, _world: World<'_>) -> f32 {
        let flux = (0..self.slots.len()).map(|slot| f64::from(luminance(self.flux(slot))));
        flux.sum::<f64>() as f32
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
                position: surface.position,
                normal: surface.normal,
                flux: self.flux(index),
                stale: address.light != NONE && !slot.fresh,
                set: self.layout.cell(index as u32).0,
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
            Some(Source::Area(_)) | None => surface.position,
        }
    }

    /// The VPL of a slot at its current position; none if it has no flux or there is no such slot.
    pub fn gpu_vpl(&self, world: World<'_>, slot: u32) -> Option<GpuVpl> {
        let index = slot as usize;
        if index >= self.slots.len() {
            return None;
        }
        let flux = self.flux(index);
        if flux == Vec3::ZERO {
            return None;
        }
        let address = &self.assignment.addresses[index];
        let surface = locate(world, &self.slots[index], address);
        Some(GpuVpl {
            position: surface.position,
            slot,
            normal: surface.normal,
            bounce: address.bounce,
            flux,
            _pad: 0,
        })
    }

    /// Flux of a slot's VPL, W; zero unless valid.
    fn flux(&self, index: usize) -> Vec3 {
        let (slot, address) = (&self.slots[index], &self.assignment.addresses[index]);
        if slot.state != SlotState::Valid {
            return Vec3::ZERO;
        }
        let (light, bounce) = (address.light as usize, address.bounce as usize);
        let share = self.flux_corrections[light][bounce] / self.live[light][bounce] as f32;
        self.changes.emitters[light].flux * share * slot.throughput
    }
}
