"""The figures of docs/HYBRID.md and its plots, from docs/hybrid."""

from .page import plot, table
from .program import read_json

# SSIM of the thesis over roughness 0, .1, .2, .3, .4, .6, 1: still, SVGF alone.
THESIS = {"boxes": [0.9459, 0.9782, 0.9717, 0.9679, 0.9664, 0.9665, 0.9677],
          "icosphere": [0.9022, 0.9539, 0.9592, 0.9597, 0.9585, 0.9396, 0.9374]}
WHAT = {"boxes": "roughness", "icosphere": "roughness", "sponza": "roughness", "pillars": "half angle, degrees", "objects": "half angle, degrees"}
MOTIONS = {"still": "still", "camera": "the camera strafes", "objects": "an object crosses", "light": "the light turns"}
BLURS = {"objects": "soft_shadows_svgf_atrous", "boxes": "reflections_svgf_atrous"}
# Milliseconds that a pass takes at least in some column, to have a row.
LEAST_MS = 2


class Figures:
    """The measured rows, by scene, motion, value and variant."""

    def __init__(self, figures):
        self.all = figures
        self.rows = {(row["scene"], row["motion"], row["value"], row["variant"]): row for row in figures["rows"]}
        self.scenes = list(dict.fromkeys(row["scene"] for row in figures["rows"]))
        self.variants = list(dict.fromkeys(key[3] for key in self.rows))

    def values(self, scene):
        return sorted({key[2] for key in self.rows if key[0] == scene})

    def cell(self, *key):
        row = self.rows.get(key)
        return f"{row['ssim']:.3f} / {row['flip']:.3f}" if row else ""


def plotted(figures, scene, folder):
    """SSIM over roughness or half angle; solid: default; dotted: SVGF alone."""
    values = figures.values(scene)
    lines = []
    for colour, (motion, label) in enumerate(MOTIONS.items()):
        for variant, style in [("default", {"marker": "o", "markersize": 3, "label": label}), ("SVGF", {"linestyle": ":"})]:
            points = [(place, figures.rows[scene, motion, value, variant]["ssim"]) for place, value in enumerate(values)
                      if (scene, motion, value, variant) in figures.rows]
            if points:
                lines.append((points, {"color": f"C{colour}", **style}))
    plot(folder / f"{scene}.svg", lines, xlabel=WHAT[scene], ylabel="SSIM against the path tracer", xticks=range(len(values)),
         xticklabels=[f"{value:g}" for value in values])


def over_values(figures, scene):
    values = figures.values(scene)
    rows = [[label if variant == "default" else "", variant, *(figures.cell(scene, motion, value, variant) for value in values)]
            for motion, label in MOTIONS.items() for variant in ["default", "SVGF"]]
    if scene in THESIS:
        rows.append(["still", "thesis, SVGF", *(f"{ssim:.3f}" for ssim in THESIS[scene])])
    return table(["", "", *(f"{value:g}" for value in values)], rows)


def extensions(figures):
    columns = ["SVGF", *(name for name in figures.variants if name.startswith("+")), "default", "all", "white noise",
               "not denoised", *(name for name in figures.variants if name.endswith("samples")), "reference again"]
    rows = [[f"{scene} {value:g}, {motion}", *(figures.cell(scene, motion, value, column) for column in columns)]
            for scene, motion, value, variant in figures.rows if variant == "all"]
    return table(["", *columns], rows)


def times(rows):
    passes = [name for name in next(iter(rows.values())) if any(row[name] >= LEAST_MS for row in rows.values())]
    return table(["pass", *rows], [[name, *(f"{row[name]:.1f}" for row in rows.values())] for name in passes])


def figures(folder):
    """Draws the plots, and gives the texts of the page by their marks."""
    measured = read_json(folder / "figures.json")
    if not measured:
        return {}
    figures = Figures(measured)
    for scene in figures.scenes:
        plotted(figures, scene, folder)
    found = {scene: over_values(figures, scene) for scene in figures.scenes}
    found |= {"measured": f"{measured['size']}, commit {measured['commit']}, {measured['device']} ({measured['driver']}), {measured['spp']} samples a pixel of the reference",
              "extensions": extensions(figures)}
    if measured["times"]:
        rows = measured["times"]
        ratios = [rows[f"{scene}, + separable"][blur] / rows[f"{scene}, default"][blur] for scene, blur in BLURS.items()]
        found |= {"times": times(rows), "separable": " and ".join(f"{ratio:.2f}" for ratio in ratios)}
    return found
