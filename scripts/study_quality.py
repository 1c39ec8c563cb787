"""The program of scripts/study-quality: the indirect light of two builds of the renderer against the path tracer, scene by
scene, at default settings and standing still. The figures go to docs/quality, from which docs/QUALITY.md is generated.
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
BUILDS = ["before", "now"]
BOUNCES = 2
# As many as there are temporal sets: times and rays are taken over one round of them, after warming up for another.
ROUND = 16
STILL = ["--time-step", 0, "--frames", 2 * ROUND + 1]
# Largest side of what a strip shows, before it is enlarged.
SHOWN = 256


class Study:
    """Runs the builds in the cache's folder, which keeps scenes and references."""

    def __init__(self, options):
        self.options = options
        self.cache = options.cache
        self.cache.mkdir(parents=True, exist_ok=True)
        self.binaries = {"before": options.before, "now": options.now}
        self.made = study_scenes.make(self.cache / "scenes")

    def run(self, build, command, *arguments):
        """What the command reports; one build judges both."""
        report = self.cache / f"{command}.json"
        done = subprocess.run([self.binaries[build], command, *map(str, arguments), "--json", report],
                              stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        if done.returncode != 0:
            sys.exit(f"study-quality: error: glowworm {command} ({build}) failed:\n{done.stderr}")
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
            figures = self.run("before", "reference", self.made.get(scene, scene), "--layers", "--pixel-filter", "center",
                               "--bounces", BOUNCES, "--seed", seed, "--spp", spp, "--size", self.options.size,
                               "--out", picture, "--resume")
            report.write_text(json.dumps(figures))
        return picture, spp

    def noise(self, scene, reference):
        """The relMSE that is due to noise of the reference: that of another one with a quarter of its samples holds four
        times as much by its own noise, and once as much by the reference's."""
        another, _ = self.reference(scene, 1, 4)
        return self.run("before", "compare", another, reference, "--layer", "indirect")["relmse"] / 5

    def render(self, build, scene, picture, *options):
        device = ["--device", self.options.device] if self.options.device else []
        return self.run(build, "render", self.made.get(scene, scene), "--layers", "--bounces", BOUNCES,
                        "--size", self.options.size, "--out", picture, *device, *options)

    def picture(self, build):
        return self.cache / f"{build}.exr"

    def speed(self, scene):
        """The builds in turn, several times. For each the median frame time of each turn and of the fastest, which other
        work on the machine disturbed least, and what is the same each time: rays a pixel, counters, the picture."""
        figures = {build: {"turns": []} for build in BUILDS}
        for turn in range(self.options.turns):
            for build in BUILDS[::1 if turn % 2 == 0 else -1]:
                report = self.render(build, scene, self.picture(build), *STILL)
                frames = report["frames"][-ROUND:]
                width, height = report["settings"]["size"]
                row = figures[build]
                row["turns"].append(statistics.median(frame["total_ms"] for frame in frames))
                if row["turns"][-1] == min(row["turns"]):
                    row["ms"] = row["turns"][-1]
                    row["passes"] = {name: statistics.median(frame["passes"][name] for frame in frames)
                                     for name in frames[0]["passes"]}
                row["rays"] = statistics.fmean(frame["shadow_rays"] for frame in frames) / (width * height)
                row["vpls"] = {name: count for name, count in frames[-1]["vpls"].items() if isinstance(count, int)}
                row |= {key: report[key] for key in ["device", "driver", "commit"]}
        return figures

    def error(self, build, reference, stops):
        compared = self.run("before", "compare", self.picture(build), reference, "--layer", "indirect", "--exposure", stops)
        drawn, expected = (study_pictures.layer(file, "indirect") for file in [self.picture(build), reference])
        return {**{key: compared[key] for key in ["relmse", "flip", "ssim", "mean_ratio"]},
                "trimmed_relmse": study_pictures.trimmed_relmse(drawn, expected),
                "brightest_block": study_pictures.brightest_block(drawn, expected),
                "pattern": study_pictures.pattern(drawn, expected)}

    def steadiness(self, build, scene):
        drawn = self.cache / "seed.exr"
        pictures = []
        for seed in range(self.options.seeds):
            self.render(build, scene, drawn, "--time-step", 0, "--seed", seed)
            pictures.append(study_pictures.layer(drawn, "indirect"))
        return study_pictures.steadiness(pictures)

    def strip(self, reference, stops, out):
        """Before, now and the reference side by side at one exposure, every pixel twice as large."""
        shown = [*map(self.picture, BUILDS), reference]
        pictures = [study_pictures.display(study_pictures.layer(file, "indirect"), stops) for file in shown]
        height, width = (min(extent, SHOWN) for extent in pictures[0].shape[:2])
        top, left = (pictures[0].shape[0] - height) // 2, (pictures[0].shape[1] - width) // 2
        cut = [picture[top:top + height, left:left + width].repeat(2, 0).repeat(2, 1) for picture in pictures]
        gap = np.full((2 * height, 8, 3), 255, np.uint8)
        Image.fromarray(np.hstack([cut[0], gap, cut[1], gap, cut[2]])).save(out, quality=72, optimize=True)

    def study(self, scene, folder):
        reference, spp = self.reference(scene)
        expected = study_pictures.layer(reference, "indirect")
        stops = study_pictures.exposure(expected)
        figures = self.speed(scene)
        for build in BUILDS:
            figures[build] |= self.error(build, reference, round(stops, 3))
            if self.options.seeds > 1:
                figures[build]["seeds"] = self.steadiness(build, scene)
        self.strip(reference, stops, folder / f"{scene}.jpg")
        return {"size": self.options.size, "spp": spp, "noise": self.noise(scene, reference), "stops": stops,
                "irradiance": float((expected @ study_pictures.LUMINANCE).mean()), "seeds": self.options.seeds, **figures}


def arguments(root):
    cache = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "glowworm" / "quality"
    target = Path(os.environ.get("CARGO_TARGET_DIR") or "target")
    parser = argparse.ArgumentParser(prog="study-quality", description=__doc__)
    parser.add_argument("--before", type=Path, metavar="BINARY", help="glowworm of the commit to compare with; it also judges")
    parser.add_argument("--now", type=Path, metavar="BINARY", default=root / target / "release" / "glowworm",
                        help="glowworm to be judged (%(default)s)")
    parser.add_argument("--scenes", default=",".join(SCENES), metavar="A,B", help="names (%(default)s)")
    parser.add_argument("--size", default="256x256", metavar="WxH", help="size of the pictures (%(default)s)")
    parser.add_argument("--spp", type=int, default=1024, metavar="N",
                        help="samples a pixel of the references (%(default)s; four times as many where few paths find light)")
    parser.add_argument("--seeds", type=int, default=0, metavar="N", help="also draw N seeds (%(default)s)")
    parser.add_argument("--turns", type=int, default=3, metavar="N", help="turns of each build, for the time (%(default)s)")
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
    if not options.page_only and not options.before:
        parser.error("--before is missing")
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
            print(study_quality_page.line(scene, figures), flush=True)
    study_quality_page.write(options.out)


if __name__ == "__main__":
    main()
