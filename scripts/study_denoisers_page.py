"""Generates docs/DENOISERS.md from the figures in docs/denoisers."""

import json

# One path a pixel and frame, or VPLs. All direct light is part of the paths, but where it is named apart.
PATHS = ["--indirect", "paths", "--direct", "paths"]
NO_TAA = ["--antialiasing", "none"]
METHODS = {
    "paths, noisy, no TAA": [*PATHS, "--denoise", "none", *NO_TAA],
    "paths, noisy": [*PATHS, "--denoise", "none"],
    "paths, accumulation alone": [*PATHS, "--denoise", "svgf", "--indirect-svgf-levels", 0],
    "paths, a-trous alone": [*PATHS, "--denoise", "svgf", "--svgf-history", 1],
    **{f"paths, SVGF, {levels} levels": [*PATHS, "--denoise", "svgf", "--indirect-svgf-levels", levels] for levels in [1, 2, 3, 5]},
    "paths, SVGF": [*PATHS, "--denoise", "svgf"],
    "paths, SVGF, no TAA": [*PATHS, "--denoise", "svgf", *NO_TAA],
    "paths, SVGF, direct light apart": [*PATHS, "--denoise", "svgf", "--direct", "soft"],
    "paths, BMFR": [*PATHS, "--denoise", "bmfr"],
    "paths, BMFR, no TAA": [*PATHS, "--denoise", "bmfr", *NO_TAA],
    "VPLs": ["--indirect", "vpls"],
    "VPLs, BMFR": ["--indirect", "vpls", "--denoise", "bmfr"],
    "VPLs, no denoiser": ["--indirect", "vpls", "--denoise", "none"],
}
# Frames since a surface came into view: from the first, up to the last.
AGES = {"0": (0, 1), "1": (1, 2), "2-3": (2, 4), "4-7": (4, 8), "8-15": (8, 16), "16-": (16, 1000)}
FEATURE_COUNTS = [1, 2, 4, 6, 8, 10, 12, 14]

HEAD = """# Denoisers

One path a pixel and frame (`--indirect paths`), cleaned by SVGF (Schied et al. 2017) or BMFR (Koskela et al. 2019), beside VPLs. The
camera moves as in H. Flatval, *Denoising Algorithms for Ray Tracing in Real-Time Applications*, 2020, in 60 frames of 1/60 s. Written by

```sh
scripts/study-denoisers             # --help lists sections and options
```

{device} ({driver}), {size}, {bounces} bounces, TAA unless named; all direct light is part of the paths (`--direct paths`) unless
it is apart (`--direct soft`). A CPU's ratios are no GPU's: rays cost it more than passes over the picture.
"""

MOTION = """## In motion

Means over every sixth of 60 frames against the path tracer's of the same moments through a box filter, whose own noise counts as error. Samples a
pixel of the reference and commit: {spp}. RMSE and SSIM are of display luminance (`glowworm compare --luminance`), at an exposure that brings 95 % of the pixels below
0.8.

{tables}

RMSE of display luminance by the number of frames since each surface came into view, where any did:

{ages}

- **flicker**: mean absolute change of the irradiance from frame to frame at the same surface points, over its mean.
- **blocks**: energy of the error at the harmonics of 32 pixels, BMFR's blocks, over that beside them in the spectrum, from the 16th frame on.
- **ms**: of a whole frame, mean; **most**: of the slowest frame over the mean; **denoiser**: of that the passes that clean the indirect light.
- **rays**: of the shaders, for each pixel of a frame.
"""

BESIDE = """## Beside Flatval 2020

RMSE / SSIM of display luminance. The thesis has other rooms (its San Miguel stands beside `atrium-drapery`), 1280x720 and references of about 1024 samples.

{table}
"""

STATIC = """## Nothing moves

Mean absolute change of display luminance from frame to frame, over the last 10 of 60 frames from a fresh start, before still frames are averaged
(`--still-frames 0`; commit {commit}{note}); Flatval 2020 has .0054 for SVGF and .0011 for BMFR. By default, the picture goes over to the mean of all frames and freezes.

{table}
"""

FEATURES = """## Features of BMFR

RMSE of display luminance / HDR-FLIP / milliseconds of the fit, by number of features (commit {commit}{note}): the first of
`{features}`.

{table}
"""

SEARCH = """## Which features

Greedy search by `scripts/search-features` over data sets of {names} at {size}, one path a pixel, against {spp} (commit {commit}): the cost is the
mean over the scenes, and over two metrics of denoised frames, HDR-FLIP and what VMAF lacks of 100, each over that of the constant alone. BMFR's ten cost {bmfr}.

{errors}

By component:

{components}

By whole vectors:

{vectors}

On a scene that the search has not seen, what it found on the others costs less than BMFR's ten in {better} of {of}, so the ten stay the default:

{unseen}

Scenes turned by 35 degrees about each axis:

{turned}
"""

PAPER = """## On paper

Bytes that each pixel moves once, where caches hold neighbours, and operations, at 1920x1080; a GPU with 500 GB/s and 10 TFLOP/s needs at least the
greater of the two times. No GPU has been measured.

| stage | reads and writes | operations | ms |
|---|---|---|---|
| SVGF: accumulation | signal, reprojection, light, moments; 56 B | 300, of which 25 taps for the rejection of history | 0.23 |
| SVGF: variance | light, moments, width; 32 B; where history is short 7x7 taps | 20; 49 taps of 40 there | 0.13 |
| SVGF: a-trous, four levels | light, depth, normal, width; 36 B each | 25 taps of 40 each | 0.83 |
| BMFR: accumulation | signal, reprojection, history; 32 B | 150 | 0.13 |
| BMFR: fit of ten features | signal, depth, normal, albedo; 36 B | 4 (13 + 12 + ... + 4) = 340 by Householder, 60 for the sum | 0.15 |
| BMFR: accumulation of the fit | fit, reprojection, history; 32 B | 50 | 0.13 |

The fit's rows stay in registers, 5 x 13 of each of 256 threads; sums over rows go by subgroups, then 8 or 16 numbers by shared memory; two barriers a
column, not bandwidth, bound it. Paths diverge after the first bounce: of two bounces a live ray in a subgroup is followed by one that ended, so
compaction could save at most half of the second bounce's time, and costs a pass and 64 B of state a path each way; it is not done. A light BVH would find
a light in logarithmic time, but chooses by bounds, which is noisier, and scenes have few lights that are not triangles of one mesh.
"""

# RMSE and SSIM in Flatval 2020, by scene and denoiser.
THESIS = {"sponza": {"SVGF": (.031, .888), "BMFR": (.029, .889)},
          "living-room": {"SVGF": (.045, .841), "BMFR": (.035, .872)},
          "atrium-drapery": {"SVGF": (.033, .867), "BMFR": (.037, .834)}}

ROWS = [("RMSE", "luminance_rmse", ".4f"), ("SSIM", "luminance_ssim", ".3f"), ("HDR-FLIP", "flip", ".3f"), ("mean", "mean_ratio", ".3f"),
        ("flicker", "flicker", ".3f"), ("blocks", "blocks", ".2f"), ("ms", "ms", ".0f"), ("most", "most", ".2f"), ("denoiser", "denoiser_ms", ".1f"), ("rays", "rays", ".1f")]


def table(head, rows):
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def read(folder, section):
    file = folder / f"{section}.json"
    return json.loads(file.read_text()) if file.exists() else None


def motion(figures):
    tables = []
    for scene, row in figures["rows"].items():
        for of in METHODS:
            if of in row:
                row[of]["most"] = row[of]["most_ms"] / row[of]["ms"]
        rows = [[name, *(format(row[name][key], form) for _, key, form in ROWS)] for name in METHODS if name in row]
        tables.append(f"**{scene}**\n\n" + table(["method", *(name for name, _, _ in ROWS)], rows))
    ages = [f"**{scene}**\n\n" + ages_of(row) for scene, row in figures["rows"].items()]
    spp = "; ".join(f"{scene} {row['spp']}, {row['commit']}" for scene, row in figures["rows"].items())
    return MOTION.format(spp=spp, tables="\n\n".join(tables), ages="\n\n".join(ages), **figures)


def beside(figures):
    rows = []
    for scene, thesis in THESIS.items():
        row = figures["rows"].get(scene, {})
        if not all(name in row for name in ["paths, noisy, no TAA", "paths, SVGF", "paths, BMFR"]):
            continue
        one = row["paths, noisy, no TAA"]["luminance_rmse"]
        cells = [scene, f"{one:.3f}"]
        for denoiser, (rmse, ssim) in thesis.items():
            ours = row[f"paths, {denoiser}"]
            cells += [f"{ours['luminance_rmse']:.3f} / {ours['luminance_ssim']:.3f}", f"{ours['luminance_rmse'] / one:.2f}", f"{rmse:.3f} / {ssim:.3f}"]
        rows.append(cells)
    return BESIDE.format(table=table(["scene", "one sample", "SVGF", "over one sample", "thesis", "BMFR", "over one sample", "thesis"], rows))


def ages_of(row):
    def cell(name, age):
        found = row[name]["by_frames_seen"].get(age)
        return "" if found is None else f"{found:.4f}"

    return table(["method", *AGES], [[name, *(cell(name, age) for age in AGES)] for name in METHODS if name in row])


def static(figures):
    scenes = list(figures["rows"])
    measured = [name for name in METHODS if any(name in row for row in figures["rows"].values())]
    rows = [[name, *(format(figures["rows"][scene][name], ".4f") if name in figures["rows"][scene] else "" for scene in scenes)] for name in measured]
    return STATIC.format(commit=figures["commit"], note=figures.get("note", ""), table=table(["method", *scenes], rows))


def features(figures):
    scenes = list(figures["rows"])

    def cell(scene, count):
        row = figures["rows"][scene].get(str(count))
        return f"{row['luminance_rmse']:.4f} / {row['flip']:.3f} / {row['fit_ms']:.1f}" if row else ""

    rows = [[str(count), *(cell(scene, count) for scene in scenes)] for count in FEATURE_COUNTS]
    return FEATURES.format(commit=figures["commit"], note=figures.get("note", ""), features=", ".join(figures["features"]), table=table(["features", *scenes], rows))


def search(figures):
    def lines(steps):
        return table(["features", "cost", "added"], [
            [str(len(step["features"])), f"{step['cost']:.3f}", "`" + ", ".join(step["features"][len(before["features"]) if before else 0:]) + "`"]
            for before, step in zip([None, *steps], steps)])

    unseen = table(["scene", "found on the others", "BMFR's ten", "found"], [
        [scene, f"{row['cost']:.3f}", f"{row['bmfr']:.3f}", "`" + ", ".join(row["features"]) + "`"] for scene, row in figures["unseen"].items()])
    turned = table(["features", "x", "y", "z"], [[name, *(f"{cost:.3f}" for cost in figures["turned"][key])]
                                                for key, name in [("bmfr", "BMFR's ten"), ("found", "found by component")] if key in figures["turned"]])
    errors = table(["HDR-FLIP / VMAF", *figures["scenes"]], [[name, *(f"{flip:.3f} / {100 - lack:.1f}" for flip, lack in figures["errors"][key])]
                                                             for key, name in [("bmfr", "BMFR's ten"), ("found", "found by component")]])
    better = sum(row["cost"] < row["bmfr"] for row in figures["unseen"].values())
    return SEARCH.format(better=better, of=len(figures["unseen"]), errors=errors, components=lines(figures["components"]), vectors=lines(figures["vectors"]), unseen=unseen, turned=turned,
                         names=", ".join(figures["scenes"]), **{key: figures[key] for key in ["commit", "size", "spp"]}, bmfr=f"{figures['bmfr']:.3f}")


def write(out):
    folder = out / "denoisers"
    found = {section: read(folder, section) for section in ["methods", "static", "features"]}
    if not found["methods"]:
        return
    parts = [HEAD.format(**found["methods"]), motion(found["methods"]), beside(found["methods"])]
    parts += [page(found[name]) for name, page in [("static", static), ("features", features)] if found[name]]
    searched = read(folder, "search")
    # A search that was broken off has no figures of its last parts.
    if searched and "turned" in searched:
        parts.append(search(searched))
    parts.append(PAPER)
    (out / "DENOISERS.md").write_text("\n".join(parts))
