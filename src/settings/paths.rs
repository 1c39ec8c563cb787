//! The settings of one-path-a-pixel path tracing: `[settings.paths]`.

use super::setting::{Conflict, settings};
use super::value::whole;
use super::{Direct, Indirect, Settings};

settings! {
    /// Settings of `--indirect paths`.
    struct PathSettings: Copy, table "settings.paths", "Path tracing (--indirect paths)";
    at settings => settings.paths;
    used if |settings| settings.indirect == Indirect::PATHS;
    conflict direct_light_without_paths;

    /// Paths a pixel and frame. More: less noise, at as many times more rays.
    "samples" samples: u32 = 1, whole("N", 1, 16);
}

fn direct_light_without_paths(settings: &Settings) -> Option<Conflict> {
    (settings.direct == Direct::Paths && settings.indirect != Indirect::PATHS).then(|| Conflict {
        keys: ["direct", "indirect"],
        message: "--direct is paths, so --indirect must be paths as well; choose it, or another --direct"
            .to_owned(),
    })
}
