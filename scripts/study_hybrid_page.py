"""Generates docs/HYBRID.md and its plots from the figures in docs/hybrid."""

import json
import re
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
matplotlib.rcParams["svg.hashsalt"] = "glowworm"
# Letters as text.
matplotlib.rcParams["svg.fonttype"] = "none"
from matplotlib import pyplot  # noqa: E402 the backend comes first

# SSIM of the thesis over roughness 0, .1, .2, .3, .4, .6, 1: still, SVGF alone. Its Sponza has one for each of
# three sets of materials.
THESIS = {"boxes": [0.9459, 0.9782, 0.9717, 0.9679, 0.9664, 0.9665, 0.9677],
          "icosphere": [0.9022, 0.9539, 0.9592, 0.9597, 0.9585, 0.9396, 0.9374]}
THESIS_SPONZA = "0.791, 0.893, 0.899"
# What stills and sequences are to reach.
TARGETS = {"boxes": (0.97, 0.95), "icosphere": (0.97, 0.95), "sponza": (0.93, 0.90), "pillars": (0.98, 0.95), "objects": (0.98, 0.95)}
WHAT = {"boxes": "roughness", "icosphere": "roughness", "sponza": "roughness", "pillars": "half angle", "objects": "half angle"}
MOTIONS = {"still": "still", "camera": "the camera strafes", "objects": "an object crosses", "light": "the light turns"}

HEAD = """# Soft shadows and reflections

`--direct soft` and `--reflections rays`, denoised by SVGF (`src/denoise/`), against the path tracer. The scenes are after those of
P. Granja, *Real Time Hybrid Rendering Techniques*, 2021, whose models are not public: **boxes** ever farther from a mirror, an
**icosphere** of wires above a glossy floor, **sponza** with glossier stone, a row of thin **pillars**, large plain **objects**
(`scripts/hybrid_scenes.py`). Compared is the light of the effect alone, in linear values: the layer `reflected` or `shadow` of
`render --layers --antialiasing none --indirect none` with that of `reference --pixel-filter center` (`--bounces 1` and 0).

{size}, commit {commit}, {device} ({driver}), {spp} samples a pixel of the reference (16 of
sharp mirrors and shadows). Still: after 32 frames. In motion: the 40th frame, with motion since the first. To make this page, in about an hour:

```sh
scripts/study-hybrid     # --help lists the options
```
"""

EXTENSIONS = """## Each extension

SSIM / HDR-FLIP. **SVGF** is the paper's alone (`--svgf-history-rejection 0 --svgf-firefly 0 --svgf-adaptive false`); **+** adds one extension to it;
**default** has history rejection, the firefly filter and the adaptive blur; **all** also the separable blur and Reinhard's curve; the last two
columns show what the path tracer has at {noisy} and how much of the error is noise of the reference itself.

{table}

Over these rows the adaptive blur alone measures best. The firefly filter helps sponza and costs some at roughness 0.2 of boxes and icosphere; it
stays on, as lone bright samples flicker. The separable blur costs little, Reinhard's curve quality; both stay off. Reinhard's
curve is inverted exactly; what it darkens is noise, whose mean lies below the curve of the mean (Jensen).
"""

LIMITS = """The path tracer at pixel centres looks textures and normal maps up at full size, the renderer in mip levels, so relief and stone of
sponza differ where they are small (albedo by 0.02 in the mean): that, not noise, decides its rows at low roughness. "Reference again" says
how much noise the reference itself has. The path tracer's samples of a light are stratified, so 16 of them are better than 32 frames of
one ray; what the denoiser adds over its input is the step from "not denoised" to "default".
"""

TIMES = """## Times

Median milliseconds of a pass under a moving camera, 512x512, {device}, one run after another: sharp ratios, slow numbers. One ray a
pixel casts soft shadows (`objects`, half angle 4 degrees) or mirrors (`boxes`, roughness 0.2, two bounces).

{table}

The separable blur takes {ratio} of the full one's time, over {levels} levels. Bytes a pixel: see [ARCHITECTURE](../ARCHITECTURE.md#the-frame).
"""

TESTS = """## Where each claim is tested

| what | where |
|---|---|
| cone and area sampling: mean of rays against the path tracer, by blocks | `tests/renderer/soft_shadows.rs` |
| GGX visible normals: mean at roughness 0, 0.2, 0.6, metal and dielectric; a mirror shows what is seen from the mirrored place | `tests/renderer/reflections.rs` |
| light of VPLs, thin surfaces and area lights in mirrors; blend above the roughness limit | `tests/renderer/mirrors.rs`, `soft_shadows.rs` |
| hundred lights, one ray a pixel | `tests/renderer/soft_shadows.rs` |
| spectrum of blue and white noise | `tests/device/noise.rs` |
| each stage of SVGF against its CPU twin; impulse, edge, grazing plane, alpha, NaN | `tests/denoise/` |
| disocclusion, reach of history, lights that go | `tests/denoise/`, `tests/renderer/soft_shadows.rs`, `reflections.rs` |
| a blur that roughness and penumbrae widen; each test of reprojection left out by itself | `tests/denoise/svgf.rs`, `reprojection.rs` |
| separable blur: time beside the full one | `benches/passes.rs` |
| antialiasing: edges, contrast in motion, trails | `tests/renderer/taa.rs` |
| stillness bit for bit, no dependence on the past | `tests/renderer/soft_shadows.rs`, `mirrors.rs`, `taa.rs` |
"""


def table(head, rows):
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows])


class Figures:
    """The measured rows, by scene, motion, value and variant."""

    def __init__(self, figures):
        self.all = figures
        self.rows = {(row["scene"], row["motion"], row["value"], row["variant"]): row for row in figures["rows"]}
        self.scenes = list(dict.fromkeys(row["scene"] for row in figures["rows"]))

    def values(self, scene):
        return sorted({key[2] for key in self.rows if key[0] == scene})

    def get(self, scene, motion, value, variant, figure="ssim"):
        row = self.rows.get((scene, motion, value, variant))
        return row and row[figure]

    def variants(self):
        return list(dict.fromkeys(key[3] for key in self.rows))


def plot(figures, scene, folder):
    """SSIM over roughness or half angle; solid: default; dashed: SVGF alone."""
    figure, axes = pyplot.subplots(figsize=(6.4, 3.4))
    values = figures.values(scene)
    places = range(len(values))
    for colour, (motion, label) in enumerate(MOTIONS.items()):
        for variant, style in [("default", "-"), ("SVGF", ":")]:
            line = [(place, figures.get(scene, motion, value, variant)) for place, value in zip(places, values)]
            axes.plot(*zip(*[point for point in line if point[1] is not None]), style, color=f"C{colour}", marker="o" if variant == "default" else None, markersize=3,
                      label=label if variant == "default" else None)
    axes.set_xticks(places, [f"{value:g}" for value in values])
    unit = ", degrees" if WHAT[scene] == "half angle" else ""
    axes.set_xlabel(WHAT[scene] + unit)
    axes.set_ylabel("SSIM against the path tracer")
    axes.grid(alpha=0.3)
    axes.legend(fontsize=8)
    figure.tight_layout()
    figure.savefig(folder / f"{scene}.svg", metadata={"Date": None})
    pyplot.close(figure)


def over_values(figures, scene):
    values = figures.values(scene)
    rows = []
    for motion, label in MOTIONS.items():
        for variant in ["default", "SVGF"]:
            cells = [cell(figures, scene, motion, value, variant) for value in values]
            rows.append([label if variant == "default" else "", variant, *cells])
    if scene in THESIS:
        rows.append(["still", "thesis, SVGF", *(f"{ssim:.3f}" for ssim in THESIS[scene])])
    head = ["", "", *(f"{value:g}" for value in values)]
    note = f"The thesis has {THESIS_SPONZA} for three sets of materials, still.\n" if scene == "sponza" else ""
    return f"""### {scene}

![SSIM of {scene} over {WHAT[scene]}, still and in motion](hybrid/{scene}.svg)

Over {WHAT[scene]}, SSIM / HDR-FLIP:

{table(head, rows)}
{note}"""


def cell(figures, scene, motion, value, variant):
    ssim, flip = (figures.get(scene, motion, value, variant, name) for name in ["ssim", "flip"])
    return "" if ssim is None else f"{ssim:.3f} / {flip:.3f}"


def extensions(figures):
    columns = ["SVGF", *(name for name in figures.variants() if name.startswith("+")), "default", "all", "white noise",
               "not denoised", *(name for name in figures.variants() if name.endswith("samples")), "reference again"]
    rows = []
    for scene, motion, value, variant in figures.rows:
        if variant == "all":
            cells = [cell(figures, scene, motion, value, column) for column in columns]
            rows.append([f"{scene} {value:g}, {motion}", *cells])
    noisy = next(name for name in columns if name.endswith("samples"))
    return EXTENSIONS.format(noisy=noisy, table=table(["", *columns], rows))


def misses(figures):
    """What falls short of the targets, said by itself."""
    lines = []
    for scene in figures.scenes:
        for motion in MOTIONS:
            least = TARGETS[scene][0 if motion == "still" else 1]
            found = [(value, figures.get(scene, motion, value, "default")) for value in figures.values(scene)]
            below = [f"{value:g} ({ssim:.3f})" for value, ssim in found if ssim is not None and ssim < least]
            if below:
                lines.append(f"- {scene}, {MOTIONS[motion]}: below {least:g} at {WHAT[scene]} {', '.join(below)}")
    worse = [f"{scene} {value:g} {motion}" for scene, motion, value, variant in figures.rows if variant.endswith("samples")
             and figures.get(scene, motion, value, "default", "flip") >= figures.rows[scene, motion, value, variant]["flip"]]
    lines.append(f"- HDR-FLIP above that of the path tracer at 16 samples: {', '.join(worse) if worse else 'nowhere'}")
    return "## What falls short\n\n" + "\n".join(lines) + "\n\n" + LIMITS


def times(figures):
    rows = figures.all["times"]
    if not rows:
        return ""
    passes = [name for name in next(iter(rows.values())) if any(row[name] >= 0.05 for row in rows.values())]
    lines = [[name, *(f"{row[name]:.1f}" for row in rows.values())] for name in passes]
    blurs = {"objects": "soft_shadows_svgf_atrous", "boxes": "reflections_svgf_atrous"}
    ratios = [rows[f"{scene}, + separable"][blur] / rows[f"{scene}, default"][blur] for scene, blur in blurs.items()]
    return TIMES.format(table=table(["pass", *rows], lines), ratio=" and ".join(f"{ratio:.2f}" for ratio in ratios), levels=4,
                        device=figures.all["device"])


def write(docs):
    """Writes the page and its plots from the figures."""
    folder = Path(docs) / "hybrid"
    if not (folder / "figures.json").exists():
        return
    figures = Figures(json.loads((folder / "figures.json").read_text()))
    for scene in figures.scenes:
        plot(figures, scene, folder)
    parts = [HEAD.format(**{key: figures.all[key] for key in ["size", "spp", "commit", "device", "driver"]})]
    parts += ["## Roughness and half angle\n", *(over_values(figures, scene) for scene in figures.scenes)]
    parts += [extensions(figures), misses(figures), times(figures), TESTS]
    text = re.sub(r"\n{3,}", "\n\n", "\n".join(parts))
    (Path(docs) / "HYBRID.md").write_text(text)
