"""Measures pictures against the path tracer, the path tracer against Mitsuba, and metrics against other programs' metrics, section by
section. The figures go to docs/results, and from there into docs/RESULTS.md. All sections take hours on two cores.
"""

import math
import os
import statistics
import subprocess
from pathlib import Path

from . import page, results_page
from .program import ROOT, Program, parser, progress, read_json, write_json

SCENES = ["cornell-box", "sponza", "sibenik", "conference", "classroom", "living-room"]
ALL_KINDS = "tests/scene-files/all-kinds.toml"
FOUR_LIGHTS = "tests/scene-files/four-lights.toml"
PUNCTUAL = ["tests/scene-files/lamps-material-grid.toml", "tests/scene-files/lamps-damaged-helmet.toml"]
SKY_LIVING_ROOM = "tests/scene-files/sky-living-room.toml"
# Small pictures of many VPLs: every pixel gathers all of them.
REFERENCE_SIZE = "128x128"
LOSS_SIZE = "128x128"
CURVE_SIZE = "32x32"
CURVE_SEEDS = range(6)
# Their mean is the limit of the curves: other seeds than the curves'.
LIMIT_SEEDS = range(100, 110)
# A square: Mitsuba's sampler would round others up.
SPEED_SPP = 144


class Lab(Program):
    """Runs programs, and stores the figures of each section."""

    def __init__(self, options):
        super().__init__(options.glowworm, options.cache)
        self.figures = options.out / "results"

    def script(self, name, *arguments, check=True):
        return subprocess.run([ROOT / "scripts/study", name, *map(str, arguments)], check=check, stdout=subprocess.PIPE, text=True).stdout

    def scene(self, name):
        return ROOT / name if "/" in name else name

    def render(self, scene, out, *options):
        return self.run("render", self.scene(scene), "--out", out, *options)

    def trace(self, scene, out, *options):
        return self.run("reference", self.scene(scene), "--out", out, *options)

    def compare(self, image, reference, *options):
        return self.run("compare", image, reference, *options)

    def reference_of(self, scene, size, spp, *options):
        """The path tracer's picture with paths through pixel centres."""
        return self.reference(self.scene(scene), "--size", size, "--spp", spp, "--pixel-filter", "center", *options)[0]

    def keep(self, section, figures):
        write_json(self.figures / f"{section}.json", figures)


def mitsuba(lab):
    """The path tracer against Mitsuba, 256x256, 1,024 samples a pixel or more."""
    report = lab.folder / "mitsuba.json"
    rows = []
    # All light of the living room comes through its windows, which few paths find.
    rooms = ["living-room", lab.scene(SKY_LIVING_ROOM)]
    scenes = [*SCENES, "material-grid", "damaged-helmet", *map(lab.scene, [ALL_KINDS, *PUNCTUAL])]
    for spp, group in [(1024, [scene for scene in scenes if scene not in rooms]), (2304, rooms)]:
        lab.script("verify-with-mitsuba", "--spp", spp, "--size", "256x256", "--json", report, *group, check=False)
        figures = read_json(report)
        rows += [{**row, "spp": spp} for row in figures["rows"]]
    figures["rows"] = rows
    lab.keep("mitsuba", figures)


def reference(lab):
    """The light that 65,536 VPLs carry against the path tracer: clamp off, 64 temporal sets."""
    rows = []
    for scene in ["cornell-box", "sponza", "conference", FOUR_LIGHTS]:
        rendered = lab.folder / "rendered.exr"
        report = lab.render(scene, rendered, "--size", REFERENCE_SIZE, "--vpls", 65536, "--temporal-sets", 64,
                            "--interleave", 2, "--clamp", 0, "--bounces", 2, "--layers")
        expected = lab.reference_of(scene, REFERENCE_SIZE, 1024, "--bounces", 2)
        compared = lab.compare(rendered, expected, "--layer", "indirect", "--blocks", 16)
        vpls = report["frames"][-1]["vpls"]
        rows.append({"scene": Path(scene).stem, "mean_ratio": compared["mean_ratio"], **compared["blocks"],
                     "valid": vpls["valid"], "escaped": vpls["escaped"], "device": report["device"]})
    lab.keep("reference", {"size": REFERENCE_SIZE, "rows": rows})


def clamp(lab):
    """What the default clamp loses, with 512 and 65,536 VPLs."""
    rows = []
    for scene in SCENES + [FOUR_LIGHTS]:
        expected = lab.reference_of(scene, LOSS_SIZE, 512, "--bounces", 2)
        row = {"scene": Path(scene).stem}
        for vpls in [512, 65536]:
            for bound in ["default", "off"]:
                rendered = lab.folder / "rendered.exr"
                lab.render(scene, rendered, "--size", LOSS_SIZE, "--vpls", vpls, "--temporal-sets", 16, "--bounces", 2,
                           "--layers", *([] if bound == "default" else ["--clamp", 0]))
                compared = lab.compare(rendered, expected, "--layer", "indirect")
                row[f"{vpls} {bound}"] = compared["mean_ratio"]
        rows.append(row)
    lab.keep("clamp", {"size": LOSS_SIZE, "rows": rows})


def convergence(lab):
    """Error of the indirect light against the number of VPLs, with the sequence and with random numbers."""
    def render(out, count, sequence, seed):
        lab.render("cornell-box", out, "--size", CURVE_SIZE, "--vpls", count, "--temporal-sets", 16, "--interleave", 1,
                   "--bounces", 2, "--layers", "--sequence", sequence, "--seed", seed)

    limit = lab.folder / "limit.exr"
    if not limit.exists():
        parts = []
        for seed in LIMIT_SEEDS:
            parts.append(lab.folder / f"limit-{seed}.exr")
            render(parts[-1], 65536, "sobol", seed)
        write_mean_irradiance(parts, limit)
    counts = [2 ** power for power in range(6, 17)]
    curves = {}
    for sequence in ["sobol", "random"]:
        curves[sequence] = []
        for count in counts:
            errors = []
            for seed in CURVE_SEEDS:
                rendered = lab.folder / "rendered.exr"
                render(rendered, count, sequence, seed)
                errors.append(lab.compare(rendered, limit, "--layer", "indirect"))
            # Over pixels and seeds alike: the root of the mean square, the mean of the absolute.
            curves[sequence].append({"rmse": math.sqrt(statistics.fmean(error["rmse"] ** 2 for error in errors)),
                                     "mae": statistics.fmean(error["mae"] for error in errors)})
    slopes = {sequence: {key: slope(counts, [point[key] for point in curve]) for key in ["rmse", "mae"]}
              for sequence, curve in curves.items()}
    lab.keep("convergence", {"size": CURVE_SIZE, "seeds": len(CURVE_SEEDS), "limit_seeds": len(LIMIT_SEEDS),
                             "counts": counts, "curves": curves, "slopes": slopes})


def write_mean_irradiance(pictures, out):
    import numpy
    import OpenEXR

    total = 0
    for picture in pictures:
        parts = {part.name(): part for part in OpenEXR.File(str(picture)).parts}
        total = total + parts["indirect"].channels["RGB"].pixels.astype(numpy.float64)
    mean = (total / len(pictures)).astype(numpy.float32)
    # The same name as in the renderer's pictures, so that they can be compared.
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    OpenEXR.File([OpenEXR.Part(header, {"RGB": mean}, "indirect")]).write(str(out))


def slope(counts, errors):
    return statistics.linear_regression(list(map(math.log, counts)), list(map(math.log, errors))).slope


def temporal(lab):
    """The dissertation's figure 30: every metric with and without temporal sets."""
    keys = ["mae", "rmse", "relmse", "psnr", "ssim", "flip", "mean_ratio", "p95_relative_error"]
    rows = []
    for scene in ["cornell-box", "sponza"]:
        expected = lab.reference_of(scene, "256x256", 512, "--bounces", 2)
        for sets in [1, 16]:
            rendered = lab.folder / "rendered.exr"
            lab.render(scene, rendered, "--size", "256x256", "--temporal-sets", sets, "--frames", sets, "--bounces", 2)
            compared = lab.compare(rendered, expected)
            rows.append({"scene": scene, "sets": sets, **{key: compared[key] for key in keys}})
    lab.keep("temporal", {"size": "256x256", "keys": keys, "rows": rows})


def speed(lab):
    """Seconds of the path tracer and of Mitsuba's variants, alternating."""
    rows = []
    for variant in ["scalar_rgb", "llvm_ad_rgb"]:
        for scene in ["sponza", "conference"]:
            ratios, seconds = [], []
            for _ in range(3):
                report = lab.folder / "speed.json"
                lab.script("verify-with-mitsuba", "--variant", variant, "--spp", SPEED_SPP, "--size", "256x256",
                           "--bounces", 2, "--json", report, scene, check=False)
                row = read_json(report)["rows"][0]
                ratios.append(row["mitsuba_seconds"] / row["glowworm_seconds"])
                seconds.append((row["glowworm_seconds"], row["mitsuba_seconds"]))
            middle = sorted(range(3), key=ratios.__getitem__)[1]
            rows.append({"variant": variant, "scene": scene, "ratios": sorted(ratios), "seconds": seconds[middle]})
    lab.keep("speed", {"size": "256x256", "spp": SPEED_SPP, "cores": os.cpu_count(), "rows": rows})


def metrics(lab):
    """The metrics of `compare` against scikit-image and flip-evaluator."""
    lab.keep("metrics", {"table": lab.script("check-metrics")})


def pictures(lab):
    """The same view by the renderer and by the path tracer, and where they differ."""
    for scene in ["cornell-box", "sponza", "conference"]:
        rendered, expected = lab.folder / "rendered.exr", lab.folder / f"picture-{scene}.exr"
        common = ["--size", "320x240", "--bounces", 2]
        shown = ["--exposure", {"cornell-box": 1.5, "sponza": -0.5, "conference": -1.5}[scene]]
        lab.trace(scene, expected, "--spp", 512, *common)
        lab.trace(scene, lab.figures / f"{scene}-reference.png", "--spp", 512, *common, *shown)
        lab.render(scene, rendered, *common)
        lab.render(scene, lab.figures / f"{scene}-render.png", *common, *shown)
        lab.compare(rendered, expected, "--heatmap", lab.figures / f"{scene}-flip.png")


def main():
    sections = {section.__name__: section for section in [mitsuba, reference, clamp, convergence, temporal, speed, metrics, pictures]}
    options = parser("results", __doc__, sections).parse_args()
    if not options.page_only:
        lab = Lab(options)
        for section in options.sections or sections:
            progress(f"{section}: {sections[section].__doc__}")
            sections[section](lab)
    page.fill(options.out / "RESULTS.md", results_page.figures(options.out / "results"))
