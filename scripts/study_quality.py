"""The program of scripts/study-quality: the indirect light of the renderer against the path tracer, scene by scene, at
default settings and standing still. The figures go to docs/quality, from which docs/QUALITY.md is generated.
"""

import argparse
import hashlib
import json
import os
import statistics
import subprocess
import sys
from pathlib import Path

import numpy as np
from PIL import Image

import study_pictures
import study_quality_page
import study_scenes
from study_quality_page import SCENES

# Few paths find the light of these, so they get so many times the samples.
MORE_SAMPLES = {"classroom": 4, "living-room": 4, "corridor": 4, "blinds": 4, "uplight": 4}
BOUNCES = 2
# As many as there are temporal sets: times and rays are taken over one round of them, after warming up for another.
ROUND = 16
STILL = ["--time-step", 0, "--frames", 2 * ROUND + 1]
# Largest side of what a strip shows, before it is enlarged.
SHOWN = 256


class Study:
    """Runs the program in the cache's folder, which keeps scenes and references."""

    def __init__(self, options):
        self.options = options
        self.cache = options.cache
        self.cache.mkdir(parents=True, exist_ok=True)
        self.rendered = self.cache / "rendered.exr"
        self.made = study_scenes.make(self.cache / "scenes")

    def run(self, command, *arguments):
        """The report of the command."""
        report = self.cache / f"{command}.json"
        done = subprocess.run([self.options.glowworm, command, *map(str, arguments), "--json", report],
                              stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        if done.returncode != 0:
            sys.exit(f"study-quality: error: glowworm {command} failed:\n{done.stderr}")
        return json.loads(report.read_text())

    def reference(self, scene, seed=0, share=1):
        """The path tracer's picture with paths through pixel centres, or one with a share of its samples and another seed,
        and its samples a pixel; rendered once."""
        spp = self.options.spp * MORE_SAMPLES.get(scene, 1) // share
        name = f"{scene}-{self.options.size}-{spp}" + (f"-seed-{seed}" if seed else "")
        if scene in self.made:
            parts = [self.made[scene].with_suffix(kind).read_bytes() for kind in [".toml", ".obj", ".mtl"]]
            name += "-" + hashlib.sha256(b"".join(parts)).hexdigest()[:8]
        picture, report = self.cache / f"{name}.exr", self.cache / f"{name}.json"
        if not (picture.exists() and report.exists()):
            figures = self.run("reference", self.made.get(scene, scene), "--layers", "--pixel-filter", "center",
                               "--bounces", BOUNCES, "--seed", seed, "--spp", spp, "--size", self.options.size,
                               "--out", picture, "--resume")
            report.write_text(json.dumps(figures))
        return picture, spp

    def noise(self, scene, reference):
        """The relMSE that is due to noise of the reference: that of another one with a quarter of its samples holds four
        times as much by its own noise, and once as much by the reference's."""
        another, _ = self.reference(scene, 1, 4)
        return self.run("compare", another, reference, "--layer", "indirect")["relmse"] / 5

    def render(self, scene, picture, *options):
        device = ["--device", self.options.device] if self.options.device else []
        return self.run("render", self.made.get(scene, scene), "--layers", "--bounces", BOUNCES,
                        "--size", self.options.size, "--out", picture, *device, *options)

    def speed(self, scene):
        """Renders several times. Gives the median frame time of each turn and of the fastest, which other work on the machine
        disturbed least, and what is the same each time: rays a pixel, counters, the picture."""
        row = {"turns": []}
        for _ in range(self.options.turns):
            report = self.render(scene, self.rendered, *STILL)
            frames = report["frames"][-ROUND:]
            width, height = report["settings"]["size"]
            row["turns"].append(statistics.median(frame["total_ms"] for frame in frames))
            if row["turns"][-1] == min(row["turns"]):
                row["ms"] = row["turns"][-1]
                row["passes"] = {name: statistics.median(frame["passes"][name] for frame in frames)
                                 for name in frames[0]["passes"]}
            row["rays"] = statistics.fmean(frame["shadow_rays"] for frame in frames) / (width * height)
            row["vpls"] = {name: count for name, count in frames[-1]["vpls"].items() if isinstance(count, int)}
            row |= {key: report[key] for key in ["device", "driver"]}
        return row

    def error(self, expected, reference, stops):
        compared = self.run("compare", self.rendered, reference, "--layer", "indirect", "--exposure", stops)
        rendered = study_pictures.layer(self.rendered, "indirect")
        return {**{key: compared[key] for key in ["relmse", "flip", "ssim", "mean_ratio"]},
                "trimmed_relmse": study_pictures.trimmed_relmse(rendered, expected),
                "brightest_block": study_pictures.brightest_block(rendered, expected),
                "pattern": study_pictures.pattern(rendered, expected)}

    def steadiness(self, scene):
        rendered = self.cache / "seed.exr"
        pictures = []
        for seed in range(self.options.seeds):
            self.render(scene, rendered, "--time-step", 0, "--seed", seed)
            pictures.append(study_pictures.layer(rendered, "indirect"))
        return study_pictures.steadiness(pictures)

    def strip(self, expected, stops, out):
        """The picture and its reference side by side at one exposure, every pixel twice as large."""
        shown = [study_pictures.layer(self.rendered, "indirect"), expected]
        pictures = [study_pictures.display(picture, stops) for picture in shown]
        height, width = (min(extent, SHOWN) for extent in pictures[0].shape[:2])
        top, left = (pictures[0].shape[0] - height) // 2, (pictures[0].shape[1] - width) // 2
        cut = [picture[top:top + height, left:left + width].repeat(2, 0).repeat(2, 1) for picture in pictures]
        gap = np.full((2 * height, 8, 3), 255, np.uint8)
        Image.fromarray(np.hstack([cut[0], gap, cut[1]])).save(out, quality=72, optimize=True)

    def study(self, scene, folder):
        reference, spp = self.reference(scene)
        expected = study_pictures.layer(reference, "indirect")
        stops = study_pictures.exposure(expected)
        figures = self.speed(scene) | self.error(expected, reference, round(stops, 3))
        if self.options.seeds > 1:
            figures["steadiness"] = self.steadiness(scene)
        self.strip(expected, stops, folder / f"{scene}.jpg")
        return {"size": self.options.size, "spp": spp, "noise": self.noise(scene, reference), "stops": stops,
                "irradiance": float((expected @ study_pictures.LUMINANCE).mean()), "seeds": self.options.seeds, **figures}


def arguments(root):
    cache = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "glowworm" / "quality"
    target = Path(os.environ.get("CARGO_TARGET_DIR") or "target")
    parser = argparse.ArgumentParser(prog="study-quality", description=__doc__)
    parser.add_argument("--glowworm", type=Path, metavar="BINARY", default=root / target / "release" / "glowworm",
                        help="the program to be measured (%(default)s)")
    parser.add_argument("--scenes", default=",".join(SCENES), metavar="A,B", help="names (%(default)s)")
    parser.add_argument("--size", default="256x256", metavar="WxH", help="size of the pictures (%(default)s)")
    parser.add_argument("--spp", type=int, default=1024, metavar="N",
                        help="samples a pixel of the references (%(default)s; four times as many where few paths find light)")
    parser.add_argument("--seeds", type=int, default=0, metavar="N", help="also render N seeds (%(default)s)")
    parser.add_argument("--turns", type=int, default=3, metavar="N", help="turns, of which the fastest counts (%(default)s)")
    parser.add_argument("--device", metavar="NAME|INDEX", help="Vulkan device, otherwise the best")
    parser.add_argument("--cache", type=Path, default=cache, metavar="DIR", help="keeps the references (%(default)s)")
    parser.add_argument("--out", type=Path, default=root / "docs", metavar="DIR",
                        help="folder of QUALITY.md and quality/ (%(default)s)")
    parser.add_argument("--page-only", action="store_true", help="measure nothing, write the page")
    options = parser.parse_args()
    options.scenes = options.scenes.split(",")
    unknown = [scene for scene in options.scenes if scene not in SCENES]
    if unknown:
        parser.error(f"{unknown[0]}: no such scene")
    return options


def main():
    options = arguments(Path(sys.argv.pop(1)))
    folder = options.out / "quality"
    folder.mkdir(parents=True, exist_ok=True)
    if not options.page_only:
        study = Study(options)
        for scene in options.scenes:
            print(f"{scene} ...", file=sys.stderr, flush=True)
            figures = study.study(scene, folder)
            (folder / f"{scene}.json").write_text(json.dumps(figures, indent=1) + "\n")
            print(study_quality_page.line(scene, folder / f"{scene}.json"), flush=True)
    study_quality_page.write(options.out)


if __name__ == "__main__":
    main()
