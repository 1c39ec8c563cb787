"""The filters of scripts/study path-space, and the figures of docs/PATH-SPACE.md, from docs/path-space."""

from .page import columns, table
from .program import read_json

# After so many frames.
FRAMES = [1, 16, 32]


def cells(which, *more):
    return ["--filter", which, *more]


def widths(which, all_of, jitter):
    return {f"{which}, {width} px, jitter {jitter}": cells(which, "--cells-width", width, "--cells-jitter", jitter) for width in all_of}


# By figure of the thesis; a name stands for its options everywhere.
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

# What the page shows of the figures; all are in docs/path-space/figures.json.
SHOWN = ["one path", "sspsf", "hpsf, 16 px, jitter 0", "hpsf, 4 px, jitter 0.6", "hpsf, 16 px, jitter 0.6", "hpsf, 64 px, jitter 0.6", "hpsf, 16 px, no normal",
         "nhpsf, 16 px", "a-nhpsf, 16 px, jitter 0.6", "cache"]
ERRORS = [("RMSE", "luminance_rmse", ".4f"), ("SSIM", "luminance_ssim", ".3f"), ("HDR-FLIP", "flip", ".3f"), ("mean", "mean_ratio", ".3f"),
          ("shadows", "shadows", ".2f")]


def measured(figures):
    def cells(row):
        after, last = row["after"], row["after"][str(FRAMES[-1])]
        flips = [f"{after[str(count)]['1']['flip']:.3f}/{after[str(count)]['inf']['flip']:.3f}" for count in FRAMES]
        return [*flips, f"{last['inf']['rmse']:.4f}", f"{last['inf']['ssim']:.3f}", f"{last['1']['mean_ratio']:.3f}/{last['inf']['mean_ratio']:.3f}",
                f"{row['shadows']:.2f}", f"{row['blocks']:.2f}" if "blocks" in row else "", f"{row['rays']:.1f}", f"{row['filter']:.2f}"]

    head = ["filter", *(f"FLIP, {count}" for count in FRAMES), "RMSE", "SSIM", "mean", "shadows", "blocks", "rays", "filter"]
    return by_scene(figures, lambda row: table(head, [[name, *cells(row[name])] for name in SHOWN if name in row]))


def by_scene(figures, text):
    return "\n\n".join(f"**{scene}**\n\n" + text(row) for scene, row in figures["rows"].items())


def direct(figures):
    return by_scene(figures, lambda row: columns(row, ERRORS, "filter"))


def albedo(figures):
    rows = [[scene, *(f"{row[way][key]:.3f}" for way in ["apart", "together"] for key in ["rmse", "flicker"])] for scene, row in figures["rows"].items()]
    return table(["scene", "apart: RMSE", "change", "together: RMSE", "change"], rows)


def equal_time(figures):
    def cell(row, name):
        limit = row["one path"]["ends"][15]
        frames = sum(end <= limit for end in row[name]["ends"])
        return f"{row[name]['flip'][max(frames, 1) - 1]:.3f} ({frames})"

    rows = figures["rows"]
    return table(["method (frames)", *rows], [[name, *(cell(row, name) if name in row else "" for row in rows.values())] for name in EQUAL_TIME])


def figures(folder):
    """The texts of the page by their marks."""
    found = {}
    for name, text in {"figures": measured, "direct": direct, "albedo": albedo, "equal_time": equal_time}.items():
        figures = read_json(folder / f"{name}.json")
        if figures:
            found |= {name: text(figures), f"{name}-commit": figures["commit"]}
            if "device" in figures:
                found["device"] = f"{figures['device']} ({figures['driver']})"
    return found
