"""The program of scripts/study-quality: the renderer against the path tracer, scene by scene, at default settings, section by
section. The figures go to docs/quality, from which docs/QUALITY.md is generated.
"""

import argparse
import hashlib
import json
import os
import shutil
import statistics
import subprocess
import sys
from pathlib import Path

import numpy as np
from PIL import Image

import study_motion
import study_pictures
import study_pixels
import study_quality_page
import study_scenes
from study_quality_page import SCENES

# Few paths find the light of these, so they get so many times the samples.
MORE_SAMPLES = {"classroom": 4, "living-room": 4, "corridor": 4, "blinds": 4, "uplight": 4}
BOUNCES = 2
# As many as there are temporal sets: times and rays are taken over one round of them, after warming up for another.
ROUND = 16
# Nothing moves, but frames are as in motion.
STILL = ["--time-step", 0, "--frames", 2 * ROUND + 1, "--still-frames", 0, "--antialiasing", "none"]
# Largest side of what a strip shows, before it is enlarged.
SHOWN = 256


class Study:
    """Runs the program in the cache's folder, which keeps scenes and references."""

    def __init__(self, options, figures):
        self.options = options
        self.cache = options.cache
        self.figures = options.out / figures
        self.figures.mkdir(parents=True, exist_ok=True)
        self.rendered = self.cache / "rendered.exr"
        self.made = study_scenes.make(self.cache / "scenes")

    def run(self, command, *arguments):
        """The report of the command."""
        report = self.cache / f"{command}.json"
        done = subprocess.run([self.options.glowworm, command, *map(str, arguments), "--json", report],
                              stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        if done.returncode != 0:
            sys.exit(f"error: glowworm {command} failed:\n{done.stderr}")
        return json.loads(report.read_text())

    def chosen(self, scenes):
        return [scene for scene in scenes if scene in self.options.scenes]

    def file(self, scene):
        """Its scene file, or its name if it has none."""
        file = self.made.get(scene) or self.options.root / "scenes" / f"{scene}.toml"
        return file if file.exists() else scene

    def rows(self, section):
        """What has been measured, by scene."""
        file = self.figures / f"{section}.json"
        return json.loads(file.read_text())["rows"] if file.exists() else {}

    def keep(self, section, figures):
        (self.figures / f"{section}.json").write_text(json.dumps(figures, indent=1) + "\n")

    def reference(self, file, size, scene, frame=0, seed=0, share=1, spp=None, pixel_filter="center", bounces=BOUNCES):
        """The path tracer's picture, with a share of the samples or `spp`, its samples a pixel and the seconds that each of them
        took; rendered once. `file` is a path or the name of `scene`, which tells how many samples it needs."""
        spp = spp or self.options.spp * MORE_SAMPLES.get(scene, 1) // share
        told = [scene, size, spp, pixel_filter, bounces, frame, seed]
        if isinstance(file, Path):
            told.append(hashlib.sha256(file.read_bytes() + Path(study_scenes.__file__).read_bytes()).hexdigest()[:8])
        name = "-".join(map(str, told))
        picture, report = self.cache / f"{name}.exr", self.cache / f"{name}.json"
        if not (picture.exists() and report.exists()):
            figures = self.run("reference", file, "--layers", "--pixel-filter", pixel_filter, "--bounces", bounces,
                               "--frame", frame, "--time-step", "1/60", "--seed", seed, "--spp", spp, "--size", size,
                               "--out", picture, "--resume")
            report.write_text(json.dumps(figures))
        figures = json.loads(report.read_text())
        width, height = figures["size"]
        return picture, spp, width * height / figures["samples_per_second"]

    def noise(self, scene, reference):
        """The relMSE that is due to noise of the reference: that of another one with a quarter of its samples holds four
        times as much by its own noise, and once as much by the reference's."""
        another, _, _ = self.reference(self.file(scene), self.options.size, scene, seed=1, share=4)
        return self.run("compare", another, reference, "--layer", "indirect")["relmse"] / 5

    def render(self, file, picture, size, *options):
        device = ["--device", self.options.device] if self.options.device else []
        layers = ["--layers"] if picture.suffix == ".exr" else []
        return self.run("render", file, *layers, "--bounces", BOUNCES, "--size", size, "--out", picture, *device, *options)

    def frames(self, file, size, last, *options):
        """Renders all frames. Gives their pictures and the report; the next call replaces them."""
        folder = self.cache / "frames"
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir()
        report = self.render(file, folder / "{frame:03}.exr", size, "--frames", last + 1, *options)
        return [folder / f"{frame:03}.exr" for frame in range(last + 1)], report

    def speed(self, scene):
        """Renders several times. Gives the median frame time of each turn and of the fastest, which other work on the machine
        disturbed least, and what is the same each time: rays a pixel, counters, the picture."""
        row = {"turns": []}
        for _ in range(self.options.turns):
            report = self.render(self.file(scene), self.rendered, self.options.size, *STILL)
            frames = report["frames"][-ROUND:]
            width, height = report["settings"]["size"]
            row["turns"].append(statistics.median(frame["total_ms"] for frame in frames))
            if row["turns"][-1] == min(row["turns"]):
                row["ms"] = row["turns"][-1]
                row["passes"] = {name: statistics.median(frame["passes"][name] for frame in frames)
                                 for name in frames[0]["passes"]}
            row["rays"] = statistics.fmean(frame["shadow_rays"] for frame in frames) / (width * height)
            row["vpls"] = {name: count for name, count in frames[-1]["vpls"].items() if isinstance(count, int)}
            row |= {key: report[key] for key in ["device", "driver", "commit"]}
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
            self.render(self.file(scene), rendered, self.options.size, *STILL, "--seed", seed)
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

    def study(self, scene):
        reference, spp, _ = self.reference(self.file(scene), self.options.size, scene)
        expected = study_pictures.layer(reference, "indirect")
        stops = study_pictures.exposure(expected)
        figures = self.speed(scene) | self.error(expected, reference, round(stops, 3))
        if self.options.seeds > 1:
            figures["steadiness"] = self.steadiness(scene)
        self.strip(expected, stops, self.figures / f"{scene}.jpg")
        return {"size": self.options.size, "spp": spp, "noise": self.noise(scene, reference), "stops": stops,
                "irradiance": float((expected @ study_pictures.LUMINANCE).mean()), "seeds": self.options.seeds, **figures}


def scenes(study):
    """The irradiance of ten scenes in which nothing moves, and what it costs."""
    for scene in study.chosen(SCENES):
        figures = study.study(scene)
        study.keep(scene, figures)
        print(study_quality_page.line(scene, study.figures / f"{scene}.json"), flush=True)


SECTIONS = {section.__name__: section for section in [
    scenes, study_motion.motion, study_motion.animations, study_pixels.pixels, study_pixels.convergence, study_pixels.textures]}


def arguments(root, program, description, sections, scenes, spp):
    cache = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "glowworm" / "quality"
    target = Path(os.environ.get("CARGO_TARGET_DIR") or "target")
    listed = "\n".join(f"  {name:12} {section.__doc__}" for name, section in sections.items())
    parser = argparse.ArgumentParser(prog=program, description=description, epilog=f"sections:\n{listed}",
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sections", nargs="*", metavar="SECTION", help="otherwise all")
    parser.add_argument("--glowworm", type=Path, metavar="BINARY", default=root / target / "release" / "glowworm",
                        help="the program to be measured (%(default)s)")
    parser.add_argument("--scenes", default=",".join(scenes),
                        metavar="A,B", help="names (%(default)s)")
    parser.add_argument("--size", default="256x256", metavar="WxH",
                        help="size of the pictures of `scenes` (%(default)s); other sections have their own")
    parser.add_argument("--spp", type=int, default=spp, metavar="N",
                        help="samples a pixel of the references (%(default)s; four times as many where few paths find light, "
                        "a quarter for each frame in motion)")
    parser.add_argument("--seeds", type=int, default=0, metavar="N", help="also render N seeds (%(default)s)")
    parser.add_argument("--turns", type=int, default=3, metavar="N", help="turns, of which the fastest counts (%(default)s)")
    parser.add_argument("--device", metavar="NAME|INDEX", help="Vulkan device, otherwise the best")
    parser.add_argument("--cache", type=Path, default=cache, metavar="DIR", help="keeps the references (%(default)s)")
    parser.add_argument("--out", type=Path, default=root / "docs", metavar="DIR",
                        help="folder of QUALITY.md and quality/ (%(default)s)")
    parser.add_argument("--page-only", action="store_true", help="measure nothing, write the page")
    options = parser.parse_args()
    options.root = root
    options.scenes = options.scenes.split(",")
    for name in options.sections:
        if name not in sections:
            parser.error(f"{name}: no such section")
    return options


def run(program, description, sections, scenes, spp, figures, write):
    """Measures the sections that are asked for, and writes the page from the folder of figures."""
    options = arguments(Path(sys.argv.pop(1)), program, description, sections, scenes, spp)
    if not options.page_only:
        study = Study(options, figures)
        for name in options.sections or sections:
            print(f"{name} ...", file=sys.stderr, flush=True)
            sections[name](study)
    write(options.out)


if __name__ == "__main__":
    run("study-quality", __doc__, SECTIONS, dict.fromkeys(study_motion.MOVING + study_pixels.PICTURES), 1024, "quality",
        study_quality_page.write)
