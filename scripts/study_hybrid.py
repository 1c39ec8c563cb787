"""The program of scripts/study-hybrid: soft shadows and reflections, denoised by SVGF and each of its extensions, against the path
tracer, scene by scene, still and in motion. The figures go to docs/hybrid/figures.json, from which docs/HYBRID.md is generated.
"""

import argparse
import hashlib
import json
import os
import statistics
import subprocess
import sys
from pathlib import Path

import hybrid_scenes
import study_hybrid_page

ROUGHNESS = [0, 0.1, 0.2, 0.3, 0.4, 0.6, 1]
HALF_ANGLES = [0, 2, 4, 6, 10, 20, 40, 90]
# Sizes of sequences; of sponza, whose reference takes longest, the chosen one alone.
MOVING = [0, 0.2, 1, 4, 90]
# Each extension by itself is measured at these values, still and under a moving camera.
CHOSEN = {"boxes": [0, 0.2, 0.4], "icosphere": [0.2], "sponza": [0.2], "pillars": [4], "objects": [4, 20]}
# A still picture after so many frames; one frame of a sequence, with its past.
FRAMES = {"still": 32, "camera": 40, "objects": 40, "light": 40}
NOISY_SAMPLES = 16

# Keys of a report.
MACHINE = ["device", "driver", "commit"]

PLAIN = {"svgf-history-rejection": 0, "svgf-firefly": 0, "svgf-adaptive": "false"}


def plain_but(**changes):
    return PLAIN | {name.replace("_", "-"): value for name, value in changes.items()}


VARIANTS = {
    "default": {},
    "SVGF": PLAIN,
    "+ history rejection": plain_but(svgf_history_rejection=2.5),
    "+ fireflies": plain_but(svgf_firefly=10),
    "+ adaptive": plain_but(svgf_adaptive="true"),
    "+ separable": plain_but(svgf_separable="true"),
    "+ Reinhard": plain_but(svgf_reinhard="true"),
    "all": {"svgf-separable": "true", "svgf-reinhard": "true"},
    "white noise": {"noise": "white"},
    "not denoised": {"denoise": "none"},
}
EVERYWHERE = ["default", "SVGF"]


class Study:
    """Runs glowworm; reports are kept in the cache by their command and scene."""

    def __init__(self, options):
        self.options = options
        self.cache = options.cache
        self.cache.mkdir(parents=True, exist_ok=True)
        self.machine = []
        self.build = hashlib.sha256(options.glowworm.read_bytes()).hexdigest()[:12]

    def run(self, command, *arguments):
        """What the command reports."""
        report = self.cache / "report.json"
        done = subprocess.run([self.options.glowworm, command, *map(str, arguments), "--json", report],
                              stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        if done.returncode != 0:
            sys.exit(f"study-hybrid: error: glowworm {command} {' '.join(map(str, arguments))} failed:\n{done.stderr}")
        return json.loads(report.read_text())

    def key(self, scene, *what):
        parts = [scene.read_text(), *map(str, what)]
        return self.cache / hashlib.sha256("\n".join(parts).encode()).hexdigest()[:24]

    def reference(self, scene, name, frame, spp, seed=0):
        """The path tracer's picture through pixel centres; rendered once."""
        bounces = 1 if layer_of(name) == "reflected" else 0
        options = ["--layers", "--pixel-filter", "center", "--bounces", bounces, "--size", self.options.size,
                   "--frame", frame, "--spp", spp, "--seed", seed]
        picture = self.key(scene, *options).with_suffix(".exr")
        if not picture.exists():
            unfinished = picture.with_name("unfinished.exr")
            self.run("reference", scene, *options, "--out", unfinished)
            unfinished.rename(picture)
        return picture

    def samples(self, value):
        """A pixel, of the reference: sharp mirrors and shadows need few."""
        return self.options.spp if value > 0 else NOISY_SAMPLES

    def error(self, picture, reference, layer):
        compared = self.run("compare", picture, reference, "--layer", layer)
        return {name: compared[name] for name in ["ssim", "flip", "mean_ratio"]}

    def measure(self, name, motion, value, variant):
        """SSIM, HDR-FLIP and mean of the layer of interest; a row of the figures."""
        scene = hybrid_scenes.make(self.cache / "scenes", name, motion, value)
        frames = FRAMES[motion]
        options = effect_options(name) + switches(VARIANTS[variant]) + [
            "--size", self.options.size, "--frames", frames, "--layers"]
        kept = self.key(scene, self.build, self.options.spp, *options).with_suffix(".json")
        if not kept.exists():
            rendered = self.cache / "rendered.exr"
            report = self.run("render", scene, *options, "--out", rendered)
            reference = self.reference(scene, name, frames - 1, self.samples(value))
            kept.write_text(json.dumps([self.error(rendered, reference, layer_of(name)), *(report[key] for key in MACHINE)]))
        row, *self.machine = json.loads(kept.read_text())
        return {"scene": name, "motion": motion, "value": value, "variant": variant} | row

    def judged(self, name, motion, value):
        """Rows of the path tracer itself: with few samples, and with another picture of as many, for the noise of the reference."""
        scene = hybrid_scenes.make(self.cache / "scenes", name, motion, value)
        frame, layer, spp = FRAMES[motion] - 1, layer_of(name), self.samples(value)
        kept = self.key(scene, "judged", frame, layer, self.options.size, spp).with_suffix(".json")
        if not kept.exists():
            reference = self.reference(scene, name, frame, spp)
            rows = {}
            if value > 0:
                rows[f"{NOISY_SAMPLES} samples"] = self.error(self.reference(scene, name, frame, NOISY_SAMPLES), reference, layer)
            if value in CHOSEN[name] and motion == "still" and value > 0:
                rows["reference again"] = self.error(self.reference(scene, name, frame, spp, 1), reference, layer)
            kept.write_text(json.dumps(rows))
        rows = json.loads(kept.read_text())
        return [{"scene": name, "motion": motion, "value": value, "variant": variant} | row for variant, row in rows.items()]

    def times(self):
        """Median milliseconds of each pass at 512x512 under a moving camera, one run after another."""
        rows = {}
        for name, value in [("objects", 4), ("boxes", 0.2)]:
            scene = hybrid_scenes.make(self.cache / "scenes", name, "camera", value)
            for variant in ["default", "+ separable", "not denoised"]:
                options = effect_options(name)[2:] + switches(VARIANTS[variant] if variant != "+ separable" else
                                                              {"svgf-separable": "true"})
                report = self.run("render", scene, *options, "--size", "512x512", "--frames", 24, "--out",
                                  self.cache / "timed.png")
                frames = report["frames"][8:]
                passes = {key: statistics.median(frame["passes"].get(key, 0) for frame in frames)
                          for key in frames[0]["passes"]}
                rows[f"{name}, {variant}"] = {"total": statistics.median(frame["total_ms"] for frame in frames)} | passes
        return rows


def layer_of(name):
    return "reflected" if name in hybrid_scenes.REFLECTIONS else "shadow"


def effect_options(name):
    kind = ["--direct", "hard", "--reflections", "rays", "--reflection-roughness", 1]
    if layer_of(name) == "shadow":
        kind = ["--direct", "soft", "--reflections", "none"]
    return ["--antialiasing", "none", "--indirect", "none", *kind]


def switches(settings):
    return [part for name, value in settings.items() for part in [f"--{name}", value]]


def values_of(name, motion):
    values = ROUGHNESS if layer_of(name) == "reflected" else HALF_ANGLES
    moving = CHOSEN[name] if name == "sponza" else MOVING
    return [value for value in values if motion == "still" or value in moving]


def runs(scenes):
    """Scene, motion, value and variants, in the order in which they are measured."""
    for name in scenes:
        for motion in hybrid_scenes.MOTIONS:
            for value in values_of(name, motion):
                closely = value in CHOSEN[name] and motion in ["still", "camera"]
                yield name, motion, value, list(VARIANTS) if closely else EVERYWHERE


def text(figures):
    """JSON with a line for each row."""
    head = json.dumps({key: value for key, value in figures.items() if key != "rows"}, indent=1)
    rows = ",\n".join("  " + json.dumps(row) for row in figures["rows"])
    return head.removesuffix("\n}") + ',\n "rows": [\n' + rows + "\n ]\n}\n"


def arguments(root):
    cache = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "glowworm" / "hybrid"
    target = Path(os.environ.get("CARGO_TARGET_DIR") or "target")
    names = list(hybrid_scenes.REFLECTIONS | hybrid_scenes.SHADOWS)
    parser = argparse.ArgumentParser(prog="study-hybrid", description=__doc__)
    parser.add_argument("--glowworm", type=Path, metavar="BINARY", default=root / target / "release" / "glowworm",
                        help="glowworm to be judged (%(default)s)")
    parser.add_argument("--scenes", default=",".join(names), metavar="A,B", help="names (%(default)s)")
    parser.add_argument("--size", default="320x180", metavar="WxH", help="size of the pictures (%(default)s)")
    parser.add_argument("--spp", type=int, default=512, metavar="N",
                        help="samples a pixel of the reference (%(default)s)")
    parser.add_argument("--cache", type=Path, default=cache, metavar="DIR", help="keeps what was measured (%(default)s)")
    parser.add_argument("--out", type=Path, default=root / "docs", metavar="DIR",
                        help="folder of HYBRID.md and hybrid/ (%(default)s)")
    parser.add_argument("--no-times", action="store_true", help="keep the times that were measured before")
    parser.add_argument("--times-only", action="store_true", help="measure the times alone")
    parser.add_argument("--page-only", action="store_true", help="measure nothing, write the page")
    options = parser.parse_args()
    options.scenes = [] if options.times_only else options.scenes.split(",")
    unknown = [scene for scene in options.scenes if scene not in names]
    if unknown:
        parser.error(f"{unknown[0]}: no such scene")
    return options


def main():
    options = arguments(Path(sys.argv.pop(1)))
    file = options.out / "hybrid" / "figures.json"
    file.parent.mkdir(parents=True, exist_ok=True)
    if not options.page_only:
        before = json.loads(file.read_text()) if file.exists() else {}
        study = Study(options)
        times = before.get("times", {}) if options.no_times else study.times()
        rows = [row for row in before.get("rows", []) if row["scene"] not in options.scenes]
        for name, motion, value, variants in runs(options.scenes):
            print(f"{name} {motion} {value:g} ...", file=sys.stderr, flush=True)
            rows += study.judged(name, motion, value)
            rows += [study.measure(name, motion, value, variant) for variant in variants]
        figures = before | dict(zip(MACHINE, study.machine)) | {"size": options.size, "spp": options.spp, "times": times, "rows": rows}
        file.write_text(text(figures))
    study_hybrid_page.write(options.out)


if __name__ == "__main__":
    main()
