"""The program of scripts/results: measures section by section, and writes docs/RESULTS.md."""

import argparse
import json
import math
import os
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

import results_page

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


class Lab:
    """Runs programs in one folder and stores the figures of each section."""

    def __init__(self, root, folder):
        self.root = root
        self.folder = folder
        self.figures = root / "docs" / "results"

    def script(self, name, *arguments, check=True):
        return subprocess.run([str(self.root / name), *map(str, arguments)], check=check, stdout=subprocess.PIPE,
                              text=True).stdout

    def scene(self, name):
        return str(self.root / name) if "/" in name else name

    def render(self, scene, out, *options):
        report = self.folder / "render.json"
        self.script("glowworm", "render", self.scene(scene), "--out", out, "--json", report, *options)
        return json.loads(report.read_text())

    def trace(self, scene, out, *options):
        report = self.folder / "reference.json"
        self.script("glowworm", "reference", self.scene(scene), "--out", out, "--json", report, *options)
        return json.loads(report.read_text())

    def compare(self, image, reference, *options):
        report = self.folder / "compare.json"
        self.script("glowworm", "compare", image, reference, "--json", report, *options)
        return json.loads(report.read_text())

    def reference(self, scene, size, spp, *options):
        """The path tracer's picture with paths through pixel centres, rendered once for each set of options."""
        name = "-".join([Path(scene).stem, size, str(spp), *map(str, options)]).replace("/", "_")
        picture = self.folder / f"reference-{name}.exr"
        if not picture.exists():
            self.trace(scene, picture, "--size", size, "--spp", spp, "--pixel-filter", "center", "--layers", *options)
        return picture

    def keep(self, section, figures):
        self.figures.mkdir(parents=True, exist_ok=True)
        (self.figures / f"{section}.json").write_text(json.dumps(figures, indent=1) + "\n")


def mitsuba(lab):
    """The path tracer against Mitsuba, 256x256, 1,024 samples a pixel or more."""
    report = lab.folder / "mitsuba.json"
    rows = []
    # All light of the living room comes through its windows, which few paths find.
    rooms = ["living-room", lab.scene(SKY_LIVING_ROOM)]
    scenes = [*SCENES, "material-grid", "damaged-helmet", *map(lab.scene, [ALL_KINDS, *PUNCTUAL])]
    for spp, group in [(1024, [scene for scene in scenes if scene not in rooms]), (2304, rooms)]:
        lab.script("scripts/verify-with-mitsuba", "--spp", spp, "--size", "256x256", "--json", report, *group, check=False)
        figures = json.loads(report.read_text())
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
        expected = lab.reference(scene, REFERENCE_SIZE, 1024, "--bounces", 2)
        compared = lab.compare(rendered, expected, "--layer", "indirect", "--blocks", 16)
        vpls = report["frames"][-1]["vpls"]
        rows.append({"scene": Path(scene).stem, "mean_ratio": compared["mean_ratio"], **compared["blocks"],
                     "valid": vpls["valid"], "escaped": vpls["escaped"], "device": report["device"]})
    lab.keep("reference", {"size": REFERENCE_SIZE, "rows": rows})


def clamp(lab):
    """What the default clamp loses, with 512 and 65,536 VPLs."""
    rows = []
    for scene in SCENES + [FOUR_LIGHTS]:
        expected = lab.reference(scene, LOSS_SIZE, 512, "--bounces", 2)
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
        expected = lab.reference(scene, "256x256", 512, "--bounces", 2)
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
                lab.script("scripts/verify-with-mitsuba", "--variant", variant, "--spp", SPEED_SPP, "--size", "256x256",
                           "--bounces", 2, "--json", report, scene, check=False)
                row = json.loads(report.read_text())["rows"][0]
                ratios.append(row["mitsuba_seconds"] / row["glowworm_seconds"])
                seconds.append((row["glowworm_seconds"], row["mitsuba_seconds"]))
            middle = sorted(range(3), key=ratios.__getitem__)[1]
            rows.append({"variant": variant, "scene": scene, "ratios": sorted(ratios), "seconds": seconds[middle]})
    lab.keep("speed", {"size": "256x256", "spp": SPEED_SPP, "cores": os.cpu_count(), "rows": rows})


def metrics(lab):
    """The metrics of `compare` against scikit-image and flip-evaluator."""
    lab.keep("metrics", {"table": lab.script("scripts/check-metrics")})


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


SECTIONS = [mitsuba, reference, clamp, convergence, temporal, speed, metrics, pictures]


def main():
    root = Path(sys.argv.pop(1))
    listed = "\n".join(f"  {section.__name__:12} {section.__doc__}" for section in SECTIONS)
    parser = argparse.ArgumentParser(prog="results", description=__doc__, epilog=f"sections:\n{listed}",
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sections", nargs="*", metavar="SECTION", help="otherwise all")
    parser.add_argument("--page-only", action="store_true", help="measure nothing, write the page")
    parser.add_argument("--keep", type=Path, metavar="DIR", help="work in this folder and leave pictures there")
    options = parser.parse_args()
    known = {section.__name__: section for section in SECTIONS}
    for name in options.sections:
        if name not in known:
            parser.error(f"{name}: no such section")
    chosen = [] if options.page_only else [known[name] for name in options.sections] or SECTIONS
    with tempfile.TemporaryDirectory(prefix="results.") as scratch:
        folder = options.keep or Path(scratch)
        folder.mkdir(parents=True, exist_ok=True)
        lab = Lab(root, folder)
        for section in chosen:
            print(f"{section.__name__}: {section.__doc__}", file=sys.stderr, flush=True)
            section(lab)
        results_page.write(root)


if __name__ == "__main__":
    main()
