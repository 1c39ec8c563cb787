//! The settings of virtual point lights: `[settings.vpls]`.

use serde::Serialize;

use super::{Range, SettingsError, text};

/// Source of the light paths' random numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Sequence {
    /// An Owen-scrambled Sobol sequence: stratified.
    #[default]
    Sobol,
    /// Independent random numbers, for comparison.
    Random,
}

/// How a pixel treats set buffers in which its surface is missing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum MissingSets {
    /// Scale the present sets by total flux over present flux: noisier, never darker.
    #[default]
    Scale,
    /// Leave their light out until they are rendered again, as in Tonna 2019, figures 18 and 27.
    Dark,
}

/// Settings of `--indirect vpls`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, clap::Args)]
#[command(next_help_heading = "Virtual point lights (--indirect vpls)")]
#[group(id = "settings.vpls")]
pub struct VplSettings {
    /// VPLs whose shadows are traced, 1 to 65,536: n x n pixels of all temporal sets share so many occlusion rays.
    /// More: smoother indirect light; shadow rays grow in proportion.
    #[arg(id = "vpls", long = "vpls", value_name = "N", value_parser = text::parse_whole, allow_negative_numbers = true, default_value = "512")]
    #[serde(rename = "vpls")]
    pub slots: u32,
    /// VPLs to draw these from, up to 65,536; at least --vpls, of which it is rounded up to a multiple. More: light that is
    /// nearer to the truth, at no more rays, but more CPU time where a light or an object moves.
    #[arg(long, value_name = "N", value_parser = text::parse_whole, allow_negative_numbers = true, default_value = "16384")]
    pub pool: u32,
    /// Most light paths tried for a VPL, of which one is taken, mostly one that lights what the camera sees, 1 to 64. More: less light
    /// that nobody sees where a light reaches it through small openings, at more CPU rays; 1: VPLs lie as the lights throw them.
    #[arg(long, value_name = "N", value_parser = text::parse_whole, allow_negative_numbers = true, default_value = "32")]
    pub candidates: u32,
    /// Interleave n, 1 to 8: each pixel gathers 1/n^2 of the VPLs. More: n^2 fewer rays, softer contact shadows.
    #[arg(long, value_name = "N", value_parser = text::parse_whole, allow_negative_numbers = true, default_value = "4")]
    pub interleave: u32,
    /// Temporal sets T, 1 to 64 and at most the VPLs. More: T times fewer rays a frame, but T frames
    /// until a change is fully visible.
    #[arg(long, value_name = "N", value_parser = text::parse_whole, allow_negative_numbers = true, default_value = "16")]
    pub temporal_sets: u32,
    /// Most slots shot in one frame, at least 1, each with its share of the pool. More: light follows changes faster, at more CPU time.
    #[arg(long, value_name = "N", value_parser = text::parse_whole, allow_negative_numbers = true, default_value = "64")]
    pub budget: u32,
    /// Temporal sets redrawn in a frame beyond the one whose turn it is, while much of the light has changed since they were
    /// drawn, 0 to 63. More: less noise after a change, at as many times more rays.
    #[arg(long, value_name = "N", value_parser = text::parse_whole, allow_negative_numbers = true, default_value = "1")]
    pub refresh: u32,
    /// Upper bound of the geometry term 1/d^2, in units of one over the squared median distance from a VPL
    /// to its parent, so that it suits a scene of any size; 0 switches it off. Short rays
    /// bring back what it takes away. Lower: fewer bright spots in corners, but more noise of these rays.
    #[arg(long, value_name = "BOUND", value_parser = text::parse_number, allow_negative_numbers = true, default_value = "400")]
    pub clamp: f32,
    /// Most distance between two positions that reprojection takes for one surface, as a fraction of view depth.
    /// Lower: holes and aliasing in motion; higher: ghosting.
    #[arg(long, value_name = "FRACTION", value_parser = text::parse_number, allow_negative_numbers = true, default_value = "0.02")]
    pub position_cutoff: f32,
    /// Random numbers of the light paths. Sobol: stratified; random: independent, far noisier, for comparison.
    /// Either costs the same.
    #[arg(long, value_enum, default_value = "sobol")]
    pub sequence: Sequence,
    /// Treatment of missing set buffers. Scale: noisier for T frames, never darker; dark: less noise,
    /// but too dark for T frames.
    #[arg(long, value_enum, default_value = "scale")]
    pub missing_sets: MissingSets,
}

impl Default for VplSettings {
    fn default() -> Self {
        Self {
            slots: 512,
            pool: 16_384,
            candidates: 32,
            interleave: 4,
            temporal_sets: 16,
            budget: 64,
            refresh: 1,
            clamp: 400.0,
            position_cutoff: 0.02,
            sequence: Sequence::Sobol,
            missing_sets: MissingSets::Scale,
        }
    }
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

    /// Checks combinations of settings.
    pub(super) fn check(&self) -> Result<(), SettingsError> {
        if self.temporal_sets <= self.slots {
            return Ok(());
        }
        Err(SettingsError::MoreSetsThanVpls {
            temporal_sets: self.temporal_sets,
            vpls: self.slots,
            from_command_line: false,
        })
    }

    /// The ranges of the settings.
    pub(super) fn ranges(&self) -> [Range; 9] {
        let at_least_0 = |value: f32| value.is_finite() && value >= 0.0;
        [
            Range::new("vpls", self.slots, (1..=65_536).contains(&self.slots), "1 to 65536"),
            Range::new("pool", self.pool, (1..=65_536).contains(&self.pool), "1 to 65536"),
            Range::new("candidates", self.candidates, (1..=64).contains(&self.candidates), "1 to 64"),
            Range::new("interleave", self.interleave, (1..=8).contains(&self.interleave), "1 to 8"),
            Range::new(
                "temporal_sets",
                self.temporal_sets,
                (1..=64).contains(&self.temporal_sets),
                "1 to 64, and at most --vpls",
            ),
            Range::new("budget", self.budget, self.budget >= 1, "at least 1"),
            Range::new("refresh", self.refresh, self.refresh <= 63, "0 to 63"),
            Range::new("clamp", self.clamp, at_least_0(self.clamp), "a finite number of at least 0"),
            Range::new(
                "position_cutoff",
                self.position_cutoff,
                at_least_0(self.position_cutoff) && self.position_cutoff > 0.0,
                "a finite number above 0",
            ),
        ]
    }
}
