//! The hash map of cells on the device, and the push constants of its passes.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};

use crate::settings::CellSettings;
use crate::vulkan::{Buffer, Device, Frame, Pass, VulkanError};

/// Words of a slot's sums. Twin: SUM_WORDS in shaders/include/cells.glsl.
const SUM_WORDS: u64 = 8;

/// `CellPush` in shaders/filters/cell_push.glsl.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub(super) struct CellPush {
    pub spread: f32,
    pub widening: f32,
    pub jitter: f32,
    pub jitters: u32,
    pub bits: u32,
    pub normal: u32,
    pub probes: u32,
    pub levels: u32,
    pub samples: u32,
    pub window: u32,
    pub growth: f32,
    pub life: u32,
    pub view: u32,
}

impl CellPush {
    /// For the view of this number.
    pub fn for_view(self, view: u32) -> Self {
        Self { view, ..self }
    }
}

/// The hash map on the device: shaders/include/cell_map.glsl.
pub(super) struct CellBuffers {
    keys: Buffer,
    sums: Buffer,
    means: Buffer,
    ages: Buffer,
    pub capacity: u32,
    is_cleared: bool,
}

impl CellBuffers {
    pub fn new(device: &Arc<Device>, settings: &CellSettings) -> Result<Self, VulkanError> {
        let capacity = settings.capacity.next_power_of_two();
        let buffer = |name, size| Buffer::new(device, name, u64::from(capacity) * size);
        Ok(Self {
            keys: buffer("cell_keys", 4)?,
            sums: buffer("cell_sums", 4 * SUM_WORDS)?,
            means: buffer("cell_means", 16)?,
            ages: buffer("cell_ages", 4)?,
            capacity,
            is_cleared: false,
        })
    }

    pub fn ages(&self) -> &Buffer {
        &self.ages
    }

    pub fn clear_once(&mut self, frame: &mut Frame<'_>) {
        if !self.is_cleared {
            for buffer in [&self.keys, &self.sums, &self.means, &self.ages] {
                frame.clear(buffer);
            }
            self.is_cleared = true;
        }
    }

    pub fn bind<'f>(&'f self, pass: Pass<'f>) -> Pass<'f> {
        pass.write("cell_keys", &self.keys).write("cell_sums", &self.sums).write("cell_means", &self.means)
    }
}
