"""Searches BMFR's features greedily (Flatval 2020, section 4.4) over data sets of several scenes.

The cost of a list is the mean over the scenes, and over two metrics of denoised frames against the path tracer's: HDR-FLIP, and
what VMAF lacks of 100, each divided by that of the constant feature alone. The pool has what Flatval's has (components of normal n
and position w, their products and roots) and distance, roughness and albedo; whole vectors are added as one in a search of their own. Each step adds the candidate that lowers the cost most.
Candidates are tried in the order of what they brought before, until one brings more than the next one ever did (lazy evaluation).
"""

import heapq
import json
import shutil
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import OpenEXR
from PIL import Image

from . import denoisers, denoisers_page, quality, vmaf
from . import pictures as images

SIZE = "160x90"
FRAMES = 14
# The first that is compared: histories are young, as they are in motion.
FIRST = 4
MOST = 12
N, W = ["nx", "ny", "nz"], ["wx", "wy", "wz"]
SINGLE = ([*N, *W] + [f"{a}*{a}" for a in N + W] + [f"sqrt({a})" for a in N + W] + [f"{w}*{n}" for w in W for n in N]
          + ["wx*wy", "wy*wz", "wx*wz", "nx*ny", "ny*nz", "nx*nz", "wx*wx*wx", "wy*wy*wy", "wz*wz*wz", "d", "d*d", "r", "ar", "ag", "ab"])
VECTORS = [[*N], [*W], [f"{a}*{a}" for a in N], [f"{a}*{a}" for a in W], [f"sqrt({a})" for a in N], [f"sqrt({a})" for a in W],
           ["wx*nx", "wy*ny", "wz*nz"], ["wx*wy", "wy*wz", "wx*wz"], ["ar", "ag", "ab"], ["d"], ["r"]]
BMFR = ["1", "nx", "ny", "nz", "wx", "wy", "wz", "wx*wx", "wy*wy", "wz*wz"]
# Degrees by which a scene is turned about each axis.
TURN = 35


class Search:
    def __init__(self, study):
        self.study = study
        self.sets = {scene: self.dataset(scene) for scene in study.chosen(denoisers.CAMERAS)}
        self.commit = self.denoise(next(iter(self.sets)), next(iter(self.sets.values())), ["1"], study.folder / "features-denoised")["commit"]
        # Errors by scene and list, kept in the cache: a search that was interrupted goes on.
        self.file = study.folder / f"features-known-{self.commit}.json"
        self.known = json.loads(self.file.read_text()) if self.file.exists() else {}
        self.stops = {scene: self.show_reference(scene) for scene in self.sets}

    def dataset(self, scene):
        """The folder of the scene's data set, written once."""
        folder = self.study.folder / f"features-{scene}-{SIZE}-{FRAMES}"
        if not (folder / "search-complete").exists():
            file = denoisers.scene_file(self.study, scene)
            self.study.run("dataset", file, "--out", folder, "--frames", FRAMES, "--samples", 1, "--spp", self.study.options.spp, "--size", SIZE,
                           "--bounces", denoisers.BOUNCES, "--resume")
            (folder / "search-complete").touch()
        return folder

    def turned(self, scene, axis):
        """The data set with positions and normals turned about an axis."""
        folder = self.study.folder / f"features-turned-{scene}-{axis}"
        shutil.rmtree(folder, ignore_errors=True)
        shutil.copytree(self.sets[scene], folder)
        angle, (a, b) = np.radians(TURN), [(1, 2), (2, 0), (0, 1)][axis]
        turn = np.eye(3)
        turn[a, a] = turn[b, b] = np.cos(angle)
        turn[b, a], turn[a, b] = np.sin(angle), -np.sin(angle)
        for frame in range(FRAMES):
            for name in ["shading_normal", "world_position"]:
                file = folder / f"{name}{frame}.exr"
                part = OpenEXR.File(str(file), separate_channels=True)
                vectors = np.stack([part.channels()[channel].pixels for channel in "RGB"], 2) @ turn.T
                channels = {channel: np.ascontiguousarray(vectors[..., i].astype(np.float32)) for i, channel in enumerate("RGB")}
                OpenEXR.File({"type": OpenEXR.scanlineimage}, channels).write(str(file))
        text = (folder / "camera_matrices.h").read_text()
        (folder / "camera_matrices.h").write_text(turned_matrices(text, turn))
        return folder

    def show_reference(self, scene):
        """Writes the reference as PNGs, which VMAF reads. Returns the stops at which it and what is compared with it are shown."""
        folder = self.sets[scene]
        stops = images.exposure(images.first_layer(folder / f"reference{FRAMES // 2}.exr"))
        show(folder, "reference", folder / "reference-shown", stops)
        return stops

    def denoise(self, scene, folder, features, out):
        """The report of a data set denoised by these features into a folder."""
        return self.study.run("denoise", folder, "--layout", "bmfr", "--denoise", "bmfr", "--bmfr-features", ",".join(features), "--out", out,
                              report=f"denoise-{scene}")

    def errors_of(self, scene, folder, features):
        """HDR-FLIP and what VMAF lacks of 100: means over frames of a data set denoised by these features."""
        with tempfile.TemporaryDirectory() as out:
            report = self.denoise(scene, folder, features, out)
            show(Path(out), "denoised", Path(out) / "shown", self.stops[scene])
            quality_of_frames = vmaf.measure(vmaf.pictures(Path(out) / "shown"), vmaf.pictures(self.sets[scene] / "reference-shown"))
        return [float(np.mean([frame["flip"] for frame in report["metrics"]["frames"][FIRST:]])), 100 - float(np.mean(quality_of_frames))]

    def errors(self, scene, features):
        key = " ".join([scene, *features])
        if key not in self.known:
            self.known[key] = self.errors_of(scene, self.sets[scene], features)
        return self.known[key]

    def share(self, scene, errors):
        """Errors over those of the constant alone."""
        return float(np.mean(np.divide(errors, self.errors(scene, ["1"]))))

    def cost(self, scenes, features):
        with ThreadPoolExecutor(2) as threads:
            errors = list(threads.map(lambda scene: self.errors(scene, features), scenes))
        self.file.write_text(json.dumps(self.known))
        return float(np.mean([self.share(scene, found) for scene, found in zip(scenes, errors)]))

    def greedy(self, scenes, pool):
        """The lists of the search by their length, each with its cost."""
        chosen, cost = ["1"], 1.0
        steps = [{"features": list(chosen), "cost": cost}]
        # What each candidate brought when it was last tried, the most first.
        heap = [(-np.inf, i) for i in range(len(pool))]
        while len(chosen) < MOST and heap:
            fresh = set()
            while True:
                gain, i = heapq.heappop(heap)
                if i in fresh:
                    break
                found = cost - self.cost(scenes, chosen + pool[i])
                fresh.add(i)
                heapq.heappush(heap, (-found, i))
            if -gain <= 0:
                break
            chosen, cost = chosen + pool[i], cost + gain
            steps.append({"features": list(chosen), "cost": cost})
            print(" ".join(scenes), f"{cost:.4f}", ",".join(chosen), flush=True)
        return steps


def show(folder, name, out, stops):
    """Writes the frames that are compared as PNGs."""
    out.mkdir(exist_ok=True)
    for frame in range(FIRST, FRAMES):
        picture = images.first_layer(folder / f"{name}{frame}.exr")
        Image.fromarray(images.display(picture, stops)).save(out / f"{frame:02}.png")


def turned_matrices(text, turn):
    """The matrices of a turned world: a turned point times the new one is the point times the old one."""
    start = text.index("{", text.index("camera_matrices"))
    end = text.index(";", start)
    numbers = text[start:end].replace("{", " ").replace("}", " ").replace("f", " ").replace(",", " ").split()
    matrices = np.array(numbers, float).reshape(-1, 4, 4)
    matrices[:, :3] = turn @ matrices[:, :3]
    rows = ["{" + ", ".join("{" + ", ".join(repr(float(x)) for x in row) + "}" for row in matrix) + "}" for matrix in matrices]
    return text[:start] + "{" + ",\n".join(rows) + "}" + text[end:]


def search(study):
    """Searches by component and by vector over all scenes, then without each of them, and turns the scenes."""
    of = Search(study)
    scenes = list(of.sets)
    singles = [[name] for name in SINGLE]
    found = {"commit": of.commit, "size": SIZE, "spp": study.options.spp, "scenes": scenes, "bmfr": of.cost(scenes, BMFR)}
    found["components"] = of.greedy(scenes, singles)
    study.keep("search", found)
    found["vectors"] = of.greedy(scenes, VECTORS)
    study.keep("search", found)
    found["unseen"] = {}
    for scene in scenes if len(scenes) > 1 else []:
        features = of.greedy([other for other in scenes if other != scene], singles)[-1]["features"]
        found["unseen"][scene] = {"features": features, "cost": of.cost([scene], features), "bmfr": of.cost([scene], BMFR)}
        study.keep("search", found)
    best = found["components"][-1]["features"]
    found["errors"] = {name: [of.errors(scene, features) for scene in scenes] for name, features in [("bmfr", BMFR), ("found", best)]}
    found["turned"] = {}
    for name, features in [("bmfr", BMFR), ("found", best)]:
        for axis in range(3):
            costs = [of.share(scene, of.errors_of(scene, of.turned(scene, axis), features)) for scene in scenes]
            found["turned"].setdefault(name, []).append(float(np.mean(costs)))
    study.keep("search", found)


def main():
    quality.run("search-features", __doc__, {"search": search}, denoisers.CAMERAS, 128, "DENOISERS.md", denoisers_page.figures)
