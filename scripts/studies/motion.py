"""Sections of scripts/study quality in which something moves: errors of single frames, and moving pictures.

The camera turns by 30 degrees a second, so that frame 64 shows the scene's own view; in the playroom lights and objects move.
"""

import json
import math
import statistics

import numpy as np
from PIL import Image

from . import pictures as images
from .quality_page import SCENES

SIZE = "128x128"
MOVING = [*SCENES, "playroom"]
FRAMES = [32, 64, 96]
MIDDLE = 64
# Pixels are sampled in their middle, as the references.
MOVES = ["--time-step", "1/60", "--antialiasing", "none"]
WAYS = {"default": [], "16x": ["--vpls", 8192, "--budget", 1024]}
# Shown moving, each sixth frame at its own speed.
SHOWN = {scene: range(32, 96, 6) for scene in ["classroom", "sponza", "playroom"]}
SHOWN_MS = 100

DEGREES_A_SECOND = 30
TURN = f"""animation = {{ keyframes = [{{ time = 0, rotation = [0, {-DEGREES_A_SECOND * MIDDLE / 60}, 0] }}], \
rotation = {{ axis = [0, 1, 0], degrees_per_second = {DEGREES_A_SECOND} }} }}"""
CORNELL = """name = "cornell-box"
[[models]]
name = "box"
builtin = "cornell-box"
[[instances]]
model = "box"
[camera]
eye = [0.278, 0.273, -0.8]
target = [0.278, 0.273, 0]
vfov_deg = 39.3077
"""


def moving(study, scene):
    """The scene with a camera that turns, or that moves by itself."""
    text = CORNELL if scene == "cornell-box" else study.file(scene).read_text()
    if "animation" in text:
        return study.file(scene)
    # Beside the models of the scenes that are made.
    file = study.folder / "scenes" / f"{scene}-turning.toml"
    file.write_text(text.replace("[camera]\n", f"[camera]\n{TURN}\n"))
    return file


def reference(study, scene, frame, share=4, seed=0, spp=None):
    """The path tracer's frame, with a share of the samples of a still picture: motion needs several."""
    spp = spp or study.options.spp // share
    return study.reference(moving(study, scene), SIZE, scene, frame=frame, seed=seed, spp=spp)


def errors(study, pictures, references, stops):
    """Means over the frames that have a reference; `pictures` by frame."""
    rows = []
    for frame, expected in references.items():
        compared = study.run("compare", pictures[frame], expected, "--layer", "indirect")
        both = [images.layer(file, "indirect") for file in [pictures[frame], expected]]
        rows.append({"flip": compared["flip"], "mean_ratio": compared["mean_ratio"],
                     "mottling": images.mottling(*both, stops)})
    return {key: statistics.fmean(row[key] for row in rows) for key in rows[0]}


def same_time(study, scene, ms, references, stops):
    """The path tracer with as many samples as fit into the time of a frame, at least one."""
    _, _, sample_seconds = reference(study, scene, MIDDLE)
    samples = max(1, round(ms / 1000 / sample_seconds))
    pictures = {frame: reference(study, scene, frame, seed=1, spp=samples)[0] for frame in references}
    return {"samples": samples, "share": ms / 1000 / (samples * sample_seconds), **errors(study, pictures, references, stops)}


def motion(study):
    """Frames of a camera that turns, and of the playroom, against the path tracer's of the same moments."""
    rows = study.rows("motion")
    for scene in study.chosen(MOVING):
        references = {frame: reference(study, scene, frame)[0] for frame in FRAMES}
        stops = images.exposure(images.layer(references[MIDDLE], "indirect"))
        row = rows[scene] = {}
        for way, options in WAYS.items():
            pictures, report = study.frames(moving(study, scene), SIZE, FRAMES[-1], *MOVES, *options)
            timed = report["frames"][FRAMES[0]:]
            row[way] = {**errors(study, pictures, references, stops),
                        "flicker": statistics.fmean(images.flicker(pictures[frame], pictures[frame - 1])
                                                    for frame in FRAMES),
                        "ms": statistics.median(frame["total_ms"] for frame in timed),
                        "rays": statistics.fmean(frame["shadow_rays"] for frame in timed) / math.prod(report["settings"]["size"])}
        another = reference(study, scene, MIDDLE, seed=1)[0]
        row["noise"] = study.run("compare", another, references[MIDDLE], "--layer", "indirect")["flip"]
        row["reference"] = same_time(study, scene, row["default"]["ms"], references, stops)
        study.keep("motion", {"size": SIZE, "spp": study.options.spp // 4, "commit": report["commit"],
                              "options": " ".join(map(str, WAYS["16x"])), "rows": rows})
        print(scene, json.dumps(row), flush=True)


def animations(study):
    """Moving pictures of the irradiance: default, 16 times the samples, the path tracer."""
    for scene in study.chosen(SHOWN):
        frames = SHOWN[scene]
        columns = [[images.layer(reference(study, scene, frame, 8)[0], "indirect") for frame in frames]]
        for options in reversed(WAYS.values()):
            pictures, _ = study.frames(moving(study, scene), SIZE, frames[-1], *MOVES, *options)
            columns.insert(0, [images.layer(pictures[frame], "indirect") for frame in frames])
        stops = images.exposure(np.stack(columns[-1]))
        shown = [Image.fromarray(images.display(np.hstack(row), stops).repeat(2, 0).repeat(2, 1))
                 for row in zip(*columns)]
        shown[0].save(study.figures / f"{scene}.gif", save_all=True, append_images=shown[1:], duration=SHOWN_MS, loop=0,
                      optimize=True)
