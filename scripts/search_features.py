"""The program of scripts/search-features: greedy search of BMFR's features (Flatval 2020, section 4.4) over data sets of several scenes.

The cost of a list is the mean HDR-FLIP of denoised frames against the path tracer's, over the scenes, each divided by that of the
constant feature alone. The pool has what Flatval's has (components of normal n and position w, their products and roots) and distance,
roughness and albedo; whole vectors are added as one in a search of their own. Each step adds the candidate that lowers the cost most.
Candidates are tried in the order of what they brought before, until one brings more than the next one ever did (lazy evaluation).
"""

import heapq
import json
import shutil

import numpy as np
import OpenEXR

import study_denoisers
import study_denoisers_page
import study_quality

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
        self.known = {}
        self.sets = {scene: self.dataset(scene) for scene in study.chosen(study_denoisers.CAMERAS)}
        self.constant = {scene: self.flip(scene, ["1"]) for scene in self.sets}

    def dataset(self, scene):
        """The folder of the scene's data set, written once."""
        folder = self.study.cache / f"features-{scene}-{SIZE}-{FRAMES}"
        if not (folder / "search-complete").exists():
            file = study_denoisers.scene_file(self.study, scene)
            self.study.run("dataset", file, "--out", folder, "--frames", FRAMES, "--samples", 1, "--spp", self.study.options.spp, "--size", SIZE,
                           "--bounces", study_denoisers.BOUNCES, "--resume")
            (folder / "search-complete").touch()
        return folder

    def turned(self, scene, axis):
        """The data set with positions and normals turned about an axis."""
        folder = self.study.cache / f"features-turned-{scene}-{axis}"
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

    def flip_of(self, folder, features):
        out = self.study.cache / "features-denoised"
        shutil.rmtree(out, ignore_errors=True)
        report = self.study.run("denoise", folder, "--layout", "bmfr", "--denoise", "bmfr", "--bmfr-features", ",".join(features), "--out", out)
        return float(np.mean([frame["flip"] for frame in report["metrics"]["frames"][FIRST:]]))

    def flip(self, scene, features):
        key = (scene, *features)
        if key not in self.known:
            self.known[key] = self.flip_of(self.sets[scene], features)
        return self.known[key]

    def cost(self, scenes, features):
        return float(np.mean([self.flip(scene, features) / self.constant[scene] for scene in scenes]))

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
    found = {"size": SIZE, "spp": study.options.spp, "scenes": scenes, "bmfr": of.cost(scenes, BMFR)}
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
    found["turned"] = {}
    for name, features in [("bmfr", BMFR), ("found", best)]:
        for axis in range(3):
            costs = [of.flip_of(of.turned(scene, axis), features) / of.constant[scene] for scene in scenes]
            found["turned"].setdefault(name, []).append(float(np.mean(costs)))
    study.keep("search", found)


if __name__ == "__main__":
    study_quality.run("search-features", __doc__, {"search": search}, study_denoisers.CAMERAS, 128, "denoisers", study_denoisers_page.write)
