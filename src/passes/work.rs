//! How the threads of a dispatch come by their work, where that makes a difference.
//!
//! In: how many groups of threads there is work for. Out: how many threads to start, and what shaders/include/work.glsl has
//! to know. llvmpipe gives each of its threads an equal share of a dispatch's workgroups and waits for the last. There, a
//! thread takes whatever nobody has taken yet from a queue (persistent threads, Aila and Laine 2009), so that one that is
//! held up, or meets what takes long, does less. GPUs share out workgroups as they go.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};

use crate::vulkan::{Buffer, Device, Frame, VulkanError};

/// Threads of a group. Twin: `GROUP` in shaders/include/work.glsl.
const GROUP: u32 = 64;

/// Threads that are started for each that would do if all took the same time. So much less work than its share must a
/// thread of the driver get done before others run out of theirs.
const SPARE: u32 = 2;

/// Counts what has been taken of a dispatch's work, on CPU devices.
pub struct WorkQueue {
    taken: Buffer,
    is_cpu: bool,
}

/// The work of one dispatch, as shaders see it.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct Work {
    /// Groups of threads that there is work for.
    groups: u32,
    /// Groups that a thread works for, one after the other. If 1, threads have their work by their number.
    at_once: u32,
}

impl WorkQueue {
    /// Makes the counter.
    pub fn new(device: &Arc<Device>) -> Result<Self, VulkanError> {
        let taken = Buffer::new(device, "work_taken", size_of::<u32>() as u64)?;
        Ok(Self { taken, is_cpu: device.is_cpu() })
    }

    /// Work for `groups` groups of 64 threads in the next dispatch; on CPU devices a thread takes that of `at_once` groups at
    /// a time.
    pub fn share_out(&self, frame: &mut Frame<'_>, groups: u32, at_once: u32) -> Work {
        if !self.is_cpu || at_once <= 1 {
            return Work { groups, at_once: 1 };
        }
        frame.clear(&self.taken);
        Work { groups, at_once }
    }

    /// The counter, to be bound as `work_taken`.
    pub fn taken(&self) -> &Buffer {
        &self.taken
    }
}

impl Work {
    /// Threads to start, at most `row` workgroups side by side.
    pub fn threads(&self, row: u32) -> [u32; 3] {
        let groups = match self.at_once {
            1 => self.groups,
            at_once => self.groups.div_ceil(at_once) * SPARE,
        };
        [groups.min(row) * GROUP, groups.div_ceil(row), 1]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_group_is_worked_for_once() {
        for groups in [1, 2, 63, 64, 1_000, 65_536] {
            for (at_once, row) in [(1, 1), (1, 48), (2, 7), (16, 512), (64, 65_535)] {
                let work = Work { groups, at_once };
                let [x, y, z] = work.threads(row);
                assert!(x % GROUP == 0 && x / GROUP <= row && z == 1, "{work:?}");
                let numbers = 0..x / GROUP * y;
                let pieces = groups.div_ceil(at_once);
                assert!(at_once == 1 || numbers.end >= SPARE * pieces, "{work:?}");
                // As shaders/include/work.glsl has it.
                let shares = numbers.map(|number| (number * at_once, (number + 1) * at_once));
                let met = shares.flat_map(|(first, end)| first..end.min(groups));
                assert!(met.eq(0..groups), "{work:?}");
            }
        }
    }
}
