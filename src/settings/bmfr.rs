//! The settings of the denoiser BMFR: `[settings.bmfr]`. Defaults are those of Koskela et al. 2019.

use super::bmfr_features::BmfrFeatures;
use super::setting::settings;
use super::value::{Kind, number};
use super::{Denoise, Settings};

settings! {
    /// Settings of `--denoise bmfr`.
    struct BmfrSettings: Copy, table "settings.bmfr", "BMFR (--denoise bmfr)";
    at settings => settings.bmfr;
    used if |settings: &Settings| settings.effects.denoise == Denoise::BMFR;

    /// Features whose linear combination is fitted to each block: products of 1, nx, ny, nz (normal), wx, wy, wz (position), d (distance to
    /// the eye), r (roughness), ar, ag, ab (albedo), such as wx*wx, and roots of magnitudes, such as sqrt(nx). More: sharper light that
    /// follows them, more noise; time grows with the square of their number.
    "bmfr_features" features: BmfrFeatures = BmfrFeatures::default(), Kind::Features;
    /// Least share of the newest frame in the signal that is fitted. More: more noise, and changes show sooner. Any costs the same.
    "bmfr_alpha" alpha: f32 = 0.2, number("SHARE", 0.0, 1.0);
    /// Least share of the newest fit in the picture. More: more flicker, and changes show sooner. Any costs the same.
    "bmfr_filtered_alpha" filtered_alpha: f32 = 0.1, number("SHARE", 0.0, 1.0);
}
