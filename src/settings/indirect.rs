//! The values of `--indirect`: names of the estimators, which register themselves in `estimators/mod.rs`.

use super::registered::registered;

registered! {
    /// The estimator of indirect light.
    struct Indirect;

    /// The default.
    VPLS = "vpls", "Virtual point lights: instant radiosity with temporal sets";
    /// One-sample path tracing.
    PATHS = "paths", "Path tracing: one path a pixel and frame, denoised";
    /// VPLs as published, for comparison.
    TONNA = "tonna", "Virtual point lights as in Tonna 2019: every one of a pixel's class by a ray; for comparison";
    /// No estimator.
    NONE = "none", "Nothing: direct light only";
}
