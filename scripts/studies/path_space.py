"""Studies path-space filters after the figures of D. Meijer, Real-time Path Traced Global Illumination for Games by Path Space
Filtering, 2019, each with its errors. The figures go to docs/path-space, and from there into docs/PATH-SPACE.md.
"""

import json
import statistics

import numpy as np
from PIL import Image

from . import path_space_page, quality
from . import pictures as images
from .path_space_page import DIRECT, EQUAL_TIME, FIGURES, FRAMES
from .pictures import LUMINANCE

SCENES = ["sponza", "atrium-drapery", "classroom"]
SIZE = "192x108"
# The thesis has one indirect bounce.
BOUNCES = 1
# Nothing moves, but frames are as in motion.
STILL = ["--time-step", 0, "--still-frames", 0, "--antialiasing", "none", "--reflections", "none"]
# Filters alone.
PATHS = [*STILL, "--bounces", BOUNCES, "--denoise", "none", "--indirect", "paths"]
EQUAL_TIME_BOUNCES = 2
# Of the reference's light, below which a pixel lies in a shadow.
SHADOW = 0.5
# Neighbours lie on one surface if their normals and depths differ less.
SAME_NORMAL, SAME_DEPTH = 0.99, 0.02


def references(study, scene):
    """The path tracer's pictures at as many bounces, and at all."""
    return {bounces: study.reference(study.file(scene), SIZE, scene, spp=study.options.spp, bounces=bounces)[0] for bounces in [BOUNCES, "inf"]}


def luminance(picture):
    return images.layer(picture, "indirect") @ LUMINANCE


def same_surface(picture):
    """Whether each pixel and its right neighbour lie on one surface."""
    normal, depth = images.channels(picture, "normal"), images.channels(picture, "depth")[..., 0]
    near, far = np.minimum(depth[:, 1:], depth[:, :-1]), np.maximum(depth[:, 1:], depth[:, :-1])
    return ((normal[:, 1:] * normal[:, :-1]).sum(2) > SAME_NORMAL) & (near > 0) & (far - near < SAME_DEPTH * near)


def blocks(picture, cells):
    """Mean gradient of the logarithm of irradiance from left to right where the cell changes, over that elsewhere."""
    colours = np.asarray(Image.open(cells).convert("RGB")).astype(int)
    border = (colours[:, 1:] != colours[:, :-1]).any(2)
    light = luminance(picture)
    gradient = np.abs(np.diff(np.log(light + 0.01 * light.mean()), axis=1))
    same = same_surface(picture)
    return float(gradient[border & same].mean() / gradient[~border & same].mean())


def shadows(picture, expected):
    """Mean irradiance where the reference has less than half of the mean around, over the reference's: light that fills shadows."""
    light = luminance(expected)
    padded = np.pad(light, 16, mode="reflect")
    sums = np.pad(padded.cumsum(0).cumsum(1), ((1, 0), (1, 0)))
    around = (sums[33:, 33:] - sums[:-33, 33:] - sums[33:, :-33] + sums[:-33, :-33]) / 33 ** 2
    mask = (light < SHADOW * around) & (light > 0)
    return float(luminance(picture)[mask].mean() / light[mask].mean())


def errors(study, picture, expected, stops):
    found = {}
    for bounces, reference in expected.items():
        compared = study.run("compare", picture, reference, "--layer", "indirect", "--exposure", stops)
        found[str(bounces)] = {key: compared[key] for key in ["rmse", "ssim", "flip", "mean_ratio"]}
    return found


def measure(study, scene, options, expected, stops):
    """Errors after 1, 16 and 32 frames, and what the last ones cost."""
    file = study.file(scene)
    pictures, report = study.frames(file, SIZE, FRAMES[-1] - 1, *PATHS, *options)
    frames = report["frames"][len(report["frames"]) // 2:]
    passes = {name: statistics.median(frame["passes"][name] for frame in frames) for name in frames[0]["passes"]}
    width, height = report["settings"]["size"]
    cells = frames[-1].get("cells", {})
    row = {"after": {str(count): errors(study, pictures[count - 1], expected, stops) for count in FRAMES},
           "shadows": shadows(pictures[-1], expected["inf"]),
           "rays": statistics.fmean(frame["rays"] for frame in frames) / (width * height),
           "filter": sum(ms for name, ms in passes.items() if name.startswith("cells_") or name == "sspsf") / passes["paths_trace"],
           "ms": sum(passes.values()), **cells}
    if cells:
        shown = study.folder / "cells.png"
        study.render(file, shown, SIZE, *PATHS, *options, "--frames", 4, "--view", "cells")
        row["blocks"] = blocks(pictures[-1], shown)
    return row, report


def figures(study):
    """The thesis's figures: widths, jitter, normals, depths, frames."""
    rows = study.rows("figures")
    for scene in study.chosen(SCENES):
        expected = references(study, scene)
        stops = round(images.exposure(images.layer(expected["inf"], "indirect")), 3)
        row = rows.setdefault(scene, {})
        for name, options in FIGURES.items():
            row[name], report = measure(study, scene, options, expected, stops)
            study.keep("figures", {"size": SIZE, "spp": study.options.spp, "device": report["device"], "driver": report["driver"],
                                   "commit": report["commit"], "rows": rows})
            print(scene, name, json.dumps(row[name]["after"][str(FRAMES[-1])]["inf"]), flush=True)


def direct(study):
    """All direct light is filtered as well, as in the thesis: display luminance of whole pictures."""
    rows = study.rows("direct")
    for scene in study.chosen(SCENES):
        expected = references(study, scene)["inf"]
        stops = round(images.exposure(images.first_layer(expected)), 3)
        row = rows[scene] = {}
        lit = images.channels(expected, "shadow").mean(2)
        mask = (lit < 0.1) & (images.channels(expected, "depth")[..., 0] > 0)
        for name, options in DIRECT.items():
            pictures, report = study.frames(study.file(scene), SIZE, FRAMES[-1] - 1, *PATHS, "--direct", "paths", *options)
            compared = study.run("compare", pictures[-1], expected, "--luminance", "--exposure", stops)
            shadow = (images.first_layer(pictures[-1]) @ LUMINANCE)[mask].mean() / (images.first_layer(expected) @ LUMINANCE)[mask].mean()
            row[name] = {**{key: compared[key] for key in ["luminance_rmse", "luminance_ssim", "flip", "mean_ratio"]}, "shadows": float(shadow)}
            study.keep("direct", {"commit": report["commit"], "rows": rows})
            print(scene, name, json.dumps(row[name]), flush=True)


def filtered(values, normal, position, depth):
    """Means over 9 x 9 pixels of the same plane, as `sspsf` takes them."""
    total, count = np.zeros_like(values), np.zeros(values.shape[:2] + (1,))
    for down in range(-4, 5):
        for right in range(-4, 5):
            other = [np.roll(of, (-down, -right), (0, 1)) for of in [values, normal, position]]
            rows, columns = np.mgrid[:values.shape[0], :values.shape[1]]
            inside = (rows + down >= 0) & (rows + down < values.shape[0]) & (columns + right >= 0) & (columns + right < values.shape[1])
            off = np.abs(((other[2] - position) * normal).sum(2))
            same = inside & ((other[1] * normal).sum(2) > 0.95) & (off < 0.01 * depth)
            total += np.where(same[..., None], other[0], 0)
            count += same[..., None]
    return total / np.maximum(count, 1)


def albedo(study):
    """Irradiance filtered and then multiplied by the albedo, against both filtered as one."""
    rows = study.rows("albedo")
    for scene in study.chosen(SCENES):
        expected = references(study, scene)[BOUNCES]
        exact = images.layer(expected, "indirect") * images.layer(expected, "albedo") / np.pi
        pictures, report = study.frames(study.file(scene), SIZE, 7, *PATHS)
        found = {"apart": [], "together": []}
        for picture in pictures[-4:]:
            read = [images.channels(picture, name) for name in ["normal", "position", "depth"]]
            light, colour = images.layer(picture, "indirect"), images.layer(picture, "albedo")
            found["apart"].append(filtered(light, read[0], read[1], read[2][..., 0]) * colour / np.pi)
            found["together"].append(filtered(light * colour / np.pi, read[0], read[1], read[2][..., 0]))
        rows[scene] = {name: {"rmse": float(np.sqrt(np.mean([(picture - exact) ** 2 for picture in all_of])) / exact.mean()),
                              "flicker": float(np.mean([np.abs(a - b).mean() for a, b in zip(all_of, all_of[1:])]) / exact.mean())}
                       for name, all_of in found.items()}
        study.keep("albedo", {"commit": report["commit"], "rows": rows})
        print(scene, json.dumps(rows[scene]), flush=True)


def equal_time(study):
    """Filters, denoisers and VPLs for the same time a frame, the camera standing: frames until that time, then the error."""
    rows = study.rows("equal_time")
    for scene in study.chosen(SCENES):
        expected = references(study, scene)["inf"]
        stops = round(images.exposure(images.layer(expected, "indirect")), 3)
        row = rows[scene] = {}
        for name, options in EQUAL_TIME.items():
            pictures, report = study.frames(study.file(scene), SIZE, FRAMES[-1] - 1, *STILL, "--bounces", EQUAL_TIME_BOUNCES, *options)
            ends = np.cumsum([frame["total_ms"] for frame in report["frames"]]) / 1000
            row[name] = {"ends": [float(end) for end in ends],
                         "flip": [study.run("compare", pictures[frame], expected, "--layer", "indirect", "--exposure", stops)["flip"]
                                  for frame in range(FRAMES[-1])]}
            study.keep("equal_time", {"commit": report["commit"], "rows": rows})
            print(scene, name, row[name]["ends"][-1], row[name]["flip"][-1], flush=True)


def main():
    sections = {section.__name__: section for section in [figures, direct, albedo, equal_time]}
    quality.run("path-space", __doc__, sections, dict.fromkeys(SCENES), 256, "PATH-SPACE.md", path_space_page.figures)
