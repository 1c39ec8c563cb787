"""Studies the denoisers. Camera motions are those of H. Flatval, Denoising Algorithms for Ray Tracing in Real-Time Applications,
2020, as far as the scenes allow. The figures go to docs/denoisers, and from there into docs/DENOISERS.md.
"""

import json
import math
import statistics

import numpy as np

from . import denoisers_page, quality
from . import pictures as images
from .denoisers_page import AGES, FEATURE_COUNTS, METHODS
from .pictures import LUMINANCE
from .program import ROOT

SIZE = "320x180"
FRAMES = 60
# Those that are compared; the first ones are new to every history.
COMPARED = range(5, FRAMES, 6)
BOUNCES = 3
# Nothing stands still.
MOVES = ["--time-step", "1/60", "--still-frames", 0, "--bounces", BOUNCES, "--size", SIZE]
# Frames of the static run, and those of its end over which the change is a mean.
STATIC_FRAMES = 60
STATIC_END = 10
# Each adds to those before: the ten of Koskela et al. 2019, in their order of use, then products.
FEATURES = ["1", "wx*wx", "ny", "wz*wz", "nx", "wy*wy", "nz", "wx", "wy", "wz", "nx*ny", "wx*wy", "d", "wx*nz"]

# The start of the camera, the way it goes in a second, degrees by which it turns left, and the light, in the scene's units.
THESIS_LIGHT = """[[lights]]
name = "lamp"
type = "area"
radiance = [40, 40, 40]
polygon = [[-1, 5, -1], [1, 5, -1], [1, 5, 1], [-1, 5, 1]]
"""
CAMERAS = {
    "sponza": {"eye": [-5, 2.5, 0], "target": [-6, 2.0, -0.5], "way": [10, 0, 0], "turn": 53, "light": THESIS_LIGHT},
    "living-room": {"eye": [5.1, 0.73, -2.3], "target": [4.14, 0.8, -2.05], "way": [-1, 0, 0.5], "turn": 20},
    "atrium-drapery": {"eye": [-9.6, 2.1, 1.5], "target": [2.0, 3.9, -0.9], "way": [5, 0, 0], "turn": 30},
}


def scene_file(study, scene, moves=True):
    """The scene with the camera, and with its light where the study has one of its own."""
    camera = CAMERAS[scene]
    text = (ROOT / "scenes" / f"{scene}.toml").read_text()
    start = text.index("[camera]")
    end = text.find("\n[", start)
    lines = ["[camera]", f"eye = {camera['eye']}", f"target = {camera['target']}", "vfov_deg = 45"]
    if moves:
        lines.append(f"animation = {{ keyframes = [{{ time = 0 }}, {{ time = 1, translation = {camera['way']}, "
                     f"rotation = [0, {camera['turn']}, 0] }}] }}")
    rest = text[end:] if end >= 0 else ""
    if "light" in camera:
        settings = rest.find("\n[settings")
        rest = "\n" + camera["light"] + (rest[settings:] if settings >= 0 else "")
    file = study.folder / "scenes" / f"{scene}-{'walk' if moves else 'static'}.toml"
    file.write_text(text[:start] + "\n".join(lines) + "\n" + rest)
    return file


def reference(study, scene, frame):
    return study.reference(scene_file(study, scene), SIZE, scene, frame=frame, spp=study.options.spp, bounces=BOUNCES,
                           pixel_filter="box")[0]


def stage_ms(report):
    """Milliseconds a frame by stage: mean, and the greatest frame of the whole."""
    frames = report["frames"][8:]
    passes = {name: statistics.fmean(frame["passes"][name] for frame in frames) for name in frames[0]["passes"]}
    denoiser = sum(ms for name, ms in passes.items() if name.startswith("indirect_"))
    totals = [frame["total_ms"] for frame in frames]
    return {"ms": statistics.fmean(totals), "most_ms": max(totals), "denoiser_ms": denoiser,
            "passes": {name: ms for name, ms in passes.items() if ms > 0}}


def error(study, picture, expected, stops):
    return study.run("compare", picture, expected, "--luminance", "--exposure", stops)


def by_frames_seen(pictures, references, seen, stops):
    """Root mean square error of display luminance by the frames since each surface came into view."""
    squares = {}
    for frame, reference in references.items():
        shown, expected = (images.encoded(images.first_layer(file), stops) @ LUMINANCE for file in [pictures[frame], reference])
        error = (shown - expected) ** 2
        for name, (first, end) in AGES.items():
            squares.setdefault(name, []).append(error[(seen[frame] >= first) & (seen[frame] < end)])
    return {name: float(np.sqrt(np.concatenate(of).mean())) for name, of in squares.items() if sum(map(len, of)) > 0}


def methods(study):
    """Each method along the camera motion, against the path tracer's frames of the same moments."""
    rows = study.rows("methods")
    for scene in study.chosen(CAMERAS):
        file = scene_file(study, scene)
        references = {frame: reference(study, scene, frame) for frame in COMPARED}
        middle = images.first_layer(references[COMPARED[len(COMPARED) // 2]])
        stops = round(images.exposure(middle), 3)
        row = rows.setdefault(scene, {})
        row |= {"stops": stops, "spp": study.options.spp}
        seen = None
        for name, options in METHODS.items():
            pictures, report = study.frames(file, SIZE, FRAMES - 1, *MOVES, *options)
            row["commit"] = report["commit"]
            compared = {frame: error(study, pictures[frame], references[frame], stops) for frame in COMPARED}
            seen = seen or images.frames_seen(pictures)
            row[name] = {
                "by_frames_seen": by_frames_seen(pictures, references, seen, stops),
                **{key: statistics.fmean(figures[key] for figures in compared.values())
                   for key in ["luminance_rmse", "luminance_ssim", "flip", "mean_ratio"]},
                "blocks": statistics.fmean(
                    images.block_energy(images.first_layer(pictures[frame]), images.first_layer(references[frame])) for frame in COMPARED if frame >= 16),
                "flip_by_frame": {frame: figures["flip"] for frame, figures in compared.items()},
                "flicker": statistics.fmean(images.flicker(pictures[frame], pictures[frame - 1]) for frame in COMPARED),
                "rays": statistics.fmean(frame.get("shadow_rays", frame.get("rays", 0)) for frame in report["frames"][8:]) / math.prod(report["settings"]["size"]),
                **stage_ms(report)}
            study.keep("methods", {"size": SIZE, "bounces": BOUNCES, "device": report["device"],
                                   "driver": report["driver"], "rows": rows})
            print(scene, name, json.dumps({key: value for key, value in row[name].items() if key not in ["passes", "by_frames_seen"]}), flush=True)


def static(study):
    """Change of display luminance from frame to frame while nothing moves, before the picture freezes."""
    rows = study.rows("static")
    for scene in study.chosen(CAMERAS):
        file = scene_file(study, scene, moves=False)
        stops = study.rows("methods").get(scene, {}).get("stops", 0)
        row = rows[scene] = {}
        for name, options in METHODS.items():
            pictures, report = study.frames(file, SIZE, STATIC_FRAMES - 1, *MOVES, *options)
            name_of_all = pictures[0].parent / "{frame:03}.exr"
            changes = study.run("compare", name_of_all, pictures[-1], "--luminance", "--exposure", stops)["frames"]
            row[name] = statistics.fmean(frame["luminance_temporal_error"] for frame in changes[-STATIC_END:])
            study.keep("static", {"commit": report["commit"], "rows": rows})
        print(scene, json.dumps(row), flush=True)


def features(study):
    """BMFR with ever more features: error, and time of the fit."""
    rows = study.rows("features")
    for scene in study.chosen(CAMERAS):
        file = scene_file(study, scene)
        stops = study.rows("methods").get(scene, {}).get("stops", 0)
        row = rows[scene] = {}
        for count in FEATURE_COUNTS:
            options = [*METHODS["paths, BMFR"], "--bmfr-features", ",".join(FEATURES[:count])]
            pictures, report = study.frames(file, SIZE, FRAMES - 1, *MOVES, *options)
            compared = [error(study, pictures[frame], reference(study, scene, frame), stops) for frame in COMPARED]
            row[str(count)] = {
                **{key: statistics.fmean(figures[key] for figures in compared) for key in ["luminance_rmse", "luminance_ssim", "flip"]},
                "fit_ms": stage_ms(report)["passes"]["indirect_bmfr_fit"]}
            study.keep("features", {"commit": report["commit"], "features": FEATURES, "rows": rows})
        print(scene, json.dumps(row), flush=True)


def main():
    quality.run("denoisers", __doc__, {section.__name__: section for section in [methods, static, features]}, CAMERAS, 256,
                "DENOISERS.md", denoisers_page.figures)
