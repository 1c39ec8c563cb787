//! The settings of one-path-a-pixel path tracing: `[settings.paths]`.

use super::Indirect;
use super::setting::settings;
use super::value::whole;

settings! {
    /// Settings of `--indirect paths`.
    struct PathSettings: Copy, table "settings.paths", "Path tracing (--indirect paths)";
    at settings => settings.paths;
    used if |settings| settings.indirect == Indirect::PATHS;

    /// Paths a pixel and frame. More: less noise, at as many times more rays.
    "samples" samples: u32 = 1, whole("N", 1, 16);
}
