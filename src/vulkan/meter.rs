//! Current and peak device memory.

use std::sync::atomic::{AtomicU64, Ordering};

/// Bytes of buffers and images.
#[derive(Debug, Default)]
pub(super) struct MemoryMeter {
    now: AtomicU64,
    peak: AtomicU64,
}

impl MemoryMeter {
    pub(super) fn add(&self, bytes: u64) {
        let now = self.now.fetch_add(bytes, Ordering::Relaxed) + bytes;
        self.peak.fetch_max(now, Ordering::Relaxed);
    }

    pub(super) fn remove(&self, bytes: u64) {
        self.now.fetch_sub(bytes, Ordering::Relaxed);
    }

    pub(super) fn peak(&self) -> u64 {
        self.peak.load(Ordering::Relaxed)
    }

    /// Resets the peak to the current use.
    pub(super) fn restart(&self) {
        self.peak.store(self.now.load(Ordering::Relaxed), Ordering::Relaxed);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_peak_is_the_most_since_the_last_start() {
        let meter = MemoryMeter::default();
        meter.add(5);
        meter.add(7);
        meter.remove(7);
        meter.add(1);
        assert_eq!(meter.peak(), 12);
        meter.restart();
        assert_eq!(meter.peak(), 6);
        meter.add(2);
        assert_eq!(meter.peak(), 8);
    }
}
