"""Studies the renderer against the path tracer, scene by scene, at default settings, section by section. The figures go to
docs/quality, and from there into docs/QUALITY.md.
"""

import shutil
import statistics
from pathlib import Path

import numpy as np
from PIL import Image

from . import made_scenes, page, pictures, quality_page
from .program import ROOT, Program, parser, progress, read_json, write_json
from .quality_page import SCENES

# Few paths find the light of these, so they get so many times the samples.
MORE_SAMPLES = {"classroom": 4, "living-room": 4, "corridor": 4, "blinds": 4, "uplight": 4}
BOUNCES = 2
# As many as there are temporal sets: times and rays are taken over one round of them, after warming up for another.
ROUND = 16
# Nothing moves, but frames are as in motion.
STILL = ["--time-step", 0, "--frames", 2 * ROUND + 1, "--still-frames", 0, "--antialiasing", "none"]
# Largest side of what a strip shows, before it is enlarged.
SHOWN = 256


class Study(Program):
    """Measures pictures of scenes, and keeps the figures of sections in a folder of docs."""

    def __init__(self, options, figures):
        super().__init__(options.glowworm, options.cache)
        self.options = options
        self.figures = options.out / figures
        self.figures.mkdir(parents=True, exist_ok=True)
        self.rendered = self.folder / "rendered.exr"
        self.made = made_scenes.make(self.folder / "scenes")

    def chosen(self, scenes):
        return [scene for scene in scenes if scene in self.options.scenes]

    def file(self, scene):
        """Its scene file, or its name if it has none."""
        file = self.made.get(scene) or ROOT / "scenes" / f"{scene}.toml"
        return file if file.exists() else scene

    def rows(self, section):
        """What has been measured, by scene."""
        return (read_json(self.figures / f"{section}.json") or {"rows": {}})["rows"]

    def keep(self, section, figures):
        write_json(self.figures / f"{section}.json", figures)

    def reference(self, file, size, scene, frame=0, seed=0, share=1, spp=None, pixel_filter="center", bounces=BOUNCES):
        """The path tracer's picture, with a share of the samples or `spp`, its samples a pixel and the seconds that each of them
        took. `file` is a path or the name of `scene`, which tells how many samples it needs."""
        spp = spp or self.options.spp * MORE_SAMPLES.get(scene, 1) // share
        picture, figures = super().reference(file, "--pixel-filter", pixel_filter, "--bounces", bounces, "--frame", frame,
                                             "--time-step", "1/60", "--seed", seed, "--spp", spp, "--size", size)
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
        folder = self.folder / "frames"
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
        rendered = pictures.layer(self.rendered, "indirect")
        return {**{key: compared[key] for key in ["relmse", "flip", "ssim", "mean_ratio"]},
                "trimmed_relmse": pictures.trimmed_relmse(rendered, expected),
                "brightest_block": pictures.brightest_block(rendered, expected),
                "pattern": pictures.pattern(rendered, expected)}

    def steadiness(self, scene):
        rendered = self.folder / "seed.exr"
        found = []
        for seed in range(self.options.seeds):
            self.render(self.file(scene), rendered, self.options.size, *STILL, "--seed", seed)
            found.append(pictures.layer(rendered, "indirect"))
        return pictures.steadiness(found)

    def strip(self, expected, stops, out):
        """The picture and its reference side by side at one exposure, every pixel twice as large."""
        shown = [pictures.display(picture, stops) for picture in [pictures.layer(self.rendered, "indirect"), expected]]
        height, width = (min(extent, SHOWN) for extent in shown[0].shape[:2])
        top, left = (shown[0].shape[0] - height) // 2, (shown[0].shape[1] - width) // 2
        cut = [picture[top:top + height, left:left + width].repeat(2, 0).repeat(2, 1) for picture in shown]
        gap = np.full((2 * height, 8, 3), 255, np.uint8)
        Image.fromarray(np.hstack([cut[0], gap, cut[1]])).save(out, quality=72, optimize=True)

    def study(self, scene):
        reference, spp, _ = self.reference(self.file(scene), self.options.size, scene)
        expected = pictures.layer(reference, "indirect")
        stops = pictures.exposure(expected)
        figures = self.speed(scene) | self.error(expected, reference, round(stops, 3))
        if self.options.seeds > 1:
            figures["steadiness"] = self.steadiness(scene)
        self.strip(expected, stops, self.figures / f"{scene}.jpg")
        return {"size": self.options.size, "spp": spp, "noise": self.noise(scene, reference), "stops": stops,
                "irradiance": float((expected @ pictures.LUMINANCE).mean()), "seeds": self.options.seeds, **figures}


def scenes(study):
    """The irradiance of ten scenes in which nothing moves, and what it costs."""
    for scene in study.chosen(SCENES):
        study.keep(scene, study.study(scene))
        print(quality_page.line(scene, study.figures / f"{scene}.json"), flush=True)


def run(name, description, sections, scenes, spp, page_name, figures):
    """Measures the sections that are asked for, and brings the page up to date; `figures` makes its texts by the folder of docs."""
    made = parser(name, description, sections, scenes=list(scenes), size="256x256", spp=spp, turns=3)
    made.add_argument("--seeds", type=int, default=0, metavar="N", help="quality: also render N seeds (%(default)s)")
    made.add_argument("--device", metavar="NAME|INDEX", help="Vulkan device, otherwise the best")
    options = made.parse_args()
    folder = Path(page_name).stem.lower()
    if not options.page_only:
        study = Study(options, folder)
        for section in options.sections or sections:
            progress(f"{section} ...")
            sections[section](study)
    page.fill(options.out / page_name, figures(options.out / folder))


def main():
    from . import motion, pixels

    sections = [scenes, motion.motion, motion.animations, pixels.pixels, pixels.convergence, pixels.textures]
    run("quality", __doc__, {section.__name__: section for section in sections}, dict.fromkeys(motion.MOVING + pixels.PICTURES), 1024,
        "QUALITY.md", quality_page.figures)
