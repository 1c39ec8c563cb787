"""Studies soft shadows and reflections, denoised by SVGF and each of its extensions, against the path tracer, scene by scene, still
and in motion. The figures go to docs/hybrid/figures.json, and from there into docs/HYBRID.md.
"""

import statistics

from . import hybrid_page, hybrid_scenes, page
from .program import Program, parser, progress, read_json, write_json

ROUGHNESS = [0, 0.1, 0.2, 0.3, 0.4, 0.6, 1]
HALF_ANGLES = [0, 2, 4, 6, 10, 20, 40, 90]
# Sizes of sequences; of sponza, whose reference takes longest, the chosen one alone.
MOVING = [0, 0.2, 1, 4, 90]
# Each extension alone is measured at these values, still and under a moving camera.
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


class Study(Program):
    """Measures one layer of a scene."""

    def __init__(self, options):
        super().__init__(options.glowworm, options.cache)
        self.options = options
        self.machine = []

    def reference_of(self, scene, name, frame, spp, seed=0):
        """The path tracer's picture through pixel centres."""
        bounces = 1 if layer_of(name) == "reflected" else 0
        return self.reference(scene, "--pixel-filter", "center", "--bounces", bounces, "--size", self.options.size, "--frame", frame,
                              "--spp", spp, "--seed", seed)[0]

    def samples(self, value):
        """A pixel, of the reference: sharp mirrors and shadows need few."""
        return self.options.spp if value > 0 else NOISY_SAMPLES

    def error(self, picture, reference, layer):
        compared = self.run("compare", picture, reference, "--layer", layer)
        return {name: compared[name] for name in ["ssim", "flip", "mean_ratio"]}

    def measure(self, name, motion, value, variant):
        """SSIM, HDR-FLIP and mean of the layer of interest; a row of the figures."""
        scene = hybrid_scenes.make(self.folder / "scenes", name, motion, value)
        frames = FRAMES[motion]
        options = effect_options(name) + switches(VARIANTS[variant]) + [
            "--size", self.options.size, "--frames", frames, "--layers"]

        def measured():
            rendered = self.folder / "rendered.exr"
            report = self.run("render", scene, *options, "--out", rendered)
            reference = self.reference_of(scene, name, frames - 1, self.samples(value))
            return [self.error(rendered, reference, layer_of(name)), *(report[key] for key in MACHINE)]

        row, *self.machine = self.once(measured, scene, self.build, self.options.spp, *options)
        return {"scene": name, "motion": motion, "value": value, "variant": variant} | row

    def judged(self, name, motion, value):
        """Rows of the path tracer itself: with few samples, and with another picture of as many, for the noise of the reference."""
        scene = hybrid_scenes.make(self.folder / "scenes", name, motion, value)
        frame, layer, spp = FRAMES[motion] - 1, layer_of(name), self.samples(value)

        def measured():
            reference = self.reference_of(scene, name, frame, spp)
            rows = {}
            if value > 0:
                rows[f"{NOISY_SAMPLES} samples"] = self.error(self.reference_of(scene, name, frame, NOISY_SAMPLES), reference, layer)
            if value in CHOSEN[name] and motion == "still" and value > 0:
                rows["reference again"] = self.error(self.reference_of(scene, name, frame, spp, 1), reference, layer)
            return rows

        rows = self.once(measured, scene, "judged", frame, layer, self.options.size, spp)
        return [{"scene": name, "motion": motion, "value": value, "variant": variant} | row for variant, row in rows.items()]

    def times(self):
        """Median milliseconds of each pass at 512x512 under a moving camera, one run after another."""
        rows = {}
        for name, value in [("objects", 4), ("boxes", 0.2)]:
            scene = hybrid_scenes.make(self.folder / "scenes", name, "camera", value)
            for variant in ["default", "+ separable", "not denoised"]:
                options = effect_options(name)[2:] + switches(VARIANTS[variant] if variant != "+ separable" else
                                                              {"svgf-separable": "true"})
                report = self.run("render", scene, *options, "--size", "512x512", "--frames", 24, "--out",
                                  self.folder / "timed.png")
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


def main():
    made = parser("hybrid", __doc__, scenes=list(hybrid_scenes.REFLECTIONS | hybrid_scenes.SHADOWS), size="320x180", spp=512)
    made.add_argument("--no-times", action="store_true", help="keep the times that were measured before")
    made.add_argument("--times-only", action="store_true", help="measure the times alone")
    options = made.parse_args()
    file = options.out / "hybrid" / "figures.json"
    if not options.page_only:
        before = read_json(file) or {}
        study = Study(options)
        times = before.get("times", {}) if options.no_times else study.times()
        scenes = [] if options.times_only else options.scenes
        rows = [row for row in before.get("rows", []) if row["scene"] not in scenes]
        for name, motion, value, variants in runs(scenes):
            progress(f"{name} {motion} {value:g} ...")
            rows += study.judged(name, motion, value)
            rows += [study.measure(name, motion, value, variant) for variant in variants]
        write_json(file, before | dict(zip(MACHINE, study.machine)) | {"size": options.size, "spp": options.spp, "times": times, "rows": rows})
    page.fill(options.out / "HYBRID.md", hybrid_page.figures(file.parent))
