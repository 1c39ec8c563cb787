//! The settings of virtual point lights: `[settings.vpls]`.

use super::setting::{Conflict, settings};
use super::value::{above_0, at_least_0, choice, choices, whole};
use super::{Indirect, Settings};

/// Source of the light paths' random numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Sequence {
    /// An Owen-scrambled Sobol sequence, which is stratified.
    Sobol,
    /// Independent random numbers, far noisier, for comparison.
    Random,
}

/// How a pixel treats set buffers in which its surface is missing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum MissingSets {
    /// The present sets are scaled by total flux over present flux: noisier for T frames, never darker.
    Scale,
    /// Their light is left out until they are rendered again, as in Tonna 2019, figures 18 and 27: less noise, but too dark
    /// for T frames.
    Dark,
}

/// How many texels a set buffer has.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum SetResolution {
    /// Half of the picture's in each direction where several sets share out the pixels and --interleave is more than 1; else all of it.
    Auto,
    /// One for each pixel.
    Full,
    /// One for each 2x2 pixels.
    Half,
}

choices!(Sequence, MissingSets, SetResolution);

settings! {
    /// Settings of `--indirect vpls`.
    struct VplSettings: Copy, table "settings.vpls", "Virtual point lights (--indirect vpls)";
    at settings => settings.vpl;
    used if |settings| [Indirect::VPLS, Indirect::TONNA].contains(&settings.indirect);
    conflict more_sets_than_vpls;

    /// VPLs whose shadows are traced: n x n pixels of all temporal sets share so many occlusion rays. More: smoother indirect
    /// light; shadow rays grow in proportion.
    "vpls" slots: u32 = 512, whole("N", 1, 65_536);
    /// VPLs to sample these from; at least --vpls, of which it is rounded up to a multiple. More: light that is nearer to the
    /// reference, at no more rays, but more CPU time where a light or an object moves.
    "pool" pool: u32 = 16_384, whole("N", 1, 65_536);
    /// Most light paths tried for a VPL, of which one is taken, mostly one that lights what the camera sees. More: less light that
    /// nobody sees where a light reaches it through small openings, at more CPU rays; 1: VPLs lie as the lights throw them.
    "candidates" candidates: u32 = 32, whole("N", 1, 64);
    /// Interleave n: each pixel gathers 1/n^2 of the VPLs. More: n^2 fewer rays, softer contact shadows.
    "interleave" interleave: u32 = 4, whole("N", 1, 8);
    /// Temporal sets T, at most the VPLs. More: T times fewer rays a frame, but T frames until a change is fully visible.
    "temporal_sets" temporal_sets: u32 = 16, whole("N", 1, 64);
    /// Resolution of the set buffers. Half: a quarter of the rays of full, and softer edges of indirect light.
    "set_resolution" set_resolution: SetResolution = SetResolution::Auto, choice::<SetResolution>();
    /// Most slots shot in one frame, each with its share of the pool. More: light follows changes faster, at more CPU time.
    "budget" budget: u32 = 64, whole("N", 1, u32::MAX);
    /// Temporal sets rendered again in a frame beyond the one whose turn it is, while much of the light has changed since they
    /// were rendered. More: less noise after a change, at as many times more rays.
    "refresh" refresh: u32 = 1, whole("N", 0, 63);
    /// Turns of a set before its newest that its light is the mean of, at most; fewer where much has changed; 0: none, as in Tonna
    /// 2019. More: less noise, and softer edges of shadows in motion. Any costs the same.
    "vpls_history" longest_history: u32 = 8, whole("N", 0, 30);
    /// Upper bound of the geometry term 1/d^2, in units of one over the squared median distance from a VPL to its parent, so that
    /// it suits a scene of any size; 0 switches it off. Short rays bring back what it takes away. Less: fewer bright spots in
    /// corners, but more noise of these rays.
    "clamp" clamp: f32 = 400.0, at_least_0("BOUND");
    /// Most distance between two positions that reprojection takes for one surface, as a fraction of view depth. More: ghosting;
    /// less: holes and aliasing in motion. Any costs the same.
    "position_cutoff" position_cutoff: f32 = 0.02, above_0("FRACTION");
    /// Random numbers of the light paths. Either costs the same.
    "sequence" sequence: Sequence = Sequence::Sobol, choice::<Sequence>();
    /// Treatment of surfaces that some set buffers lack. Either costs the same.
    "missing_sets" missing_sets: MissingSets = MissingSets::Scale, choice::<MissingSets>();
}

impl VplSettings {
    /// VPLs of the pool in each of the slots.
    pub fn vpls_per_slot(&self) -> u32 {
        self.pool.div_ceil(self.slots).max(1)
    }

    /// VPLs of the pool in all slots.
    pub fn pool_size(&self) -> u32 {
        self.slots * self.vpls_per_slot()
    }
}

/// Each temporal set needs a VPL.
fn more_sets_than_vpls(settings: &Settings) -> Option<Conflict> {
    let VplSettings { temporal_sets, slots, .. } = settings.vpl;
    (temporal_sets > slots).then(|| Conflict {
        keys: ["temporal_sets", "vpls"],
        message: format!(
            "--temporal-sets is {temporal_sets}, but must be at most --vpls, which is {slots}; lower the one or raise the other"
        ),
    })
}
