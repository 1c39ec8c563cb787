"""Generates docs/RESULTS.md from the figures in docs/results."""

import json

import matplotlib

matplotlib.use("Agg")
matplotlib.rcParams["svg.hashsalt"] = "glowworm"
from matplotlib import pyplot  # noqa: E402 the backend comes first


def percent(share, digits=1):
    return f"{100 * share:.{digits}f} %"


def table(head, rows):
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows])


def mitsuba(figures, _):
    rows = [[r["scene"], f"{r['spp']:,}", f"{r['mean_ratio']:.4f}", percent(r["blocks_within_3_percent"]),
             percent(r["block_p95"], 2)] for r in figures["rows"]]
    head = ["scene", "samples a pixel", "mean, glowworm over Mitsuba", "blocks within 3 %", "95 % of blocks within"]
    return f"""## The path tracer against Mitsuba

`glowworm reference` and Mitsuba {figures['mitsuba']} ({figures['variant']}) on what `glowworm export` wrote, {figures['size']},
2 bounces. Blocks are of 16 x 16 pixels, by mean luminance. Materials that Mitsuba does not have come from the
`glowworm_bsdf.py` of the export.

{table(head, rows)}
"""


def reference(figures, _):
    rows = [[r["scene"], f"{r['mean_ratio']:.4f}", percent(r["within_5_percent"]), percent(r["p95_relative_error"], 2),
             f"{r['valid']:,}", f"{r['escaped']:,}"] for r in figures["rows"]]
    head = ["scene", "mean, renderer over path tracer", "blocks within 5 %", "95 % of blocks within", "valid VPLs", "escaped"]
    return f"""## The light of VPLs against the path tracer

The indirect part alone (irradiance), 65,536 VPLs in 64 temporal sets, 2 bounces, clamp off, interleave 2,
{figures['size']}, on {figures['rows'][0]['device']}; blocks of 16 x 16 pixels.

{table(head, rows)}

Sponza's blocks fall short of 95 %: two thirds of the paths of its light leave through the roof, and without a clamp single
VPLs that lie near a visible corner outweigh the hundreds of others that light a block. By block the medians agree; what is
left falls slowly with the number of VPLs, as such heavy tails do (interleave 1, means over several seeds): 72 to 87 % of the
blocks with 65,536 VPLs, 88 % with twice, 91 % with three times as many.
"""


def clamp(figures, _):
    rows = [[r["scene"], *(f"{r[f'{vpls} {bound}']:.3f}" for vpls in [512, 65536] for bound in ["default", "off"])]
            for r in figures["rows"]]
    head = ["scene", "512 VPLs", "512, clamp off", "65,536 VPLs", "65,536, clamp off"]
    return f"""## What the clamp costs

Mean indirect light over the path tracer's, {figures['size']}, 2 bounces, with the default `--clamp` and without. What is
missing lies in corners and where objects touch. With few VPLs the mean without a clamp also depends on whether one
happens to lie next to something that is seen.

{table(head, rows)}
"""


def convergence(figures, folder):
    figure, axes = pyplot.subplots(figsize=(6.4, 4.2), layout="constrained")
    for sequence, marker in [("sobol", "o"), ("random", "s")]:
        curve = [point["rmse"] for point in figures["curves"][sequence]]
        axes.loglog(figures["counts"], curve, marker=marker,
                    label=f"{sequence}: slope {figures['slopes'][sequence]['rmse']:.2f}")
    axes.set(xlabel="VPLs", ylabel="RMSE of the irradiance, W/m²", title="cornell-box")
    axes.grid(True, which="both", alpha=0.3)
    axes.legend()
    figure.savefig(folder / "convergence.svg", metadata={"Date": None})
    pyplot.close(figure)
    rows = [[f"{count:,}", *(f"{figures['curves'][s][i][key]:.4f}" for key in ["rmse", "mae"] for s in ["sobol", "random"])]
            for i, count in enumerate(figures["counts"])]
    slopes = ["slope", *(f"{figures['slopes'][s][key]:.2f}" for key in ["rmse", "mae"] for s in ["sobol", "random"])]
    head = ["VPLs", "RMSE", "RMSE, random", "MAE", "MAE, random"]
    return f"""## Convergence

Error of the indirect light of the Cornell box against the number of VPLs, {figures['size']}, default settings but interleave 1,
over {figures['seeds']} seeds: with the Owen-scrambled Sobol sequence, and with independent random numbers
(`--sequence random`). The limit is the mean of {figures['limit_seeds']} pictures of 65,536 VPLs with other seeds; how far that is
from the path tracer's, the clamp table says.

![RMSE against the number of VPLs, on logarithmic axes](results/convergence.svg)

{table(head, [*rows, slopes])}
"""


def temporal(figures, _):
    def shown(row, key):
        return f"{row[key]:.3g}" if key != "mean_ratio" else f"{row[key]:.3f}"

    rows = [[r["scene"], str(r["sets"]), *(shown(r, key) for key in figures["keys"])] for r in figures["rows"]]
    return f"""## With and without temporal sets

The dissertation's figure 30: a still picture of 512 VPLs, {figures['size']}, default settings, against the path tracer, rendered
in one frame and in 16.

{table(["scene", "T", *figures["keys"]], rows)}
"""


def speed(figures, _):
    rows = [[r["scene"], r["variant"], f"{r['seconds'][0]:.1f}", f"{r['seconds'][1]:.1f}",
             f"{r['ratios'][1]:.2f}", f"{r['ratios'][0]:.2f} to {r['ratios'][2]:.2f}"] for r in figures["rows"]]
    head = ["scene", "Mitsuba's variant", "glowworm, s", "Mitsuba, s", "times as fast", "of three runs"]
    return f"""## Speed of the path tracer

`glowworm reference` and Mitsuba alternating, {figures['size']}, {figures['spp']} samples per pixel, 2 bounces, {figures['cores']} cores, without loading.

{table(head, rows)}
"""


def metrics(figures, _):
    return f"""## Metrics against other programs

`glowworm compare`, scikit-image (SSIM) and flip-evaluator (FLIP) on the same pairs of pictures (`scripts/check-metrics`).

```text
{figures['table'].strip()}
```
"""


def pictures(folder):
    rows = []
    for scene in ["cornell-box", "sponza", "conference"]:
        if (folder / f"{scene}-render.png").exists():
            rows.append([scene, *(f"![{scene}, {what}](results/{scene}-{what}.png)" for what in ["render", "reference", "flip"])])
    if not rows:
        return ""
    head = ["", "`render`, 512 VPLs", "`reference`, 512 samples a pixel", "HDR-FLIP"]
    return f"## Pictures\n\n{table(head, rows)}\n"


SECTIONS = [mitsuba, reference, clamp, convergence, temporal, speed, metrics]


def write(root):
    """Writes the page from the available figures."""
    folder = root / "docs" / "results"
    parts = ["""# Results

How far the pictures are from the reference, measured by `scripts/results`; run it to have the same for your machine.
The renderer is judged by the path tracer (`glowworm reference`), and the path tracer by
[Mitsuba 3](https://www.mitsuba-renderer.org), a renderer that nobody here wrote.

Pictures and figures of `render` are of an earlier version (commit cac0112), before sets accumulated their turns and still frames were averaged.
""", pictures(folder)]
    for section in SECTIONS:
        file = folder / f"{section.__name__}.json"
        if file.exists():
            parts.append(section(json.loads(file.read_text()), folder))
    (root / "docs" / "RESULTS.md").write_text("\n".join(part for part in parts if part))
