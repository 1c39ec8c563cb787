"""Generates docs/PATH-SPACE.md from the figures in docs/path-space."""

from study_denoisers_page import read, table

# After so many frames.
FRAMES = [1, 16, 32]


def cells(which, *more):
    return ["--filter", which, *more]


def widths(which, all_of, jitter):
    return {f"{which}, {width} px, jitter {jitter}": cells(which, "--cells-width", width, "--cells-jitter", jitter) for width in all_of}


# Rows by figure of the thesis; a name stands for its options everywhere.
GROUPS = {
    "Raw, and screen space (figures 7 and 8)": {"one path": [], "sspsf": cells("sspsf")},
    "Widths without and with jitter (figures 9 and 10)": widths("hpsf", [4, 8, 16, 32, 64], 0) | widths("hpsf", [4, 8, 16, 32, 64], 0.6),
    "Normals in the key (figures 11 and 14)": {
        "hpsf, 16 px, no normal": cells("hpsf", "--cells-normal-bits", 0),
        "hpsf, 16 px, jittered normal": cells("hpsf", "--cells-normal", "jittered"),
        "hpsf, 16 px, normal in the verification": cells("hpsf", "--cells-normal", "verification"),
        "nhpsf, 16 px, no normal": cells("nhpsf", "--cells-normal-bits", 0),
    },
    "At every vertex (figures 12 and 13)": {
        "nhpsf, 16 px": cells("nhpsf"),
        "nhpsf, 16 px, cells behind it 4 times as wide": cells("nhpsf", "--cells-widening", 4),
    },
    "Kept paths (figures 15 to 17)": widths("a-nhpsf", [4, 16, 32], 0) | widths("a-nhpsf", [4, 16, 32], 0.6)
    | {f"a-nhpsf, 16 px, {depth} vertices": cells("a-nhpsf", "--cells-depth", depth) for depth in [2, 8, 16]},
    "Variants": {
        "hpsf, 16 px, jittered 4 times": cells("hpsf", "--cells-jitters", 4),
        "hpsf, 16 px, one size of cells": cells("hpsf", "--cells-levels", 1),
        "hpsf, 16 px, evicted at once": cells("hpsf", "--cells-life", 1, "--cells-window", 0),
        "cache": cells("cache"),
    },
}
FIGURES = {name: options for group in GROUPS.values() for name, options in group.items()}
DIRECT = {"one path": [], "sspsf": cells("sspsf"), "hpsf": cells("hpsf"), "hpsf, no normal": cells("hpsf", "--cells-normal-bits", 0),
          "nhpsf": cells("nhpsf"), "nhpsf, no normal": cells("nhpsf", "--cells-normal-bits", 0), "a-nhpsf": cells("a-nhpsf"),
          "cache": cells("cache"), "cache, SVGF": cells("cache", "--denoise", "svgf"), "SVGF": ["--denoise", "svgf"]}
PATHS = ["--indirect", "paths"]
EQUAL_TIME = {"one path": [*PATHS, "--denoise", "none"], "SVGF": PATHS, "BMFR": [*PATHS, "--denoise", "bmfr"],
              **{which: [*PATHS, "--denoise", "none", "--filter", which] for which in ["sspsf", "hpsf", "nhpsf", "a-nhpsf"]},
              "cache, SVGF": [*PATHS, "--filter", "cache"], "hpsf, SVGF": [*PATHS, "--filter", "hpsf"], "VPLs": ["--indirect", "vpls"]}

HEAD = """# Path-space filters

`--indirect paths --filter sspsf|hpsf|nhpsf|a-nhpsf|cache` shares the light of one path a pixel among vertices that lie near each other (Keller et al. 2014;
D. Meijer, *Real-time Path Traced Global Illumination for Games by Path Space Filtering*, 2019). A denoiser follows; `--denoise none` shows the filter alone.
Settings: `--cells-...` in [OPTIONS](OPTIONS.md). Tables by

```sh
scripts/study-path-space            # --help lists sections and options
```

| filter | what a pixel gets | bounces |
|---|---|---|
| `sspsf` | the mean of 9 x 9 pixels of about the same plane and normal | those of the path |
| `hpsf` | the mean of the visible surface's cell | those of the path |
| `nhpsf` | the same, where every vertex adds to its cell its own light and albedo times the mean of the next vertex's cell in the last frame | all, over frames |
| `a-nhpsf` | the same, and each pixel goes on with a path that it keeps, by a light and a scattered ray a frame, up to `--cells-depth` vertices | all, over frames |
| `cache` | the light of its own path at the visible surface, and albedo times the cell of the second vertex; no cell nearer than its width; levels of detail are dithered | all, over frames |

**Cells.** A cell is a cube whose side is the power of two below `--cells-width` pixels at its distance from the eye, and the sides of `--cells-normal-bits`
planes on which the normal lies: opposite walls never share a cell. Position, level and normal are hashed twice, to a slot and to the word that verifies it; probing is
linear. A vertex is moved along its surface by up to `--cells-jitter` widths first, so that blocks become noise.

Where other passes bring direct light, visible surfaces have cells of their own, which lack it. What a path meets last is known by its cell alone, and dark until there
is one.

**Sums** are 64-bit integers of two 32-bit atomics, so their order does not matter: reruns have the same bits unless the map is so full that it drops samples.
The newest frame has at least the share of one in `--cells-window`, at first of fewer; of one in two while lights or objects move, and it stands alone for four frames after
that, so that light that went from cell to cell is gone. Cells without samples are evicted after `--cells-life` frames.

**Kept paths** (`a-nhpsf`) go on from what they met in the last frame, or, where they have all their vertices, from the deepest vertex of the pixel's new path. Reports count kept paths by their vertices (`kept`). Where objects move they begin anew.

**Mirrors.** With `--direct paths`, what reflection rays hit is lit by the cache where it has a cell, so those paths need no rays.

**Views**: `cells`, `cell-lod`, `cell-samples`, `cell-age`, `cell-probes`, `cell-occupancy`, `paths-raw`, by `--view` and in the window.

**As in the thesis**: `--cells-levels 1 --cells-life 1 --cells-window 0 --cells-normal-bits 2` and `--direct paths`. What differs: the level follows the distance to the eye,
not the length of the path, so that one point has one cell; lobes are apart at the visible surface, so both of its rules for where to filter are one; the
vertex after the last one is known by its cell alone; kept paths go on where the camera moves.

**Standing still.** Still frames average the light of paths of `--bounces` alone. Where the filters show more bounces than these, dim corners get darker as the picture
settles; `--bounces 8` leaves next to no difference.

## Energy and noise

Mean of frames 60 to 120 over the path tracer's, and error of one frame over that of one path, without a denoiser: cornell-box, 48 x 48, 2 bounces, cells of 4 pixels;
light that is left eight frames after a lamp goes out.

```sh
cargo test --release --test renderer filters -- --nocapture
```

| filter | against | mean | error | left |
|---|---|---|---|---|
{energy}

Meijer's nHPSF looks too bright against pictures of fewer bounces; against all bounces it is not.
"""

MEASURED = """## The thesis's figures, with errors

Irradiance of still views at {size}, one indirect bounce, no denoiser; {device} ({driver}, commit {commit}). HDR-FLIP after 1, 16 and 32 frames against the path
tracer's of one bounce / of all; the rest after 32: RMSE over the reference's of all bounces, SSIM, and the mean over that of one bounce / of all. Cells
of 16 px are ten times as wide in the scene here as at 1080p, so blur and filled shadows are those of cells that nobody would choose there.

- **shadows**: mean where the reference has less than half of the light around, over the reference's: 1 keeps shadows, more fills them.
- **blocks**: gradients where the cell changes over those elsewhere on a surface: 1 shows no blocks.
- **rays** a pixel; **filter**: milliseconds of its passes over those of `paths_trace`; **dropped** samples a frame; a map has 56 B a slot, 28 MiB by default.

{tables}
"""

DIRECT_TEXT = """## Direct light filtered as well

As in the thesis (`--direct paths`): RMSE and SSIM of display luminance and HDR-FLIP after 32 frames against all bounces; **shadows**: mean radiance in the
shadow of direct light over the reference's.

{tables}
"""

ALBEDO = """## Albedo apart

The thesis's first contribution, which it does not measure: 9 x 9 means of irradiance, multiplied by the albedo afterwards, against means of the radiance. RMSE over the
mean of the reference, and mean change from frame to frame over the same, one path a pixel.

{table}
"""

EQUAL = """## Equal time

HDR-FLIP of the irradiance against all bounces at the time in which one path a pixel has had 16 frames, two bounces, camera standing, before still frames are averaged. A CPU's times:
rays cost it more than passes.

{table}
"""

PAPER = """## Cost

Medians of frames 4 to 11 of `render sponza --size 640x360 --indirect paths --filter cache --still-frames 0 --frames 12`, llvmpipe (LLVM 15.0.6, 256 bits), shares of the same frame's
`paths_trace`:

| filter | `cells_insert` | `cells_resolve` | `cells_read` | cells |
|---|---|---|---|---|
| `hpsf` | 2.2 % | .7 % | 1.0 % | 8,952 |
| `nhpsf` | 10.2 % | .9 % | .8 % | 76,280 |
| `cache` | 8.9 % | .8 % | .2 % | 85,580 |

nhpsf and cache trace one more ray a path, a-nhpsf two more than these a pixel. On paper at 1920x1080, of a pixel: vertices of two bounces 96 B written, read and half of them written again, and for each of
three vertices some 70 B of atomics on cells that mostly lie in a cache: 0.6 ms and some 50 million atomics at 500 GB/s; resolving half a million slots reads
20 MB, 0.04 ms. Meijer measured 1.5 ms for writing 1080p on an RTX 2080 Ti. A reverse pass over the vertices of a path within a frame would need a
synchronization of the whole picture for each vertex but the last; reading the last frame's map needs none. No GPU has been measured.

VPLs do not read the cache for the light that their bounded geometry term lacks: `bias_compensation`, which finds it by a short ray and one light there, takes 1.4 % of a frame
of VPLs in sponza and .6 % in classroom (320x180, defaults, the same device); filling and resolving a map for it would cost more than it could save.
"""


def cells_of(scene, name):
    row = scene[name]
    after = row["after"]
    flips = " ".join(f"{after[str(count)]['1']['flip']:.3f}/{after[str(count)]['inf']['flip']:.3f}" for count in FRAMES)
    last = after[str(FRAMES[-1])]
    means = f"{last['1']['mean_ratio']:.3f}/{last['inf']['mean_ratio']:.3f}"
    blocks = f"{row['blocks']:.2f}" if "blocks" in row else ""
    dropped = str(row["dropped"]) if "dropped" in row else ""
    return [name, *flips.split(" "), f"{last['inf']['rmse']:.4f}", f"{last['inf']['ssim']:.3f}", means, f"{row['shadows']:.2f}", blocks,
            f"{row['rays']:.1f}", f"{row['filter']:.2f}", dropped]


def measured(figures):
    head = ["filter", *(f"FLIP, {count}" for count in FRAMES), "RMSE", "SSIM", "mean", "shadows", "blocks", "rays", "filter", "dropped"]
    tables = []
    for scene, row in figures["rows"].items():
        tables.append(f"### {scene}")
        for title, group in GROUPS.items():
            rows = [cells_of(row, name) for name in group if name in row]
            if rows:
                tables.append(f"**{title}**\n\n{table(head, rows)}")
    return MEASURED.format(tables="\n\n".join(tables), **figures)


def direct(figures):
    head = ["filter", "RMSE", "SSIM", "HDR-FLIP", "mean", "shadows"]
    keys = [("luminance_rmse", ".4f"), ("luminance_ssim", ".3f"), ("flip", ".3f"), ("mean_ratio", ".3f"), ("shadows", ".2f")]
    tables = [f"**{scene}**\n\n" + table(head, [[name, *(format(row[name][key], form) for key, form in keys)] for name in DIRECT if name in row])
              for scene, row in figures["rows"].items()]
    return DIRECT_TEXT.format(tables="\n\n".join(tables))


def albedo(figures):
    rows = [[scene, *(f"{row[way][key]:.3f}" for way in ["apart", "together"] for key in ["rmse", "flicker"])] for scene, row in figures["rows"].items()]
    return ALBEDO.format(table=table(["scene", "apart: RMSE", "change", "together: RMSE", "change"], rows))


def equal_time(figures):
    scenes = list(figures["rows"])

    def cell(scene, name):
        row = figures["rows"][scene]
        if name not in row:
            return ""
        limit = row["one path"]["ends"][15]
        frames = sum(end <= limit for end in row[name]["ends"])
        return f"{row[name]['flip'][max(frames, 1) - 1]:.3f} ({frames})"

    rows = [[name, *(cell(scene, name) for scene in scenes)] for name in EQUAL_TIME]
    return EQUAL.format(table=table(["method (frames)", *scenes], rows))


SECTIONS = {"figures": measured, "direct": direct, "albedo": albedo, "equal_time": equal_time}
# By the command beside the table.
ENERGY = [("`sspsf`", "2 bounces", "1.024", ".34", ""), ("`hpsf`", "2 bounces", ".999", ".22", ".1 %"), ("`nhpsf`", "all bounces", ".987", ".24", "2.4 %"),
          ("`a-nhpsf`", "all bounces", ".997", ".23", ".6 %"), ("`cache`", "all bounces", ".989", ".95", ".8 %")]


def write(out):
    folder = out / "path-space"
    energy = "\n".join("| " + " | ".join(row) + " |" for row in ENERGY)
    parts = [HEAD.format(energy=energy)]
    for name, section in SECTIONS.items():
        figures = read(folder, name)
        if figures:
            parts.append(section(figures))
    (out / "PATH-SPACE.md").write_text("\n".join([*parts, PAPER]))
