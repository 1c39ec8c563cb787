//! Devices that are lost on purpose, to test what comes of it: `GLOWWORM_LOSE_DEVICE=40,90` loses the device of this program's 40th
//! submission there, and that of its 90th.

use std::sync::LazyLock;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering::Relaxed};

/// Numbers of submissions, from 1 on.
static LOSSES: LazyLock<Vec<u64>> = LazyLock::new(|| {
    let text = std::env::var("GLOWWORM_LOSE_DEVICE").unwrap_or_default();
    text.split(',').filter_map(|number| number.parse().ok()).collect()
});
/// Submissions of all devices so far.
static SUBMISSIONS: AtomicU64 = AtomicU64::new(0);

/// Whether a device is lost on purpose. It stays so.
#[derive(Default)]
pub(super) struct Loss(AtomicBool);

impl Loss {
    /// Whether the next submission fails.
    pub fn strikes(&self) -> bool {
        if !LOSSES.is_empty() && LOSSES.contains(&(SUBMISSIONS.fetch_add(1, Relaxed) + 1)) {
            self.0.store(true, Relaxed);
        }
        self.0.load(Relaxed)
    }
}
