"""Compares `glowworm reference` with Mitsuba 3, an independent renderer: exports scenes, renders them with both, compares the pictures.

A scene passes if its mean luminance agrees within 1 % and 95 % of its blocks of 16 x 16 pixels do within 3 %. With
too few samples noise alone fails it. Materials that Mitsuba does not have come from the glowworm_bsdf.py of the export.
"""

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import mitsuba as mi
import numpy as np

from .program import ROOT, Program, parser, progress, write_json

FILES = "tests/scene-files"
SHIPPED = ["cornell-box", "material-grid", f"{FILES}/all-kinds.toml", f"{FILES}/lamps-material-grid.toml",
           f"{FILES}/soft-lights.toml"]
WITH_ASSETS = ["sponza", "sibenik", "conference", "classroom", "living-room", "damaged-helmet",
               f"{FILES}/lamps-damaged-helmet.toml", f"{FILES}/sky-living-room.toml"]
MEAN_TOLERANCE = 0.01
BLOCK_SHARE = 0.95
# Samples at once: multijitter wants squares, and more would take much memory.
SAMPLES_AT_ONCE = [256, 64, 16, 4, 1]


def arguments():
    made = parser("verify-with-mitsuba", __doc__, size="256x256")
    made.add_argument("scenes", nargs="*", metavar="SCENE", help="names or files; otherwise all that are there")
    made.add_argument("--spp", type=int, default=1024, help="samples of each pixel (%(default)s)")
    made.add_argument("--bounces", metavar="N", help="bounces of light, otherwise the scene's")
    made.add_argument("--frame", default="0", metavar="K", help="frame of the animation (%(default)s)")
    made.add_argument("--ci", action="store_true", help="the shipped scenes, small: some minutes on two cores")
    made.add_argument("--variant", help="Mitsuba's, otherwise llvm_ad_rgb where it works, else scalar_rgb")
    made.add_argument("--keep", type=Path, metavar="DIR", help="leave exports and pictures in this folder")
    made.add_argument("--json", type=Path, metavar="FILE", help="write the figures to FILE")
    options = made.parse_args()
    if options.ci:
        options.size = "128x96"
    if options.spp < 1:
        made.error("--spp must be at least 1")
    if not options.scenes:
        scenes = SHIPPED + (WITH_ASSETS if os.environ.get("GLOWWORM_ASSETS") and not options.ci else [])
        options.scenes = [str(ROOT / name) if "/" in name else name for name in scenes]
    return options


def working_variant():
    """Tried in a separate process: an unsuitable LLVM aborts it."""
    trial = ("import mitsuba as mi; mi.set_variant('llvm_ad_rgb'); "
             "print(mi.render(mi.load_dict(mi.cornell_box()), spp=1))")
    works = subprocess.run([sys.executable, "-c", trial], capture_output=True).returncode == 0
    return "llvm_ad_rgb" if works else "scalar_rgb"


class Bench(Program):
    """Runs both programs in one folder."""

    def __init__(self, options, folder):
        super().__init__(options.glowworm, folder)
        self.spp = options.spp
        self.common = ["--size", options.size, "--frame", options.frame, *(["--bounces", options.bounces] if options.bounces else [])]

    def traced(self, scene, name):
        """File of glowworm's picture, and the seconds that it took."""
        picture = self.folder / f"{name}-glowworm.exr"
        return picture, self.run("reference", scene, *self.common, "--spp", self.spp, "--out", picture)["seconds"]

    def mitsuba(self, name, background):
        """File of Mitsuba's picture of the export NAME, and the seconds that it took."""
        scene = load(self.folder / name)
        total, samples, start = 0.0, 0, time.perf_counter()
        while samples < self.spp:
            count = next(count for count in SAMPLES_AT_ONCE if count <= self.spp - samples)
            picture = np.array(mi.render(scene, spp=count, seed=samples), dtype=np.float64)
            total, samples = total + picture * count, samples + count
        seconds = time.perf_counter() - start
        picture = total / samples
        if picture.shape[2] == 4:
            picture = picture[..., :3] + (1.0 - picture[..., 3:]) * np.array(background)
        file = self.folder / f"{name}-mitsuba.exr"
        mi.Bitmap(picture.astype(np.float32)).write(str(file))
        return file, seconds


def load(folder):
    """The scene of an export, with the materials that it brings."""
    plugin = folder / "glowworm_bsdf.py"
    scene = str(folder / "scene.xml")
    if not plugin.exists():
        return mi.load_file(scene)
    # All exports bring the same.
    sys.path.append(str(folder))
    import glowworm_bsdf
    return mi.load_file(scene, materials=glowworm_bsdf.MATERIALS)


def row(scene, compared, seconds, verdict):
    return {
        "scene": scene,
        "mean_ratio": compared["mean_ratio"],
        "block_p95": compared["blocks"]["p95_relative_error"],
        "blocks_within_3_percent": compared["blocks"]["within_3_percent"],
        "glowworm_seconds": seconds[0],
        "mitsuba_seconds": seconds[1],
        "passed": verdict,
    }


def agrees(compared):
    return (abs(compared["mean_ratio"] - 1.0) <= MEAN_TOLERANCE
            and compared["blocks"]["within_3_percent"] >= BLOCK_SHARE)


def verify(bench, scene):
    """The row of the table for one scene."""
    name = Path(scene).stem
    report = bench.export(scene, bench.folder / name, *bench.common)
    theirs, their_seconds = bench.mitsuba(name, report["background"])
    ours, our_seconds = bench.traced(scene, name)
    compared = bench.run("compare", ours, theirs, "--blocks", 16)
    return row(name, compared, (our_seconds, their_seconds), agrees(compared))


def show(rows):
    print("| scene | glowworm / Mitsuba, mean | blocks within 3 % | 95 % of blocks within | glowworm, s | Mitsuba, s | |")
    print("|---|---|---|---|---|---|---|")
    for r in rows:
        verdict = "agrees" if r["passed"] else "DIFFERS"
        print(f"| {r['scene']} | {r['mean_ratio']:.4f} | {100 * r['blocks_within_3_percent']:.1f} % "
              f"| {100 * r['block_p95']:.2f} % | {r['glowworm_seconds']:.0f} | {r['mitsuba_seconds']:.0f} | {verdict} |")


def start_mitsuba(variant):
    """Chooses the variant, and gives its name."""
    variant = variant or working_variant()
    mi.set_variant(variant)
    mi.set_log_level(mi.LogLevel.Error)
    return variant


def main():
    options = arguments()
    variant = start_mitsuba(options.variant)
    print(f"Mitsuba {mi.__version__} ({variant}), {options.size}, {options.spp} samples a pixel", flush=True)
    with tempfile.TemporaryDirectory(prefix="verify-with-mitsuba.") as scratch:
        bench = Bench(options, options.keep or Path(scratch))
        rows = []
        for scene in options.scenes:
            progress(f"{scene} ...")
            rows.append(verify(bench, scene))
    show(rows)
    if options.json:
        write_json(options.json, {"mitsuba": mi.__version__, "variant": variant, "spp": options.spp, "size": options.size, "rows": rows})
    return 0 if all(r["passed"] for r in rows) else 1
