//! What one run measured, frame by frame.

use serde::{Deserialize, Serialize};

use crate::report::{FrameFigures, PASS_NAMES, PerPass};

/// One column for each quantity, one value for each frame. Times are in milliseconds.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Samples {
    /// From the beginning of a frame until the device is done with it.
    pub total_ms: Vec<f64>,
    /// The ten passes.
    pub passes: PerPass<Vec<f64>>,
    /// What lies between the passes: recording, uploads, submission, waking up.
    pub other_ms: Vec<f64>,
    /// The VPLs.
    pub vpls: VplColumns,
    /// Occlusion rays cast by the shaders.
    pub shadow_rays: Vec<u64>,
}

/// Slots: how many hold a usable VPL, have escaped, are stale, became invalid, were shot.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs, reason = "as in VplCounters")]
pub struct VplColumns {
    pub valid: Vec<u32>,
    pub escaped: Vec<u32>,
    pub stale: Vec<u32>,
    pub invalidated: Vec<u32>,
    pub shot: Vec<u32>,
}

/// What a quantity is counted in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    /// Milliseconds.
    Milliseconds,
    /// Frames a second.
    PerSecond,
    /// A number of things.
    Count,
}

impl Unit {
    /// As in tables.
    pub fn symbol(self) -> &'static str {
        match self {
            Self::Milliseconds => "ms",
            Self::PerSecond => "1/s",
            Self::Count => "",
        }
    }
}

/// The whole frame.
pub const TOTAL: &str = "total";
/// Frames a second.
pub const FPS: &str = "fps";
/// What lies between the passes.
pub const OTHER: &str = "other";

/// The stages that make up a frame: the ten passes, and what lies between them.
pub fn stages() -> impl Iterator<Item = &'static str> {
    PASS_NAMES.into_iter().chain([OTHER])
}

impl Samples {
    /// Adds a frame that took `wall_ms` from its beginning until the device was done.
    pub fn push(&mut self, wall_ms: f64, figures: &FrameFigures) {
        let total = rounded(wall_ms);
        self.total_ms.push(total);
        let mut stages = 0.0;
        for (column, ms) in self.passes.0.iter_mut().zip(figures.passes.0) {
            let ms = rounded(ms);
            stages += ms;
            column.push(ms);
        }
        self.other_ms.push(rounded(total - stages));
        self.vpls.valid.push(figures.vpls.valid);
        self.vpls.escaped.push(figures.vpls.escaped);
        self.vpls.stale.push(figures.vpls.stale);
        self.vpls.invalidated.push(figures.vpls.invalidated);
        self.vpls.shot.push(figures.vpls.shot);
        self.shadow_rays.push(figures.shadow_rays);
    }

    /// Frames.
    pub fn len(&self) -> usize {
        self.total_ms.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.total_ms.is_empty()
    }

    /// Whether every column has one value for each of `frames` frames, times are finite, and frames took some.
    pub fn is_whole(&self, frames: usize) -> bool {
        let quantities = self.quantities();
        quantities.iter().all(|(_, _, column)| column.len() == frames && column.iter().all(|v| v.is_finite()))
            && self.total_ms.iter().all(|&ms| ms > 0.0)
    }

    /// Every quantity: name, unit, one value for each frame.
    pub fn quantities(&self) -> Vec<(&'static str, Unit, Vec<f64>)> {
        let ms = Unit::Milliseconds;
        let counts = |column: &[u32]| column.iter().map(|&count| f64::from(count)).collect();
        let mut quantities = vec![(TOTAL, ms, self.total_ms.clone())];
        quantities.push((FPS, Unit::PerSecond, self.total_ms.iter().map(|ms| 1e3 / ms).collect()));
        quantities.extend(
            PASS_NAMES.into_iter().zip(&self.passes.0).map(|(name, column)| (name, ms, column.clone())),
        );
        quantities.push((OTHER, ms, self.other_ms.clone()));
        for (name, column) in [
            ("vpls_valid", &self.vpls.valid),
            ("vpls_escaped", &self.vpls.escaped),
            ("vpls_stale", &self.vpls.stale),
            ("vpls_invalidated", &self.vpls.invalidated),
            ("vpls_shot", &self.vpls.shot),
        ] {
            quantities.push((name, Unit::Count, counts(column)));
        }
        let rays = self.shadow_rays.iter().map(|&rays| rays as f64).collect();
        quantities.push(("shadow_rays", Unit::Count, rays));
        quantities
    }
}

/// To a tenth of a microsecond, beyond which timers tell nothing.
fn rounded(ms: f64) -> f64 {
    (ms * 1e4).round() / 1e4
}
