"""Compares whole pictures after one second of rendering, by Mitsuba and by the renderer. The figures go to docs/quality/equal-time.json,
and from there into docs/QUALITY.md.

Mitsuba renders what `glowworm export` wrote, with its path tracer and as many samples a pixel as a second allows; the
renderer draws as many frames from its first one on as a second allows, at least one, at default settings. Loading and
compiling do not count; the best of several turns does. Each picture is compared with the path tracer's (`glowworm
reference`) of its own pixel filter: all over the pixel for Mitsuba, its centre for the renderer.
"""

import os
import tempfile
import time
from pathlib import Path

import mitsuba as mi
import numpy as np
from PIL import Image

from . import page, pictures, quality_page
from .program import Program, parser, progress, write_json
from .verify_with_mitsuba import load, start_mitsuba

# Most frames that are rendered.
MOST_FRAMES = 32
SCENES = ["cornell-box", "sponza", "sibenik", "conference", "classroom", "living-room"]
SECONDS = 1.0
# Of each pixel at once: multijitter wants squares.
SAMPLES = [1, 4, 9, 16, 25, 36, 49, 64, 81, 100, 144, 196, 256]


class Lab(Program):
    """Runs the renderer in a scratch folder; the cache keeps references."""

    def __init__(self, options, folder):
        super().__init__(options.glowworm, folder)
        self.options = options
        self.traced = Program(options.glowworm, options.cache)

    def render(self, scene, frames, out):
        return self.run("render", scene, "--size", self.options.size, "--bounces", 2, "--time-step", 0, "--frames", frames, "--out", out)

    def reference_of(self, scene, pixel_filter):
        return self.traced.reference(scene, "--pixel-filter", pixel_filter, "--bounces", 2, "--spp", self.options.spp,
                                     "--size", self.options.size)[0]

    def frames(self, scene):
        """How many frames a second holds, and the seconds that they take."""
        report = self.render(scene, MOST_FRAMES, self.folder / "frames.exr")
        ends = np.cumsum([frame["total_ms"] for frame in report["frames"]]) / 1000
        count = max(1, int(np.searchsorted(ends, SECONDS, side="right")))
        return count, float(ends[count - 1]), report["device"]

    def errors(self, rendered, reference):
        """FLIP of the tone-mapped pictures, and HDR-FLIP of the linear ones."""
        stops = pictures.exposure(pictures.layer(reference, "colour"))
        shown = []
        for name, file in [("rendered", rendered), ("reference", reference)]:
            shown.append(self.folder / f"{name}.png")
            Image.fromarray(pictures.display(pictures.first_layer(file), stops)).save(shown[-1])
        return {"flip": self.run("compare", *shown)["flip"],
                "hdr_flip": self.run("compare", rendered, reference)["flip"]}


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
    report = lab.export(scene, lab.folder / scene, "--size", lab.options.size, "--bounces", 2)
    box, centre = (lab.reference_of(scene, pixel_filter) for pixel_filter in ["box", "center"])
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


def main():
    made = parser("equal-time", __doc__, scenes=SCENES, size="256x256", spp=1024, turns=3)
    made.add_argument("--variant", help="Mitsuba's, otherwise llvm_ad_rgb where it works, else scalar_rgb")
    options = made.parse_args()
    rows, folder = [], options.out / "quality"
    if not options.page_only:
        variant = start_mitsuba(options.variant)
        with tempfile.TemporaryDirectory(prefix="equal-time.") as scratch:
            lab = Lab(options, Path(scratch))
            for scene in options.scenes:
                progress(f"{scene} ...")
                rows.append(measure(lab, scene))
                write_json(folder / "equal-time.json", {"mitsuba": mi.__version__, "variant": variant, "size": options.size,
                                                        "cores": os.cpu_count(), "rows": rows})
    page.fill(options.out / "QUALITY.md", quality_page.figures(folder))
