"""The program of scripts/equal-time: whole pictures after one second of rendering, by Mitsuba and by the renderer.

Mitsuba renders what `glowworm export` wrote, with its path tracer and as many samples a pixel as a second allows; the
renderer draws as many frames from its first one on as a second allows, at least one, at default settings. Loading and
compiling do not count; the best of several turns does. Each picture is compared with the path tracer's (`glowworm
reference`) of its own pixel filter: all over the pixel for Mitsuba, its centre for the renderer.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import mitsuba as mi
import numpy as np
from PIL import Image

import study_pictures
import study_quality_page
from study_quality_page import MOST_FRAMES
from verify_with_mitsuba import load, working_variant

SCENES = ["cornell-box", "sponza", "sibenik", "conference", "classroom", "living-room"]
SECONDS = 1.0
# Of each pixel at once: multijitter wants squares.
SAMPLES = [1, 4, 9, 16, 25, 36, 49, 64, 81, 100, 144, 196, 256]


class Lab:
    """Runs the program in a scratch folder; the cache keeps references."""

    def __init__(self, options, folder):
        self.options = options
        self.folder = folder

    def run(self, command, *arguments):
        report = self.folder / "report.json"
        asked = [] if command == "export" else ["--json", report]
        done = subprocess.run([self.options.glowworm, command, *map(str, arguments), *asked],
                              stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        if done.returncode != 0:
            sys.exit(f"equal-time: error: glowworm {command} failed:\n{done.stderr}")
        return json.loads(report.read_text()) if asked else None

    def render(self, scene, frames, out):
        return self.run("render", scene, "--size", self.options.size, "--bounces", 2, "--time-step", 0, "--frames", frames,
                        "--out", out)

    def export(self, scene):
        """The report of the scene's export."""
        out = self.folder / scene
        self.run("export", scene, "--size", self.options.size, "--bounces", 2, "--out", out)
        return json.loads((out / "glowworm-export.json").read_text())

    def reference(self, scene, pixel_filter):
        name = f"{scene}-{self.options.size}-{self.options.spp}"
        name += ("-box" if pixel_filter == "box" else "")
        picture, report = self.options.cache / f"{name}.exr", self.options.cache / f"{name}.json"
        if not (picture.exists() and report.exists()):
            figures = self.run("reference", scene, "--layers", "--pixel-filter", pixel_filter, "--bounces", 2,
                               "--spp", self.options.spp, "--size", self.options.size, "--out", picture, "--resume")
            report.write_text(json.dumps(figures))
        return picture

    def frames(self, scene):
        """How many frames a second holds, and the seconds that they take."""
        report = self.render(scene, MOST_FRAMES, self.folder / "frames.exr")
        ends = np.cumsum([frame["total_ms"] for frame in report["frames"]]) / 1000
        count = max(1, int(np.searchsorted(ends, SECONDS, side="right")))
        return count, float(ends[count - 1]), report["device"]

    def errors(self, rendered, reference):
        """FLIP of the tone-mapped pictures, and HDR-FLIP of the linear ones."""
        stops = study_pictures.exposure(study_pictures.layer(reference, "colour"))
        shown = []
        for name, file in [("rendered", rendered), ("reference", reference)]:
            shown.append(self.folder / f"{name}.png")
            Image.fromarray(study_pictures.display(colour(file), stops)).save(shown[-1])
        return {"flip": self.run("compare", *shown)["flip"],
                "hdr_flip": self.run("compare", rendered, reference)["flip"]}


def colour(file):
    """The picture of an EXR of either program: its first part."""
    part = study_pictures.OpenEXR.File(str(file)).parts[0]
    return part.channels["RGB"].pixels[..., :3].astype(np.float64)


class Mitsuba:
    """One exported scene."""

    def __init__(self, folder, background):
        self.scene = load(folder)
        self.background = np.array(background)
        self.seed = 0

    def render(self, samples):
        """The picture and the seconds it took."""
        self.seed += 1
        start = time.perf_counter()
        picture = np.array(mi.render(self.scene, spp=samples, seed=self.seed), dtype=np.float64)
        return picture, time.perf_counter() - start

    def in_a_second(self, turns):
        """The mean of renderings that together take a second, its samples a pixel, and the seconds."""
        seconds = {}
        for samples in SAMPLES:
            # The first one compiles.
            self.render(samples)
            seconds[samples] = min(self.render(samples)[1] for _ in range(turns))
            if seconds[samples] > SECONDS:
                break
        # Take as many at once as fit, then fill what is left of the second.
        chosen, left = [], SECONDS
        for samples in sorted(seconds, reverse=True):
            while seconds[samples] <= left and len(chosen) < 64:
                chosen.append(samples)
                left -= seconds[samples]
        chosen = chosen or SAMPLES[:1]
        total, spent = 0.0, 0.0
        for samples in chosen:
            picture, took = self.render(samples)
            total, spent = total + samples * picture, spent + took
        picture = total / sum(chosen)
        if picture.shape[2] == 4:
            picture = picture[..., :3] + (1 - picture[..., 3:]) * self.background
        return picture, sum(chosen), SECONDS - left, spent


def measure(lab, scene):
    report = lab.export(scene)
    box, centre = (lab.reference(scene, pixel_filter) for pixel_filter in ["box", "center"])
    picture, samples, seconds, spent = Mitsuba(lab.folder / scene, report["background"]).in_a_second(lab.options.turns)
    rendered = lab.folder / "rendered.exr"
    mi.Bitmap(picture.astype(np.float32)).write(str(rendered))
    row = {"scene": scene, "integrator": report["integrator"],
           "mitsuba": {"samples": samples, "seconds": seconds, "spent": spent, **lab.errors(rendered, box)}}
    count, seconds, device = max((lab.frames(scene) for _ in range(lab.options.turns)), key=lambda turn: (turn[0], -turn[1]))
    lab.render(scene, count, rendered)
    # Against the antialiased picture, too, which counts jagged edges as errors.
    antialiased = {f"{key}_antialiased": value for key, value in lab.errors(rendered, box).items()}
    row["glowworm"] = {"frames": count, "seconds": seconds, "device": device, **lab.errors(rendered, centre), **antialiased}
    return row


def arguments(root):
    cache = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "glowworm" / "quality"
    target = Path(os.environ.get("CARGO_TARGET_DIR") or "target")
    parser = argparse.ArgumentParser(prog="equal-time", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--glowworm", type=Path, metavar="BINARY", default=root / target / "release" / "glowworm",
                        help="the program to be measured (%(default)s)")
    parser.add_argument("--scenes", default=",".join(SCENES), metavar="A,B", help="names (%(default)s)")
    parser.add_argument("--size", default="256x256", metavar="WxH", help="size of the pictures (%(default)s)")
    parser.add_argument("--spp", type=int, default=1024, metavar="N", help="samples a pixel of the references (%(default)s)")
    parser.add_argument("--turns", type=int, default=3, metavar="N", help="turns, of which the fastest counts (%(default)s)")
    parser.add_argument("--variant", help="Mitsuba's, otherwise llvm_ad_rgb where it works, else scalar_rgb")
    parser.add_argument("--cache", type=Path, default=cache, metavar="DIR", help="keeps the references (%(default)s)")
    parser.add_argument("--out", type=Path, default=root / "docs", metavar="DIR",
                        help="folder of QUALITY.md and quality/ (%(default)s)")
    return parser.parse_args()


def main():
    root = Path(sys.argv.pop(1))
    options = arguments(root)
    options.cache.mkdir(parents=True, exist_ok=True)
    (options.out / "quality").mkdir(parents=True, exist_ok=True)
    variant = options.variant or working_variant()
    mi.set_variant(variant)
    mi.set_log_level(mi.LogLevel.Error)
    rows = []
    with tempfile.TemporaryDirectory(prefix="equal-time.") as scratch:
        lab = Lab(options, Path(scratch))
        for scene in options.scenes.split(","):
            print(f"{scene} ...", file=sys.stderr, flush=True)
            rows.append(measure(lab, scene))
            figures = {"mitsuba": mi.__version__, "variant": variant, "size": options.size, "cores": os.cpu_count(), "rows": rows}
            (options.out / "quality" / "equal-time.json").write_text(json.dumps(figures, indent=1) + "\n")
    print(study_quality_page.equal_time(figures))
    study_quality_page.write(options.out)


if __name__ == "__main__":
    main()
