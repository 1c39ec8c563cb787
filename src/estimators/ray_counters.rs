//! Counts of rays that shaders cast: shaders/include/ray_counter.glsl.

use std::sync::Arc;

use crate::vulkan::{Buffer, Device, Frame, VulkanError};

/// Sums that workgroups share their rays out to, 64 bits each. Twin: shaders/include/ray_counter.glsl.
const RAY_COUNTERS: u64 = 32;

/// The rays of a frame.
#[derive(Clone)]
pub struct RayCounters(Arc<Buffer>);

impl RayCounters {
    /// Makes the sums, and so many words of other counts behind them.
    ///
    /// # Errors
    /// Where the device lacks memory.
    pub fn new(device: &Arc<Device>, more: u64) -> Result<Self, VulkanError> {
        Ok(Self(Arc::new(Buffer::new(device, "ray_counters", RAY_COUNTERS * 8 + more * 4)?)))
    }

    /// Begins to count the rays of a frame.
    pub fn begin(&self, frame: &mut Frame<'_>) {
        frame.clear(&self.0);
    }

    /// The sums that shaders write, and that are read back.
    pub fn buffer(&self) -> &Buffer {
        &self.0
    }

    /// The rays that were read back.
    pub fn sum(read_back: &[u8]) -> u64 {
        let (words, _) = read_back.as_chunks();
        words.iter().take(RAY_COUNTERS as usize).map(|word| u64::from_le_bytes(*word)).sum()
    }

    /// The other counts that were read back.
    pub fn more(read_back: &[u8]) -> impl Iterator<Item = u32> {
        let (words, _) = read_back.as_chunks();
        words.iter().skip(2 * RAY_COUNTERS as usize).map(|word| u32::from_le_bytes(*word))
    }
}
