//! The settings of one-path-a-pixel path tracing: `[settings.paths]`, and of its path-space filters: `[settings.cells]`.

use super::setting::{Conflict, settings};
use super::value::{choice, choices, number, whole};
use super::{Direct, Indirect, Settings};

/// Path-space filters: they share the light of paths among vertices that lie near each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum PathFilter {
    /// None: each pixel has the light of its own paths.
    None,
    /// Screen space: 9 x 9 pixels that see about the same surface.
    Sspsf,
    /// Hashed cells of visible surfaces: a pixel has the mean of its cell.
    Hpsf,
    /// Hashed cells at every vertex of a path: light of the next one comes from its cell, so that over frames all bounces add up.
    Nhpsf,
    /// nhpsf, and each frame goes on with a path of earlier frames, by two more rays a pixel: cells that no short path reaches get light.
    ANhpsf,
    /// A radiance cache: cells from the second vertex on, none near the first, coarser ones where samples are few.
    Cache,
}

/// The normal in the key of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum CellNormal {
    /// The normals of the triangles.
    Exact,
    /// The normals of the triangles, jittered.
    Jittered,
    /// The normals of the triangles, but in the verification alone: cells of one place stand side by side.
    Verification,
}

choices!(PathFilter, CellNormal);

settings! {
    /// Settings of `--indirect paths`.
    struct PathSettings: Copy, table "settings.paths", "Path tracing (--indirect paths)";
    at settings => settings.paths;
    used if |settings| settings.indirect == Indirect::PATHS;
    conflict light_without_paths;

    /// Paths a pixel and frame. More: less noise, at as many times more rays.
    "samples" samples: u32 = 1, whole("N", 1, 16);
    /// Path-space filter. Each but sspsf costs two passes over the vertices and one over the cells; nhpsf and cache also one more
    /// ray a path.
    "filter" filter: PathFilter = PathFilter::None, choice::<PathFilter>();
}

settings! {
    /// Settings of the hash map of cells.
    struct CellSettings: Copy, table "settings.cells", "Cells of path-space filters (--filter)";
    at settings => settings.cells;
    used if |settings: &Settings| settings.paths.filter.has_cells();

    /// Width of a cell as the eye sees it, pixels; rounded down to a power of two in the world. More: less noise, and light that leaks
    /// over the edges of shadows. Any costs the same.
    "cells_width" width: f32 = 16.0, number("PIXELS", 1.0, 1024.0);
    /// How far a vertex is moved along its surface before its cell is found, cell widths. More: no blocks, but more noise. Any costs
    /// the same.
    "cells_jitter" jitter: f32 = 0.6, number("WIDTHS", 0.0, 1.0);
    /// Positions that each vertex is moved to. More: less noise, at as many times more accesses to the map.
    "cells_jitters" jitters: u32 = 1, whole("N", 1, 8);
    /// Bits of the normal in the key. More: edges and relief stay sharp, and cells have fewer samples. Any costs the same.
    "cells_normal_bits" normal_bits: u32 = 3, whole("BITS", 0, 4);
    /// The normal in the key. Any costs the same.
    "cells_normal" normal: CellNormal = CellNormal::Exact, choice::<CellNormal>();
    /// Cells of the map, rounded up to a power of two. More: 56 bytes each, and a pass over all of them a frame; too few: samples are
    /// dropped.
    "cells_capacity" capacity: u32 = 1 << 19, whole("N", 256, 1 << 24);
    /// Slots that are looked at for a cell; 0: there are no cells, and all light is that of the pixel's own path. More: fuller maps
    /// work, and a cell that is not there takes longer to miss.
    "cells_probes" probes: u32 = 16, whole("N", 0, 64);
    /// Sizes of cells, each four times as wide as the one before: where a cell has few samples the next one is read. More: less noise
    /// where vertices are rare, at as many times more accesses.
    "cells_levels" levels: u32 = 2, whole("N", 1, 4);
    /// How many times as wide cells are behind the visible surface. More: less noise, and coarser indirect light. Any costs the same.
    "cells_widening" widening: f32 = 1.0, number("FACTOR", 1.0, 16.0);
    /// Frames of which a cell holds the mean, at most, while nothing changes; 0: any number. More: less noise, and changes show later.
    /// Any costs the same.
    "cells_window" window: u32 = 32, whole("FRAMES", 0, 4096);
    /// Frames after which a cell without samples is evicted; 1: at once. More: what comes into view again is less noisy; too many: the
    /// map fills up. Any costs the same.
    "cells_life" life: u32 = 16, whole("FRAMES", 1, 1024);
    /// Vertices of a path that frames go on with, the visible surface among them (--filter a-nhpsf). More: light reaches farther from
    /// what the eye sees. Any costs the same.
    "cells_depth" depth: u32 = 4, whole("VERTICES", 2, 16);
}

impl PathFilter {
    /// Whether it has a hash map of cells.
    pub fn has_cells(self) -> bool {
        !matches!(self, Self::None | Self::Sspsf)
    }

    /// Whether frames go on with paths of earlier ones.
    pub fn continues(self) -> bool {
        self == Self::ANhpsf
    }
}

fn light_without_paths(settings: &Settings) -> Option<Conflict> {
    let key = match settings {
        _ if settings.indirect == Indirect::PATHS => return None,
        Settings { direct: Direct::Paths, .. } => "direct",
        _ if settings.paths.filter != PathFilter::None => "filter",
        _ => return None,
    };
    Some(Conflict {
        keys: [key, "indirect"],
        message: format!(
            "--{key} is for paths, so --indirect must be paths as well; choose it, or another --{key}"
        ),
    })
}
