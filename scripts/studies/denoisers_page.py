"""The methods of scripts/study denoisers, and the figures of docs/DENOISERS.md, from docs/denoisers."""

from .page import columns, table
from .program import read_json

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

# What the page shows of the methods; the figures of all are in docs/denoisers/methods.json.
SHOWN = ["paths, noisy", "paths, accumulation alone", "paths, SVGF", "paths, SVGF, direct light apart", "paths, BMFR", "VPLs", "VPLs, BMFR",
         "VPLs, no denoiser"]
SHOWN_AGES = ["0", "1", "4-7", "16-"]
# RMSE and SSIM in Flatval 2020, by scene and denoiser.
THESIS = {"sponza": {"SVGF": (.031, .888), "BMFR": (.029, .889)},
          "living-room": {"SVGF": (.045, .841), "BMFR": (.035, .872)},
          "atrium-drapery": {"SVGF": (.033, .867), "BMFR": (.037, .834)}}
ROWS = [("RMSE", "luminance_rmse", ".4f"), ("SSIM", "luminance_ssim", ".3f"), ("HDR-FLIP", "flip", ".3f"), ("mean", "mean_ratio", ".3f"),
        ("flicker", "flicker", ".3f"), ("ms", "ms", ".0f"), ("denoiser", "denoiser_ms", ".1f"), ("rays", "rays", ".1f")]


def shown(row):
    return {name: row[name] for name in SHOWN if name in row}


def motion(figures):
    return "\n\n".join(f"**{scene}**\n\n" + columns(shown(row), ROWS, "method") for scene, row in figures["rows"].items())


def ages(figures):
    def cell(row, age):
        found = row["by_frames_seen"].get(age)
        return "" if found is None else f"{found:.4f}"

    scenes = figures["rows"]
    head = ["method", *(f"{scene}, {age}" for scene in scenes for age in SHOWN_AGES)]
    return table(head, [[name, *(cell(row[name], age) for row in scenes.values() for age in SHOWN_AGES)] for name in SHOWN])


def beside(figures):
    rows = []
    for scene, thesis in THESIS.items():
        row = figures["rows"][scene]
        one = row["paths, noisy, no TAA"]["luminance_rmse"]
        cells = [scene, f"{one:.3f}"]
        for denoiser, (rmse, ssim) in thesis.items():
            ours = row[f"paths, {denoiser}"]
            cells += [f"{ours['luminance_rmse']:.3f} / {ours['luminance_ssim']:.3f}", f"{ours['luminance_rmse'] / one:.2f}", f"{rmse:.3f} / {ssim:.3f}"]
        rows.append(cells)
    return table(["scene", "one sample", "SVGF", "over one sample", "thesis", "BMFR", "over one sample", "thesis"], rows)


def static(figures):
    rows = figures["rows"]
    return table(["method", *rows], [[name, *(f"{row[name]:.4f}" if name in row else "" for row in rows.values())] for name in SHOWN])


def features(figures):
    def cell(row, count):
        found = row.get(str(count))
        return f"{found['luminance_rmse']:.4f} / {found['flip']:.3f} / {found['fit_ms']:.1f}" if found else ""

    rows = figures["rows"]
    return table(["features", *rows], [[count, *(cell(row, count) for row in rows.values())] for count in FEATURE_COUNTS])


def search(found):
    """The texts of the search, by their marks."""
    def steps(lists):
        added = zip([[], *(step["features"] for step in lists)], lists)
        return table(["features", "cost", "added"], [[len(step["features"]), f"{step['cost']:.3f}", f"`{', '.join(step['features'][len(before):])}`"]
                                                     for before, step in added])

    names = {"bmfr": "BMFR's ten", "found": "found by component"}
    return {
        "search-bmfr": f"{found['bmfr']:.3f}", "search-commit": found["commit"], "search-components": steps(found["components"]),
        "search-vectors": steps(found["vectors"]),
        "search-errors": table(["HDR-FLIP / VMAF", *found["scenes"]], [
            [name, *(f"{flip:.3f} / {100 - lack:.1f}" for flip, lack in found["errors"][key])] for key, name in names.items()]),
        "search-unseen": table(["scene", "found on the others", "BMFR's ten", "found"], [
            [scene, f"{row['cost']:.3f}", f"{row['bmfr']:.3f}", f"`{', '.join(row['features'])}`"] for scene, row in found["unseen"].items()]),
        "search-turned": table(["features", "x", "y", "z"], [[name, *(f"{cost:.3f}" for cost in found["turned"][key])]
                                                             for key, name in names.items()])}


def figures(folder):
    """The texts of the page by their marks."""
    found = {}
    methods = read_json(folder / "methods.json")
    if methods:
        found |= {"device": f"{methods['device']} ({methods['driver']})", "motion": motion(methods), "ages": ages(methods), "beside": beside(methods),
                  "references": "; ".join(f"{scene} {row['spp']}, {row['commit']}" for scene, row in methods["rows"].items())}
    for name, text in {"static": static, "features": features}.items():
        measured = read_json(folder / f"{name}.json")
        if measured:
            found |= {name: text(measured), f"{name}-commit": measured["commit"] + measured.get("note", "")}
    searched = read_json(folder / "search.json")
    # A search that was broken off has no figures of its last parts.
    return found | (search(searched) if searched and "turned" in searched else {})
